//! The photon of the lecture: 20 bytes [slide 25].

use std::f32::consts::PI;
use std::sync::LazyLock;

use gi_core::math::Rgb;
pub use gi_core::walk::PhotonKind;
use glam::Vec3;

/// Light that has arrived at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub struct Photon {
    /// Where, world.
    pub position: [f32; 3],
    /// What it brings.
    pub payload: Payload,
}

/// All of a photon but its position: what a search hands out, and what the fast layout keeps apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub struct Payload {
    /// Power, already divided by the number of emitted paths; see [`Rgbe`].
    pub power: Rgbe,
    /// Angles phi and theta of the unit direction back to where the light came from.
    pub phi: u8,
    /// See `phi`.
    pub theta: u8,
    /// Bits 0 and 1: the split axis in the left-balanced tree. Bits 2 and 3: the [`PhotonKind`]. Bits 4 to 15: angles of the
    /// surface's normal on the side that the light came from.
    pub flags: u16,
}

impl Photon {
    /// A photon at `p` that came from `wo` (unit), on the side of the unit normal `n`.
    pub fn new(p: Vec3, power: Rgbe, wo: Vec3, n: Vec3, kind: PhotonKind) -> Self {
        let [phi, theta] = angles::<256>(wo);
        let [n_phi, n_theta] = angles::<64>(n);
        let flags = (kind as u16) << 2 | (u16::from(n_phi) << 4) | (u16::from(n_theta) << 10);
        Photon { position: p.to_array(), payload: Payload { power, phi, theta, flags } }
    }

    /// Where, world.
    #[inline]
    pub fn p(&self) -> Vec3 {
        Vec3::from_array(self.position)
    }
}

impl Payload {
    /// Unit direction back to where the light came from, within 0.79 degrees.
    #[inline]
    pub fn direction(&self) -> Vec3 {
        let table = &*FINE;
        table.direction(self.phi.into(), self.theta.into())
    }

    /// Unit normal on the side that the light came from, within 3.2 degrees.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        COARSE.direction(usize::from(self.flags >> 4 & 63), usize::from(self.flags >> 10))
    }

    /// What the path met.
    #[inline]
    pub fn kind(&self) -> PhotonKind {
        match self.flags >> 2 & 3 {
            0 => PhotonKind::Direct,
            1 => PhotonKind::Caustic,
            _ => PhotonKind::Indirect,
        }
    }

    /// Split axis in the left-balanced tree.
    #[inline]
    pub fn axis(&self) -> usize {
        usize::from(self.flags & 3)
    }

    /// The same with another split axis.
    #[inline]
    pub fn with_axis(self, axis: usize) -> Self {
        Payload { flags: self.flags & !3 | axis as u16, ..self }
    }
}

/// Three mantissas of eight bits with one exponent \[Ward91\]: channel = mantissa 2^(exponent - 136).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Rgbe([u8; 4]);

impl Rgbe {
    /// No light.
    pub const BLACK: Rgbe = Rgbe([0; 4]);

    /// The nearest. Each channel is off by at most 1/254 of the largest one.
    pub fn nearest(c: Rgb) -> Self {
        Self::dithered(c, [0.5; 3])
    }

    /// Rounded up where `u` (uniform in [0, 1)) says so, such that the mean over `u` is `c` itself. Photons of one
    /// wall have one colour: rounding to the nearest would err the same way in all of them, by half of a weak channel
    /// and more. Below 2e-36 the result is black; above 1e38 it is the largest number there is.
    pub fn dithered(c: Rgb, u: [f32; 3]) -> Self {
        let most = c.max();
        if most < SMALLEST || most.is_nan() {
            return Rgbe([0; 4]);
        }
        // most = m 2^e with m in [0.5, 1).
        let mut e = (most.to_bits() >> 23) as i32 - 126;
        if most * exp2(8 - e) > 255.0 {
            e += 1;
        }
        if e + 128 > 255 {
            return Rgbe([255; 4]);
        }
        let scale = exp2(8 - e);
        let c = c.to_array();
        let m = [0, 1, 2].map(|k| (c[k].max(0.0) * scale + u[k]) as u8);
        Rgbe([m[0], m[1], m[2], (e + 128) as u8])
    }

    /// Back to floats.
    #[inline]
    pub fn to_rgb(self) -> Rgb {
        let [r, g, b, e] = self.0;
        let scale = exp2(i32::from(e) - 136);
        Rgb::new(f32::from(r), f32::from(g), f32::from(b)) * scale
    }

    /// The bytes, exponent last.
    pub fn to_bytes(self) -> [u8; 4] {
        self.0
    }

    /// From bytes as [`Rgbe::to_bytes`] gives them.
    pub fn from_bytes(bytes: [u8; 4]) -> Self {
        Rgbe(bytes)
    }
}

/// 2^-119: the scale of its mantissas is the largest power of two that is a float.
const SMALLEST: f32 = f32::from_bits(8 << 23);

/// 2^e for e from -136 to 136, in two steps where it is no normal number.
#[inline]
fn exp2(e: i32) -> f32 {
    let power = |e: i32| f32::from_bits(((e + 127) as u32) << 23);
    if (-126..=127).contains(&e) { power(e) } else { power(e / 2) * power(e - e / 2) }
}

/// The cells of `N` steps in phi and in theta that a unit vector lies in.
fn angles<const N: usize>(d: Vec3) -> [u8; 2] {
    let turn = d.y.atan2(d.x) * (0.5 / PI);
    let phi = ((turn - turn.floor()) * N as f32) as usize;
    let theta = (d.z.clamp(-1.0, 1.0).acos() * (N as f32 / PI)) as usize;
    [phi.min(N - 1) as u8, theta.min(N - 1) as u8]
}

/// Cosines and sines of the middles of `N` steps.
struct Angles<const N: usize> {
    phi: [[f32; 2]; N],
    theta: [[f32; 2]; N],
}

impl<const N: usize> Angles<N> {
    fn new() -> Self {
        let table = |whole: f32| {
            std::array::from_fn(|k| {
                let (sin, cos) = ((k as f32 + 0.5) * whole / N as f32).sin_cos();
                [cos, sin]
            })
        };
        Angles { phi: table(2.0 * PI), theta: table(PI) }
    }

    #[inline]
    fn direction(&self, phi: usize, theta: usize) -> Vec3 {
        let ([cos_phi, sin_phi], [cos, sin]) = (self.phi[phi], self.theta[theta]);
        Vec3::new(sin * cos_phi, sin * sin_phi, cos)
    }
}

static FINE: LazyLock<Angles<256>> = LazyLock::new(Angles::new);
static COARSE: LazyLock<Angles<64>> = LazyLock::new(Angles::new);

#[cfg(test)]
mod tests {
    use super::*;
    use gi_core::rng::Pcg;
    use gi_core::warp;

    #[test]
    fn a_photon_has_20_bytes() {
        assert_eq!(size_of::<Photon>(), 20);
        assert_eq!(size_of::<Payload>(), 8);
    }

    #[test]
    fn angles_round_trip_within_their_bounds() {
        let mut rng = Pcg::new(1, 0);
        let corners =
            [Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z, Vec3::new(-1.0, -0.0, 0.0)];
        let random: Vec<Vec3> = (0..100_000).map(|_| warp::sphere(rng.next_2d())).collect();
        let mut worst = [0f32; 2];
        for d in corners.into_iter().chain(random) {
            let photon = Photon::new(Vec3::ZERO, Rgbe::default(), d, d, PhotonKind::Caustic);
            let payload = photon.payload.with_axis(2);
            assert_eq!((payload.kind(), payload.axis()), (PhotonKind::Caustic, 2));
            let off = |e: Vec3| e.cross(d).length().atan2(e.dot(d)).to_degrees();
            worst = [worst[0].max(off(payload.direction())), worst[1].max(off(payload.normal()))];
        }
        // Half a step of theta and half a step of phi, at a right angle to each other.
        assert!(worst[0] < 0.79 && worst[1] < 3.2, "{worst:?}");
        assert!(worst[0] > 0.7 && worst[1] > 2.8, "the bounds are not tight: {worst:?}");
    }

    #[test]
    fn powers_round_trip_within_their_bound_at_every_scale() {
        let mut rng = Pcg::new(2, 0);
        for k in 0..200_000 {
            let scale = 2f32.powf(230.0 * rng.next_f32() - 110.0);
            let mut c = Rgb::new(rng.next_f32(), rng.next_f32(), rng.next_f32()) * scale;
            if k % 3 == 0 {
                c = Rgb::new(255.4, 255.5, 255.6).map(|v| v * 2f32.powi(k % 50));
            }
            let back = Rgbe::nearest(c).to_rgb();
            let off = (back - c).map(f32::abs).max();
            assert!(off <= c.max() * (1.0 / 254.0), "{c:?} came back as {back:?}");
        }
        assert_eq!(Rgbe::nearest(Rgb::BLACK).to_rgb(), Rgb::BLACK);
        assert_eq!(Rgbe::nearest(Rgb::grey(f32::NAN)).to_rgb(), Rgb::BLACK);
        assert!(Rgbe::nearest(Rgb::grey(f32::MAX)).to_rgb().is_finite());
    }

    #[test]
    fn dithered_powers_are_right_on_average_in_the_weakest_channel_too() {
        let mut rng = Pcg::new(3, 0);
        let c = Rgb::new(0.9, 0.013, 0.0021);
        let n = 100_000;
        let (mut mean, mut square) = ([0f64; 3], [0f64; 3]);
        for _ in 0..n {
            let u = [rng.next_f32(), rng.next_f32(), rng.next_f32()];
            for (k, v) in Rgbe::dithered(c, u).to_rgb().to_array().into_iter().enumerate() {
                mean[k] += f64::from(v) / f64::from(n);
                square[k] += f64::from(v * v) / f64::from(n);
            }
        }
        for (k, exact) in c.to_array().into_iter().enumerate() {
            let error = ((square[k] - mean[k] * mean[k]).max(0.0) / f64::from(n)).sqrt();
            let off = (mean[k] - f64::from(exact)).abs();
            assert!(off < 4.0 * error + 1e-9, "channel {k}: {} is not {exact} +- {error}", mean[k]);
        }
    }
}
