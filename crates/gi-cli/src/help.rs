//! How the help is arranged, and what is made of it: man pages and completions for shells.

use std::process::ExitCode;

use clap::{Arg, Command};
use clap_complete::Shell;

use crate::say::{print, say};

/// The flag that prints a man page or completions. It is for `make install`, and the help does not list it.
pub(crate) const GENERATE: &str = "--generate";

/// A program's command with the technique's flags under headings and an example at the end.
pub(crate) fn arranged(command: Command) -> Command {
    let name = command.get_name().to_string();
    let command = command.mut_args(|flag| {
        let heading = if is_for_figures(&flag) { "Figures" } else { "Technique" };
        if flag.get_help_heading().is_some() { flag } else { flag.help_heading(heading) }
    });
    command.after_help(format!(
        "Example: a small picture of 4 passes, with statistics\n  {name} scenes/cornell-box.xml -o out.exr --size 256x256 --spp 4 --stats run.json"
    ))
}

/// Whether a flag shows what a technique does, instead of changing it.
pub(crate) fn is_for_figures(flag: &Arg) -> bool {
    let name = flag.get_long().unwrap_or_default();
    let begins =
        ["show", "probe", "trace-pixel", "pixel"].iter().any(|word| name.starts_with(word));
    let is_points = name.ends_with("-out") && !["cache-out", "map-out"].contains(&name);
    begins || is_points
}

/// Print the man page (`what` is "man") or the completions for a shell: bash, elvish, fish, powershell or zsh.
pub fn generate(mut command: Command, what: &str) -> ExitCode {
    let name = command.get_name().to_string();
    let mut bytes = Vec::new();
    let done = match what.parse::<Shell>() {
        _ if what == "man" => clap_mangen::Man::new(command).render(&mut bytes).is_ok(),
        Ok(shell) => {
            clap_complete::generate(shell, &mut command, name, &mut bytes);
            true
        }
        Err(_) => false,
    };
    if !done {
        say(format!(
            "error: {GENERATE} {what}: expected man, bash, elvish, fish, powershell or zsh"
        ));
        return ExitCode::from(2);
    }
    print(String::from_utf8_lossy(&bytes));
    ExitCode::SUCCESS
}
