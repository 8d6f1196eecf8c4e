//! Exponential noise with its exact densities, in one dimension, against quadrature: the densities have edges, and a weight
//! that is wrong on one side of an edge shows.

use faer::mat;
use motes_models::{
    GraphDiffusion, GraphDiffusionConfig, Measurements, ModelShape, Noise, Seed, StateSpaceModel, Step,
};
use motes_proposals::{
    Backend, Cell, Family, Fcnn, FcnnConfig, Gnn, GnnConfig, Learnable, Psi, PsiConfig, Rnn, RnnConfig,
};
use motes_smc::{Bootstrap, FilterSettings, Proposal, ResampleWhen};
use motes_tests::{
    NEVER_HALF_ALWAYS, PARTICLES, RUNS, Reference, evidence_scores, is_unbiased, trained_family,
};

const A: f64 = 0.9;
const HORIZON: usize = 5;
const POINTS: usize = 20_001;

fn model() -> GraphDiffusion {
    let config = GraphDiffusionConfig {
        measurement_dim: 1,
        noise: Noise::Exponential,
        ..GraphDiffusionConfig::new(1)
    };
    GraphDiffusion::on_graph(&config, mat![[A]].as_ref()).unwrap()
}

/// `p(x_t, y_{0:t})` on an even grid that ends where the likelihood of `y_t` does.
struct Forward {
    low: f64,
    step: f64,
    density: Vec<f64>,
}

impl Forward {
    fn points(&self) -> impl Iterator<Item = f64> + '_ {
        (0..POINTS).map(|i| self.low + self.step * i as f64)
    }

    /// `∫ f(x) p(x, y) dx` up to each grid point, by the trapezoidal rule.
    fn cumulative(&self, f: impl Fn(f64) -> f64) -> Vec<f64> {
        let values: Vec<f64> = self.points().zip(&self.density).map(|(x, density)| f(x) * density).collect();
        let mut sums = vec![0.0];
        for pair in values.windows(2) {
            sums.push(sums[sums.len() - 1] + 0.5 * self.step * (pair[0] + pair[1]));
        }
        sums
    }

    /// The value between grid points of what is given at them.
    fn interpolate(&self, values: &[f64], x: f64) -> f64 {
        let place = ((x - self.low) / self.step).clamp(0.0, (POINTS - 1) as f64);
        let at = (place as usize).min(POINTS - 2);
        values[at] + (place - at as f64) * (values[at + 1] - values[at])
    }
}

/// The exact evidence and last mean. The noise has density `exp(−(v + σ)/σ)/σ` for `v ≥ −σ`, so that the integral over the
/// past is a cumulative one: `∫ p(x|x') p(x', y) dx' = exp(−(x + σ)/σ)/σ ∫_{x' ≤ (x+σ)/a} exp(a x'/σ) p(x', y) dx'`.
fn exact() -> Reference<GraphDiffusion> {
    let model = model();
    let measurements = Measurements::new(1, vec![1.5, 1.2, 1.4, 0.9, 1.1]).unwrap();
    let sigma = 10_f64.powf(-0.25);
    let mut forward: Option<Forward> = None;
    for (time, y) in measurements.rows().enumerate() {
        let (low, high) = (-8.0, y[0] + sigma);
        let step = (high - low) / (POINTS - 1) as f64;
        let mut next = Forward { low, step, density: vec![0.0; POINTS] };
        let predicted: Vec<f64> = match &forward {
            None => next
                .points()
                .map(|x| model.density().unwrap().log_density(&Step::of_index(0), None, &[x]).exp())
                .collect(),
            Some(before) => {
                let sums = before.cumulative(|x| (A * x / sigma).exp());
                let into = |x: f64| {
                    (-(x + sigma) / sigma).exp() / sigma * before.interpolate(&sums, (x + sigma) / A)
                };
                next.points().map(into).collect()
            }
        };
        // One grid point is the edge itself, where rounding may put the likelihood at 0: its limit from inside.
        let likelihood = |x: f64| (-(y[0] - x + sigma) / sigma).exp() / sigma;
        next.density = next.points().zip(predicted).map(|(x, p)| p * likelihood(x)).collect();
        let middle = next.points().nth(POINTS / 2).unwrap();
        let stated = model.log_likelihood(&Step::of_index(time), &[middle], y).unwrap().exp();
        assert!((stated / likelihood(middle) - 1.0).abs() < 1e-12, "the model has another density");
        forward = Some(next);
    }
    let last = forward.unwrap();
    let evidence = last.cumulative(|_| 1.0)[POINTS - 1];
    let last_mean = last.cumulative(|x| x)[POINTS - 1] / evidence;
    Reference { log_evidence: evidence.ln(), last_mean, model, measurements, missing: vec![] }
}

fn assert_unbiased<P: Proposal<GraphDiffusion> + Clone>(
    exact: &Reference<GraphDiffusion>,
    rules: &[ResampleWhen],
    defensive_weight: Option<f64>,
    runs: usize,
    name: &str,
    proposal: &P,
) {
    for &resample_when in rules {
        let settings = FilterSettings { resample_when, defensive_weight, ..FilterSettings::new(PARTICLES) };
        let scores = evidence_scores(exact, proposal, settings, runs);
        println!("{name}, {resample_when:?}: z = {scores:.2?}");
        assert!(is_unbiased(&scores), "{name}, {resample_when:?}: z = {scores:?}");
    }
}

#[test]
fn bootstrap() {
    assert_unbiased(&exact(), &NEVER_HALF_ALWAYS, None, RUNS, "bootstrap", &Bootstrap);
}

/// Alone, a Gaussian draws too often where the density is 0 for so few particles; with a share of the transition it does not.
fn check<F: Family + Learnable + Proposal<GraphDiffusion> + Clone>(
    exact: &Reference<GraphDiffusion>,
    config: &F::Config,
) {
    let half = [ResampleWhen::EssBelow(0.5)];
    let drawn = F::create(
        config,
        &ModelShape::on_graph(&model()),
        HORIZON,
        Backend::Native.into(),
        &Seed::from_u64(32),
    )
    .unwrap();
    // Outside the support the exact objective is −∞ and has no gradient: trained under Gaussian densities of the same moments.
    let believed = exact.model.with_noise(Noise::Gaussian);
    let trained: F = trained_family(config, &believed, HORIZON, Backend::Native.into());
    for (name, proposal) in [("as initialised", drawn), ("trained", trained)] {
        assert_unbiased(
            exact,
            &half,
            Some(0.2),
            10_000,
            &format!("defensive {}, {name}", F::NAME),
            &proposal,
        );
    }
}

#[test]
fn every_family() {
    let exact = exact();
    check::<Fcnn>(&exact, &FcnnConfig { widths: vec![4], ..FcnnConfig::paper() });
    check::<Rnn>(&exact, &RnnConfig { cell: Cell::Lstm, hidden: 4, ..RnnConfig::paper() });
    check::<Gnn>(&exact, &GnnConfig { features: vec![4], ..GnnConfig::paper() });
    check::<Psi>(&exact, &PsiConfig { layers: 3, ..PsiConfig::paper() });
}
