//! The memory that a scene may take. Every large allocation is counted before it is made.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Number of consumers that an error names.
const NAMED: usize = 3;

/// The memory of a whole scene, in bytes: what it may take, and what its files have taken.
#[derive(Debug, Default)]
pub(crate) struct Budget {
    limit: u64,
    taken: Mutex<Taken>,
}

#[derive(Debug, Default)]
struct Taken {
    total: u64,
    by: BTreeMap<String, u64>,
    /// Whether an error has named the largest consumers already.
    named: bool,
}

impl Budget {
    pub(crate) fn new(limit: u64) -> Self {
        Budget { limit, taken: Mutex::default() }
    }

    /// Memory that is taken now, in bytes.
    pub(crate) fn total(&self) -> u64 {
        self.taken().total
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A claim of nothing yet, for a file or for something else with a name.
    pub(crate) fn claim(&self, what: impl fmt::Display) -> Claim<'_> {
        Claim { budget: self, what: what.to_string(), bytes: 0 }
    }

    fn take(&self, what: &str, bytes: u64) -> Result<(), String> {
        let mut taken = self.taken();
        if bytes <= self.limit - taken.total.min(self.limit) {
            taken.total += bytes;
            *taken.by.entry(what.to_owned()).or_default() += bytes;
            return Ok(());
        }
        let most = Size(self.limit);
        if std::mem::replace(&mut taken.named, true) {
            return Err(format!("the scene would take more than {most} of memory"));
        }
        let mut by: Vec<(&String, &u64)> =
            taken.by.iter().filter(|(_, bytes)| **bytes > 0).collect();
        by.sort_by_key(|(name, bytes)| (std::cmp::Reverse(**bytes), name.as_str()));
        let largest = by.iter().take(NAMED).map(|(name, n)| format!("`{name}` {}", Size(**n)));
        let largest: Vec<String> = largest.collect();
        let so_far = match largest.is_empty() {
            true => String::new(),
            false => format!(" {} are taken, most by {}.", Size(taken.total), largest.join(", ")),
        };
        Err(format!(
            "it needs {} more, and the scene may take {most} of memory.{so_far} --max-memory raises the limit",
            Size(bytes)
        ))
    }

    fn give_back(&self, what: &str, bytes: u64) {
        let mut taken = self.taken();
        taken.total -= bytes;
        if let Some(of_it) = taken.by.get_mut(what) {
            *of_it -= bytes;
            if *of_it == 0 {
                taken.by.remove(what);
            }
        }
    }
}

/// Memory taken from a budget. It is given back when the claim is dropped, unless it is kept.
#[derive(Debug)]
pub(crate) struct Claim<'a> {
    budget: &'a Budget,
    what: String,
    bytes: u64,
}

impl Claim<'_> {
    /// Take as many bytes in all, or give back the rest.
    ///
    /// # Errors
    /// A message without the name of the file. The claim is unchanged.
    pub(crate) fn set(&mut self, bytes: u64) -> Result<(), String> {
        match bytes.checked_sub(self.bytes) {
            Some(more) => self.budget.take(&self.what, more)?,
            None => self.budget.give_back(&self.what, self.bytes - bytes),
        }
        self.bytes = bytes;
        Ok(())
    }

    /// Take more if the claim is smaller. In steps, because something grows by many small pieces.
    pub(crate) fn at_least(&mut self, bytes: u64) -> Result<(), String> {
        const STEP: u64 = 1 << 20;
        if bytes <= self.bytes { Ok(()) } else { self.set(bytes + STEP) }
    }

    /// Set the final size, and keep it for as long as the scene is being loaded.
    pub(crate) fn keep(mut self, bytes: u64) -> Result<(), String> {
        self.set(bytes)?;
        self.bytes = 0;
        Ok(())
    }
}

impl Drop for Claim<'_> {
    fn drop(&mut self) {
        if self.bytes > 0 {
            self.budget.give_back(&self.what, self.bytes);
        }
    }
}

/// A number of bytes, for messages.
struct Size(u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = [(1_000_000_000, "GB"), (1_000_000, "MB"), (1000, "kB")];
        match units.iter().find(|(unit, _)| self.0 >= *unit) {
            Some((unit, name)) => write!(f, "{:.1} {name}", self.0 as f64 / *unit as f64),
            None => write!(f, "{} bytes", self.0),
        }
    }
}

/// Half of this machine's memory, or of what its control group may use.
pub(crate) fn half_of_the_machine() -> u64 {
    /// If the system does not say how much there is.
    const UNKNOWN: u64 = 8 << 30;
    let installed = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
    });
    let group = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok();
    let group = group.and_then(|text| text.trim().parse::<u64>().ok());
    installed.into_iter().chain(group).min().unwrap_or(UNKNOWN) / 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_names_the_largest_consumers() {
        let budget = Budget::new(10_000_000);
        budget.claim("a.exr").keep(6_000_000).unwrap();
        budget.claim("b.exr").keep(1_000_000).unwrap();
        let mut third = budget.claim("c.exr");
        assert_eq!(
            third.set(4_000_000).unwrap_err(),
            "it needs 4.0 MB more, and the scene may take 10.0 MB of memory. 7.0 MB are taken, most by \
             `a.exr` 6.0 MB, `b.exr` 1.0 MB. --max-memory raises the limit"
        );
        third.set(3_000_000).unwrap();
        drop(third);
        budget.claim("d.exr").keep(3_000_000).unwrap();
        assert!(budget.claim("e").set(u64::MAX).unwrap_err().contains("more than 10.0 MB"));
    }
}
