//! The reference problem of the statistical tests, and a proposal that can be made wrong on purpose.
use faer::mat;
use motes_models::{
    Gaussian, LinearGaussian, Measurements, PartialMeasurements, Seed, StateSpaceModel, Step, Stream, kalman,
};
use motes_smc::{
    Conditional, Context, FilterBank, FilterError, FilterSettings, Proposal, ProposalError, ResampleWhen,
};
use rand::RngExt;
use rand_distr::StandardNormal;

/// The three resampling rules that evidence is tested under; a bug may show at one of them only.
pub const NEVER_HALF_ALWAYS: [ResampleWhen; 3] =
    [ResampleWhen::Never, ResampleWhen::EssBelow(0.5), ResampleWhen::Always];

/// Runs of filters that a score is taken of.
pub const RUNS: usize = 20_000;
/// Particles of each of them.
pub const PARTICLES: usize = 64;
/// The score from which on a test refuses.
pub const REFUSED: f64 = 4.0;

/// What tests of evidence ask of the scores of evidence and mean.
pub fn is_unbiased(scores: &[f64; 2]) -> bool {
    scores.iter().all(|z| z.abs() < REFUSED)
}

/// One dimension, a = 0.9, q = r = 1, five measurements.
///
/// No random draw decides how hard the problem is: each measurement lies one standard deviation of its prediction
/// away from it, above and below in turn, so every one is as surprising as measurements are on average.
pub struct Reference<Model = LinearGaussian> {
    /// The model.
    pub model: Model,
    /// Its measurements, five of them.
    pub measurements: Measurements,
    /// The times whose measurements a filter does not get.
    pub missing: Vec<usize>,
    /// Their exact log-evidence.
    pub log_evidence: f64,
    /// The exact mean of the last state given all measurements.
    pub last_mean: f64,
}

/// The reference problem with its exact answers.
pub fn reference() -> Reference {
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    let model = LinearGaussian::new(initial, mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[1.0]]).unwrap();
    let mut values = vec![];
    for time in 0..5 {
        // The prediction does not depend on the measurement that is still missing.
        values.push(0.0);
        let filtered = kalman::filter(&model, &Measurements::new(1, values.clone()).unwrap()).unwrap();
        let predicted = &filtered.steps[time].predicted;
        let deviation = (predicted.covariance[(0, 0)] + 1.0).sqrt();
        values[time] = predicted.mean[0] + if time % 2 == 0 { deviation } else { -deviation };
    }
    let measurements = Measurements::new(1, values).unwrap();
    let exact = kalman::filter(&model, &measurements).unwrap();
    let last_mean = exact.steps[4].filtered.mean[0];
    Reference { log_evidence: exact.log_evidence(), last_mean, model, measurements, missing: vec![] }
}

/// The same without the measurements at times 1 and 3.
pub fn reference_with_gaps() -> Reference {
    let Reference { model, measurements, .. } = reference();
    let missing = vec![1, 3];
    let seen = |(time, value): (usize, &f64)| (!missing.contains(&time)).then_some(*value);
    let values = measurements.values().iter().enumerate().map(seen).collect();
    let exact = kalman::filter_partial(&model, &PartialMeasurements::new(1, values).unwrap()).unwrap();
    let last_mean = exact.steps[4].filtered.mean[0];
    Reference { log_evidence: exact.log_evidence(), last_mean, model, measurements, missing }
}

/// Scores of the mean of Ẑ/Z against 1 and of (Ẑ/Z)·x̂_T against the exact mean, in standard errors.
pub fn evidence_scores<M: StateSpaceModel, P: Proposal<M> + Clone>(
    reference: &Reference<M>,
    proposal: &P,
    settings: FilterSettings,
    runs: usize,
) -> [f64; 2] {
    let seed = Seed::from_u64(21);
    let (mut ratios, mut products) = (Vec::with_capacity(runs), Vec::with_capacity(runs));
    let batch = 1000;
    for block in 0..runs / batch {
        let seed = seed.nth(block as u64);
        let found = match estimates(reference, proposal, settings, seed.streams(batch)) {
            Some(found) => found,
            // One collapsed and took the whole bank with it. Alone each gets what it would get in the bank, and the estimate of
            // one that collapses is 0.
            None => seed
                .streams(batch)
                .into_iter()
                .flat_map(|stream| {
                    estimates(reference, proposal, settings, vec![stream]).unwrap_or(vec![(0.0, 0.0)])
                })
                .collect(),
        };
        for (ratio, mean) in found {
            ratios.push(ratio);
            products.push(ratio * mean);
        }
    }
    [score(&ratios, 1.0), score(&products, reference.last_mean)]
}

/// Ẑ/Z and x̂_T of each filter of a bank; none if one of them collapsed.
fn estimates<M: StateSpaceModel, P: Proposal<M> + Clone>(
    reference: &Reference<M>,
    proposal: &P,
    settings: FilterSettings,
    streams: Vec<Stream>,
) -> Option<Vec<(f64, f64)>> {
    let filters = streams.len();
    let mut bank = FilterBank::with_streams(&reference.model, proposal.clone(), settings, streams).unwrap();
    for (time, measurement) in reference.measurements.rows().enumerate() {
        let stepped = match reference.missing.contains(&time) {
            true => bank.step_at(&Step::of_index(time), &vec![None; measurement.len()]),
            false => bank.step(measurement),
        };
        match stepped {
            Ok(()) => {}
            Err(FilterError::Collapse { .. }) => return None,
            Err(error) => panic!("{error}"),
        }
    }
    let estimate = |filter| {
        let mut mean = [0.0];
        bank.mean(filter, &mut mean);
        ((bank.log_evidence(filter) - reference.log_evidence).exp(), mean[0])
    };
    Some((0..filters).map(estimate).collect())
}

/// (mean − expected) in standard errors.
pub fn score(values: &[f64], expected: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - expected) / (variance / n).sqrt()
}

/// A Gaussian around the conditional mean of the reference model, with a density that may lie about its variance.
#[derive(Clone)]
pub struct ScalarGaussian {
    /// The variance of its draws.
    pub variance: f64,
    /// The variance of the density that it states.
    pub claimed_variance: f64,
    /// What was measured at the step that it was prepared for.
    measurement: f64,
}

impl ScalarGaussian {
    /// With a density that says what it draws.
    pub fn of_variance(variance: f64) -> Self {
        ScalarGaussian { variance, claimed_variance: variance, measurement: f64::NAN }
    }

    /// Wider than the optimum, whose variance is ½.
    pub fn wide() -> Self {
        ScalarGaussian::of_variance(0.9)
    }

    /// The planted bug: a density off by 10% in variance.
    pub fn lying() -> Self {
        ScalarGaussian { claimed_variance: 0.99, ..ScalarGaussian::wide() }
    }
}

impl Proposal<LinearGaussian> for ScalarGaussian {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a> = ScalarConditional<'a>;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        _model: &LinearGaussian,
        _step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        self.measurement = measurement[0].unwrap_or(f64::NAN);
        Ok(measurement[0].is_some())
    }

    fn condition<'a>(
        &'a self,
        _model: &'a LinearGaussian,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<ScalarConditional<'a>, ProposalError> {
        Ok(ScalarConditional { proposal: self, context })
    }
}

/// [`ScalarGaussian`] given the past.
pub struct ScalarConditional<'a> {
    proposal: &'a ScalarGaussian,
    context: Context<'a>,
}

impl ScalarConditional<'_> {
    fn mean(&self, row: usize) -> f64 {
        let predicted = self.context.previous.map_or(0.0, |previous| 0.9 * previous.row(row)[0]);
        0.5 * (predicted + self.proposal.measurement)
    }
}

impl Conditional for ScalarConditional<'_> {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let block = states.len() / streams.len();
        for row in 0..states.len() {
            let epsilon: f64 = streams[row / block].sample(StandardNormal);
            states[row] = self.mean(row) + self.proposal.variance.sqrt() * epsilon;
        }
        self.log_density(states, log_density);
    }

    fn log_density(&mut self, states: &[f64], log_density: &mut [f64]) {
        let variance = self.proposal.claimed_variance;
        for (row, (state, out)) in states.iter().zip(log_density).enumerate() {
            let squared = (state - self.mean(row)).powi(2);
            *out = -0.5 * squared / variance - 0.5 * (std::f64::consts::TAU * variance).ln();
        }
    }
}
