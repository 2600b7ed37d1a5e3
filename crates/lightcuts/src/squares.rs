//! The sphere of directions in pieces: the faces of a cube around it, divided into squares.

use gi_core::bsdf::Toward;
use gi_core::math::Bounds;
use glam::Vec3;

/// `N` squares, an equal number on each face, as the cones around them: axes, and cosines and sines of the half angles.
pub(crate) struct Squares<const N: usize> {
    x: [f32; N],
    y: [f32; N],
    z: [f32; N],
    cos: [f32; N],
    sin: [f32; N],
}

impl<const N: usize> Squares<N> {
    /// Number of squares along the side of a face.
    pub(crate) const SIDE: usize = (N / 6).isqrt();

    pub(crate) fn new() -> Self {
        let axis: [Vec3; N] = std::array::from_fn(|k| Self::square(k).center().normalize());
        let cos: [f32; N] = std::array::from_fn(|k| far_cos(&Self::square(k), axis[k]));
        Squares {
            x: axis.map(|a| a.x),
            y: axis.map(|a| a.y),
            z: axis.map(|a| a.z),
            cos,
            sin: cos.map(|c| (1.0 - c * c).sqrt()),
        }
    }

    /// Square number `k`.
    pub(crate) fn square(k: usize) -> Bounds {
        Self::part(k, 1, [0, 0])
    }

    /// A part of square `k`, if each square is divided into `parts` x `parts`.
    pub(crate) fn part(k: usize, parts: usize, [u, v]: [usize; 2]) -> Bounds {
        let side = Self::SIDE;
        let place = [k % side * parts + u, k / side % side * parts + v];
        on_face(k / (side * side), side * parts, place)
    }

    /// Which squares a cone touches: `yes` for these, `no` for the others. The cone is that of [`Toward::around`].
    #[inline]
    pub(crate) fn touched<T: Copy>(
        &self,
        (axis, sin, cos): (Vec3, f32, f32),
        [no, yes]: [T; 2],
    ) -> [T; N] {
        let mut touched = [yes; N];
        if sin < 1.0 {
            // Without branches, so that the compiler can vectorise it.
            for (k, touched) in touched.iter_mut().enumerate() {
                let between = self.x[k] * axis.x + self.y[k] * axis.y + self.z[k] * axis.z;
                let touches = between >= self.cos[k] * cos - self.sin[k] * sin;
                *touched = if touches { yes } else { no };
            }
        }
        touched
    }

    /// The directions into each square.
    pub(crate) fn toward() -> [Toward; N] {
        std::array::from_fn(|k| Toward::new(Vec3::ZERO, &Self::square(k)))
    }
}

/// The smallest cosine between `axis` and a corner of a box seen from the origin, with a margin for rounding.
fn far_cos(b: &Bounds, axis: Vec3) -> f32 {
    let corner = |c: usize| {
        Vec3::from_array([0, 1, 2].map(|i| if c >> i & 1 == 0 { b.min[i] } else { b.max[i] }))
    };
    (0..8).map(|c| corner(c).normalize().dot(axis)).fold(1.0, f32::min) - 1e-4
}

/// A square of a face; `n` squares lie along the side of the face.
fn on_face(face: usize, n: usize, place: [usize; 2]) -> Bounds {
    let (axis, side) = (face / 2, if face.is_multiple_of(2) { -1.0 } else { 1.0 });
    let (mut min, mut max) = (Vec3::splat(side), Vec3::splat(side));
    for (across, place) in [(axis + 1) % 3, (axis + 2) % 3].into_iter().zip(place) {
        let at = |i: usize| 2.0 * i as f32 / n as f32 - 1.0;
        (min[across], max[across]) = (at(place), at(place + 1));
    }
    Bounds { min, max }
}
