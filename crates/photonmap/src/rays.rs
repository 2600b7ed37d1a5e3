//! The random numbers of gather rays and of the estimates of a pixel.

use gi_core::rng::hash_words;
use gi_core::sampler::Sampler;
use gi_core::technique::Setting;

/// The random numbers of a pixel in a pass. The gather rays of all passes are one sequence, so that they are stratified
/// together.
pub(crate) struct Rays {
    pub(crate) seed: u32,
    pub(crate) stream: u32,
    pub(crate) pass: u32,
}

impl Rays {
    pub(crate) fn of_pixel(setting: &Setting, [x, y]: [usize; 2], pass: u32) -> Self {
        let stream = (y * setting.camera.size()[0] + x) as u32;
        Rays { seed: setting.seed, stream, pass }
    }

    /// Two numbers for gather ray `k` of the `n` of this pass.
    #[inline]
    pub(crate) fn direction(&self, k: u32, n: u32) -> [f32; 2] {
        let index = self.pass.wrapping_mul(n).wrapping_add(k);
        Sampler::new(self.seed ^ 0x6761_7468, self.stream, index).next_2d()
    }

    /// Numbers that probe the disc of an estimate at the vertex after `segments` segments.
    pub(crate) fn probes(&self, segments: u32) -> impl FnMut() -> [f32; 2] {
        let seed = hash_words(&[self.seed, 0x6469_7363, segments]);
        let mut sampler = Sampler::new(seed, self.stream, self.pass);
        move || sampler.next_2d()
    }
}
