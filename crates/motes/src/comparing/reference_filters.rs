//! How references are made: by the exact filter where there is one, else by filters with many particles.

use motes_inference::LogMean;
use motes_models::{Seed, StepRecord};

use super::ahead_reference::{about_look_ahead, by_look_ahead, particles as of_look_ahead};
use super::kept;
use super::options::{CompareOptions, MOST_REFERENCE_FILTERS};
use super::reference::Reference;
use super::sequence::Sequence;
use crate::engine::Running;
use crate::error::MotesError;
use crate::evidence_estimate::EvidenceEstimate;
use crate::exact::filter_series;
use crate::model::Model;
use crate::options::{FilterOptions, ProposalName};

/// The share of a reference filter's particles that is drawn from the transition.
const DEFENSIVE: f64 = 0.1;

/// What a reference filter may draw from.
fn candidates(options: &CompareOptions) -> Vec<ProposalName> {
    let mut candidates = vec![ProposalName::Linearised, ProposalName::Bootstrap];
    if options.reference_filters > 1 {
        let is_of_its_own = |proposal: &&ProposalName| match proposal {
            ProposalName::Learned(learned) => learned.designed_filter().is_none(),
            _ => false,
        };
        candidates.extend(options.proposals.iter().filter(is_of_its_own).cloned());
    }
    candidates
}

/// The particles of all filters behind a reference for one sequence; the exact filter counts as one.
pub(super) fn particles(model: &Model, options: &CompareOptions) -> usize {
    if model.exact_system().is_some() {
        return 1;
    }
    let more = if options.reference_filters > 1 { options.reference_filters } else { 0 };
    (candidates(options).len() + more) * options.reference_particles + of_look_ahead(model, options)
}

/// The reference for the sequence of that number: the one that is kept, if there is one.
pub(super) fn reference(
    model: &Model,
    sequence: &Sequence,
    options: &CompareOptions,
    number: usize,
) -> Result<Reference, MotesError> {
    let Some(folder) = &options.references else { return computed(model, sequence, options, number) };
    if let Some(found) = kept::read(folder, number, sequence.measurements.len())? {
        return Ok(found);
    }
    let found = computed(model, sequence, options, number)?;
    // A file has numbers only; where all filters collapsed there are others.
    if found.log_evidence.is_finite() {
        kept::write(folder, number, &found)?;
    }
    Ok(found)
}

fn computed(
    model: &Model,
    sequence: &Sequence,
    options: &CompareOptions,
    number: usize,
) -> Result<Reference, MotesError> {
    if let Some(system) = model.exact_system() {
        // Steps before the first row, where x_0 comes before it.
        let before = sequence.steps.first().map_or(0, |steps| steps.len().saturating_sub(1));
        let steps: Vec<&[StepRecord]> = sequence.steps.iter().map(Vec::as_slice).collect();
        let rows: Vec<&[Option<f64>]> = sequence.measurements.iter().map(Vec::as_slice).collect();
        if let Some(exact) = filter_series(system, &steps, &rows)? {
            let increments = exact.increments[before..].to_vec();
            return Ok(Reference {
                name: format!("{}, which is exact", system.name()),
                means: exact.means[before..].to_vec(),
                log_evidence: increments.iter().sum(),
                increments,
                error: None,
            });
        }
    }
    // A filter that misses mass has too little evidence: the one with most is nearest to the truth.
    let filter = FilterOptions {
        check: false,
        particles: options.reference_particles,
        defensive: Some(DEFENSIVE),
        ..options.filter.clone()
    };
    let run = |proposal: &ProposalName, filter_number: u64| {
        let seed = options.filter.seed.wrapping_add(1 + filter_number);
        by_particles(model, sequence, &FilterOptions { seed, ..filter.clone() }, number, proposal.clone())
    };
    let candidates = candidates(options);
    let (mut best, mut failure) = (None::<(ProposalName, Answers, f64)>, None);
    for candidate in candidates {
        match run(&candidate, 0) {
            Ok(found) => {
                let evidence: f64 = found.1.iter().sum();
                if best.as_ref().is_none_or(|(_, _, most)| evidence > *most) {
                    best = Some((candidate, found, evidence));
                }
            }
            Err(error) => failure = Some(error),
        }
    }
    let Some((proposal, first, _)) = best else {
        return Err(failure.unwrap_or(MotesError::Interrupted));
    };
    let particles = options.reference_particles;
    let rest =
        format!("whichever has most evidence, with {DEFENSIVE} of their particles from the transition");
    let ahead = about_look_ahead(options);
    let seed = Seed::from_u64(options.filter.seed).child("reference").nth(number as u64);
    let look_ahead = |plain: &EvidenceEstimate| by_look_ahead(model, sequence, options, plain, &seed);
    if options.reference_filters <= 1 {
        let name = format!("bootstrap or linearised with {particles} particles, {rest}; {ahead}");
        let (means, increments) = first;
        let log_evidence = increments.iter().sum();
        let plain = Reference { name, means, increments, log_evidence, error: None };
        return Ok(plain.or_surer(look_ahead(&EvidenceEstimate::of_one(log_evidence))));
    }
    // Not the one that was chosen by: the most of several is too much.
    let next = |number: usize| match run(&proposal, 1 + number as u64) {
        // A filter that collapses has estimated an evidence of 0.
        Err(MotesError::Filter { .. }) => Ok((first.0.clone(), vec![f64::NEG_INFINITY; first.1.len()])),
        found => found,
    };
    let fewest = options.reference_filters;
    let mut all = (0..fewest).map(next).collect::<Result<Vec<Answers>, MotesError>>()?;
    // Filters that look ahead may know what it would take very many of these to know.
    let surer = look_ahead(&EvidenceEstimate::of(&evidence_of(&all)));
    let wanted = options.reference_error;
    while surer.is_none() && is_rough(&all, wanted) {
        all.push(next(all.len())?);
    }
    if all.iter().all(|(_, increments)| increments.contains(&f64::NEG_INFINITY)) {
        all.push(first);
    }
    let count = if wanted.is_some() { "filters or more" } else { "filters" };
    let name = format!(
        "the mean of {fewest} {count} with {particles} particles: bootstrap, linearised or learned, {rest}; {ahead}"
    );
    Ok(mean_of(&all, name).or_surer(surer))
}

/// Whether the standard error of the mean of these filters is too large, and more may be added.
fn is_rough(all: &[Answers], wanted: Option<f64>) -> bool {
    // What is no number, of filters that all collapsed, is not small.
    let is_known = |wanted: f64| EvidenceEstimate::of(&evidence_of(all)).error <= wanted;
    wanted.is_some_and(|wanted| all.len() < MOST_REFERENCE_FILTERS && !is_known(wanted))
}

/// The log-evidence of each filter.
fn evidence_of(all: &[Answers]) -> Vec<f64> {
    all.iter().map(|(_, increments)| increments.iter().sum()).collect()
}

/// The filters' evidence averaged, which stays unbiased; their means by their evidence so far; and the standard error of the logarithm of the average.
fn mean_of(all: &[Answers], name: String) -> Reference {
    let times = all[0].1.len();
    let mut sums = vec![0.0; all.len()];
    let (mut means, mut increments, mut before) = (Vec::new(), Vec::new(), 0.0);
    for time in 0..times {
        sums.iter_mut().zip(all).for_each(|(sum, (_, increments))| *sum += increments[time]);
        let now = LogMean::of(&sums);
        let mut mean = vec![0.0; all[0].0[time].len()];
        for ((of_filter, _), share) in all.iter().zip(now.shares()) {
            mean.iter_mut().zip(&of_filter[time]).for_each(|(mean, x)| *mean += share * x);
        }
        means.push(mean);
        increments.push(now.log() - before);
        before = now.log();
    }
    let error = Some(EvidenceEstimate::of(&evidence_of(all)).error);
    Reference { name, means, increments, log_evidence: before, error }
}

/// Means, and increments of the log-evidence.
type Answers = (Vec<Vec<f64>>, Vec<f64>);

/// Those of a filter with many particles.
fn by_particles(
    model: &Model,
    sequence: &Sequence,
    options: &FilterOptions,
    number: usize,
    proposal: ProposalName,
) -> Result<Answers, MotesError> {
    let filter = FilterOptions { proposal, ..options.clone() };
    let mut running = Running::new(model, &filter, number)?;
    let (mut means, mut increments) = (Vec::new(), Vec::new());
    for (steps, measurement) in sequence.steps.iter().zip(&sequence.measurements) {
        let before = running.log_evidence();
        running.advance_by(steps, measurement)?;
        increments.push(running.log_evidence() - before);
        means.push(running.means().to_vec());
    }
    Ok((means, increments))
}
