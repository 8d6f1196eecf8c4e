//! The report card of proposals side by side, on sequences whose truth is known or on data.

mod card;
mod designed;
mod equal_time;
mod kept;
mod options;
mod paired;
mod reference;
mod reference_filters;
mod sequence;
mod twisted;

use std::ops::ControlFlow;
use std::time::Instant;

pub use card::{Card, Figure};
pub use designed::designed;
pub use equal_time::{EqualTime, Point, Reached};
pub use options::{CompareOptions, MOST_REFERENCE_FILTERS};
pub use paired::Paired;
pub use sequence::Sequence;

use crate::data::Data;
use crate::engine::Running;
use crate::error::MotesError;
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::simulating::{simulate, simulate_along};
use crate::threads::thread_pool;
use card::Steps;
use reference::Reference;
use reference_filters::{particles as reference_particles, reference};

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The card of each proposal.
    pub cards: Vec<(ProposalName, Card)>,
    /// The proposal that the others are held against, and each of them beside it.
    pub paired: Option<(ProposalName, Vec<Paired>)>,
    /// Error against time of each.
    pub equal_time: EqualTime,
    /// What evidence and means are held against.
    pub reference: String,
    /// The standard error of the reference's log-evidence of each sequence, where it is an estimate of several filters.
    pub reference_errors: Vec<f64>,
    /// Sequences and their times together.
    pub size: [usize; 2],
}

/// How far a comparison has come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared {
    /// Filters that are done; a reference counts as one.
    pub filters: usize,
    /// All filters.
    pub of: usize,
    /// The share of all particles that these filters had: what is left takes about as long as the rest of them.
    pub share: f64,
}

/// Compares proposals on simulated sequences, or on the series of `data`; `proceed` is asked after each filter, with how far it has come.
///
/// # Errors
/// [`MotesError`] as [`crate::filter`] and [`crate::simulate`], but for filters that collapse: those have a place on the card.
pub fn compare(
    model: &Model,
    data: Option<&Data>,
    options: &CompareOptions,
    mut proceed: impl FnMut(Compared) -> ControlFlow<()>,
) -> Result<Comparison, MotesError> {
    compare_until(model, data, options, &mut proceed)
}

/// [`compare`], compiled once whatever asks.
fn compare_until(
    model: &Model,
    data: Option<&Data>,
    options: &CompareOptions,
    proceed: &mut dyn FnMut(Compared) -> ControlFlow<()>,
) -> Result<Comparison, MotesError> {
    for proposal in &options.proposals {
        if *proposal == ProposalName::Exact {
            let reason = "proposals are held against it unasked, where the model has it".into();
            return Err(MotesError::Proposal { proposal: "exact".into(), reason });
        }
        // Before all the work of a reference.
        if let (ProposalName::Learned(learned), Kind::Learnable(_)) = (proposal, model.kind()) {
            learned.check_model(model)?;
        }
    }
    let sequences = match data {
        Some(data) => sequence::of_data(data),
        None => {
            let seed = options.filter.seed;
            let none = Compared { filters: 0, of: 1, share: 0.0 };
            let drawn = match &options.inputs {
                Some(inputs) => simulate_along(model, inputs, options.sequences, seed, |_| proceed(none))?,
                None => simulate(model, options.steps, options.sequences, seed, |_| proceed(none))?,
            };
            sequence::of_simulations(&drawn)
        }
    };
    let count = sequences.len();
    let of = count * (1 + options.proposals.len() * (1 + options.particles.len()));
    let of_reference = reference_particles(model, options);
    let of_proposal = options.filter.particles + options.particles.iter().sum::<usize>();
    let all_particles = (count * of_reference + count * options.proposals.len() * of_proposal) as f64;
    let (mut filters, mut particles_done) = (0, 0);
    let mut step = |particles: usize| {
        filters += 1;
        particles_done += particles;
        match proceed(Compared { filters, of, share: particles_done as f64 / all_particles }) {
            ControlFlow::Break(()) => Err(MotesError::Interrupted),
            ControlFlow::Continue(()) => Ok(()),
        }
    };
    let mut references = Vec::new();
    for (number, sequence) in sequences.iter().enumerate() {
        references.push(reference(model, sequence, options, number)?);
        step(of_reference)?;
    }
    let timed = thread_pool(Some(options.timed_threads))?;
    let (mut cards, mut of_cards, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for proposal in &options.proposals {
        let mut runs = Vec::new();
        for (number, (sequence, reference)) in sequences.iter().zip(&references).enumerate() {
            let filter = FilterOptions { proposal: proposal.clone(), check: false, ..options.filter.clone() };
            runs.push(timed.install(|| run(model, sequence, reference, &filter, number, true))?);
            step(options.filter.particles)?;
        }
        cards.push((proposal.clone(), Card::of(&runs, options.filter.particles)));
        of_cards.push(runs);
        for &particles in &options.particles {
            let mut runs = Vec::new();
            for (number, (sequence, reference)) in sequences.iter().zip(&references).enumerate() {
                let filter = FilterOptions {
                    proposal: proposal.clone(),
                    particles,
                    check: false,
                    ..options.filter.clone()
                };
                runs.push(timed.install(|| run(model, sequence, reference, &filter, number, false))?);
                step(particles)?;
            }
            points.push(Point::of(proposal.clone(), particles, &runs));
        }
    }
    let particles = options.filter.particles;
    let paired = paired::baseline(&options.proposals).map(|at| {
        let others = options.proposals.iter().zip(&of_cards).enumerate().filter(|(other, _)| *other != at);
        let beside = others.map(|(_, (name, runs))| Paired::of(name.clone(), runs, &of_cards[at], particles));
        (options.proposals[at].clone(), beside.collect())
    });
    let times = sequences.iter().map(|sequence| sequence.measurements.len()).sum();
    let reference = references.first().map(|reference| reference.name.clone()).unwrap_or_default();
    let reference_errors = references.iter().filter_map(|reference| reference.error).collect();
    let (equal_time, size) = (EqualTime { points }, [count, times]);
    Ok(Comparison { cards, paired, equal_time, reference, reference_errors, size })
}

/// One filter over one sequence; `estimates` says whether its estimates are of interest.
fn run(
    model: &Model,
    sequence: &Sequence,
    reference: &Reference,
    options: &FilterOptions,
    number: usize,
    estimates: bool,
) -> Result<Steps, MotesError> {
    let mut running = Running::new(model, options, number)?;
    let mut steps = Steps::new(sequence.measurements.len());
    for (time, (of_row, measurement)) in sequence.steps.iter().zip(&sequence.measurements).enumerate() {
        let before = running.log_evidence();
        let start = Instant::now();
        let advanced = running.advance_by(of_row, measurement);
        steps.seconds += start.elapsed().as_secs_f64();
        match advanced {
            Ok(()) => {}
            Err(MotesError::Filter { .. }) => return Ok(steps.lost_at(time)),
            Err(error) => return Err(error),
        }
        steps.log_evidence += running.log_evidence() - before;
        if estimates {
            steps.add(&running, sequence, reference, time);
        }
    }
    steps.log_evidence_gap = Some(steps.log_evidence - reference.log_evidence);
    Ok(steps)
}
