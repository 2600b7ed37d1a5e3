//! The table of all lights. Its file is long because each method of a light is one match over all kinds of light.

use std::f32::consts::PI;
use std::sync::OnceLock;

use glam::{Mat3, Vec3};

use super::{Discrete, Emitter, EmitterPoint, Environment, LightSource, LightTree, Slide, Vantage};
use crate::geometry::{Geometry, Shape};
use crate::math::{Frame, Rgb, one_minus_cos, sqr};
use crate::warp;

/// A light, prepared for sampling.
#[derive(Clone, Debug)]
pub enum Light {
    /// A primitive of a shape.
    Area {
        /// Its geometry.
        emitter: Emitter,
        /// Index of the shape whose emission it has.
        shape: u32,
        /// Index of the primitive in the shape.
        primitive: u32,
    },
    /// A point.
    Point {
        /// Position.
        position: Vec3,
        /// Power per steradian.
        intensity: Rgb,
    },
    /// A cone of light from a point.
    Spot {
        /// Position.
        position: Vec3,
        /// Frame whose normal is the axis.
        frame: Frame,
        /// Power per steradian inside the beam.
        intensity: Rgb,
        /// Half angle of the cone, radians.
        cutoff: f32,
        /// Half angle of full intensity, radians.
        beam: f32,
        /// The picture in front of it.
        slide: Option<Box<Slide>>,
    },
    /// Parallel light.
    Directional {
        /// Frame whose normal is the direction in which the light travels.
        frame: Frame,
        /// Irradiance on a plane perpendicular to it.
        irradiance: Rgb,
    },
    /// The same radiance from all directions.
    Constant {
        /// Radiance.
        radiance: Rgb,
    },
    /// A picture at infinity.
    Environment(Box<Environment>),
    /// A disc at infinity.
    DistantDisc {
        /// Frame whose normal points to its centre.
        frame: Frame,
        /// 1 - cos of its angular radius.
        one_minus_cos: f32,
        /// Radiance.
        radiance: Rgb,
    },
}

/// Light that arrives at a point from a sampled light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction toward the light.
    pub wi: Vec3,
    /// Position of the light; `None` at infinity.
    pub p: Option<Vec3>,
    /// Radiance that arrives if nothing is in between. For point and directional lights: irradiance on a plane
    /// perpendicular to `wi`.
    pub radiance: Rgb,
    /// Density per solid angle, including the probability of the light; for point and directional lights, the
    /// probability alone.
    pub pdf_w: f32,
    /// Whether other sampling strategies cannot find this light.
    pub delta: bool,
    /// The emitting primitive and its shape, if the light is a surface.
    pub primitive: Option<[u32; 2]>,
    /// Index of the light.
    pub light: u32,
    /// Unit geometric normal at `p` if the light is a surface, else the direction in which the light travels.
    pub ng: Vec3,
    /// Index of an environment map whose radiance is not yet looked up: it is still a factor on `radiance`.
    pub(crate) map: Option<u32>,
}

impl LightSample {
    /// Light that arrives at `p` from a point with this intensity; none at the point itself.
    #[inline]
    fn of_point(light: u32, p: Vec3, position: Vec3, intensity: Rgb) -> Option<Self> {
        let to = position - p;
        let distance_sq = to.length_squared();
        let wi = to / distance_sq.sqrt();
        (distance_sq > 0.0).then(|| LightSample {
            wi,
            p: Some(position),
            radiance: intensity / distance_sq,
            pdf_w: 1.0,
            delta: true,
            primitive: None,
            light,
            ng: -wi,
            map: None,
        })
    }
}

/// All lights of a scene.
#[derive(Clone, Debug, Default)]
pub struct Lights {
    lights: Vec<Light>,
    by_power: Discrete,
    /// For each shape, its first light, if it emits light.
    first_of_shape: Vec<Option<u32>>,
    /// Indices of the lights at infinity.
    distant: Vec<u32>,
    /// Centre and radius of the scene, for light from outside.
    pub(super) sphere: (Vec3, f32),
    /// Built when it is needed.
    tree: OnceLock<LightTree>,
    /// Whether there are so many lights that the tree chooses better than power.
    are_many: bool,
}

/// With more lights than this at finite distance, the light tree chooses. With 8 lamps, power has half the error in direct
/// light and twice the error in all light; with 128 lamps, the tree is better in both.
const MANY: usize = 32;

impl Lights {
    pub(crate) fn new(shapes: &[Shape], sources: Vec<LightSource>, sphere: (Vec3, f32)) -> Self {
        let mut lights = Vec::new();
        let mut first_of_shape = Vec::with_capacity(shapes.len());
        for (k, shape) in shapes.iter().enumerate() {
            let shines = shape.emission.as_ref().is_some_and(|e| !e.is_black());
            first_of_shape.push(shines.then_some(lights.len() as u32));
            if shines {
                push_area(&mut lights, k as u32, shape);
            }
        }
        let mut distant = Vec::new();
        for source in sources {
            let light = Light::from_source(source);
            if light.is_distant() {
                distant.push(lights.len() as u32);
            }
            lights.push(light);
        }
        let by_power = Discrete::new(lights.iter().map(|l| l.power(shapes, sphere.1)));
        let tree = OnceLock::new();
        let are_many = lights.iter().filter(|l| !l.is_infinite()).count() > MANY;
        let lights = Lights { lights, by_power, first_of_shape, distant, sphere, tree, are_many };
        if are_many {
            lights.tree(shapes);
        }
        lights
    }

    /// The tree of all lights, which is built at the first call.
    pub(crate) fn tree(&self, shapes: &[Shape]) -> &LightTree {
        self.tree.get_or_init(|| {
            let radius = self.sphere.1;
            let power = |light: &Light| light.power(shapes, radius);
            LightTree::new(&self.lights, shapes, power, PI * sqr(radius))
        })
    }

    /// A copy of the tree that learns during rendering.
    pub(crate) fn learning_tree(&self, shapes: &[Shape]) -> LightTree {
        self.tree(shapes).learning(self.sphere)
    }

    /// The tree of all lights if there are many.
    pub(crate) fn tree_of_many(&self) -> Option<&LightTree> {
        if self.are_many { self.tree.get() } else { None }
    }

    /// Centre and radius of the scene.
    pub(crate) fn sphere(&self) -> (Vec3, f32) {
        self.sphere
    }

    /// All lights in order.
    pub fn all(&self) -> &[Light] {
        &self.lights
    }

    /// Probability of a light if lights are chosen by power.
    pub fn probability(&self, light: usize) -> f32 {
        self.by_power.probability(light)
    }

    /// Whether nothing emits light.
    pub fn is_empty(&self) -> bool {
        self.by_power.is_empty()
    }

    /// Sample a light in proportion to its power. Returns its index, its probability, and `u` rescaled for further use.
    #[inline]
    pub(crate) fn choose(&self, u: f32) -> Option<(usize, f32, f32)> {
        self.by_power.sample(u)
    }

    /// Choose a light for a point. Returns its index, its probability, and the first random number rescaled for further
    /// use.
    #[inline]
    pub(crate) fn choose_for(&self, at: &Vantage, u: [f32; 2]) -> Option<(usize, f32, f32)> {
        match at.tree {
            Some(tree) => tree.choose(at, u),
            None => self.choose(u[0]),
        }
    }

    /// Probability with which [`Lights::choose_for`] chooses a light.
    #[inline]
    pub(crate) fn probability_for(&self, at: &Vantage, light: usize) -> f32 {
        match at.tree {
            Some(tree) => tree.probability(at, light),
            None => self.probability(light),
        }
    }

    /// The lights at infinity.
    pub(crate) fn distant(&self) -> impl Iterator<Item = (usize, &Light)> {
        self.distant.iter().map(|&k| (k as usize, &self.lights[k as usize]))
    }

    /// The index of the light of primitive `primitive` of shape `shape`, if it emits light.
    #[inline]
    pub fn of_primitive(&self, shape: u32, primitive: u32) -> Option<usize> {
        self.first_of_shape[shape as usize].map(|first| (first + primitive) as usize)
    }

    /// Factor on the radiance of a light sample that is not yet looked up: see [`LightSample::map`].
    #[inline]
    pub(crate) fn looked_up(&self, sample: &LightSample) -> Rgb {
        match sample.map.map(|k| &self.lights[k as usize]) {
            Some(Light::Environment(map)) => map.radiance(sample.wi),
            _ => Rgb::WHITE,
        }
    }

    /// Light that arrives at `p` from light `light`; its density per solid angle does not include the probability of
    /// the light. `emission` evaluates a shape's radiance at a point of one of its primitives. Environment maps are not
    /// looked up.
    #[inline]
    pub(crate) fn sample_light(
        &self,
        light: usize,
        p: Vec3,
        u: [f32; 2],
        emission: impl Fn(u32, u32, &EmitterPoint) -> Rgb,
    ) -> Option<LightSample> {
        let index = light as u32;
        let distant = |wi: Vec3, radiance, pdf_w| {
            let (delta, primitive, light, map) = (false, None, index, None);
            let ng = -wi;
            Some(LightSample { wi, p: None, radiance, pdf_w, delta, primitive, light, ng, map })
        };
        match &self.lights[light] {
            Light::Area { emitter, shape, primitive } => {
                let (point, pdf_w) = emitter.sample_from(p, u)?;
                let wi = (point.p - p).try_normalize()?;
                let radiance = emission(*shape, *primitive, &point);
                let primitive = Some([*shape, *primitive]);
                let (p, ng, delta, map) = (Some(point.p), point.normal, false, None);
                let light = index;
                Some(LightSample { wi, p, radiance, pdf_w, delta, primitive, light, ng, map })
            }
            Light::Point { position, intensity } => {
                LightSample::of_point(index, p, *position, *intensity)
            }
            Light::Spot { position, intensity, .. } => {
                let d = (p - *position).normalize_or_zero();
                let intensity = *intensity * self.lights[light].spot_fade(d);
                LightSample::of_point(index, p, *position, intensity)
            }
            Light::Directional { frame, irradiance } => Some(LightSample {
                wi: -frame.n,
                p: None,
                radiance: *irradiance,
                pdf_w: 1.0,
                delta: true,
                primitive: None,
                light: index,
                ng: frame.n,
                map: None,
            }),
            Light::Constant { radiance } => distant(warp::sphere(u), *radiance, warp::sphere_pdf()),
            Light::Environment(map) => {
                let (wi, pdf_w) = map.sample(u)?;
                let sample = distant(wi, Rgb::WHITE, pdf_w)?;
                Some(LightSample { map: Some(light as u32), ..sample })
            }
            Light::DistantDisc { frame, one_minus_cos, radiance } => {
                let wi = frame.to_world(warp::cone(u, *one_minus_cos));
                distant(wi, *radiance, warp::cone_pdf(*one_minus_cos))
            }
        }
    }
}

impl Light {
    fn from_source(source: LightSource) -> Self {
        match source {
            LightSource::Point { position, intensity } => Light::Point { position, intensity },
            LightSource::Spot { position, direction, intensity, cutoff, beam } => Light::Spot {
                position,
                frame: Frame::from_normal(direction),
                intensity,
                cutoff,
                beam,
                slide: None,
            },
            LightSource::Projector { position, axes, intensity, cutoff, beam, picture, window } => {
                Light::Spot {
                    position,
                    frame: Frame::from_normal(axes[2].normalize_or(Vec3::Z)),
                    intensity,
                    cutoff,
                    beam,
                    slide: Some(Box::new(Slide::new(picture, axes, cutoff, window))),
                }
            }
            LightSource::Directional { direction, irradiance } => {
                Light::Directional { frame: Frame::from_normal(direction), irradiance }
            }
            LightSource::Constant { radiance } => Light::Constant { radiance },
            LightSource::Environment { image, scale, to_world } => {
                // Only the rotation of the map matters: light at infinity has no scale.
                let m = Mat3::from(to_world.matrix3);
                let rotation = Mat3::from_cols(
                    m.x_axis.normalize(),
                    m.y_axis.normalize(),
                    m.z_axis.normalize(),
                );
                Light::Environment(Box::new(Environment::new(image, scale, rotation)))
            }
            LightSource::DistantDisc { direction, angular_radius, radiance } => {
                let one_minus_cos = one_minus_cos(angular_radius);
                Light::DistantDisc { frame: Frame::from_normal(direction), one_minus_cos, radiance }
            }
        }
    }

    /// Whether the light is at infinity and visible to rays that leave the scene.
    fn is_distant(&self) -> bool {
        matches!(self, Light::Constant { .. } | Light::Environment(_) | Light::DistantDisc { .. })
    }

    /// Whether its light comes from outside the scene.
    pub fn is_infinite(&self) -> bool {
        self.is_distant() || matches!(self, Light::Directional { .. })
    }

    /// Radiance of a light at infinity from direction `d`, and the density per solid angle of sampling that direction.
    #[inline]
    pub(crate) fn escaped(&self, d: Vec3) -> (Rgb, f32) {
        match self {
            Light::Constant { radiance } => (*radiance, warp::sphere_pdf()),
            Light::Environment(map) => (map.radiance(d), map.pdf_w(d)),
            // Compute 1 - cos as half the squared distance of unit vectors, which is accurate for a narrow disc.
            Light::DistantDisc { frame, one_minus_cos, radiance }
                if 0.5 * d.distance_squared(frame.n) <= *one_minus_cos =>
            {
                (*radiance, warp::cone_pdf(*one_minus_cos))
            }
            _ => (Rgb::BLACK, 0.0),
        }
    }

    /// Intensity of a spot within its beam, averaged over its picture, as luminance; 0 for other lights.
    pub(super) fn mean_intensity(&self) -> f32 {
        let Light::Spot { intensity, cutoff, beam, slide, .. } = self else { return 0.0 };
        let mean = |slide: &Slide| slide.mean(spot_angle(*cutoff, *beam));
        (*intensity * slide.as_deref().map_or(Rgb::WHITE, mean)).luminance()
    }

    /// Emitted power as luminance; for lights at infinity, the power that falls on the scene's bounding sphere.
    fn power(&self, shapes: &[Shape], scene_radius: f32) -> f32 {
        let disc = PI * sqr(scene_radius);
        match self {
            Light::Area { emitter, shape, .. } => {
                let radiance =
                    shapes[*shape as usize].emission.as_ref().map_or(Rgb::BLACK, |e| e.mean());
                PI * emitter.area() * radiance.luminance().max(0.0)
            }
            Light::Point { intensity, .. } => 4.0 * PI * intensity.luminance(),
            Light::Spot { cutoff, beam, .. } => spot_angle(*cutoff, *beam) * self.mean_intensity(),
            Light::Directional { irradiance, .. } => disc * irradiance.luminance(),
            Light::Constant { radiance } => disc * 4.0 * PI * radiance.luminance(),
            Light::Environment(map) => disc * map.flux(),
            Light::DistantDisc { one_minus_cos, radiance, .. } => {
                disc * 2.0 * PI * one_minus_cos * radiance.luminance()
            }
        }
    }
}

/// The solid angle over which a spot of full intensity would emit the same power.
fn spot_angle(cutoff: f32, beam: f32) -> f32 {
    PI * (one_minus_cos(cutoff) + one_minus_cos(beam))
}

/// Full inside the beam, then linear in the angle to zero at the cutoff.
#[inline]
pub(super) fn spot_fade(d: Vec3, axis: Vec3, cutoff: f32, beam: f32) -> f32 {
    // The angle between unit vectors by their distance, which is exact for narrow spots too.
    let angle = 2.0 * (0.5 * d.distance(axis)).min(1.0).asin();
    if angle <= beam {
        1.0
    } else if angle >= cutoff {
        0.0
    } else {
        (cutoff - angle) / (cutoff - beam)
    }
}

/// Add one light for each primitive of an emitting shape.
fn push_area(lights: &mut Vec<Light>, k: u32, shape: &Shape) {
    let outward = !shape.flip_normals;
    let oriented = |n: Vec3| if outward { n } else { -n };
    let mut push = |emitter, primitive| lights.push(Light::Area { emitter, shape: k, primitive });
    match &shape.geometry {
        Geometry::Mesh(mesh) => {
            for t in 0..mesh.triangles.len() {
                let face = mesh.oriented_normal(t);
                push(Emitter::triangle(mesh.corners(t), oriented(face)), t as u32);
            }
        }
        Geometry::Sphere { center, radius, .. } => {
            push(Emitter::Sphere { center: *center, radius: *radius, outward }, 0);
        }
        Geometry::Disk { center, du, dv } => {
            let normal = oriented(du.cross(*dv).normalize_or_zero());
            push(Emitter::Disk { center: *center, axes: [*du, *dv], normal }, 0);
        }
        Geometry::Cylinder { p0, p1, radius } => {
            push(Emitter::Cylinder { ends: [*p0, *p1], radius: *radius, outward }, 0);
        }
    }
}
