//! Chooses the kernel that traverses a tree, from the processor's instruction sets.

#[cfg(target_arch = "x86_64")]
use super::kernel_x86;
use super::layout::Tree;
use super::portable;
use crate::ray::{Hit, Ray};

/// An instruction set with its own kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Isa {
    /// Plain Rust.
    Portable,
    /// SSE2, which every 64-bit x86 has.
    #[cfg(target_arch = "x86_64")]
    Sse2,
    /// AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 on 256-bit vectors.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Isa {
    /// The instruction sets that this processor supports, fastest last.
    #[cfg(target_arch = "x86_64")]
    pub(super) fn available() -> Vec<Isa> {
        let mut found = vec![Isa::Portable, Isa::Sse2];
        let avx2 = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        if avx2 {
            found.push(Isa::Avx2);
        }
        let avx512 = is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512dq");
        if avx2 && avx512 {
            found.push(Isa::Avx512);
        }
        found
    }

    /// The instruction sets that this processor supports, fastest last.
    #[cfg(not(target_arch = "x86_64"))]
    pub(super) fn available() -> Vec<Isa> {
        vec![Isa::Portable]
    }
}

/// The instruction set used to trace rays on this processor: the fastest one that a kernel exists for.
pub fn instruction_set() -> &'static str {
    match Isa::available().last() {
        #[cfg(target_arch = "x86_64")]
        Some(Isa::Avx512) => "AVX-512",
        #[cfg(target_arch = "x86_64")]
        Some(Isa::Avx2) => "AVX2",
        #[cfg(target_arch = "x86_64")]
        Some(Isa::Sse2) => "SSE2",
        _ => "portable",
    }
}

type Trace = unsafe fn(&Tree, &Ray) -> Option<Hit>;

/// The two functions that traverse a tree.
#[derive(Clone, Copy)]
pub(super) struct Kernel {
    closest: Trace,
    any: Trace,
}

impl Kernel {
    /// The kernel for an available instruction set. Trees without solids get a kernel without code for solids.
    pub(super) fn new(isa: Isa, solids: bool) -> Self {
        assert!(Isa::available().contains(&isa), "this processor has no {isa:?}");
        let (closest, any): (Trace, Trace) = match (isa, solids) {
            (Isa::Portable, _) => (portable::trace::<false>, portable::trace::<true>),
            #[cfg(target_arch = "x86_64")]
            (Isa::Sse2, false) => {
                (kernel_x86::trace_sse2::<false, false>, kernel_x86::trace_sse2::<true, false>)
            }
            #[cfg(target_arch = "x86_64")]
            (Isa::Sse2, true) => {
                (kernel_x86::trace_sse2::<false, true>, kernel_x86::trace_sse2::<true, true>)
            }
            #[cfg(target_arch = "x86_64")]
            (Isa::Avx2, false) => {
                (kernel_x86::trace_avx2::<false, false>, kernel_x86::trace_avx2::<true, false>)
            }
            #[cfg(target_arch = "x86_64")]
            (Isa::Avx2, true) => {
                (kernel_x86::trace_avx2::<false, true>, kernel_x86::trace_avx2::<true, true>)
            }
            #[cfg(target_arch = "x86_64")]
            (Isa::Avx512, false) => {
                (kernel_x86::trace_avx512::<false, false>, kernel_x86::trace_avx512::<true, false>)
            }
            #[cfg(target_arch = "x86_64")]
            (Isa::Avx512, true) => {
                (kernel_x86::trace_avx512::<false, true>, kernel_x86::trace_avx512::<true, true>)
            }
        };
        Kernel { closest, any }
    }

    /// The kernel for the best available instruction set.
    pub(super) fn best(solids: bool) -> Self {
        let isa = Isa::available().pop().unwrap_or(Isa::Portable);
        Kernel::new(isa, solids)
    }

    #[inline]
    pub(super) fn closest(&self, tree: &Tree, ray: &Ray) -> Option<Hit> {
        // SAFETY: `new` returns only kernels whose instructions this processor supports.
        unsafe { (self.closest)(tree, ray) }
    }

    #[inline]
    pub(super) fn any(&self, tree: &Tree, ray: &Ray) -> Option<u32> {
        // SAFETY: `new` returns only kernels whose instructions this processor supports.
        unsafe { (self.any)(tree, ray).map(|hit| hit.prim) }
    }
}
