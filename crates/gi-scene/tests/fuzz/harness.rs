//! Runs a check on many damaged files, one after the other.
//!
//! Each run takes a few seconds, or `GILAB_FUZZ_SECONDS`. `GILAB_FUZZ_SEED` changes the damage.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use super::damage::{Damage, Rng};

/// Time per run without `GILAB_FUZZ_SECONDS`.
const SECONDS: u64 = 4;
/// Longest time for one input, both in the world and of the processors that this process had: a busy machine is no hang.
const MOST: Duration = Duration::from_secs(10);
/// How often the processor time is read: that takes longer than many an input.
const READ_EVERY: Duration = Duration::from_millis(100);

fn number(variable: &str, default: u64) -> u64 {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// Damage these files in many ways until the time is over. `check` says whether an input is valid, or what must not
/// happen. A panic and a hang must not happen either. An input that fails is kept in the folder for temporary files.
pub(crate) fn fuzz(
    name: &str,
    files: &[Vec<u8>],
    check: impl FnMut(&[u8]) -> Result<bool, String> + Send,
) {
    // On one thread, because to hand small work to another takes longer than the work.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| fuzz_here(name, files, check));
}

fn fuzz_here(name: &str, files: &[Vec<u8>], mut check: impl FnMut(&[u8]) -> Result<bool, String>) {
    let time = Duration::from_secs(number("GILAB_FUZZ_SECONDS", SECONDS));
    let mut rng = Rng(number("GILAB_FUZZ_SEED", 1));
    let (mut inputs, mut valid) = (0u64, 0u64);
    let (start, mut guard) = (Instant::now(), Guard::new());
    while start.elapsed() < time {
        let bytes = Damage { rng: &mut rng, files }.copy();
        match guard.run(|| check(&bytes)) {
            Ok(is_valid) => valid += u64::from(is_valid),
            Err(why) => {
                let kept = std::env::temp_dir().join(format!("gilab-fuzz-{inputs}-{name}"));
                std::fs::write(&kept, &bytes).unwrap();
                panic!("input {inputs}, kept as {}: {why}", kept.display());
            }
        }
        inputs += 1;
    }
    let rate = inputs as f64 / start.elapsed().as_secs_f64();
    println!("{name}: {inputs} inputs, {valid} of them valid, {rate:.0} per second");
    assert!(inputs > 10 && valid > 0, "{name}: {inputs} inputs, {valid} valid");
}

/// The result of a check of one input. A panic is an error, and so is a long time.
#[allow(dead_code)] // not every test has single inputs
pub(crate) fn guarded(check: impl FnOnce() -> Result<bool, String>) -> Result<bool, String> {
    Guard::new().run(check)
}

/// Checks inputs, and turns panics and hangs into errors.
pub(crate) struct Guard {
    /// When the processor time was read.
    read: Instant,
    /// The processor time at that time, where the system tells it.
    processor: Option<Duration>,
}

impl Guard {
    pub(crate) fn new() -> Self {
        Guard { read: Instant::now(), processor: processor_time() }
    }

    /// The result of a check of one input.
    pub(crate) fn run(
        &mut self,
        check: impl FnOnce() -> Result<bool, String>,
    ) -> Result<bool, String> {
        let start = Instant::now();
        if start - self.read > READ_EVERY {
            *self = Guard::new();
        }
        let valid = catch_unwind(AssertUnwindSafe(check)).map_err(|_| "panic".to_owned())??;
        let mut time = start.elapsed();
        if time > MOST
            && let (Some(before), Some(after)) = (self.processor, processor_time())
        {
            // A little too long: it was read a little before the check.
            time = time.min(after - before);
        }
        if time > MOST { Err(format!("it took {time:?}")) } else { Ok(valid) }
    }
}

/// Processor time of this process so far, where the system tells it.
fn processor_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the program's name in parentheses, fields 3, 4, ...; 14 and 15 are hundredths of seconds.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let hundredths = [11, 12].map(|k| fields.get(k).and_then(|field| field.parse::<u64>().ok()));
    Some(Duration::from_millis(10 * (hundredths[0]? + hundredths[1]?)))
}
