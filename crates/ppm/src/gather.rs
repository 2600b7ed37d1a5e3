//! Gather photons at a point: the radiance that they contribute toward the eye.

use std::f64::consts::PI;

use gi_core::bsdf::Bsdf;
use gi_core::disc::Disc;
use gi_core::eye::Covers;
use gi_core::geometry::Surface;
use gi_core::math::Rgb;
use gi_core::scene::Scene;
use glam::Vec3;

use crate::photons::{Arrival, Photons, SAME_SURFACE};
use crate::statistics::Pass;
use gi_core::walk::PhotonKind;

/// A gather point.
pub(crate) struct Point<'p, 'a> {
    pub(crate) surface: &'p Surface,
    /// Unit direction toward the eye.
    pub(crate) wo: Vec3,
    pub(crate) bsdf: &'p Bsdf<'a>,
    /// The scattering that photons cover.
    pub(crate) covers: Covers,
    /// Maximum number of segments of a photon.
    pub(crate) max_segments: Option<u32>,
    /// What one unit of radiance here adds to the picture.
    pub(crate) throughput: Rgb,
}

/// The radii of gathering, world units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Discs {
    pub(crate) radius: f32,
    /// Radius of the kernel for second derivatives, if they are needed.
    pub(crate) derivative: Option<f32>,
}

/// The result of gathering.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Gathered {
    /// Number of photons that contribute: they lie on this surface, and f is not zero.
    pub(crate) photons: u64,
    /// The farthest of these: position, side of the surface, and squared distance.
    farthest: Option<(Vec3, f32, f32)>,
    /// Whether photons of another surface lie within the radius.
    has_others: bool,
    /// Sums of f times power, by the kind of path.
    pub(crate) direct: Rgb,
    pub(crate) indirect: Rgb,
    pub(crate) caustic: Rgb,
    /// Luminance weighted by the throughput, from the disc of the derivative: the Laplacian of the radiance over the
    /// surface, and the density of squared contributions.
    pub(crate) laplacian: f64,
    pub(crate) squares: f64,
}

impl Gathered {
    /// Add the result at another point, weighted by the throughput there.
    pub(crate) fn add(&mut self, other: &Gathered, throughput: Rgb) {
        self.photons += other.photons;
        self.direct += throughput * other.direct;
        self.indirect += throughput * other.indirect;
        self.caustic += throughput * other.caustic;
        self.laplacian += other.laplacian;
        self.squares += other.squares;
    }

    /// As [`Pass`] for the statistics.
    pub(crate) fn pass(&self) -> Pass {
        let flux = (self.direct + self.indirect + self.caustic).to_array().map(f64::from);
        Pass { photons: self.photons, flux }
    }
}

/// Which scattering photons cover: all but delta lobes if no lobe is narrower than `min_roughness`, else the Lambertian
/// part. `None` where there is none: paths continue there.
pub(crate) fn covers(bsdf: &Bsdf, wo: Vec3, min_roughness: f32) -> Option<Covers> {
    if bsdf.roughness() >= min_roughness {
        Some(Covers::NonDelta)
    } else {
        bsdf.diffuse_part(wo).map(Covers::Diffuse)
    }
}

/// Gather only the photons on the visible part of the disc, as seen from just above the point, and scale the flux from
/// the area of that part to that of the disc. `u` gives uniform points.
///
/// Usually this costs one shadow ray to the farthest photon and one probe at a random point of the disc. If either
/// fails, or photons of another surface lie within the radius, the visibility of every photon is tested.
pub(crate) fn gather_seen(
    scene: &Scene,
    grid: &Photons,
    point: &Point,
    discs: Discs,
    u: impl FnMut() -> [f32; 2],
) -> Gathered {
    let all = gather(grid, point, discs);
    let Some((farthest, side, _)) = all.farthest else { return all };
    let Surface { p, ng, .. } = *point.surface;
    let disc = |side: f32| Disc::new(scene, p, ng * side, discs.radius, SAME_SURFACE);
    let inverse_share = disc(1f32.copysign(point.wo.dot(ng))).inverse_share(u);
    let is_clear = inverse_share == 1.0 && !all.has_others && disc(side).sees(farthest);
    let mut seen = all;
    if !is_clear {
        let [above, below] = [1.0, -1.0].map(|side| disc(side).lowered());
        seen = gather_where(grid, point, discs, |q, side| {
            if side > 0.0 { above.sees(q) } else { below.sees(q) }
        });
    }
    for flux in [&mut seen.direct, &mut seen.indirect, &mut seen.caustic] {
        *flux *= inverse_share;
    }
    seen
}

/// Gather at a point.
pub(crate) fn gather(grid: &Photons, point: &Point, discs: Discs) -> Gathered {
    gather_where(grid, point, discs, |_, _| true)
}

/// Gather the photons whose position and side `takes` accepts (side 1 is that of the geometric normal).
#[inline]
fn gather_where(
    grid: &Photons,
    point: &Point,
    discs: Discs,
    takes: impl Fn(Vec3, f32) -> bool,
) -> Gathered {
    let Point { bsdf, wo, surface, .. } = *point;
    let whole = |wi: Vec3| bsdf.f(wo, wi);
    match point.covers {
        // The usual case.
        Covers::NonDelta | Covers::Visible { .. } if bsdf.is_diffuse() => {
            match bsdf.diffuse_part(wo) {
                Some(part) if part.normal.dot(surface.ns()).abs() > 1.0 - 1e-6 => {
                    let f = part.albedo * gi_core::math::INV_PI;
                    let above = |a: &Arrival| a.wi.dot(part.normal) > 0.0;
                    sum(grid, point, discs, takes, |a| if above(a) { f } else { Rgb::BLACK })
                }
                Some(_) => sum(grid, point, discs, takes, |a| whole(a.wi)),
                // A black surface, or the back of a surface that scatters only on its front.
                None => Gathered::default(),
            }
        }
        Covers::NonDelta | Covers::Visible { .. } => {
            sum(grid, point, discs, takes, |a| whole(a.wi))
        }
        // Gather exactly the part of the scattering that the continued path leaves out.
        Covers::Diffuse(part) => sum(grid, point, discs, takes, |a| {
            let left = bsdf.beside_diffuse(&part, wo, a.wi);
            whole(a.wi) * (Rgb::WHITE - left)
        }),
    }
}

/// Sum over the accepted photons within the radius. `f` is the BSDF.
#[inline]
fn sum(
    grid: &Photons,
    point: &Point,
    discs: Discs,
    takes: impl Fn(Vec3, f32) -> bool,
    f: impl Fn(&Arrival) -> Rgb,
) -> Gathered {
    let mut out = Gathered::default();
    let ng = point.surface.ng;
    let radius_sq = discs.radius * discs.radius;
    let derivative_sq = discs.derivative.map(|h| h * h);
    let reach = discs.derivative.map_or(discs.radius, |h| h.max(discs.radius));
    grid.within(point.surface.p, reach, |q, arrival, distance_sq| {
        let too_long = point.max_segments.is_some_and(|most| arrival.segments > most);
        // If photons cover only a part of the scattering, direct light is sampled.
        let sampled =
            arrival.kind == PhotonKind::Direct && matches!(point.covers, Covers::Diffuse(_));
        let lights = arrival.lights(ng);
        out.has_others |= !lights && distance_sq < radius_sq;
        if too_long || sampled || !lights {
            return;
        }
        let (f, side) = (f(arrival), 1f32.copysign(arrival.wi.dot(ng)));
        if f.is_black() || !takes(q, side) {
            return;
        }
        let flux = f * arrival.power;
        if distance_sq < radius_sq {
            out.photons += 1;
            if out.farthest.is_none_or(|(_, _, d)| distance_sq > d) {
                out.farthest = Some((q, side, distance_sq));
            }
            match arrival.kind {
                PhotonKind::Direct => out.direct += flux,
                PhotonKind::Caustic => out.caustic += flux,
                PhotonKind::Indirect => out.indirect += flux,
            }
        }
        if let Some(h_sq) = derivative_sq.filter(|h_sq| distance_sq < *h_sq) {
            let seen = f64::from((flux * point.throughput).luminance());
            out.laplacian += seen * f64::from(laplacian_kernel(distance_sq / h_sq));
            out.squares += seen * seen;
        }
    });
    if let Some(h_sq) = derivative_sq {
        out.laplacian /= f64::from(h_sq * h_sq);
        out.squares /= PI * f64::from(h_sq);
    }
    out
}

/// The radius of the disc that contains `count` contributing photons, between `least` and `most`. The search starts at
/// `guess`. `None` if there is no photon within `most`.
pub(crate) fn radius_of(
    grid: &Photons,
    point: &Point,
    count: usize,
    guess: f32,
    [least, most]: [f32; 2],
) -> Option<f32> {
    let mut reach = guess.clamp(least, most);
    let found = loop {
        let found = gather(grid, point, Discs { radius: reach, derivative: None }).photons as usize;
        if found >= count || reach >= most {
            break found;
        }
        reach = (1.6 * reach).min(most);
    };
    if found == 0 {
        return None;
    }
    // Only a fraction of the photons on this surface contribute: count the same fraction of the nearest photons.
    let mut near = Vec::new();
    grid.within(point.surface.p, reach, |_, arrival, distance_sq| {
        if arrival.lights(point.surface.ng) {
            near.push(distance_sq);
        }
    });
    let rank = (count * near.len()).div_ceil(found);
    if rank > near.len() {
        return Some(most);
    }
    let (_, kth, _) = near.select_nth_unstable_by(rank - 1, f32::total_cmp);
    Some(kth.sqrt().clamp(least, most))
}

/// The kernel (1 - s)^3 over the unit disc, where s is the squared distance divided by h^2: its Laplacian, normalised
/// so that the weighted sum over photons gives the Laplacian of their density. Requires `s` below 1; divide the result
/// by `h`^4.
#[inline]
pub(crate) fn laplacian_kernel(s: f32) -> f32 {
    // K = 4 / pi (1 - s)^3; in two dimensions lap g(s) = 4 (g' + s g'').
    48.0 * gi_core::math::INV_PI * (1.0 - s) * (3.0 * s - 1.0)
}

#[cfg(test)]
mod tests;
