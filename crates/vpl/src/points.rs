//! Virtual point lights on light sources: direct light by many point lights [slides 53, 61].

use std::fmt::{Display, Formatter};

use gi_core::light::{Discrete, Light};
use gi_core::sampler::Sampler;
use gi_core::scene::Scene;

use crate::light::{Vpl, Vpls};

/// Numbers of points on extended light sources. A light source without extent is always one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightNumbers {
    /// Points on all kinds without a number of their own, distributed by power.
    pub total: u32,
    /// Points on area lights.
    pub area: Option<u32>,
    /// Directions of environments.
    pub sky: Option<u32>,
    /// Directions of discs at infinity.
    pub sun: Option<u32>,
}

/// Print in the option's syntax: `4096,sky=1000`.
impl Display for LightNumbers {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        let LightNumbers { total, area, sky, sun } = self;
        write!(f, "{total}")?;
        let kinds = [("area", area), ("sky", sky), ("sun", sun)];
        let given = kinds.iter().filter_map(|(kind, number)| Some((kind, number.as_ref()?)));
        given.into_iter().try_for_each(|(kind, number)| write!(f, ",{kind}={number}"))
    }
}

/// Separates the random numbers of points from those of paths.
const SALT: u32 = 0x706f_696e;

/// Light sources of one kind, and their sampling weights.
struct Group {
    lights: Vec<usize>,
    by_power: Discrete,
    asked: Option<u32>,
}

/// A part of a sequence of samples.
#[derive(Clone, Copy)]
struct SampleRange {
    seed: u32,
    first: u32,
    count: u32,
}

impl Group {
    fn new(scene: &Scene, asked: Option<u32>, is: impl Fn(&Light) -> bool) -> Self {
        let all = scene.lights();
        let kind = all.all().iter().enumerate().filter(|(_, l)| is(l));
        let lights: Vec<usize> = kind.map(|(k, _)| k).collect();
        let by_power = Discrete::new(lights.iter().map(|&k| all.probability(k)));
        Group { lights, by_power, asked }
    }

    /// Sample points `first..first + count` of the sequence; each has 1 / count of the power.
    fn draw(&self, scene: &Scene, range: SampleRange, out: &mut Vec<Vpl>) {
        let SampleRange { seed, first, count } = range;
        for i in 0..count {
            let mut sampler = Sampler::new(seed ^ SALT, 0, first.wrapping_add(i));
            let (u, u_p, u_d) = (sampler.next_1d(), sampler.next_2d(), sampler.next_2d());
            // One sample per part of the unit interval: with as many points as equal lights, each light gets one.
            let u = ((i as f32 + u) / count as f32).min(1.0 - f32::EPSILON);
            let Some((k, probability, _)) = self.by_power.sample(u) else { return };
            let emission = scene.emit_from((self.lights[k], probability), u_p, u_d);
            out.extend(emission.map(|e| Vpl::of_emission(scene, &e, count as f32)));
        }
    }
}

/// Sample points on all light sources. Set `index` continues the sequence of the sets before it.
pub fn points(scene: &Scene, numbers: &LightNumbers, seed: u32, index: u32) -> Vpls {
    let groups = [
        Group::new(scene, numbers.area, |l| matches!(l, Light::Area { .. })),
        Group::new(scene, numbers.sky, |l| {
            matches!(l, Light::Environment(_) | Light::Constant { .. })
        }),
        Group::new(scene, numbers.sun, |l| matches!(l, Light::DistantDisc { .. })),
    ];
    let power = |g: &Group| if g.asked.is_none() { g.by_power.total() } else { 0.0 };
    let shared: f64 = groups.iter().map(power).sum();
    let mut set = Vpls::default();
    for group in groups.iter().filter(|g| g.by_power.total() > 0.0) {
        let share = || (f64::from(numbers.total) * power(group) / shared).round().max(1.0) as u32;
        let count = group.asked.unwrap_or_else(share);
        let range = SampleRange { seed, first: index.wrapping_mul(count), count };
        group.draw(scene, range, &mut set.lights);
    }
    let without_extent = |l: &Light| {
        matches!(l, Light::Point { .. } | Light::Spot { .. } | Light::Directional { .. })
    };
    for (k, _) in scene.lights().all().iter().enumerate().filter(|(_, l)| without_extent(l)) {
        let emission = scene.emit_from((k, 1.0), [0.5; 2], [0.5; 2]);
        set.lights.extend(emission.map(|e| Vpl::of_emission(scene, &e, 1.0)));
    }
    set.lights.retain(|v| !v.power.is_black());
    set
}
