//! The passes of a run: made until the budget is spent, gone on with from a checkpoint, or added up from several.

use std::ops::Range;
use std::time::Instant;

use gi_core::camera::Camera;
use gi_core::film::Film;
use gi_core::filter::Filter;
use gi_core::technique::Technique;

use crate::checkpoint::{Checkpoint, Identity, Keeper, no_state};
use crate::progress::Progress;
use crate::{Common, Failure, Program};

/// What a checkpoint must have in common with a run.
pub(crate) fn identity<P: Program>(
    common: &Common,
    world: u64,
    camera: &Camera,
    filter: Filter,
) -> Identity {
    vec![
        ("program", P::command().get_name().to_string()),
        ("scene", format!("{world:016x}")),
        ("camera", format!("{camera:?}")),
        ("filter", format!("{filter:?}")),
        ("seed", common.seed.to_string()),
        ("component", format!("{:?}", common.component)),
    ]
}

/// Passes until the budget is spent, or the technique says that it is enough.
pub(crate) fn passes<'a>(
    technique: &mut impl Technique<'a>,
    common: &Common,
    film: &mut Film,
    identity: &Identity,
    start: Instant,
) -> Result<(), Failure> {
    let budget = common.budget();
    let first = common.first_pass;
    if first > 0 && !technique.passes_are_independent() {
        return Err(Failure::Input(
            "error: --first-pass: the passes of this method build on each other".into(),
        ));
    }
    // Before the work, not after it.
    if common.checkpoint.is_some() {
        technique.save_state().ok_or_else(no_state)?;
    }
    let mut made = first..first;
    let mut keeper = common.checkpoint.as_deref().map(|path| Keeper::new(path, identity));
    if let (true, Some(path)) = (common.resume, &common.checkpoint) {
        made = Checkpoint::read(path)?.resume(identity, technique, film)?;
        if made.start != first {
            let text = format!("error: {} begins with pass {}", path.display(), made.start);
            return Err(Failure::Input(text));
        }
    }
    let progress = Progress::new(budget, film.size(), common.quiet);
    while budget.goes_on(made.len() as u32, start.elapsed())
        && made.end < u32::MAX - 1
        && !technique.is_done()
    {
        technique.pass(made.end, film);
        made.end += 1;
        progress.update(made.len() as u32, start.elapsed());
        if let Some(keeper) = &mut keeper {
            keeper.keep(technique, film, &made, false)?;
        }
    }
    progress.finish();
    match &mut keeper {
        Some(keeper) => keeper.keep(technique, film, &made, true),
        None => Ok(()),
    }
}

/// Add up the passes of checkpoints.
pub(crate) fn merge<'a>(
    technique: &mut impl Technique<'a>,
    common: &Common,
    [film, spare]: [&mut Film; 2],
    identity: &Identity,
) -> Result<(), Failure> {
    let mut all: Vec<Range<u32>> = Vec::new();
    for path in &common.merge {
        let passes =
            Checkpoint::read(path)?.merge(identity, technique, [&mut *film, &mut *spare])?;
        if let Some(twice) = all.iter().find(|r| r.start < passes.end && passes.start < r.end) {
            let text = format!(
                "error: {}: its passes {passes:?} overlap with {twice:?} of another",
                path.display()
            );
            return Err(Failure::Input(text));
        }
        all.push(passes);
    }
    Ok(())
}
