use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub};

/// A linear Rec. 709 triple: radiance, power, throughput or reflectance. Not a point, hence not a `Vec3`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Rgb {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
}

impl Rgb {
    /// No light.
    pub const BLACK: Rgb = Rgb::grey(0.0);
    /// One in every channel.
    pub const WHITE: Rgb = Rgb::grey(1.0);

    /// A triple from its channels.
    #[inline]
    pub const fn new(r: f32, g: f32, b: f32) -> Self {
        Rgb { r, g, b }
    }

    /// The same value in every channel.
    #[inline]
    pub const fn grey(v: f32) -> Self {
        Rgb { r: v, g: v, b: v }
    }

    /// Rec. 709 luminance.
    #[inline]
    pub fn luminance(self) -> f32 {
        0.212_671 * self.r + 0.715_160 * self.g + 0.072_169 * self.b
    }

    /// Mean of the channels.
    #[inline]
    pub fn mean(self) -> f32 {
        (self.r + self.g + self.b) * (1.0 / 3.0)
    }

    /// Largest channel.
    #[inline]
    pub fn max(self) -> f32 {
        self.r.max(self.g).max(self.b)
    }

    /// Whether no channel carries light.
    #[inline]
    pub fn is_black(self) -> bool {
        self.r == 0.0 && self.g == 0.0 && self.b == 0.0
    }

    /// Whether every channel is a finite number.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.r.is_finite() && self.g.is_finite() && self.b.is_finite()
    }

    /// Apply `f` to each channel.
    #[inline]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Rgb::new(f(self.r), f(self.g), f(self.b))
    }

    /// Combine two triples channel by channel.
    #[inline]
    pub fn zip(self, o: Rgb, f: impl Fn(f32, f32) -> f32) -> Self {
        Rgb::new(f(self.r, o.r), f(self.g, o.g), f(self.b, o.b))
    }

    /// `self` at 0, `other` at 1.
    #[inline]
    pub fn lerp(self, other: Rgb, t: f32) -> Self {
        self * (1.0 - t) + other * t
    }

    /// The channels in order.
    #[inline]
    pub fn to_array(self) -> [f32; 3] {
        [self.r, self.g, self.b]
    }
}

impl From<[f32; 3]> for Rgb {
    #[inline]
    fn from([r, g, b]: [f32; 3]) -> Self {
        Rgb { r, g, b }
    }
}

impl Add for Rgb {
    type Output = Rgb;
    #[inline]
    fn add(self, o: Rgb) -> Rgb {
        Rgb::new(self.r + o.r, self.g + o.g, self.b + o.b)
    }
}

impl Sub for Rgb {
    type Output = Rgb;
    #[inline]
    fn sub(self, o: Rgb) -> Rgb {
        Rgb::new(self.r - o.r, self.g - o.g, self.b - o.b)
    }
}

impl Mul for Rgb {
    type Output = Rgb;
    #[inline]
    fn mul(self, o: Rgb) -> Rgb {
        Rgb::new(self.r * o.r, self.g * o.g, self.b * o.b)
    }
}

impl Mul<f32> for Rgb {
    type Output = Rgb;
    #[inline]
    fn mul(self, k: f32) -> Rgb {
        Rgb::new(self.r * k, self.g * k, self.b * k)
    }
}

impl Div<f32> for Rgb {
    type Output = Rgb;
    #[inline]
    fn div(self, k: f32) -> Rgb {
        self * (1.0 / k)
    }
}

impl AddAssign for Rgb {
    #[inline]
    fn add_assign(&mut self, o: Rgb) {
        *self = *self + o;
    }
}

impl MulAssign for Rgb {
    #[inline]
    fn mul_assign(&mut self, o: Rgb) {
        *self = *self * o;
    }
}

impl MulAssign<f32> for Rgb {
    #[inline]
    fn mul_assign(&mut self, k: f32) {
        *self = *self * k;
    }
}

impl Sum for Rgb {
    fn sum<I: Iterator<Item = Rgb>>(iter: I) -> Rgb {
        iter.fold(Rgb::BLACK, |a, b| a + b)
    }
}
