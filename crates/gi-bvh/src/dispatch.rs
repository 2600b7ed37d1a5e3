//! Chooses the kernel that traverses a tree, from the processor's instruction sets.

use std::sync::OnceLock;

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

/// Environment variable that forces an instruction set: `avx512`, `avx2`, `sse2` or `portable`.
pub const ISA_VARIABLE: &str = "GILAB_ISA";

/// Check [`ISA_VARIABLE`]. Rays ignore a wrong value.
///
/// # Errors
/// One line: the variable names an unknown instruction set, or one that this processor does not have.
pub fn check_instruction_set() -> Result<(), String> {
    chosen().as_ref().map(|_| ()).map_err(String::clone)
}

/// The name of the instruction set that rays are traced with: the one that [`ISA_VARIABLE`] names, or else the fastest
/// that this processor has.
pub fn instruction_set() -> &'static str {
    match best() {
        Isa::Portable => "portable",
        #[cfg(target_arch = "x86_64")]
        Isa::Sse2 => "SSE2",
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => "AVX2",
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => "AVX-512",
    }
}

fn best() -> Isa {
    let fastest = || Isa::available().pop().unwrap_or(Isa::Portable);
    chosen().as_ref().ok().copied().flatten().unwrap_or_else(fastest)
}

/// What [`ISA_VARIABLE`] names; `None` if it is not set. It is read once.
fn chosen() -> &'static Result<Option<Isa>, String> {
    static CHOSEN: OnceLock<Result<Option<Isa>, String>> = OnceLock::new();
    let parse = |name: std::ffi::OsString| Isa::parse(&name.to_string_lossy());
    let name = || std::env::var_os(ISA_VARIABLE).filter(|name| !name.is_empty());
    CHOSEN.get_or_init(|| name().map(parse).transpose())
}

impl Isa {
    fn parse(name: &str) -> Result<Isa, String> {
        // As pictures write it, too: AVX-512.
        let isa = match name.to_ascii_lowercase().replace('-', "").as_str() {
            "portable" => Isa::Portable,
            #[cfg(target_arch = "x86_64")]
            "sse2" => Isa::Sse2,
            #[cfg(target_arch = "x86_64")]
            "avx2" => Isa::Avx2,
            #[cfg(target_arch = "x86_64")]
            "avx512" => Isa::Avx512,
            _ => {
                let known = "use portable, or on x86-64 sse2, avx2 or avx512";
                return Err(format!("{ISA_VARIABLE}={name} is no instruction set: {known}"));
            }
        };
        if Isa::available().contains(&isa) {
            Ok(isa)
        } else {
            Err(format!("{ISA_VARIABLE}={name}: this processor does not have these instructions"))
        }
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

    /// The kernel for the instruction set that is used, see [`instruction_set`].
    pub(super) fn best(solids: bool) -> Self {
        Kernel::new(best(), solids)
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
