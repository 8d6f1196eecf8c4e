//! `motes compare`.

use motes::output::{Output, card_json, card_text};
use motes::{CompareOptions, FilterOptions, Model, MotesError, ProposalName, Running, compare};
use motes_cli::Interrupt;

use super::args::{CompareArgs, on_threads};
use super::failure::Failure;
use super::input;
use super::progress::Progress;
use super::say::{say_ignored, write};

/// Particles of the reference.
pub(super) const REFERENCE_PARTICLES: usize = 20_000;

pub(super) fn run(args: &CompareArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read()?;
    let output = args.output.clone().map(Output::File);
    if let Some(output) = &output {
        output.check().map_err(|source| MotesError::Output { file: output.name(), source })?;
    }
    let filter = FilterOptions {
        particles: args.particles,
        defensive: args.defensive,
        resample_below: args.resample_below,
        resampling: args.resampling,
        seed: args.model.seed,
        ..FilterOptions::default()
    };
    let data = args.data.as_ref().map(|path| input::data(path, &model, interrupt)).transpose()?;
    if let Some(data) = &data {
        say_ignored(&data.columns, args.model.quiet);
    }
    let options = CompareOptions {
        proposals: proposals(args, &model, &filter)?,
        filter,
        particles: args.at.clone(),
        sequences: args.sequences,
        steps: args.steps,
        reference_particles: REFERENCE_PARTICLES,
    };
    let mut progress = Progress::new(1000, args.model.quiet);
    // On one thread unless others are asked for: times are those of one.
    let compared = on_threads(args.model.threads.or(Some(1)), || {
        compare(&model, data.as_ref(), &options, |done, total| {
            progress.done(1000 * done / total.max(1));
            interrupt.check()
        })
    });
    progress.finish();
    let compared = compared??;
    let text = card_text(&compared, args.particles);
    match (&output, args.json) {
        (Some(output), _) => write(output, &text)?,
        (None, false) => write(&Output::Standard, &text)?,
        (None, true) => {}
    }
    if args.json {
        write(&Output::Standard, &card_json(&compared, None))?;
    }
    Ok(0)
}

/// Those asked for, or all that the model has.
fn proposals(
    args: &CompareArgs,
    model: &Model,
    filter: &FilterOptions,
) -> Result<Vec<ProposalName>, MotesError> {
    let is_there = |proposal: &ProposalName| {
        let options = FilterOptions { proposal: proposal.clone(), particles: 1, ..filter.clone() };
        Running::new(model, &options, 0).map(drop)
    };
    let named = args.proposals.iter().map(|proposal| proposal.of(model));
    let named: Vec<ProposalName> = named.collect::<Result<_, _>>()?;
    match named.is_empty() {
        true => Ok(there(model, filter)),
        false => named.iter().try_for_each(is_there).map(|()| named),
    }
}

/// The designed proposals that a model has.
pub(super) fn there(model: &Model, filter: &FilterOptions) -> Vec<ProposalName> {
    let is_there = |proposal: &ProposalName| {
        let options = FilterOptions { proposal: proposal.clone(), particles: 1, ..filter.clone() };
        Running::new(model, &options, 0).is_ok()
    };
    ProposalName::DESIGNED.into_iter().filter(is_there).collect()
}
