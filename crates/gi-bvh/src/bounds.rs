use glam::{Affine3A, Vec3};

/// An axis-aligned box in world units; empty when `min > max` in any axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// The empty box. Adding a point gives the box of that point.
    pub const EMPTY: Bounds = Bounds { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The smallest box around some points.
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| b.with(p))
    }

    /// This box extended to contain `p`.
    #[inline]
    pub fn with(self, p: Vec3) -> Self {
        Bounds { min: self.min.min(p), max: self.max.max(p) }
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(self, other: Bounds) -> Self {
        Bounds { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether the box is empty.
    #[inline]
    pub fn is_empty(self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// Side lengths; zero if the box is empty.
    #[inline]
    pub fn extent(self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// The centre of the box.
    #[inline]
    pub fn center(self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// The box around the eight transformed corners.
    pub fn transformed(self, m: &Affine3A) -> Self {
        if self.is_empty() {
            return self;
        }
        let pick = |bit: u32, axis: usize| if bit == 0 { self.min[axis] } else { self.max[axis] };
        Bounds::of(
            (0..8u32).map(|k| {
                m.transform_point3(Vec3::new(pick(k & 1, 0), pick(k & 2, 1), pick(k & 4, 2)))
            }),
        )
    }
}
