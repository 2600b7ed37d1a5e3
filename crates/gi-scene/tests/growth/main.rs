//! The time to load a scene grows about linearly with its size, whatever the scene contains.
//!
//! `GILAB_GROWTH=1000000 cargo test -p gi-scene --test growth -- --nocapture` prints the times from a thousand elements
//! to that number, and the exponent of each kind. `GILAB_GROWTH_KIND` selects kinds whose names contain it.

#[path = "../common/mod.rs"]
mod common;
mod kinds;

use std::time::{Duration, Instant};

use common::Folder;
use gi_scene::{Options, load};
use kinds::{KINDS, Kind};

/// Processor time that the threads of this process have taken, to the nanosecond, where the system tells it.
fn processor_time() -> Option<Duration> {
    let threads = std::fs::read_dir("/proc/self/task").ok()?;
    let of_thread = |entry: std::fs::DirEntry| {
        let text = std::fs::read_to_string(entry.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    };
    Some(Duration::from_nanos(threads.flatten().filter_map(of_thread).sum()))
}

/// The time to load `n` elements and to show all messages: of processors if the system tells it, because a machine may be busy.
fn time(kind: &Kind, n: usize) -> Duration {
    let folder = Folder::new();
    let path = (kind.write)(&folder, n);
    let (start, before) = (Instant::now(), processor_time());
    let shown = match load(&path, &Options::default()) {
        Ok(loaded) => loaded.warnings.join("\n"),
        Err(problems) => problems.to_string(),
    };
    let processors = processor_time().zip(before).map(|(after, before)| after.abs_diff(before));
    let time = processors.unwrap_or_else(|| start.elapsed());
    let lines = shown.lines().count();
    assert!(lines <= 600, "{}: {lines} lines of messages", kind.name);
    time
}

/// The exponent of the growth from `n` to `m` elements.
fn exponent(n: usize, m: usize, before: Duration, after: Duration) -> f64 {
    (after.as_secs_f64() / before.as_secs_f64()).ln() / (m as f64 / n as f64).ln()
}

#[test]
fn loading_time_is_not_quadratic_in_the_number_of_elements() {
    let Some(most) = std::env::var("GILAB_GROWTH").ok().and_then(|n| n.parse().ok()) else {
        return KINDS.iter().for_each(check);
    };
    let only = std::env::var("GILAB_GROWTH_KIND").unwrap_or_default();
    for kind in KINDS.iter().filter(|kind| kind.name.contains(&only)) {
        let (mut n, mut times) = (1000, Vec::new());
        while n <= most {
            times.push((n, time(kind, n)));
            if times[times.len() - 1].1 > Duration::from_secs(60) {
                break;
            }
            n *= 10;
        }
        let text: Vec<String> =
            times.iter().map(|(n, t)| format!("{n}: {:.3} s", t.as_secs_f64())).collect();
        let exponent = match times[..] {
            [.., (n, before), (m, after)] => exponent(n, m, before, after),
            _ => f64::NAN,
        };
        println!("{:<40} {}, exponent {exponent:.2}", kind.name, text.join(", "));
    }
}

/// Largest exponent of growth. From 2,000 to 16,000 elements, quadratic growth would take 64 times as long, linear growth 8 times. The
/// limit in between leaves room for a busy machine.
const MOST: f64 = 1.6;

fn check(kind: &Kind) {
    // Short times vary most on a busy machine.
    let best = |n: usize| {
        let first = time(kind, n);
        let more = if first < Duration::from_millis(100) { 5 } else { 1 };
        (0..more).map(|_| time(kind, n)).min().map_or(first, |least| least.min(first))
    };
    let few = || best(2_000).max(Duration::from_millis(2));
    let (mut before, mut after) = (few(), best(16_000));
    // Other work on the machine lengthens times. So if they look quadratic, measure again, and keep the shortest.
    for _ in 0..3 {
        if exponent(2_000, 16_000, before, after) >= MOST {
            (before, after) = (before.min(few()), after.min(best(16_000)));
        }
    }
    let found = exponent(2_000, 16_000, before, after);
    assert!(found < MOST, "{}: {before:?}, then {after:?}: n^{found:.2}", kind.name);
}
