//! Translucent solids by the diffusion dipole, as an alternative to photons in the medium [slide 34].
//!
//! Photons are stored where they enter a solid body. The exitance at x is
//!
//! B(x) = sum over those photons of R_d(|x - p|) power   [Jensen01b; clusters: Jensen02]
//!
//! where R_d is the diffuse reflectance of a half-space of the medium at that distance from the point of entry. The radiance outside
//! is L(wo) = (1 - F(wo)) / (1 - F) B / pi, with the Fresnel reflectance F(wo) and its hemispherical mean F. An eye path refracts
//! into the body and finds the radiance B / (pi (1 - F_in)) there.
//!
//! F is that of the boundary alone. Light that glass beyond the boundary reflects enters the body again.
//!
//! B includes all scattered light, and counts as indirect light. Photons still walk through the medium: light that leaves the body
//! toward other surfaces is exact in their maps. Gather rays that hit the body use the dipole.
//!
//! Bias: the dipole assumes a flat half-space. Thin, convex or backlit parts are too dark. Light after few scatterings is lost (peaked
//! phase functions, shadow edges). Absorption must be small compared to scattering. A ball of 40 mean free paths in uniform light
//! is 8 % too bright at an albedo of 0.9, 8 % too dark at 0.99 and 9 % too dark at 0.999.

mod entries;
mod profile;

use gi_core::medium::MediumId;
use std::collections::BTreeMap;

use gi_core::eye::{Beam, Entrance};
use gi_core::math::Rgb;
use gi_core::medium::first_equal;
use gi_core::scene::Scene;
use gi_core::walk::LightEvent;
use glam::Vec3;

use crate::photon::Rgbe;
use crate::shoot::{Chunk, Hits, Source, Step, Wanted, collect, dither, paths};
use crate::solids::{Bodies, Solids};
use entries::{Entries, Entry};
use profile::Dipole;

/// Rounding of powers has random numbers of its own.
const STREAM: u32 = 0x6469_706f;

/// The photons that entered the solid bodies of a scene.
pub(crate) struct Dipoles {
    bodies: Bodies,
    /// By body and medium.
    entries: BTreeMap<Body, Entries>,
    /// Paths begun.
    emitted: u64,
    gave_up: bool,
}

/// A body: one of its primitives, and its medium (the first of equal media).
type Body = (u32, MediumId);

fn body(scene: &Scene, bodies: &Bodies, prim: u32, medium: MediumId) -> Body {
    (bodies.body(prim), first_equal(scene.media(), medium))
}

impl Dipoles {
    /// Trace photons until `count` have entered solids that contain no lights.
    pub(crate) fn shoot(source: &Source, solids: &Solids, count: usize) -> Self {
        let (scene, bodies) = (source.scene, Bodies::of(source.scene));
        let Hits { chunks, emitted, gave_up } = collect(count, |_, k| chunk(source, solids, k));
        let share = (1.0 / emitted.max(1) as f64) as f32;
        let mut entries: BTreeMap<Body, Vec<Entry>> = BTreeMap::new();
        for (k, Entering { prim, medium, p, power, depth }) in
            chunks.into_iter().flatten().enumerate()
        {
            let power = Rgbe::dithered(power * share, dither(source.seed ^ STREAM, k));
            let entry = Entry { position: p.to_array(), power, depth };
            entries.entry(body(scene, &bodies, prim, medium)).or_default().push(entry);
        }
        let entries = entries.into_iter().map(|(body, e)| (body, Entries::build(e))).collect();
        Dipoles { bodies, entries, emitted, gave_up }
    }

    /// Radiance of diffused light of at most `depth` segments where a beam enters a solid body. A beam that was reflected inside gets
    /// none: the light was added where the path entered.
    pub(crate) fn radiance(&self, scene: &Scene, beam: &Beam, depth: u8) -> Rgb {
        let Some(Entrance { prim, eta }) = beam.entered else { return Rgb::BLACK };
        let body = body(scene, &self.bodies, prim, beam.medium);
        let Some(entries) = self.entries.get(&body) else { return Rgb::BLACK };
        let dipole = Dipole::new(scene.medium(beam.medium), eta);
        dipole.radiance_inside(entries.exitance(beam.ray.o, &dipole, depth))
    }

    /// What is worth knowing.
    pub(crate) fn statistics(&self) -> Vec<(String, f64)> {
        let sum = |what: fn(&Entries) -> usize| self.entries.values().map(what).sum::<usize>();
        [
            ("dipole_photons", sum(Entries::len) as f64),
            ("dipole_paths", self.emitted as f64),
            ("dipole_bytes", sum(Entries::bytes) as f64),
            ("dipole_bodies", self.entries.len() as f64),
            ("dipole_gave_up", f64::from(u8::from(self.gave_up))),
        ]
        .map(|(name, value)| (name.to_string(), value))
        .to_vec()
    }
}

/// A photon that enters a body, before it is packed: its power is not yet divided by the number of paths.
struct Entering {
    prim: u32,
    medium: MediumId,
    p: Vec3,
    power: Rgb,
    depth: u8,
}

/// The photons of a chunk of paths that enter solid bodies.
fn chunk(source: &Source, solids: &Solids, chunk: u64) -> Chunk<Entering> {
    let mut out = Chunk::new();
    for path in paths(chunk) {
        source.walk(Wanted::Volume, path, &mut |step| {
            out.hits.extend(entering(&step).filter(|e| solids.is_dark(e.medium)));
        });
        out.end_path(None);
    }
    out
}

/// The photon of a step that enters a medium from outside.
fn entering(step: &Step) -> Option<Entering> {
    let (LightEvent::Surface(vertex), Some(walk)) = (step.event, step.after) else { return None };
    let (medium, power) = (walk.medium()?, walk.power());
    let enters = vertex.medium != Some(medium) && power.is_finite();
    let depth = (vertex.depth + 2).min(255) as u8;
    let (prim, p) = (vertex.surface.prim, vertex.surface.p);
    enters.then_some(Entering { prim, medium, p, power, depth })
}
