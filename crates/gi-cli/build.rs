//! Tells the programs which version and commit they are built from. Without git, or outside of a repository, the commit is
//! unknown, which is no error.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rerun-if-env-changed=GILAB_COMMIT");
    let given = std::env::var("GILAB_COMMIT").ok();
    // Looked up for release builds only: others would be built anew after every commit.
    let is_release = std::env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = given.or_else(|| if is_release { commit() } else { None });
    let commit = commit.unwrap_or_default();
    let number = std::env::var("CARGO_PKG_VERSION").unwrap_or_default();
    let version = if commit.is_empty() { number } else { format!("{number} (commit {commit})") };
    println!("cargo:rustc-env=GILAB_COMMIT={commit}");
    println!("cargo:rustc-env=GILAB_VERSION={version}");
}

/// The commit that is checked out, marked if files differ from it.
fn commit() -> Option<String> {
    for watched in [git(&["rev-parse", "--git-path", "logs/HEAD"])?, "..".into()] {
        if Path::new(&watched).exists() {
            println!("cargo:rerun-if-changed={watched}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?;
    let changes = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(if changes.is_empty() { commit } else { format!("{commit} with changes") })
}

/// What git says.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok().filter(|_| output.status.success())?;
    Some(text.trim().to_string())
}
