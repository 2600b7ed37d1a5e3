//! BRDF tables [slide 18]: the coefficients c_k of f_r times the cosine, for a material's glossy lobe and each
//! elevation of the outgoing direction. Lobes are isotropic, so azimuth 0 represents all, and only functions with m >=
//! 0 are not zero.

use std::f32::consts::FRAC_PI_2;

use gi_core::bsdf::GlossyLobe;
use gi_core::math::Rgb;
use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use crate::sh::{Basis, Coefficients, MAX_FUNCTIONS, MAX_ORDER, Window};

/// Number of elevations of the outgoing direction, at equal angles from the normal to the horizon.
const ELEVATIONS: usize = 64;
/// Angle of the last elevation: at the horizon itself the BRDF is not defined.
const LAST: f32 = FRAC_PI_2 - 1e-3;
/// Number of samples of a lobe along each side of the unit square.
const SIDE: usize = 64;
/// Fraction of a lobe's energy that an automatic order may leave out.
pub const LEFT_OUT: f32 = 0.05;

/// A lobe's coefficients.
#[derive(Clone, Debug)]
pub struct BrdfTable {
    /// Number of bands.
    pub order: usize,
    /// Fraction of the energy, the integral of (f_r cos)^2, that these bands leave out; the mean over outgoing
    /// directions.
    pub left_out: f32,
    basis: Basis,
    /// One row per elevation, with the functions of m >= 0; (l, m) is at l (l + 1) / 2 + m.
    rows: Vec<Vec3A>,
}

/// Number of functions with m >= 0 of an order.
const fn halved(order: usize) -> usize {
    order * (order + 1) / 2
}

/// A lobe's full projection at one elevation, and its energy.
struct Projection {
    coefficients: Coefficients,
    energy: f32,
}

/// Outgoing direction of elevation `i`.
fn outgoing(i: usize) -> Vec3 {
    let angle = LAST * i as f32 / (ELEVATIONS - 1) as f32;
    Vec3::new(angle.sin(), 0.0, angle.cos())
}

/// Project a lobe onto `bands` bands, with samples of the lobe on a regular grid.
fn project(lobe: &GlossyLobe, basis: Basis, bands: usize, wo: Vec3) -> Projection {
    let mut coefficients = [Vec3A::ZERO; MAX_FUNCTIONS];
    let (mut energy, mut y) = (0.0f64, [0.0; MAX_FUNCTIONS]);
    let per = 1.0 / (SIDE * SIDE) as f32;
    for k in 0..SIDE * SIDE {
        let at = |k: usize| (k as f32 + 0.5) / SIDE as f32;
        let Some((wi, weight)) = lobe.sample(wo, [at(k / SIDE), at(k % SIDE)]) else { continue };
        basis.evaluate(bands, wi, &mut y);
        let weight = weight * per;
        let value = Vec3A::from_array(weight.to_array());
        coefficients[..bands * bands].iter_mut().zip(y).for_each(|(c, y)| *c += value * y);
        energy += f64::from((lobe.f_cos(wo, wi) * weight).mean());
    }
    Projection { coefficients, energy: energy as f32 }
}

impl Projection {
    /// Fraction of the energy in bands from `order` on.
    fn left_out(&self, order: usize) -> f32 {
        let kept: f32 =
            self.coefficients[..order * order].iter().map(|c| c.length_squared() / 3.0).sum();
        if self.energy > 0.0 { (1.0 - kept / self.energy).max(0.0) } else { 0.0 }
    }
}

/// Mean over outgoing directions, weighted by their cosine.
fn mean(all: &[Projection], of: impl Fn(&Projection) -> f32) -> f32 {
    let weight = |i: usize| outgoing(i).x * outgoing(i).z;
    let sum: f32 = all.iter().enumerate().map(|(i, p)| weight(i) * of(p)).sum();
    sum / (0..all.len()).map(weight).sum::<f32>()
}

impl BrdfTable {
    /// Tabulate a lobe with `order` bands. 0 selects the smallest order that leaves out at most [`LEFT_OUT`] of the
    /// energy, up to [`MAX_ORDER`].
    pub fn new(lobe: &GlossyLobe, basis: Basis, window: Window, order: usize) -> Self {
        let bands = if order == 0 { MAX_ORDER } else { order };
        let project = |i| project(lobe, basis, bands, outgoing(i));
        let all: Vec<Projection> = (0..ELEVATIONS).into_par_iter().map(project).collect();
        let left_out = |order: usize| mean(&all, |p| p.left_out(order));
        let order = match order {
            0 => (1..MAX_ORDER).find(|&n| left_out(n) <= LEFT_OUT).unwrap_or(MAX_ORDER),
            n => n,
        };
        let mut rows = Vec::with_capacity(ELEVATIONS * halved(order));
        for p in &all {
            for l in 0..order {
                let factor = window.factor(l, order);
                rows.extend((0..=l).map(|m| p.coefficients[l * (l + 1) + m] * factor));
            }
        }
        BrdfTable { order, left_out: left_out(order), basis, rows }
    }

    /// The coefficients for an outgoing direction of cosine `cos_o`.
    #[inline]
    pub fn at(&self, cos_o: f32) -> BrdfRow<'_> {
        let x = (cos_o.clamp(0.0, 1.0).acos() / LAST).min(1.0) * (ELEVATIONS - 1) as f32;
        let i = (x as usize).min(ELEVATIONS - 2);
        let width = halved(self.order);
        let row = |i: usize| &self.rows[i * width..(i + 1) * width];
        BrdfRow { order: self.order, low: row(i), high: row(i + 1), fraction: x - i as f32 }
    }

    /// The directional reflectance rho_hd(w_o): the integral of f_r cos over all incoming directions [slide 15].
    pub fn albedo(&self, cos_o: f32) -> Rgb {
        let BrdfRow { low, high, fraction, .. } = self.at(cos_o);
        Rgb::from((low[0].lerp(high[0], fraction) * self.basis.integral()).to_array())
    }

    /// The basis functions at `wi` as if they were light: the dot product with them is the approximation of f_r cos at
    /// `wi`.
    pub fn light_from(&self, wi: Vec3) -> Coefficients {
        let mut y = [0.0; MAX_FUNCTIONS];
        self.basis.evaluate(self.order, wi, &mut y);
        y.map(Vec3A::splat)
    }
}

/// Coefficients c_k(w_o) at one elevation of the outgoing direction, between two rows of a table. Functions with m >= 0
/// only; (l, m) is at l (l + 1) / 2 + m.
#[derive(Clone, Copy, Debug)]
pub struct BrdfRow<'t> {
    /// Number of bands.
    pub order: usize,
    /// The row nearer the normal.
    pub low: &'t [Vec3A],
    /// The row nearer the horizon.
    pub high: &'t [Vec3A],
    /// Position between the two rows, from 0 to 1.
    pub fraction: f32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dot;
    use crate::sh::tests::quadrature;
    use crate::test_scenes::lobe_scene;
    use gi_core::math::INV_PI;

    #[test]
    fn tables_give_the_lobes_albedo_and_more_bands_leave_out_less() {
        let scene = lobe_scene(0.3);
        let lobe = scene.glossy_lobe(0).expect("a lobe");
        let directions = quadrature(200);
        for basis in [Basis::Sh, Basis::Hsh] {
            let table = BrdfTable::new(&lobe, basis, Window::None, 10);
            for i in [0, 20, 45] {
                let wo = outgoing(i);
                let exact: f64 = directions
                    .iter()
                    .filter(|(d, _)| d.z > 0.0)
                    .map(|(d, w)| w * f64::from(lobe.f_cos(wo, *d).g))
                    .sum();
                let found = f64::from(table.albedo(wo.z).g);
                // 64 samples per side of a smooth lobe; the quadrature's rings end at the horizon, where f cos is 0.
                assert!(
                    (found / exact - 1.0).abs() < 3e-3,
                    "{basis:?}, {i}: {found} is not {exact}"
                );
            }
            let left: Vec<f32> =
                (1..9).map(|n| BrdfTable::new(&lobe, basis, Window::None, n).left_out).collect();
            assert!(left.windows(2).all(|w| w[1] <= w[0]), "{basis:?}: {left:?}");
            let n = BrdfTable::new(&lobe, basis, Window::None, 0).order;
            let left = |n| BrdfTable::new(&lobe, basis, Window::None, n).left_out;
            assert!(left(n) <= LEFT_OUT && left(n - 1) > LEFT_OUT, "{basis:?}: {n}");
        }
    }

    #[test]
    fn constant_light_gives_the_albedo() {
        let scene = lobe_scene(0.2);
        let lobe = scene.glossy_lobe(0).expect("a lobe");
        // In hemispherical harmonics, constant light from above is exactly the first function.
        let table = BrdfTable::new(&lobe, Basis::Hsh, Window::None, 8);
        let mut light = [Vec3A::ZERO; MAX_FUNCTIONS];
        light[0] = Vec3A::splat((0.5 * INV_PI).sqrt().recip());
        for cos_o in [1.0, 0.7, 0.3] {
            let (found, albedo) = (dot(&table.at(cos_o), &light), table.albedo(cos_o));
            assert!((found.g / albedo.g - 1.0).abs() < 1e-5, "{found:?} is not {albedo:?}");
        }
    }

    #[test]
    fn under_band_limited_light_the_error_falls_to_zero_with_the_order() {
        // Light with 6 bands: the error is the sum over the bands that are left out.
        let scene = lobe_scene(0.25);
        let lobe = scene.glossy_lobe(0).expect("a lobe");
        let mut rng = gi_core::rng::Pcg::new(9, 0);
        let environments: Vec<Coefficients> = (0..200)
            .map(|_| {
                let mut light = [Vec3A::ZERO; MAX_FUNCTIONS];
                light[..36].iter_mut().for_each(|c| *c = Vec3A::splat(rng.next_f32() - 0.5));
                light
            })
            .collect();
        for basis in [Basis::Sh, Basis::Hsh] {
            let tables: Vec<BrdfTable> =
                (1..9).map(|n| BrdfTable::new(&lobe, basis, Window::None, n)).collect();
            let error = |table: &BrdfTable| -> f64 {
                let off = |light: &Coefficients, cos_o: f32| {
                    let exact = dot(&tables[7].at(cos_o), light).g;
                    f64::from(dot(&table.at(cos_o), light).g - exact).powi(2)
                };
                environments.iter().map(|e| off(e, 0.9) + off(e, 0.6) + off(e, 0.3)).sum()
            };
            let errors: Vec<f64> = tables.iter().map(error).collect();
            assert!(errors[..6].windows(2).all(|w| w[1] < 0.95 * w[0]), "{basis:?}: {errors:?}");
            assert!(errors[5] < 1e-8 * errors[0] && errors[6] < 1e-8 * errors[0], "{errors:?}");
        }
    }
}
