//! Coverage-guided fuzzing: libFuzzer changes small valid files of one kind, keeps what reaches new code, and changes
//! that again. The checks are those of the tests in `crates/gi-scene/tests/fuzz` and `tests/fuzz`.
//!
//! `GILAB_FUZZ_KIND` is the kind; `list` prints all of them. The small valid files are written to the folder
//! `GILAB_FUZZ_SEEDS`. All else is libFuzzer's command line. `scripts/fuzz.sh` runs this program.
#![no_main]

#[path = "../../../crates/gi-scene/tests/common/mod.rs"]
mod common;
#[path = "../../../crates/gi-scene/tests/fuzz/corpus.rs"]
mod corpus;
#[path = "../../../crates/gi-scene/tests/fuzz/damage.rs"]
#[allow(dead_code)] // libFuzzer chooses the file
mod damage;
#[path = "../../../crates/gi-scene/tests/fuzz/harness.rs"]
#[allow(dead_code)] // libFuzzer has the loop
mod harness;
mod kinds;
#[path = "../../../crates/gi-scene/tests/fuzz/loaders.rs"]
#[allow(dead_code)] // kinds.rs has the names
mod loaders;
#[path = "../../fuzz/pixels.rs"]
mod pixels;
#[path = "../../fuzz/saved.rs"]
#[allow(dead_code)] // kinds.rs has the names
mod saved;

use std::alloc::System;
use std::cell::RefCell;

use cap::Cap;
use libfuzzer_sys::{fuzz_mutator, fuzz_target, fuzzer_mutate};

use damage::{Damage, Rng};
use kinds::Kind;

/// The repository.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Memory that an input may take besides what its files are allowed: a program has buffers too.
const BESIDES: usize = 1 << 26;

/// An allocation beyond the limit ends the program, and libFuzzer keeps the input.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, usize::MAX);

thread_local! {
    static KIND: RefCell<Option<Kind>> = const { RefCell::new(None) };
}

/// What happens before the first input.
fn start() {
    let variable = |name: &str| std::env::var(name).unwrap_or_default();
    let name = variable("GILAB_FUZZ_KIND");
    if name == "list" {
        println!("{}", kinds::names().join("\n"));
        std::process::exit(0);
    }
    // This thread is the pool: to hand small work to another takes longer than the work.
    rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global().unwrap();
    let Some(kind) = Kind::new(&name) else {
        eprintln!("GILAB_FUZZ_KIND is `{name}`, not one of {}", kinds::names().join(", "));
        std::process::exit(2);
    };
    let folder = variable("GILAB_FUZZ_SEEDS");
    if !folder.is_empty() {
        for (k, bytes) in kind.files.iter().enumerate() {
            std::fs::write(format!("{folder}/seed-{k}"), bytes).unwrap();
        }
    }
    KIND.set(Some(kind));
}

fuzz_target!(init: start(), |bytes: &[u8]| {
    KIND.with_borrow_mut(|kind| {
        let kind = kind.as_mut().expect("set before the first input");
        let limit = MEMORY.allocated() + loaders::MEMORY as usize + BESIDES;
        MEMORY.set_limit(limit).expect("more than there is");
        let checked = kind.check(bytes);
        MEMORY.set_limit(usize::MAX).expect("no limit");
        if let Err(why) = checked {
            eprintln!("{why}");
            std::process::abort();
        }
    });
});

// Half of the changes know what text consists of; the others are libFuzzer's, which know what the code compares with.
fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    if seed.is_multiple_of(2) {
        return fuzzer_mutate(data, size, max_size);
    }
    KIND.with_borrow(|kind| {
        let files = kind.as_ref().map_or(&[][..], |kind| &kind.files);
        let mut bytes = data[..size].to_vec();
        Damage { rng: &mut Rng(u64::from(seed)), files }.once(&mut bytes);
        bytes.truncate(max_size);
        data[..bytes.len()].copy_from_slice(&bytes);
        bytes.len()
    })
});
