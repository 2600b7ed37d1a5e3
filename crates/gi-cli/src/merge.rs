//! Adds up the passes of several runs, from their checkpoints.

use std::ops::Range;
use std::path::Path;

use gi_core::film::Film;
use gi_core::technique::Technique;

use crate::checkpoint::{Checkpoint, Identity, Summary, refuse};
use crate::say::say;
use crate::{Common, Failure};

/// A file, and which passes it holds.
struct Shard<'a> {
    path: &'a Path,
    seed: String,
    passes: Range<u32>,
}

/// Add up the passes of checkpoints, in any order. One is in memory at a time. Returns the number of the last pass.
pub(crate) fn merge<'a>(
    technique: &mut impl Technique<'a>,
    common: &Common,
    [film, spare]: [&mut Film; 2],
    identity: &Identity,
) -> Result<u32, Failure> {
    let independent = technique.passes_are_independent();
    let differs: &[&str] = if independent { &[] } else { &["seed"] };
    let look = |path| {
        let Summary { seed, passes } = Checkpoint::look(path, identity, differs)?;
        Ok(Shard { path, seed, passes })
    };
    let shards = common.merge.iter().map(|path| look(path));
    let mut shards = shards.collect::<Result<Vec<Shard>, Failure>>()?;
    // Their order on the command line must not matter.
    shards.sort_by_key(|shard| {
        (shard.passes.start, shard.passes.end, shard.seed.len(), shard.seed.clone())
    });
    if independent { check_ranges(&shards) } else { check_seeds(&shards) }?;
    for shard in &shards {
        let checkpoint = Checkpoint::read(shard.path)?;
        let passes =
            checkpoint.resume(identity, differs, spare, |state| technique.merge_state(state))?;
        if passes != shard.passes {
            return Err(refuse(shard.path, "another program has just written it"));
        }
        film.merge(spare);
    }
    if !independent && !common.quiet {
        say(format!(
            "the passes of this method build on each other: the picture is the mean over {} runs with their own seeds, weighted by their passes",
            shards.len()
        ));
    }
    Ok(shards.iter().map(|shard| shard.passes.end).max().unwrap_or(0).saturating_sub(1))
}

/// Check that every pass from the first to the last is there once. The shards are sorted.
fn check_ranges(shards: &[Shard]) -> Result<(), Failure> {
    let mut next = 0;
    for shard in shards {
        let Range { start, end } = shard.passes;
        if start < next {
            return Err(refuse(
                shard.path,
                &format!("its passes {} are in another file too", range(start..next.min(end))),
            ));
        }
        if start > next {
            return Err(refuse(
                shard.path,
                &format!(
                    "it begins with pass {start}, and no file holds {}; give the files of all passes",
                    range(next..start)
                ),
            ));
        }
        next = end;
    }
    Ok(())
}

/// Check that no seed is there twice.
fn check_seeds(shards: &[Shard]) -> Result<(), Failure> {
    for (k, shard) in shards.iter().enumerate() {
        if let Some(other) = shards[..k].iter().find(|other| other.seed == shard.seed) {
            let cause = format!(
                "it has the same seed as {}, {}; the passes of this method build on each other, so separate runs must have separate seeds",
                other.path.display(),
                shard.seed
            );
            return Err(refuse(shard.path, &cause));
        }
    }
    Ok(())
}

/// The first and the last number of a range, in words.
fn range(passes: Range<u32>) -> String {
    match passes.len() {
        1 => passes.start.to_string(),
        _ => format!("{} to {}", passes.start, passes.end.saturating_sub(1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shards(ranges: &[Range<u32>]) -> Vec<Shard<'static>> {
        let shard = |passes: &Range<u32>| Shard {
            path: Path::new("a.checkpoint"),
            seed: "1".into(),
            passes: passes.clone(),
        };
        ranges.iter().map(shard).collect()
    }

    #[test]
    fn every_pass_must_be_there_once() {
        assert!(check_ranges(&shards(&[0..3, 3..4, 4..9])).is_ok());
        let cause = |ranges: &[Range<u32>]| match check_ranges(&shards(ranges)) {
            Err(failure) => failure.text().to_string(),
            Ok(()) => panic!("{ranges:?} were accepted"),
        };
        assert!(cause(&[0..3, 2..5]).contains("its passes 2 are in another file"));
        assert!(cause(&[0..3, 0..3]).contains("0 to 2 are in another file"));
        assert!(cause(&[0..3, 5..9]).contains("no file holds 3 to 4"));
        assert!(cause(&[1..9, 9..10]).contains("no file holds 0;"));
    }
}
