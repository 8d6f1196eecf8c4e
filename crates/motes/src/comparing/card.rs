//! The figures of one proposal.

use super::reference::Reference;
use super::sequence::Sequence;
use crate::engine::Running;

/// The probabilities between which intervals lie that hold the truth in half and in nine tenths of the cases.
const INTERVALS: [[f64; 2]; 2] = [[0.25, 0.75], [0.05, 0.95]];

/// What one filter did on one sequence.
#[derive(Debug, Clone, Default)]
pub(super) struct Steps {
    /// The number of times of the sequence.
    times: usize,
    pub(super) seconds: f64,
    pub(super) log_evidence: f64,
    /// None if the filter collapsed.
    pub(super) log_evidence_gap: Option<f64>,
    sizes: Vec<f64>,
    evidence_errors: Vec<f64>,
    state_errors: Vec<f64>,
    tail_indices: Vec<f64>,
    /// How often each interval held the truth, and how often it was asked.
    held: [usize; 2],
    asked: usize,
}

impl Steps {
    pub(super) fn new(times: usize) -> Self {
        Steps { times, ..Steps::default() }
    }

    /// A filter that collapsed has no effective particles and no evidence from then on.
    pub(super) fn lost_at(mut self, time: usize) -> Self {
        let rest = self.times - time;
        self.sizes.extend(std::iter::repeat_n(0.0, rest));
        self.evidence_errors.extend(std::iter::repeat_n(1.0, rest));
        self.log_evidence_gap = None;
        self
    }

    /// The mean of `K_eff` over steps.
    pub(super) fn mean_size(&self) -> Option<f64> {
        (!self.sizes.is_empty()).then(|| self.sizes.iter().sum::<f64>() / self.sizes.len() as f64)
    }

    /// Takes in a step.
    pub(super) fn add(
        &mut self,
        running: &Running<'_>,
        sequence: &Sequence,
        reference: &Reference,
        time: usize,
    ) {
        self.sizes.extend(running.effective_sample_size());
        let increment = running.last_increment();
        self.evidence_errors.push((1.0 - (increment - reference.increments[time]).exp()).abs());
        let squares =
            running.means().iter().zip(&reference.means[time]).map(|(found, exact)| (found - exact).powi(2));
        self.state_errors.push(squares.sum());
        self.tail_indices.extend(running.diagnosis().and_then(|diagnosis| diagnosis.pareto_k));
        let Some(truth) = &sequence.truth else { return };
        for (coordinate, truth) in truth[time].iter().enumerate() {
            let quantiles = running.quantiles(coordinate, INTERVALS.as_flattened());
            self.asked += 1;
            for (held, ends) in self.held.iter_mut().zip(quantiles.chunks_exact(2)) {
                *held += usize::from(ends[0] <= *truth && *truth <= ends[1]);
            }
        }
    }
}

/// A mean over sequences, with half the width of an interval that holds it in 95 of 100 cases.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// The mean.
    pub mean: f64,
    /// `1.96` standard errors; none of a single sequence.
    pub half_width: Option<f64>,
}

impl Figure {
    /// Of one value for each sequence; none if there is no value.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Option<Figure> {
        let values: Vec<f64> = values.collect();
        let n = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let half_width = (values.len() > 1).then(|| 1.96 * (variance / n).sqrt());
        Some(Figure { mean, half_width })
    }
}

/// The figures of a proposal over all sequences.
#[derive(Debug, Clone, PartialEq)]
pub struct Card {
    /// `K_eff/K`, before resampling.
    pub ess_fraction: Option<Figure>,
    /// The value that `K_eff/K` is below at one step in a hundred; none of a filter that looks ahead.
    pub ess_fraction_q01: Option<f64>,
    /// The log-evidence of a sequence less that of the reference; over those that did not collapse.
    pub log_evidence_gap: Option<Figure>,
    /// The mean of `|1 − exp(ℓ̂_t − ℓ_t)|`.
    pub e_l: Option<Figure>,
    /// The mean squared distance of the filter's mean from the reference's.
    pub e_x: Option<Figure>,
    /// The mean of `k̂` over steps.
    pub pareto_k: Option<f64>,
    /// How often the middle half of the particles holds the truth.
    pub coverage_50: Option<f64>,
    /// How often the middle nine tenths do.
    pub coverage_90: Option<f64>,
    /// Particles drawn and weighed in a second.
    pub particle_steps_per_second: f64,
    /// Milliseconds for a step.
    pub ms_per_step: f64,
    /// Sequences on which the filter collapsed.
    pub lost: usize,
}

impl Card {
    /// Of filters with `particles` particles, one for each sequence.
    pub(super) fn of(runs: &[Steps], particles: usize) -> Card {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let over = |figure: &dyn Fn(&Steps) -> &[f64]| {
            Figure::of(runs.iter().map(figure).filter(|values| !values.is_empty()).map(mean))
        };
        let k = particles as f64;
        let scaled = |figure: Option<Figure>| {
            figure.map(|f| Figure { mean: f.mean / k, half_width: f.half_width.map(|width| width / k) })
        };
        let mut sizes: Vec<f64> = runs.iter().flat_map(|run| run.sizes.iter().copied()).collect();
        sizes.sort_by(f64::total_cmp);
        let indices: Vec<f64> = runs.iter().flat_map(|run| run.tail_indices.iter().copied()).collect();
        let asked: usize = runs.iter().map(|run| run.asked).sum();
        let held = |interval: usize| runs.iter().map(|run| run.held[interval]).sum::<usize>();
        let coverage = |interval| (asked > 0).then(|| held(interval) as f64 / asked as f64);
        let (times, seconds) = totals(runs);
        Card {
            ess_fraction: scaled(over(&|run| &run.sizes)),
            ess_fraction_q01: sizes.get(sizes.len() / 100).map(|size| size / k),
            log_evidence_gap: Figure::of(runs.iter().filter_map(|run| run.log_evidence_gap)),
            e_l: over(&|run| &run.evidence_errors),
            e_x: over(&|run| &run.state_errors),
            pareto_k: (!indices.is_empty()).then(|| mean(&indices)),
            coverage_50: coverage(0),
            coverage_90: coverage(1),
            particle_steps_per_second: times * k / seconds,
            ms_per_step: 1e3 * seconds / times,
            lost: runs.iter().filter(|run| run.log_evidence_gap.is_none()).count(),
        }
    }
}

/// Steps and seconds of all runs.
pub(super) fn totals(runs: &[Steps]) -> (f64, f64) {
    let times = runs.iter().map(|run| run.times as f64).sum();
    (times, runs.iter().map(|run| run.seconds).sum::<f64>().max(1e-9))
}
