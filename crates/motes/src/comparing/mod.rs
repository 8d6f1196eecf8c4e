//! The report card of proposals side by side, on sequences whose truth is known or on data.

mod ahead_reference;
mod card;
mod designed;
mod equal_time;
mod gain;
mod kept;
mod options;
mod paired;
mod reference;
mod reference_filters;
mod run;
mod sequence;

use std::ops::ControlFlow;

pub use card::{Card, Figure};
pub use designed::{designed, designed_for_recorded};
pub use equal_time::{EqualTime, Point, TimeToError};
pub use gain::Gain;
use gain::is_best_at_last;
pub use options::{CompareOptions, MOST_REFERENCE_FILTERS};
pub use paired::Paired;
pub use sequence::Sequence;

use crate::contender::Contender;
use crate::data::Data;
use crate::error::MotesError;
use crate::model::{Kind, Model};
use crate::options::{FilterOptions, ProposalName};
use crate::recorded::with_derivatives;
use crate::simulating::{simulate, simulate_along};
use crate::threads::thread_pool;
use card::Steps;
use reference_filters::{particles as reference_particles, reference};
use run::{run_ahead, run_on_line};

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// The card of each proposal.
    pub cards: Vec<(Contender, Card)>,
    /// The proposal that the others are held against, and each of them beside it.
    pub paired: Option<(Contender, Vec<Paired>)>,
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
pub struct ComparisonProgress {
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
    mut proceed: impl FnMut(ComparisonProgress) -> ControlFlow<()>,
) -> Result<Comparison, MotesError> {
    compare_until(model, data, options, &mut proceed)
}

/// [`compare`], compiled once whatever asks.
fn compare_until(
    model: &Model,
    data: Option<&Data>,
    options: &CompareOptions,
    proceed: &mut dyn FnMut(ComparisonProgress) -> ControlFlow<()>,
) -> Result<Comparison, MotesError> {
    check_proposals(model, options)?;
    let contenders = Contender::of(&options.proposals);
    let sequences = match data {
        Some(data) => sequence::of_data(data),
        None => {
            let seed = options.filter.seed;
            let none = ComparisonProgress { filters: 0, of: 1, share: 0.0 };
            let drawn = match &options.inputs {
                Some(inputs) => simulate_along(model, inputs, options.sequences, seed, |_| proceed(none))?,
                None => simulate(model, options.steps, options.sequences, seed, |_| proceed(none))?,
            };
            sequence::of_simulations(&drawn)
        }
    };
    let count = sequences.len();
    let of = count * (1 + contenders.len() * (1 + options.particles.len()));
    let of_reference = reference_particles(model, options);
    let of_proposal = options.filter.particles + options.particles.iter().sum::<usize>();
    let all_particles = (count * of_reference + count * contenders.len() * of_proposal) as f64;
    let (mut filters, mut particles_done) = (0, 0);
    let mut step = |particles: usize| {
        filters = (filters + 1).min(of);
        particles_done += particles;
        let share = (particles_done as f64 / all_particles).min(1.0);
        match proceed(ComparisonProgress { filters, of, share }) {
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
    let run_all =
        |contender: &Contender, particles: usize, estimates: bool, step: &mut dyn FnMut(usize) -> _| {
            let filter = FilterOptions {
                proposal: contender.proposal().clone(),
                particles,
                check: false,
                ..options.filter.clone()
            };
            let mut runs = Vec::with_capacity(count);
            for (number, (sequence, reference)) in sequences.iter().zip(&references).enumerate() {
                runs.push(timed.install(|| match contender.looks_ahead() {
                    true => run_ahead(model, sequence, reference, &filter, number),
                    false => run_on_line(model, sequence, reference, &filter, number, estimates),
                })?);
                step(particles)?;
            }
            Ok::<Vec<Steps>, MotesError>(runs)
        };
    let (particles, mut of_cards, mut points) = (options.filter.particles, Vec::new(), Vec::new());
    for contender in &contenders {
        of_cards.push(run_all(contender, particles, true, &mut step)?);
        let first = points.len();
        for &particles in &options.particles {
            let runs = run_all(contender, particles, false, &mut step)?;
            points.push(Point::of(contender.clone(), particles, &runs));
        }
        let is_designed_filter = !contender.looks_ahead() && !contender.is_learned();
        let most = options.particles_up_to.filter(|_| is_designed_filter).unwrap_or(0);
        let mut more = 3 * options.particles.last().copied().unwrap_or(most);
        while more <= most && is_best_at_last(&points[first..]) {
            let runs = run_all(contender, more, false, &mut step)?;
            points.push(Point::of(contender.clone(), more, &runs));
            more *= 3;
        }
    }
    let cards = contenders.iter().zip(&of_cards);
    let cards = cards.map(|(contender, runs)| (contender.clone(), Card::of(runs, particles))).collect();
    let paired = paired::baseline(&contenders).map(|at| {
        let others = contenders.iter().zip(&of_cards).enumerate().filter(|(other, _)| *other != at);
        let beside = others.map(|(_, (one, runs))| Paired::of(one.clone(), runs, &of_cards[at], particles));
        (contenders[at].clone(), beside.collect())
    });
    let times = sequences.iter().map(|sequence| sequence.measurements.len()).sum();
    let reference = references.first().map(|reference| reference.name.clone()).unwrap_or_default();
    let reference_errors = references.iter().filter_map(|reference| reference.error).collect();
    let (equal_time, size) = (EqualTime { points }, [count, times]);
    Ok(Comparison { cards, paired, equal_time, reference, reference_errors, size })
}

/// Whether all can be compared, before all the work of a reference.
fn check_proposals(model: &Model, options: &CompareOptions) -> Result<(), MotesError> {
    options.proposals.iter().try_for_each(|proposal| match (proposal, model.kind()) {
        (ProposalName::Exact, _) => {
            let reason = "proposals are held against it unasked, where the model has it".into();
            Err(MotesError::Proposal { proposal: proposal.to_string(), reason })
        }
        (ProposalName::LookAhead, _) => with_derivatives(model).map(drop),
        (ProposalName::Learned(learned), Kind::Learnable(_)) => learned.check_model(model),
        _ => Ok(()),
    })
}
