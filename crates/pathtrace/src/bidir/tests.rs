//! The weights of all ways to find a path sum to one.

use gi_core::bsdf::{Bsdf, Transport};
use gi_core::eye::{EyeEvent, EyeWalk, PathLimits};
use gi_core::film::Show;
use gi_core::filter::{Filter, FilterTable};
use gi_core::geometry::Surface;
use gi_core::light::{LightEnd, LightSample};
use gi_core::medium::MediumId;
use gi_core::rng::Pcg;
use gi_core::scene::Scene;
use gi_core::warp;
use gi_tests::World;
use glam::Vec3;

use super::light_paths::LightPaths;
use super::vertex::{Site, Vertex};
use super::weight::{self, Partials};
use super::{Bidirectional, Plan};
use crate::params::{Heuristic, Mode, Params};

/// A vertex of a path, without direction.
enum Point {
    Surface(Surface, Option<MediumId>),
    Medium(Vec3, MediumId),
}

impl Point {
    fn p(&self) -> Vec3 {
        match self {
            Point::Surface(surface, _) => surface.p,
            Point::Medium(p, _) => *p,
        }
    }

    /// Call `visit` with this vertex of a path that comes along `wo`.
    fn visit<R>(
        &self,
        scene: &Scene,
        (transport, wo): (Transport, Vec3),
        partials: Partials,
        visit: impl FnOnce(&Vertex) -> R,
    ) -> R {
        let bsdf: Bsdf;
        let site = match self {
            Point::Surface(surface, medium) => {
                bsdf = scene.bsdf(surface, wo, transport);
                Site::Surface { surface, bsdf: &bsdf, medium: *medium }
            }
            Point::Medium(p, medium) => Site::Medium { p: *p, medium: *medium },
        };
        let carried = gi_core::math::Rgb::WHITE;
        let (segments, non_delta) = (1, 0);
        visit(&Vertex { scene, site, transport, wo, carried, partials, segments, non_delta })
    }
}

/// A path: the lens, points, and a light.
struct Path {
    lens: Vec3,
    points: Vec<Point>,
    /// Whether the scattering at each point was by a delta lobe.
    delta: Vec<bool>,
    light: LightSample,
}

impl Path {
    /// Unit direction from point `k` to the next one on the way to the light.
    fn toward_light(&self, k: usize) -> Vec3 {
        match self.points.get(k + 1) {
            Some(next) => (next.p() - self.points[k].p()).normalize(),
            None => self.light.wi,
        }
    }

    /// Unit direction from point `k` to the next one on the way to the eye.
    fn toward_eye(&self, k: usize) -> Vec3 {
        let next = if k > 0 { self.points[k - 1].p() } else { self.lens };
        (next - self.points[k].p()).normalize()
    }

    fn distance_sq(&self, k: usize) -> f32 {
        self.points[k].p().distance_squared(self.points[k - 1].p())
    }

    /// The partials with which the subpath from the eye reaches each point, and those with which it leaves the last one.
    fn seen_from_eye(&self, of: &Bidirectional) -> (Vec<Partials>, Partials) {
        let scene = of.setting.scene;
        let (mut reached, mut leaving) = (Vec::new(), None::<Partials>);
        for (k, point) in self.points.iter().enumerate() {
            let (wo, wi) = (self.toward_eye(k), self.toward_light(k));
            let come = (Transport::Radiance, wo);
            let facing = point.visit(scene, come, Partials::default(), |v| v.facing(wo));
            let partials = match leaving {
                Some(leaving) => leaving.reach(&of.ways, facing, self.distance_sq(k)),
                None => {
                    let distance = self.lens.distance(point.p());
                    Partials::of_eye(&of.ways, of.setting.camera.importance(-wo, distance), facing)
                }
            };
            reached.push(partials);
            leaving = Some(point.visit(scene, come, partials, |v| {
                let pdf_w = (!self.delta[k]).then(|| v.f_cos_pdf(wi).1);
                of.leave(v, (wi, pdf_w))
            }));
        }
        (reached, leaving.expect("a point"))
    }

    /// The partials with which the subpath from the light reaches each point.
    fn seen_from_light(&self, of: &Bidirectional, end: &LightEnd) -> Vec<Partials> {
        let scene = of.setting.scene;
        let (mut reached, mut leaving) = (Vec::new(), None::<Partials>);
        for k in (0..self.points.len()).rev() {
            let (wo, wi) = (self.toward_light(k), self.toward_eye(k));
            let come = (Transport::Power, wo);
            let point = &self.points[k];
            let facing = point.visit(scene, come, Partials::default(), |v| v.facing(wo));
            let partials = match leaving {
                Some(leaving) => leaving.reach(&of.ways, facing, self.distance_sq(k + 1)),
                None => Partials::of_light(&of.ways, end, facing),
            };
            reached.push(partials);
            leaving = Some(point.visit(scene, come, partials, |v| {
                let pdf_w = (!self.delta[k]).then(|| v.f_cos_pdf(wi).1);
                of.leave(v, (wi, pdf_w))
            }));
        }
        reached.reverse();
        reached
    }

    /// Whether the path carries light as far as its last vertex is concerned; the others were sampled.
    fn carries(&self, of: &Bidirectional) -> bool {
        let last = self.points.len() - 1;
        let both = [
            ((Transport::Radiance, self.toward_eye(last)), self.light.wi),
            ((Transport::Power, self.light.wi), self.toward_eye(last)),
        ];
        both.into_iter().all(|(come, wi)| {
            self.points[last].visit(of.setting.scene, come, Partials::default(), |v| {
                let (f_cos, pdf_w) = v.f_cos_pdf(wi);
                !f_cos.is_black() && pdf_w > 0.0
            })
        })
    }

    /// The sum of the weights of all ways to find this path.
    fn sum_of_weights(&self, of: &Bidirectional) -> f32 {
        let scene = of.setting.scene;
        let last = self.points.len() - 1;
        let end = scene.lights().end_of_sample(&self.light, self.points[last].p());
        let (eye, leaving) = self.seen_from_eye(of);
        let light = self.seen_from_light(of, &end);
        let at = |k: usize, transport, partials: &[Partials], visit: &dyn Fn(&Vertex) -> f32| {
            let wo = match transport {
                Transport::Radiance => self.toward_eye(k),
                Transport::Power => self.toward_light(k),
            };
            self.points[k].visit(scene, (transport, wo), partials[k], visit)
        };
        // Direct light: scattered once, except by delta lobes on the eye's side.
        let direct = !self.delta[last] && self.delta[..last].iter().all(|delta| *delta);
        let mut sum = 0.0;
        if end.reach > 0.0 {
            sum += weight::hit_light(&of.ways, &leaving, &end, direct);
        }
        if !self.delta[last] {
            sum += at(last, Transport::Radiance, &eye, &|v| {
                let (wi, joint) = (self.light.wi, v.joint(self.light.wi, 1.0));
                weight::light_sample(&of.ways, &eye[last], &end, v.f_cos_pdf(wi).1, &joint, direct)
            });
        }
        if !self.delta[0] {
            sum += at(0, Transport::Power, &light, &|v| {
                let d = self.toward_eye(0);
                let importance =
                    of.setting.camera.importance(-d, self.lens.distance(self.points[0].p()));
                weight::camera(&of.ways, &light[0], &v.joint(d, importance), direct)
            });
        }
        for k in 0..last {
            if !self.delta[k] && !self.delta[k + 1] {
                let (d, distance_sq) = (self.toward_light(k), self.distance_sq(k + 1));
                sum += at(k, Transport::Radiance, &eye, &|z| {
                    at(k + 1, Transport::Power, &light, &|y| {
                        let ours = z.joint(d, y.f_cos_pdf(-d).1 / distance_sq);
                        let theirs = y.joint(-d, z.f_cos_pdf(d).1 / distance_sq);
                        weight::connection(&of.ways, (&eye[k], &ours), (&light[k + 1], &theirs))
                    })
                });
            }
        }
        for k in (0..=last).filter(|k| of.ways.merges > 0.0 && !self.delta[*k]) {
            sum += at(k, Transport::Radiance, &eye, &|z| {
                let wi = self.toward_light(k);
                let densities = [z.f_cos_pdf(wi).1, z.reverse_pdf_w(wi)];
                if z.merges() {
                    weight::merging(&of.ways, [&eye[k], &light[k]], densities, direct)
                } else {
                    0.0
                }
            });
        }
        sum
    }
}

/// Paths of a scene: walks from the eye, with a light sample at every vertex that can be connected.
fn paths(of: &Bidirectional, index: u32, mut take: impl FnMut(&Path)) {
    let (scene, mut rng) = (of.setting.scene, Pcg::new(3, u64::from(index)));
    let [w, h] = of.setting.camera.size();
    let pixel = [rng.next_below(w as u32) as usize, rng.next_below(h as u32) as usize];
    let mut walk = EyeWalk::through_pixel(&of.setting, of.limits, pixel, index);
    walk.use_media(of.camera_medium);
    let (lens, mut points, mut delta) = (walk.segment().o, Vec::new(), Vec::new());
    while let Some(event) = &walk.next_event() {
        let before = walk.segments();
        let (point, connects) = match event {
            EyeEvent::Surface(v) => (Point::Surface(v.surface, v.medium), !v.bsdf.is_delta()),
            EyeEvent::Medium(v) => (Point::Medium(v.p, v.medium), true),
        };
        let p = point.p();
        points.push(point);
        if connects && let Some(light) = scene.sample_light(p, rng.next_2d()) {
            let mut path = Path { lens, points, delta: [&delta[..], &[false]].concat(), light };
            take(&path);
            points = std::mem::take(&mut path.points);
        }
        let goes_on = match event {
            EyeEvent::Surface(v) => walk.scatter(v),
            EyeEvent::Medium(v) => walk.scatter_within(v),
        };
        if !goes_on {
            return;
        }
        if walk.segments() == before {
            // It passed straight through, which is no vertex of the path.
            points.pop();
        } else {
            delta.push(walk.turned().1.is_none());
        }
    }
}

#[test]
fn a_light_vertex_that_faces_away_scatters_nothing_in_that_direction() {
    for name in ["cornell-glossy.xml", "patio.xml", "lamp.xml", "gallery.xml"] {
        let world = World::load(name, [64, 64], &[]);
        let setting = world.setting(1, Show::All);
        let params = Params { mode: Mode::Bdpt, ..Params::default() };
        let of = Bidirectional::new(setting, &params, Plan::make(&setting, &params), 0);
        let paths = LightPaths::trace(&of, 0, &FilterTable::new(Filter::Box));
        let (mut rng, mut away, mut all) = (Pcg::new(5, 0), 0, 0);
        for vertex in (0..of.light_paths).flat_map(|path| paths.path(path)) {
            let d = warp::sphere(rng.next_2d());
            all += 1;
            if vertex.faces_away(d) {
                away += 1;
                let f_cos = vertex.visit(setting.scene, |v| v.f_cos_pdf(d).0);
                assert!(f_cos.is_black(), "{name}: {f_cos:?}");
            }
        }
        // Half of all directions lie behind an opaque surface.
        assert!(3 * away > all, "{name}: {away} of {all}");
    }
}

#[test]
fn the_weights_of_all_ways_to_find_a_path_sum_to_one() {
    for (name, least) in [
        ("cornell-glossy.xml", 3000),
        ("cornell-spheres.xml", 3000),
        ("patio.xml", 1500),
        ("bulb.xml", 1000),
        ("lamp.xml", 1500),
        ("gallery.xml", 3000),
        ("marble.xml", 1000),
    ] {
        let world = World::load(name, [64, 64], &[]);
        let setting = world.setting(1, Show::All);
        for mode in [Mode::Bdpt, Mode::Vcm] {
            for heuristic in [Heuristic::Balance, Heuristic::Power] {
                let limits = PathLimits { max_depth: Some(8), ..PathLimits::default() };
                let params = Params { mode, heuristic, limits, ..Params::default() };
                let of = Bidirectional::new(setting, &params, Plan::make(&setting, &params), 0);
                let (mut count, mut wrong, mut worst) = (0, 0, 0f32);
                for index in 0..1500 {
                    paths(&of, index, |path| {
                        if path.carries(&of) {
                            let sum = path.sum_of_weights(&of);
                            let error = (sum - 1.0).abs();
                            count += 1;
                            // Not a number is wrong too.
                            wrong += u32::from(error.is_nan() || error > 2e-2);
                            worst = worst.max(error);
                        }
                    });
                }
                println!(
                    "{name} {mode:?} {heuristic:?}: {count} paths, {wrong} off, worst {worst:.1e}"
                );
                assert!(count > least, "{name} {mode:?}: {count} paths");
                // Rounding of directions matters where lobes are narrow or points are close.
                assert!(wrong * 500 <= count, "{name} {mode:?} {heuristic:?}: {wrong} of {count}");
            }
        }
    }
}
