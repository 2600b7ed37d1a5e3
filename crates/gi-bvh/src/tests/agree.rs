//! Compares hits with a brute-force search in double precision.

use std::sync::Arc;

use super::*;

type V = [f64; 3];

fn wide(v: Vec3) -> V {
    v.to_array().map(f64::from)
}
fn sub(a: V, b: V) -> V {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
fn along(a: V, d: V, t: f64) -> V {
    [a[0] + d[0] * t, a[1] + d[1] * t, a[2] + d[2] * t]
}

/// The intersection of a ray with the extended surface of a primitive.
#[derive(Clone, Copy)]
struct Crossing {
    t: f64,
    uv: [f64; 2],
    /// Distance inside the border, in the primitive's parameters; negative outside.
    inside: f64,
    /// The cosine of the angle between the ray and the normal.
    cosine: f64,
}

fn cross_triangle(ray: &Ray, t: &Triangle) -> Vec<Crossing> {
    let [a, b, c] = t.v.map(wide);
    let (o, d) = (wide(ray.o), wide(ray.d));
    let n = cross(sub(b, a), sub(c, a));
    let n2 = dot(n, n);
    let distance = dot(sub(a, o), n) / dot(d, n);
    let p = along(o, d, distance);
    let u = dot(cross(sub(p, a), sub(c, a)), n) / n2;
    let v = dot(cross(sub(b, a), sub(p, a)), n) / n2;
    let cosine = dot(d, n).abs() / (n2 * dot(d, d)).sqrt();
    vec![Crossing { t: distance, uv: [u, v], inside: u.min(v).min(1.0 - u - v), cosine }]
}

fn quadratic(a: f64, b: f64, c: f64) -> Vec<f64> {
    let root = (b * b - a * c).sqrt();
    vec![(b - root) / a, (b + root) / a]
}

fn cross_solid(ray: &Ray, solid: &Solid) -> Vec<Crossing> {
    let (o, d) = (wide(ray.o), wide(ray.d));
    match *solid {
        Solid::Sphere { center, radius } => {
            let (f, r) = (sub(o, wide(center)), f64::from(radius));
            let ts = quadratic(dot(d, d), -dot(f, d), dot(f, f) - r * r);
            let crossing = |t: f64| {
                let cosine = dot(along(f, d, t), d).abs() / (r * dot(d, d).sqrt());
                Crossing { t, uv: [0.0; 2], inside: 1.0, cosine }
            };
            ts.into_iter().filter(|t| !t.is_nan()).map(crossing).collect()
        }
        Solid::Disk { center, du, dv } => {
            let (c, du, dv) = (wide(center), wide(du), wide(dv));
            let n = cross(du, dv);
            let t = dot(sub(c, o), n) / dot(d, n);
            let p = sub(along(o, d, t), c);
            let a = dot(cross(p, dv), n) / dot(n, n);
            let b = dot(cross(du, p), n) / dot(n, n);
            let cosine = dot(d, n).abs() / (dot(n, n) * dot(d, d)).sqrt();
            vec![Crossing { t, uv: [a, b], inside: 1.0 - (a * a + b * b).sqrt(), cosine }]
        }
        Solid::Cylinder { p0, p1, radius } => {
            let (foot, axis, r) = (wide(p0), sub(wide(p1), wide(p0)), f64::from(radius));
            let across = |x: V| along(x, axis, -dot(x, axis) / dot(axis, axis));
            let (f, e) = (across(sub(o, foot)), across(d));
            let ts = quadratic(dot(e, e), -dot(f, e), dot(f, f) - r * r);
            let crossing = |t: f64| {
                let u = dot(sub(along(o, d, t), foot), axis) / dot(axis, axis);
                let cosine = dot(along(f, e, t), e).abs() / (r * dot(d, d).sqrt());
                Crossing { t, uv: [u, 0.0], inside: u.min(1.0 - u), cosine }
            };
            ts.into_iter().filter(|t| !t.is_nan()).map(crossing).collect()
        }
        Solid::Instance { .. } => unreachable!("instances are searched as moved triangles"),
    }
}

/// Everything in a scene: identifier, instance, and intersection function.
struct Scene {
    triangles: Vec<Triangle>,
    solids: Vec<(Solid, u32)>,
    /// Triangles of instances, transformed to the world.
    moved: Vec<(u32, Triangle)>,
}

impl Scene {
    fn crossings(&self, ray: &Ray) -> Vec<(u32, u32, Crossing)> {
        let none = Hit::NO_INSTANCE;
        let own = self
            .triangles
            .iter()
            .flat_map(|t| cross_triangle(ray, t).into_iter().map(|c| (t.id, none, c)));
        let plain = self.solids.iter().filter(|s| !matches!(s.0, Solid::Instance { .. }));
        let solids =
            plain.flat_map(|(s, id)| cross_solid(ray, s).into_iter().map(|c| (*id, none, c)));
        let moved = self
            .moved
            .iter()
            .flat_map(|(i, t)| cross_triangle(ray, t).into_iter().map(|c| (t.id, *i, c)));
        own.chain(solids).chain(moved).collect()
    }

    /// Whether a primitive is within the ray's interval, except for rounding.
    fn may_meet(&self, ray: &Ray, id: u32) -> bool {
        let within = |t: f64| t > f64::from(ray.tmin) - 1e-2 && t < f64::from(ray.tmax) + 1e-2;
        let near = |c: &Crossing| c.inside > -1e-2 && (within(c.t) || c.cosine < 1e-2);
        self.crossings(ray).iter().any(|(own, _, c)| *own == id && near(c))
    }

    /// Check a hit: it must be a real crossing, and no clear crossing may come before it.
    fn check(&self, ray: &Ray, hit: Option<Hit>) -> Result<(), String> {
        // Rounding error of t, and of u and v, in single precision, before division by the cosine.
        const ROUNDING: f64 = 2e-5;
        let (tmin, tmax) = (f64::from(ray.tmin), f64::from(ray.tmax));
        let slack = |c: &Crossing| {
            ROUNDING / c.cosine.max(1e-9) * (1.0 + 1.0 / dot(wide(ray.d), wide(ray.d)).sqrt())
        };
        let crossings = self.crossings(ray);
        let before = hit.map_or(tmax, |h| f64::from(h.t));
        for (id, instance, c) in &crossings {
            let clear = c.inside > 2e-3 && c.cosine > 0.01;
            if clear && c.t > tmin + slack(c) && c.t < before - slack(c) {
                return Err(format!(
                    "missed primitive {id} of {instance} at {} before {hit:?}",
                    c.t
                ));
            }
        }
        let Some(h) = hit else { return Ok(()) };
        if !(h.t > ray.tmin && h.t <= ray.tmax) {
            return Err(format!("{h:?} outside {tmin}..{tmax}"));
        }
        let explains = |c: &Crossing| {
            let near = (c.t - f64::from(h.t)).abs() <= slack(c) && c.inside > -100.0 * slack(c);
            let uv = |k: usize, x: f32| (c.uv[k] - f64::from(x)).abs() < 100.0 * slack(c);
            near && uv(0, h.u) && uv(1, h.v)
        };
        let explained =
            crossings.iter().any(|(id, i, c)| (*id, *i) == (h.prim, h.instance) && explains(c));
        if explained { Ok(()) } else { Err(format!("{h:?} is not a crossing")) }
    }
}

fn random_solid(rng: &mut Pcg, size: f32) -> Solid {
    let center = in_cube(rng);
    let radius = size * (0.1 + rng.next_f32());
    match rng.next_below(3) {
        0 => Solid::Sphere { center, radius },
        1 => Solid::Disk { center, du: in_cube(rng) * size, dv: in_cube(rng) * size },
        _ => Solid::Cylinder {
            p0: center,
            p1: center + in_cube(rng) * size * 3.0,
            radius: 0.3 * radius,
        },
    }
}

fn random_scene(rng: &mut Pcg, triangles: u32, solids: u32, instances: u32) -> Scene {
    let size = 1.5 / ((triangles + solids + 10 * instances).max(1) as f32).cbrt();
    let own = soup(rng, triangles, size);
    let mut all: Vec<(Solid, u32)> =
        (0..solids).map(|k| (random_solid(rng, 0.3 * size), 1000 + k)).collect();
    let mut moved = Vec::new();
    for index in 0..instances {
        let (inner, to_world) = (soup(rng, 10, 0.5), placement(rng));
        let tree = Arc::new(build(&inner));
        moved.extend(
            mapped(&inner, |p| to_world.transform_point3(p)).into_iter().map(|t| (index, t)),
        );
        all.push((Solid::Instance { tree, to_world, index }, 2000 + index));
    }
    Scene { triangles: own, solids: all, moved }
}

fn random_ray(rng: &mut Pcg) -> Ray {
    let length = [0.3, 1.0, 7.0][rng.next_below(3) as usize];
    let mut ray = Ray::new(in_cube(rng) * 1.5, on_sphere(rng) * length);
    if rng.next_below(3) == 0 {
        ray.tmin = rng.next_f32() / length;
    }
    if rng.next_below(3) == 0 {
        ray.tmax = ray.tmin + rng.next_f32() / length;
    }
    ray
}

fn compare(scenes: u64, rays: u32, shape: impl Fn(&mut Pcg) -> Scene) {
    let mut hits = 0;
    for seed in 0..scenes {
        let mut rng = Pcg::new(seed, 1);
        let scene = shape(&mut rng);
        let bvh = Bvh::build(&scene.triangles, &scene.solids).expect("sound input");
        let rays: Vec<Ray> = (0..rays).map(|_| random_ray(&mut rng)).collect();
        for_each_kernel(bvh, |bvh, isa| {
            for ray in &rays {
                let hit = bvh.closest(ray);
                hits += u32::from(hit.is_some());
                if let Err(e) = scene.check(ray, hit) {
                    panic!("scene {seed}, {isa:?}, {ray:?}: {e}");
                }
                let any = bvh.any(ray);
                assert!(
                    any.is_some() == hit.is_some() && any.is_none_or(|id| scene.may_meet(ray, id)),
                    "scene {seed}, {isa:?}, {ray:?}: {hit:?} but {any:?}"
                );
            }
        });
    }
    assert!(hits > 0, "no ray hit anything");
}

#[test]
fn triangles_agree_with_brute_force() {
    compare(1000, 50, |rng| {
        let count = 1 + rng.next_below(60);
        random_scene(rng, count, 0, 0)
    });
}

#[test]
fn many_triangles_agree_with_brute_force() {
    compare(3, 500, |rng| random_scene(rng, 6000, 0, 0));
}

#[test]
fn solids_agree_with_brute_force() {
    compare(600, 50, |rng| {
        let count = 1 + rng.next_below(40);
        random_scene(rng, 0, count, 0)
    });
}

#[test]
fn mixed_scenes_agree_with_brute_force() {
    compare(600, 50, |rng| {
        let (triangles, solids) = (rng.next_below(40), rng.next_below(20));
        let instances = 1 + rng.next_below(4);
        random_scene(rng, triangles, solids, instances)
    });
}

#[test]
fn all_kernels_report_the_same_hits() {
    for seed in 0..30 {
        let mut rng = Pcg::new(seed, 2);
        let scene = random_scene(&mut rng, 500, 50, 3);
        let rays: Vec<Ray> = (0..2000).map(|_| random_ray(&mut rng)).collect();
        let mut first: Option<Vec<Option<Hit>>> = None;
        let bvh = Bvh::build(&scene.triangles, &scene.solids).expect("sound input");
        for_each_kernel(bvh, |bvh, isa| {
            let hits: Vec<Option<Hit>> = rays.iter().map(|r| bvh.closest(r)).collect();
            let reference = first.get_or_insert_with(|| hits.clone());
            for ((a, b), ray) in reference.iter().zip(&hits).zip(&rays) {
                let same = match (a, b) {
                    (Some(a), Some(b)) => {
                        a.prim == b.prim
                            && a.instance == b.instance
                            && (a.t - b.t).abs() <= 1e-4 * (1.0 + a.t)
                    }
                    (a, b) => a.is_none() && b.is_none(),
                };
                assert!(same, "scene {seed}, {isa:?}, {ray:?}: {a:?} and {b:?}");
            }
        });
    }
}
