//! How long a run lasts.

use std::time::Duration;

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    /// After so many passes.
    Passes(u32),
    /// With the first pass that ends after this time, preparation included. For comparisons at equal time; the bits
    /// then depend on the machine.
    Time(Duration),
}

impl Budget {
    /// Whether there is to be another pass, `passes` done and `elapsed` gone.
    pub fn goes_on(self, passes: u32, elapsed: Duration) -> bool {
        match self {
            Budget::Passes(n) => passes < n,
            Budget::Time(time) => passes == 0 || elapsed < time,
        }
    }
}

/// A time span with its unit: 500ms, 30s, 5m, 1.5h; a bare number is seconds.
///
/// # Errors
/// What was expected.
pub fn parse_time(text: &str) -> Result<Duration, String> {
    let units = [("ms", 1e-3), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let split =
        units.iter().find_map(|(unit, seconds)| text.strip_suffix(unit).map(|n| (n, *seconds)));
    let (number, unit) = split.unwrap_or((text, 1.0));
    let value: f64 = number.trim().parse().map_err(|_| "expected a time span: 30s, 5m, 1.5h")?;
    // Thirty years are as good as for ever, and safely within what a Duration holds.
    if !(value * unit > 0.0 && value * unit < 1e9) {
        return Err("expected a time span above zero and below 30 years".into());
    }
    Ok(Duration::from_secs_f64(value * unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_spans() {
        let ms = |t| parse_time(t).map(|d| d.as_millis());
        assert_eq!(ms("30s"), Ok(30_000));
        assert_eq!(ms("500ms"), Ok(500));
        assert_eq!(ms("1.5h"), Ok(5_400_000));
        assert_eq!(ms("2"), Ok(2_000));
        assert!(
            ["", "s", "-1s", "0", "nan", "inf", "1e30h"].iter().all(|t| parse_time(t).is_err())
        );
    }

    #[test]
    fn at_least_one_pass_in_any_time() {
        let second = Duration::from_secs(1);
        assert!(Budget::Time(second).goes_on(0, 2 * second));
        assert!(!Budget::Time(second).goes_on(1, 2 * second));
        assert!(Budget::Passes(2).goes_on(1, 9 * second) && !Budget::Passes(2).goes_on(2, second));
    }
}
