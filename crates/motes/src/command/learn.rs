//! `motes learn`.

use std::sync::Arc;

use motes::output::{Output, card_json, card_text};
use motes::train::Learned;
use motes::{
    CompareOptions, LearnOutcome, LearnedProposal, LearnedWorth, MotesError, PotentialNotes, ProposalName,
    compare, learn, learns_over_prior, of_starts, on_threads,
};
use motes_cli::{Interrupt, status};

use super::args::LearnArgs;
use super::compare::card_page;
use super::failure::Failure;
use super::input;
use super::progress::Progress;
use super::say::{say_ignored, warn, write};

pub(super) fn run(args: &LearnArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read_beside(args.data.as_deref())?;
    let page = args.report.clone().map(Output::File);
    if let Some(page) = &page {
        page.check().map_err(|source| MotesError::Output { file: page.name(), source })?;
    }
    let objective = args.objective.objective;
    if objective.needs_recorded() && args.data.is_none() {
        let line =
            format!("--objective {objective}: it learns from data; name a file of them after the model");
        return Err(Failure::new(2, line));
    }
    let data = args.data.as_ref().map(|path| input::data(path, &model, interrupt)).transpose()?;
    if let Some(data) = &data {
        say_ignored(&data.columns, args.model.quiet);
    }
    let options = args.options(&model)?;
    if !learns_over_prior(&model, data.as_ref(), &options) {
        warn(of_starts(&model).as_slice(), args.model.quiet, false);
    }
    let progress = Progress::new(1000, args.model.quiet);
    let outcome = on_threads(args.model.threads, || {
        learn(&model, data.as_ref(), &options, |done, total| {
            progress.done(1000 * done / total.max(1));
            interrupt.check()
        })
    });
    progress.finish();
    let outcome = outcome??;
    let not_learned = outcome.warnings();
    let LearnOutcome { proposal, history, training_seconds, .. } = outcome;
    proposal.save(&args.output, &model)?;
    let (mut notes, mut warnings) = said(&proposal, history.as_ref(), training_seconds);
    warnings.extend(not_learned);
    let prior = proposal.potential_notes().and_then(|notes| notes.prior.as_ref());
    if args.sequences > 0 {
        notes.extend(prior.map(|prior| format!("the card is of the model at {}", prior.describe())));
    }
    if !args.model.quiet {
        notes.iter().for_each(|note| status(&format!("motes: {note}")));
        warnings.iter().for_each(|warning| status(&format!("motes: warning: {warning}")));
    }
    if args.sequences == 0 {
        return Ok(0);
    }
    let card = CompareOptions {
        sequences: args.sequences,
        steps: args.steps,
        inputs: data
            .filter(|_| model.time_column().is_some() || !model.input_columns().is_empty())
            .map(Arc::new),
        // On one thread unless others are asked for: times are those of one.
        timed_threads: args.model.threads.unwrap_or(1),
        ..CompareOptions::of_learned(&model, proposal, args.particles, args.model.seed)
    };
    let progress = Progress::new(1000, args.model.quiet);
    let compared = on_threads(args.model.threads, || {
        compare(&model, None, &card, |compared| {
            progress.done((1000.0 * compared.share) as usize);
            interrupt.check()
        })
    });
    progress.finish();
    let compared = compared.and_then(|compared| compared);
    let compared = compared.map_err(|error| match error {
        // The proposal is there; only its card is not.
        MotesError::Simulation(reason) => MotesError::Simulation(format!("no card: {reason}")),
        other => other,
    })?;
    if let Some(output) = &page {
        let title = format!("A proposal learned for {}", model.name());
        write(output, &card_page(&title, &compared, &card, &args.model, [&notes, &warnings])?)?;
    }
    match args.json {
        true => write(&Output::Standard, &card_json(&compared, Some(training_seconds)))?,
        false => write(&Output::Standard, &card_text(&compared, args.particles))?,
    }
    Ok(0)
}

/// What there is to say of what was learned, and what there is to warn of.
fn said(proposal: &LearnedProposal, history: Option<&Learned>, seconds: f64) -> (Vec<String>, Vec<String>) {
    let mut notes = vec![format!("chosen: {}", proposal.notes().choice)];
    notes.extend(history.map(|history| of_network(history, seconds)));
    notes.extend(proposal.potential_notes().map(of_potentials));
    let mut warnings = Vec::new();
    if let Some(history) = history {
        notes.extend(of_course(history));
        if let Some(step) = history.diverged_at {
            warnings.push(format!("learning diverged at update {step}; the best weights before are kept"));
        }
    }
    if let Some(designed) = &proposal.notes().worse_than {
        warnings.push(format!("{designed} did better on validation sequences; take --proposal {designed}"));
    }
    let worth = proposal.potential_notes().and_then(|notes| notes.worth.as_ref());
    if let Some((designed, advantage)) = worth.and_then(LearnedWorth::advantage)
        && advantage < 1.0
    {
        warnings.push(match designed == ProposalName::LookAhead.as_str() {
            true => {
                "potentials of a smoother have less error at equal work: motes evidence and motes smooth take these, as by --proposal look-ahead".into()
            }
            false => format!(
                "the evidence of recorded data has less error by {designed} at equal work; take --proposal {designed} for motes evidence"
            ),
        });
    }
    (notes, warnings)
}

/// What there is to say of a network for each particle.
fn of_network(history: &Learned, seconds: f64) -> String {
    let before = history.validation.first().map_or(f64::NAN, |(_, figure)| *figure);
    let figure = match history.objective.needs_recorded() {
        false => format!("gain over the transition {:.3} nats a step", history.best_gain()),
        true => format!(
            "log-evidence of held-out data {:.3} nats a time, {before:.3} before",
            history.best_gain()
        ),
    };
    format!(
        "{} updates, the best after {}; {seconds:.1} s in all; {figure}",
        history.steps, history.best_step
    )
}

/// What went another way than it should while it learned.
fn of_course(history: &Learned) -> Vec<String> {
    let overflowed = (history.overflowed > 0.0).then(|| {
        format!(
            "{:.2} % of the simulated sequences ran to numbers that are not finite and were cut there; take fewer --steps, or look at the \
             transition's noise",
            100.0 * history.overflowed
        )
    });
    let new_beginnings = history.new_beginnings.iter().map(|update| {
        format!(
            "learning lost its way by update {update}; it went on from the best weights before, with steps a quarter as long"
        )
    });
    overflowed.into_iter().chain(new_beginnings).collect()
}

/// What there is to say of potentials.
fn of_potentials(notes: &PotentialNotes) -> String {
    let begin = format!(
        "evidence of recorded data: potentials learned in {:.1} s ({} updates, gain over the transition {:.3} nats a step)",
        notes.seconds, notes.updates, notes.gain
    );
    let Some(worth) = &notes.worth else { return begin };
    let Some((designed, advantage)) = worth.advantage() else { return begin };
    let errors: Vec<String> =
        worth.all().map(|worth| format!("{} {:.3}", worth.proposal, worth.error)).collect();
    format!(
        "{begin}; at equal work {} times the precision of {designed}; filters draw by {}; error of the log-evidence with 100 particles: {}",
        number(advantage),
        notes.filters,
        errors.join("; ")
    )
}

/// Two digits.
fn number(value: f64) -> String {
    if value >= 10.0 { format!("{value:.0}") } else { format!("{value:.1}") }
}
