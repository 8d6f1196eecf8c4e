//! Filters with a proposal that is learned once, of models that are stated once.
//!
//! Weights are those of an untrained proposal: they change what particles do, not what a step costs.

use motes_models::equations::{Coordinates, Equations, Scalar, normal};
use motes_models::{Measurements, ModelShape, simulate};
use motes_proposals::{Amortised, AmortisedConfig, Backend, Base, Covariance, Family, HeadConfig, Sees};
use motes_smc::{FilterBank, FilterSettings, ResampleWhen, Resampling};

use crate::folder::seed;
use crate::task::{Answer, LearnedTask};
use crate::work::{Work, of_evidences};

/// Times of a filter.
pub(crate) const HORIZON: usize = 100;

/// The share of the transition that the command mixes in.
const DEFENSIVE: f64 = 0.1;

/// The names of the models.
pub(crate) const MODELS: [&str; 2] = ["growth", "tracking"];

/// The growth model.
struct Growth;

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    #[inline(always)]
    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
        state.push(normal(0.0, 5.0_f64.sqrt()));
    }

    #[inline(always)]
    fn transition<S: Scalar>(&self, time: usize, x: &[S], state: &mut impl Coordinates<S>) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * time as f64).cos();
        state.push(normal(drift, 10.0_f64.sqrt()));
    }

    #[inline(always)]
    fn measurement<S: Scalar>(&self, _: usize, x: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

/// A target in the plane, seen by distance and direction.
struct Tracking;

impl Equations for Tracking {
    fn dimensions(&self) -> [usize; 2] {
        [4, 2]
    }

    #[inline(always)]
    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
        for (mean, sd) in [(5.0, 1.0), (5.0, 1.0), (0.2, 0.1), (-0.1, 0.1)] {
            state.push(normal(mean, sd));
        }
    }

    #[inline(always)]
    fn transition<S: Scalar>(&self, _: usize, x: &[S], state: &mut impl Coordinates<S>) {
        (0..2).for_each(|i| state.push(normal(x[i] + x[i + 2], 0.05)));
        (2..4).for_each(|i| state.push(normal(x[i], 0.05)));
    }

    #[inline(always)]
    fn measurement<S: Scalar>(&self, _: usize, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal((x[0] * x[0] + x[1] * x[1]).sqrt(), 0.1));
        y.push(normal(x[1].atan2(x[0]), 0.02));
    }
}

/// What `motes learn` takes for the model where nothing is said.
fn config(model: &str) -> AmortisedConfig {
    let covariance = Covariance::Full;
    let (base, head) = match model {
        "growth" => (Base::Transition, HeadConfig::Mixture { components: 5, covariance }),
        _ => (Base::Linearised, HeadConfig::Gaussian { covariance }),
    };
    AmortisedConfig { widths: vec![64, 64], sees: Sees::All, base, head }
}

/// Floating-point operations of the networks in a filter of so many particles.
pub(crate) fn operations(model: &str, particles: usize) -> f64 {
    let [n, m] = if model == "growth" { Growth.dimensions() } else { Tracking.dimensions() };
    let config = config(model);
    let outputs = config.head.head(n).map_or(0, |head| head.outputs());
    let inputs = 2 * (n + m);
    let widths = [&[inputs], config.widths.as_slice()].concat();
    let hidden: usize = widths.windows(2).map(|pair| pair[0] * pair[1]).sum();
    // The outputs see the inputs, too.
    let last = widths.last().map_or(0, |last| (last + inputs) * outputs);
    2.0 * ((hidden + last) * particles * (HORIZON - 1)) as f64
}

/// Gets ready for a task.
pub(crate) fn prepare(task: &LearnedTask) -> Result<Box<dyn Work>, String> {
    match task.model.as_str() {
        "growth" => Ok(Box::new(Filtering::of(Growth, task)?)),
        "tracking" => Ok(Box::new(Filtering::of(Tracking, task)?)),
        other => Err(format!("there is no model {other}")),
    }
}

struct Filtering<M> {
    model: M,
    measurements: Measurements,
    proposal: Amortised,
    particles: usize,
    runs: u64,
}

impl<M: Equations> Filtering<M> {
    fn of(model: M, task: &LearnedTask) -> Result<Self, String> {
        let drawn = simulate(&model, HORIZON, &mut seed().child("learned").stream());
        let measurements = drawn.map_err(|error| error.to_string())?.measurements;
        let shape = ModelShape::of(&model);
        let proposal = Amortised::create(
            &config(&task.model),
            &shape,
            0,
            Backend::Native.into(),
            &seed().child("weights"),
        )
        .map_err(|error| error.to_string())?;
        Ok(Filtering { model, measurements, proposal, particles: task.particles, runs: 0 })
    }

    fn evidence(&mut self) -> Result<f64, String> {
        let settings = FilterSettings {
            resampling: Resampling::Systematic,
            resample_when: ResampleWhen::EssBelow(0.5),
            defensive_weight: Some(DEFENSIVE),
            ..FilterSettings::new(self.particles)
        };
        self.runs += 1;
        let seed = seed().child("learned filter").nth(self.runs);
        let mut bank = FilterBank::new(&self.model, self.proposal.clone(), settings, 1, &seed)
            .map_err(|error| error.to_string())?;
        bank.run(&self.measurements, |_| ()).map_err(|error| error.to_string())?;
        Ok(bank.log_evidence(0))
    }
}

impl<M: Equations> Work for Filtering<M> {
    fn check(&mut self) -> Result<Answer, String> {
        let found: Result<Vec<f64>, String> = (0..20).map(|_| self.evidence()).collect();
        Ok(of_evidences(&found?))
    }

    fn run(&mut self) -> Result<(), String> {
        self.evidence().map(|_| ())
    }
}
