//! Hessians of irradiance: second derivatives by the position in the tangent plane, from the rays of the record. They
//! give the error of extrapolation along the gradient \[Schwarzhaupt12\].

use std::f32::consts::PI;

use gi_core::math::Rgb;
use glam::{DMat2, DVec2, DVec3, Vec3};

use crate::gradients::Gradient;
use crate::hemisphere::{Hemisphere, Seen};

/// Second derivatives of the mean of the channels, by the tangents s and t of the record's frame.
pub type Hessian = DMat2;

/// The Hessian without occlusion: the surface that each ray hits is a small, unoccluded emitter. Let w be its
/// direction, r its distance, m its normal, and G = cos cos' / r^2. The second derivative of G, divided by G, is (24 w
/// w' - 4 I - 4 (m w' + w m') / cos') / r^2. The cosine cos' is at least `GRAZING`, because the term is unbounded for
/// surfaces seen at grazing angles.
pub fn geometric(h: &Hemisphere) -> Hessian {
    let mut sum = DMat2::ZERO;
    for s in h.all().iter().filter(|s| s.distance.is_finite()) {
        let (w, r_sq) = (flat(s.direction), f64::from(s.distance).powi(2));
        let m = s.normal * -1f32.copysign(s.normal.dot(s.direction));
        let cos = f64::from(-m.dot(s.direction)).max(GRAZING);
        // m points back to the record: the cosine at the emitter is -m . w.
        let m = -flat(m);
        let mw = outer(m, w);
        let second =
            outer(w, w) * 24.0 - DMat2::IDENTITY * 4.0 - (mw + mw.transpose()) * (4.0 / cos);
        sum += second * (f64::from(s.radiance.mean()) / r_sq);
    }
    sum * (f64::from(PI) / h.all().len() as f64)
}

/// Smallest cosine at an emitter that [`geometric`] divides by.
const GRAZING: f64 = 0.1;

/// The Hessian with occlusion, and the gradient. The hit points of the rays form a closed mesh around the record, with
/// triangles between neighbours. Each triangle has the radiance of its farthest corner, so that near surfaces occlude
/// distant ones. Irradiance is Lambert's sum over the edges, 1/2 (L_left - L_right) n . Gamma; its derivatives are
/// those of the edges.
pub fn occlusion(h: &Hemisphere) -> (Gradient, Hessian) {
    let mesh = Mesh::new(h);
    let (mut gradient, mut hessian) = ([DVec2::ZERO; 3], DMat2::ZERO);
    mesh.for_each_edge(|a, b, left, right| {
        let difference = left - right;
        if difference.is_black() {
            return;
        }
        let edge = edge_derivatives(a, b);
        for (g, c) in gradient.iter_mut().zip(difference.to_array()) {
            *g += edge.0 * (0.5 * f64::from(c));
        }
        hessian += edge.1 * (0.5 * f64::from(difference.mean()));
    });
    (Gradient(gradient.map(|g| g.extend(0.0).as_vec3())), hessian)
}

/// Length of rays that hit nothing, in units of the largest distance of the other rays.
const FAR: f64 = 100.0;

/// The mesh of [`occlusion`]: row 0 is the innermost ring, the last row is the horizon.
struct Mesh {
    sectors: usize,
    rows: Vec<Vec<(DVec3, Rgb, f64)>>,
}

impl Mesh {
    fn new(h: &Hemisphere) -> Self {
        let farthest = h.all().iter().map(|s| s.distance).filter(|d| d.is_finite());
        let far = FAR * f64::from(farthest.fold(0.0, f32::max).max(f32::MIN_POSITIVE));
        let vertex = |s: &Seen, direction: DVec3| {
            let r = if s.distance.is_finite() { f64::from(s.distance) } else { far };
            (direction * r, s.radiance, r)
        };
        let (rings, sectors) = (h.strata.rings, h.strata.sectors);
        let row = |j: usize, level: bool| {
            let of = |k: usize| {
                let s = h.at(j, k);
                let d = s.direction.as_dvec3();
                vertex(s, if level { d.with_z(0.0).normalize() } else { d })
            };
            (0..sectors).map(of).collect()
        };
        let mut rows: Vec<_> = (0..rings).map(|j| row(j, false)).collect();
        // The last row lies on the horizon and copies the lowest ring.
        rows.push(row(rings - 1, true));
        Mesh { sectors, rows }
    }

    /// Call `edge` with the two ends of each edge, and with the radiance on its left and on its right, as seen from the
    /// record.
    fn for_each_edge(&self, mut edge: impl FnMut(DVec3, DVec3, Rgb, Rgb)) {
        let n = self.sectors;
        // Each cell between two rows is split along the diagonal from (j, k) to (j + 1, k + 1), into a lower and an
        // upper triangle.
        let lower = |j: usize, k: usize| self.farthest([(j, k), (j + 1, k), (j + 1, k + 1)]);
        let upper = |j: usize, k: usize| self.farthest([(j, k), (j + 1, k + 1), (j, k + 1)]);
        let at = |j: usize, k: usize| self.rows[j][k % n].0;
        let cap = self.cap();
        for j in 0..self.rows.len() {
            for k in 0..n {
                // The edge along the row, between the cell outside and the cell (or the cap) inside.
                let outside = if j + 1 < self.rows.len() { upper(j, k) } else { Rgb::BLACK };
                let inside = if j > 0 { lower(j - 1, k) } else { cap };
                edge(at(j, k), at(j, k + 1), inside, outside);
                if j + 1 < self.rows.len() {
                    // The edge to the next row, and the diagonal of the cell.
                    edge(at(j, k), at(j + 1, k), lower(j, k), upper(j, (k + n - 1) % n));
                    edge(at(j, k), at(j + 1, k + 1), upper(j, k), lower(j, k));
                }
            }
        }
    }

    /// Radiance of the farthest corner.
    fn farthest(&self, corners: [(usize, usize); 3]) -> Rgb {
        let of = |(j, k): (usize, usize)| self.rows[j][k % self.sectors];
        let mut best = of(corners[0]);
        for corner in &corners[1..] {
            let v = of(*corner);
            if v.2 > best.2 {
                best = v;
            }
        }
        best.1
    }

    /// Mean radiance of the innermost ring, for the cap around the normal.
    fn cap(&self) -> Rgb {
        self.rows[0].iter().map(|v| v.1).sum::<Rgb>() / self.sectors as f32
    }
}

/// First and second derivatives of n . Gamma of the edge from `a` to `b` (relative to the record) when the record moves
/// in its tangent plane. Gamma is normal to `a` and `b`, and its length is the angle Theta between them.
fn edge_derivatives(a: DVec3, b: DVec3) -> (DVec2, DMat2) {
    // n . Gamma = N q, where N = n . (a x b) is linear in the move, and q = Theta / |a x b|.
    let (e, c) = (b - a, a.cross(b));
    let (n, grad_n) = (c.z, DVec2::new(-e.y, e.x));
    let (p, grad_p) = (a.dot(b), -flat_d(a + b));
    let (sq, grad_sq) = (c.length_squared(), flat_d(e.cross(c)) * -2.0);
    let hess_p = DMat2::IDENTITY * 2.0;
    let hess_sq = (DMat2::IDENTITY * e.length_squared() - outer(flat_d(e), flat_d(e))) * 2.0;
    let q = Quotient::new(p, sq);
    let grad_q = grad_p * q.by_p + grad_sq * q.by_sq;
    let mixed = outer(grad_p, grad_sq);
    let hess_q = outer(grad_p, grad_p) * q.by_pp
        + (mixed + mixed.transpose()) * q.by_p_sq
        + outer(grad_sq, grad_sq) * q.by_sq_sq
        + hess_p * q.by_p
        + hess_sq * q.by_sq;
    let cross = outer(grad_n, grad_q);
    (grad_n * q.value + grad_q * n, cross + cross.transpose() + hess_q * n)
}

/// q(p, C) = atan2(sqrt(C), p) / sqrt(C) and its derivatives; D = p^2 + C.
struct Quotient {
    value: f64,
    by_p: f64,
    by_sq: f64,
    by_pp: f64,
    by_p_sq: f64,
    by_sq_sq: f64,
}

impl Quotient {
    fn new(p: f64, sq: f64) -> Self {
        let d = p * p + sq;
        let (by_p, by_pp, by_p_sq) = (-1.0 / d, 2.0 * p / (d * d), 1.0 / (d * d));
        // For nearly parallel vectors the closed form cancels: use the series of atan.
        if p > 0.0 && sq < 1e-3 * p * p {
            let t = sq / (p * p);
            let value = (1.0 - t / 3.0 + t * t / 5.0 - t.powi(3) / 7.0) / p;
            let by_sq = (-1.0 / 3.0 + 2.0 * t / 5.0 - 3.0 * t * t / 7.0 + 4.0 * t.powi(3) / 9.0)
                / p.powi(3);
            let by_sq_sq = (2.0 / 5.0 - 6.0 * t / 7.0 + 12.0 * t * t / 9.0) / p.powi(5);
            return Quotient { value, by_p, by_sq, by_pp, by_p_sq, by_sq_sq };
        }
        let s = sq.sqrt();
        let value = s.atan2(p) / s;
        let by_sq = (p / d - value) / (2.0 * sq);
        let by_sq_sq = -(p / (d * d) + by_sq) / (2.0 * sq) - (p / d - value) / (2.0 * sq * sq);
        Quotient { value, by_p, by_sq, by_pp, by_p_sq, by_sq_sq }
    }
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

fn flat(v: Vec3) -> DVec2 {
    v.truncate().as_dvec2()
}

fn flat_d(v: DVec3) -> DVec2 {
    v.truncate()
}

/// Eigenvalues of a symmetric matrix, the one of larger absolute value first, and the unit eigenvector of the first.
pub fn eigen(h: Hessian) -> ([f64; 2], DVec2) {
    let (a, b, d) = (h.x_axis.x, 0.5 * (h.x_axis.y + h.y_axis.x), h.y_axis.y);
    let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
    let root = (half * half + b * b).sqrt();
    // The eigenvalue with the sign of the mean has the larger absolute value.
    let (large, small) =
        if mean >= 0.0 { (mean + root, mean - root) } else { (mean - root, mean + root) };
    let vector = if root == 0.0 {
        DVec2::X
    } else if (large - d).abs() > (large - a).abs() {
        DVec2::new(large - d, b)
    } else {
        DVec2::new(b, large - a)
    };
    ([large, small], vector.normalize_or(DVec2::X))
}

#[cfg(test)]
mod tests;
