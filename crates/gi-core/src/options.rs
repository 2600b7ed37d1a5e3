//! Command-line options that several techniques share, and the trait of all parameters.
//!
//! A technique declares its own options in its `params.rs`: type, default, valid range and help of each option are in
//! one place. The options in this file are flattened into them.

use std::path::PathBuf;
use std::str::FromStr;
use std::sync::LazyLock;

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, ValueEnum};

/// The parameters of a technique: its part of the command line.
pub trait Parameters: Args {
    /// Check rules that involve several options.
    ///
    /// # Errors
    /// A message of one line that names the options and says what is wrong with them.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// The largest number of segments of a path; `None` is unbounded.
    fn max_depth(&self) -> Option<u32>;

    /// Whether the technique simulates participating media.
    fn simulates_media(&self) -> bool {
        false
    }

    /// Whether it also simulates media whose density varies.
    fn simulates_varying_media(&self) -> bool {
        false
    }

    /// Whether the technique reliably finds caustics, by paths that start at the lights. `has_media` tells whether the scene has media.
    fn finds_focused_light(&self, _has_media: bool) -> bool {
        false
    }

    /// Whether the technique's paths from the eye find the light sources in view, so that [`crate::eye::SourceRays`] can
    /// find them instead.
    fn can_leave_out_sources(&self) -> bool {
        true
    }

    /// Files to write in addition to the picture. [`crate::technique::Technique::export`] returns their contents.
    fn outputs(&self) -> Vec<PathBuf> {
        Vec::new()
    }
}

/// The values that an empty command line gives. Every option then has its default, so the code need not repeat it.
pub fn defaults<A: Args>() -> A {
    let command = A::augment_args(Command::new("defaults"));
    let matches = command.try_get_matches_from(["defaults"]).expect("no option is required");
    A::from_arg_matches(&matches).expect("every option has a default")
}

/// A value parser for numbers. `range` describes the numbers that `is_valid` accepts; error messages quote it.
pub fn number<T: FromStr + 'static>(
    range: &'static str,
    is_valid: fn(&T) -> bool,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text| text.parse().ok().filter(is_valid).ok_or_else(|| format!("expected {range}"))
}

/// Parse the position of a pixel: its column and its row, counted from the top left corner.
///
/// # Errors
/// A message with the expected format.
pub fn pixel(text: &str) -> Result<[usize; 2], String> {
    let wrong = "expected two pixel coordinates from the top left corner: X,Y";
    let (x, y) = text.split_once(',').ok_or(wrong)?;
    let number = |t: &str| t.trim().parse().map_err(|_| wrong.to_string());
    Ok([number(x)?, number(y)?])
}

/// Default of `--rr-depth`, and its value in programs without that option.
const RR_DEPTH: u32 = 2;

/// Limits of path lengths. These are the options `--max-depth`, and `--rr-depth` in programs that add [`rr_depth`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathLimits {
    /// The largest number of segments of a path; `None` is unbounded.
    pub max_depth: Option<u32>,
    /// Number of segments after which Russian roulette may end a path. For eye paths that had an estimate it is at least 5.
    pub rr_depth: u32,
}

impl PathLimits {
    /// Whether a path with this many segments may have another one.
    #[inline]
    pub fn goes_on(&self, segments: u32) -> bool {
        self.max_depth.is_none_or(|most| segments < most)
    }
}

impl Default for PathLimits {
    fn default() -> Self {
        PathLimits { max_depth: None, rr_depth: RR_DEPTH }
    }
}

/// The option `--max-depth`.
fn max_depth() -> Arg {
    let parse = |text: &str| match text.parse() {
        Ok(-1) => Ok(None),
        Ok(n @ 1i32..) => Ok(Some(n as u32)),
        _ => Err("a path has at least 1 segment; -1 is unbounded"),
    };
    Arg::new("max_depth")
        .long("max-depth")
        .value_name("N")
        .default_value("-1")
        .allow_negative_numbers(true)
        .value_parser(parse)
        .help("Largest number of segments of a path: 1 shows only lights, 2 adds direct light; -1 is unbounded")
}

/// The option `--rr-depth`. [`PathLimits`] reads it in programs that have it.
pub fn rr_depth() -> Arg {
    static DEFAULT: LazyLock<String> = LazyLock::new(|| RR_DEPTH.to_string());
    Arg::new("rr_depth")
        .long("rr-depth")
        .value_name("N")
        .default_value(DEFAULT.as_str())
        .value_parser(clap::value_parser!(u32))
        .help("Number of segments after which Russian roulette may end a path")
}

impl Args for PathLimits {
    fn augment_args(command: Command) -> Command {
        command.arg(max_depth())
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for PathLimits {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut limits = PathLimits::default();
        limits.update_from_arg_matches(matches)?;
        Ok(limits)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        if let Some(most) = matches.get_one("max_depth") {
            self.max_depth = *most;
        }
        // Not all programs have `--rr-depth`; in the others, clap does not know the name.
        if let Ok(Some(depth)) = matches.try_get_one("rr_depth") {
            self.rr_depth = *depth;
        }
        Ok(())
    }
}

/// Part of the light that a picture shows, see [`crate::film::Components`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Show {
    /// All light
    #[default]
    All,
    /// Light sources that are visible, and direct illumination of the visible surface
    Direct,
    /// Light that was scattered at least twice by surfaces or media other than mirrors and glass
    Indirect,
    /// Light that mirrors and glass focus onto the visible surface
    Caustic,
}

/// Which surface the layers Albedo, N and Z describe.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SurfaceLayers {
    /// The first surface that the eye sees
    #[default]
    First,
    /// The first surface that is not a mirror or clear glass; its albedo is multiplied by what those reflect or transmit
    NonSpecular,
}

/// How light focused by mirrors and glass is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Caustics {
    /// By paths from the eye: unbiased, but small lamps behind glass show as bright specks
    Path,
    /// By photons: blurred over discs that shrink from pass to pass
    Photon,
}

/// The option `--caustics`.
#[derive(Args, Clone, Copy, Debug, PartialEq, Eq)]
pub struct CausticOptions {
    /// How light focused by mirrors and glass is found
    #[arg(long, value_enum, default_value_t = Caustics::Photon)]
    pub caustics: Caustics,
}

impl CausticOptions {
    /// Whether photons find that light.
    pub fn by_photons(&self) -> bool {
        self.caustics == Caustics::Photon
    }
}

impl From<Caustics> for CausticOptions {
    fn from(caustics: Caustics) -> Self {
        CausticOptions { caustics }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Parse a command line in a program with these options.
    fn parse<A: Args>(arguments: &[&str]) -> Result<A, clap::Error> {
        let command = A::augment_args(Command::new("test").no_binary_name(true));
        A::from_arg_matches(&command.try_get_matches_from(arguments)?)
    }

    #[derive(Args)]
    #[command(arg(rr_depth()))]
    struct WithRoulette {
        #[command(flatten)]
        limits: PathLimits,
    }

    #[test]
    fn an_empty_command_line_gives_the_default_limits() {
        assert_eq!(defaults::<PathLimits>(), PathLimits::default());
        assert_eq!(defaults::<WithRoulette>().limits, PathLimits::default());
    }

    #[test]
    fn depths_are_read_and_only_programs_with_roulette_have_its_option() {
        let given = parse::<PathLimits>(&["--max-depth", "3"]).expect("a depth");
        assert_eq!(given, PathLimits { max_depth: Some(3), rr_depth: RR_DEPTH });
        assert_eq!(parse::<PathLimits>(&["--max-depth", "-1"]).expect("a depth").max_depth, None);
        assert!(parse::<PathLimits>(&["--rr-depth", "9"]).is_err());
        let given = parse::<WithRoulette>(&["--rr-depth", "9"]).expect("a depth");
        assert_eq!(given.limits, PathLimits { max_depth: None, rr_depth: 9 });
        for wrong in ["0", "-2", "x", "3000000000"] {
            let message = parse::<PathLimits>(&["--max-depth", wrong]).expect_err(wrong);
            assert!(message.to_string().contains("at least 1 segment"), "{message}");
        }
    }

    #[test]
    fn numbers_outside_their_range_are_refused_and_the_error_states_the_range() {
        let share = number("a number from 0 to 1", |x: &f32| (0.0..=1.0).contains(x));
        assert_eq!(share("0.5"), Ok(0.5));
        for wrong in ["1.1", "nan", "x", ""] {
            assert_eq!(share(wrong), Err("expected a number from 0 to 1".into()), "{wrong}");
        }
    }

    #[test]
    fn pixels() {
        assert_eq!(pixel("3, 4"), Ok([3, 4]));
        assert!(["3", "3,4,5", "-1,4", "1.5,4", ","].iter().all(|t| pixel(t).is_err()));
    }
}
