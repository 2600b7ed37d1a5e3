//! `--help` states the defaults that the code uses.

use std::collections::HashMap;
use std::fmt::Debug;

use clap::{Args, Command};
use gi_core::options::PathLimits;

/// The help of a program's options, by their names without `--`.
fn help_by_option(command: &mut Command) -> HashMap<String, String> {
    let help = command.render_long_help().to_string();
    let options = help.split("\n      --").skip(1);
    options
        .map(|text| {
            let name = text.split([' ', '\n', '=', ',']).next().expect("a name");
            (name.to_string(), text.split_whitespace().collect::<Vec<_>>().join(" "))
        })
        .collect()
}

/// The values in the `{:?}` text of parameters, by field name, including fields of nested structs.
fn values_by_field(parameters: &impl Debug) -> HashMap<String, String> {
    let text = format!("{parameters:?}");
    let fields = text.split(['{', '}', ',']).filter_map(|part| part.split_once(": "));
    fields.map(|(name, value)| (name.trim().to_string(), value.trim().to_string())).collect()
}

/// Whether a value in the help equals that of a field: the same number, or the name of the same variant.
fn is_same(said: &str, value: &str) -> bool {
    match (said.parse::<f64>(), value.parse::<f64>()) {
        (Ok(said), Ok(value)) => said == value,
        _ => said.replace('-', "") == value.to_lowercase(),
    }
}

/// Check the help of all options of a technique against its default parameters. Returns the number of defaults.
fn check<P: Args + Default + Debug>(program: &str) -> usize {
    let mut command = P::augment_args(Command::new("program"));
    let help = help_by_option(&mut command);
    let mut values = values_by_field(&P::default());
    // Values whose `{:?}` text differs from that on the command line.
    assert_eq!(values.insert("max_depth".into(), "-1".into()).as_deref(), Some("None"));
    if let Some(total) = values.get("total").cloned() {
        values.insert("lights".into(), total);
    }
    let mut count = 0;
    for option in command.get_arguments().filter(|a| !a.get_default_values().is_empty()) {
        let Some(name) = option.get_long().filter(|_| option.get_action().takes_values()) else {
            continue;
        };
        let text = help.get(name).unwrap_or_else(|| panic!("{program}: no help for --{name}"));
        let said = text.rsplit_once("[default: ").and_then(|(_, rest)| rest.split_once(']'));
        let (said, _) = said.unwrap_or_else(|| panic!("{program}: no default of --{name}: {text}"));
        let id = option.get_id().as_str();
        let value = values.get(id).unwrap_or_else(|| panic!("{program}: no field {id}"));
        assert!(is_same(said, value), "{program}: --{name} says {said}, the code {value}");
        count += 1;
    }
    count
}

#[test]
fn help_states_the_defaults_of_the_code() {
    let counts = [
        check::<pathtrace::Params>("pathtrace"),
        check::<irrcache::Params>("irrcache"),
        check::<radcache::Params>("radcache"),
        check::<photonmap::Params>("photonmap"),
        check::<ppm::Params>("ppm"),
        check::<instant_radiosity::Params>("instant-radiosity"),
        check::<lightcuts::Params>("lightcuts"),
    ];
    // pathtrace has --mode, --max-depth and --rr-depth; the others have more.
    assert!(counts.iter().all(|count| *count >= 3), "{counts:?}");
}

/// `--max-cut` has two defaults, which its help describes in words.
#[test]
fn help_states_the_default_of_the_largest_cut() {
    let help = help_by_option(&mut lightcuts::Params::augment_args(Command::new("program")));
    let most = lightcuts::Params::default().cut.max_clusters();
    assert!(help["max-cut"].contains(&format!("[default: {most}, ")), "{}", help["max-cut"]);
}

#[test]
fn defaults_that_differ_from_the_help_are_found() {
    #[derive(Args, Debug)]
    struct Wrong {
        #[arg(long, default_value_t = 0.5)]
        alpha: f32,
        #[command(flatten)]
        limits: PathLimits,
    }
    impl Default for Wrong {
        fn default() -> Self {
            Wrong { alpha: 0.7, limits: PathLimits::default() }
        }
    }
    let refused = std::panic::catch_unwind(|| check::<Wrong>("wrong"));
    assert!(refused.is_err(), "the check accepted a default of 0.7 instead of 0.5");
}
