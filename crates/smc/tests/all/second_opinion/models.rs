//! Models that filters are judged on, and the judging of a whole sequence.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Measurements, Seed, Simulator, Step, simulate};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter, Proposal, SecondOpinion, Verdict, WeightReport};

/// The growth model, whose measurement `x²/20` does not tell `x` from `−x`.
pub(crate) struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

/// `N` independent coordinates `x_t = a x_{t−1} + q v`, measured with noise `r w`; for this model the linearised proposal is the optimum.
pub(crate) struct Linear {
    pub(crate) coordinates: usize,
    pub(crate) a: f64,
    pub(crate) q: f64,
    pub(crate) r: f64,
}

impl Equations for Linear {
    fn dimensions(&self) -> [usize; 2] {
        [self.coordinates, self.coordinates]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        let sd = self.q / (1.0 - self.a * self.a).sqrt();
        (0..self.coordinates).for_each(|i| state[i] = draws.draw(normal(0.0, sd)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..self.coordinates).for_each(|i| state[i] = draws.draw(normal(x[i] * self.a, self.q)));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        (0..self.coordinates).for_each(|i| y.push(normal(x[i], self.r)));
    }
}

/// Stochastic volatility: `x_t = φ x_{t−1} + σ v`, `y_t = β e^{x_t/2} w`.
pub(crate) struct Volatility {
    pub(crate) phi: f64,
    pub(crate) sigma: f64,
    pub(crate) beta: f64,
}

impl Equations for Volatility {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, self.sigma / (1.0 - self.phi * self.phi).sqrt()));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * self.phi, self.sigma));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, (x[0] / 2.0).exp() * self.beta));
    }
}

/// What is said of a filter after a whole sequence.
pub(crate) struct Judged {
    pub(crate) verdict: Verdict,
    /// What the filter's own weights say.
    pub(crate) report: WeightReport,
}

/// Filters `measurements` with both filters side by side.
pub(crate) fn judge<M: motes_models::StateSpaceModel, P: Proposal<M>>(
    model: &M,
    proposal: P,
    settings: FilterSettings,
    measurements: &Measurements,
    seed: &Seed,
) -> Judged {
    let stream = seed.child("filter").stream();
    let mut filter = ParticleFilter::new(model, proposal, settings, stream).unwrap();
    let stream = seed.child("bootstrap").stream();
    let mut bootstrap = ParticleFilter::new(model, Bootstrap, settings, stream).unwrap();
    let (mut opinion, mut report) = (SecondOpinion::new(), WeightReport::default());
    for measurement in measurements.rows() {
        filter.step(measurement).unwrap();
        let _ = bootstrap.step(measurement);
        opinion.step(&filter, &bootstrap).unwrap();
        report.add(&filter.diagnosis());
    }
    assert_eq!(opinion.steps(), measurements.len());
    Judged { verdict: opinion.verdict(), report }
}

/// The same for so many sequences of the model, with numbers from `seeds`.
pub(crate) fn judge_all<M: Simulator, P: Proposal<M>>(
    model: &M,
    proposal: impl Fn() -> P,
    settings: FilterSettings,
    horizon: usize,
    seeds: std::ops::Range<u64>,
) -> Vec<Judged> {
    let judged = seeds.map(|number| {
        let seed = Seed::from_u64(910).nth(number);
        let data = simulate(model, horizon, &mut seed.child("data").stream()).unwrap();
        judge(model, proposal(), settings, &data.measurements, &seed)
    });
    judged.collect()
}
