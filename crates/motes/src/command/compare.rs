//! `motes compare`.

use std::sync::Arc;

use motes::output::{CardReport, Output, card_json, card_report, card_text};
use motes::{
    CompareOptions, Comparison, Data, FilterOptions, Model, MotesError, ProposalName, Running, compare,
    designed_for_recorded, of_starts, on_threads,
};
use motes_cli::Interrupt;

use super::args::CompareArgs;
use super::compare_fits;
use super::failure::Failure;
use super::fitted_args::at_point;
use super::input;
use super::model_args::ModelArgs;
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::summary::command_line;

pub(super) fn run(args: &CompareArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let filter = FilterOptions {
        particles: args.particles,
        defensive: args.defensive,
        resample_below: args.resample_below,
        resampling: args.resampling,
        seed: args.model.seed,
        ..FilterOptions::default()
    };
    if let (Some(other), Some(data)) = (&args.data, &args.data_of_both) {
        return compare_fits::run(args, [other, data], &filter, interrupt);
    }
    let file = args.model.read_beside(args.data.as_deref())?;
    let model = match args.parameters.as_slice() {
        [] => file,
        [folder] => at_point(folder, args.at, &file, &args.model.set)?,
        _ => {
            let line = "--parameters: there is one model, and more than one folder of a fit; two models are compared by motes compare MODEL MODEL DATA";
            return Err(Failure::new(2, line));
        }
    };
    warn(of_starts(&model).as_slice(), args.model.quiet, false);
    let [output, page] = [&args.output, &args.report].map(|path| path.clone().map(Output::File));
    for output in output.iter().chain(&page) {
        output.check().map_err(|source| MotesError::Output { file: output.name(), source })?;
    }
    let data = args.data.as_ref().map(|path| input::data(path, &model, interrupt)).transpose()?;
    if let Some(data) = &data {
        say_ignored(&data.columns, args.model.quiet);
    }
    let inputs = args.inputs.as_ref().map(|path| Data::open_inputs(path, &model)).transpose()?;
    let options = CompareOptions {
        proposals: proposals(args, &model, &filter)?,
        filter,
        particles: args.sweep.clone(),
        sequences: args.sequences,
        steps: args.steps,
        inputs: inputs.map(Arc::new),
        particles_up_to: None,
        reference_particles: CompareOptions::REFERENCE_PARTICLES,
        reference_filters: 1,
        reference_error: None,
        references: None,
        // On one thread unless others are asked for: times are those of one.
        timed_threads: args.model.threads.unwrap_or(1),
    };
    let progress = Progress::new(1000, args.model.quiet);
    let compared = on_threads(args.model.threads, || {
        compare(&model, data.as_ref(), &options, |compared| {
            progress.done((1000.0 * compared.share) as usize);
            interrupt.check()
        })
    });
    progress.finish();
    let compared = compared??;
    if let Some(output) = &page {
        let title = format!("Proposals of {}", model.name());
        write(output, &card_page(&title, &compared, &options, &args.model, [&[], &[]])?)?;
    }
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

/// The card as a page, with notes and warnings above it.
pub(super) fn card_page(
    title: &str,
    comparison: &Comparison,
    options: &CompareOptions,
    model: &ModelArgs,
    [notes, warnings]: [&[String]; 2],
) -> Result<String, MotesError> {
    let filter = &options.filter;
    let mut settings = vec![
        ("model".to_string(), model.model.display().to_string()),
        ("particles".into(), filter.particles.to_string()),
        ("resample below".into(), filter.resample_below.to_string()),
        ("resampling".into(), format!("{:?}", filter.resampling).to_lowercase()),
        ("seed".into(), filter.seed.to_string()),
        ("threads of the filters that are timed".into(), options.timed_threads.to_string()),
    ];
    settings.extend(model.set.iter().map(|(name, value)| (format!("--set {name}"), value.to_string())));
    let report = CardReport {
        title,
        comparison,
        particles: filter.particles,
        notes,
        warnings,
        settings: &settings,
        command: &command_line(),
    };
    card_report(&report).map_err(|error| MotesError::Report(error.to_string()))
}

/// Those asked for, or all that the model has.
fn proposals(
    args: &CompareArgs,
    model: &Model,
    filter: &FilterOptions,
) -> Result<Vec<ProposalName>, MotesError> {
    let is_there = |proposal: &ProposalName| {
        let options = FilterOptions { proposal: proposal.clone(), particles: 1, ..filter.clone() };
        match proposal {
            // It is no filter's; `compare` says itself where a model has none.
            ProposalName::LookAhead => Ok(()),
            _ => Running::new(model, &options, 0).map(drop),
        }
    };
    let named = args.proposals.iter().map(|proposal| proposal.of(model));
    let named: Vec<ProposalName> = named.collect::<Result<_, _>>()?;
    match named.is_empty() {
        true => Ok(designed_for_recorded(model, filter)),
        false => named.iter().try_for_each(is_there).map(|()| named),
    }
}
