//! Running one unit: draw its problem, train its proposal, run its filters, measure.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use motes_proposals::{Backend, Family, FrameSettings, Frames, save};
use motes_smc::{
    Bootstrap, FilterBank, FilterSettings, FixedLagSmoother, ParticleFilter, Proposal, ResampleWhen,
    Resampling,
};
use motes_train::{AdamConfig, GradientFlow, History, Objective, TrainConfig, train};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::config;
use crate::config::Training;
use crate::methods::Visitor;
use crate::metrics::{Recorded, metrics};
use crate::problem::{Model, Problem};
use crate::reference::{ReferenceCache, References};
use crate::series::Series;
use crate::{Interrupt, UnitConfig};

/// A number with its name.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// The name, as in the tables.
    pub name: String,
    /// The value; finite.
    pub value: f64,
}

impl Metric {
    pub(crate) fn new(name: &str, value: f64) -> Self {
        Metric { name: name.into(), value }
    }
}

/// What a unit found.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// What depends on nothing but the configuration.
    pub metrics: Vec<Metric>,
    /// What depends on the clock.
    pub timings: Vec<Metric>,
    /// Estimates over time, where the experiment shows them.
    pub series: Option<Series>,
}

/// Why a unit has no result.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitError {
    /// It failed, and would fail again.
    #[error("{0}")]
    Failed(String),
    /// Its trained proposal could not be written; nothing is wrong with the unit.
    #[error("{0}")]
    NotKept(String),
    /// It was abandoned because the run is being stopped.
    #[error("interrupted")]
    Interrupted,
}

/// A failure for any reason.
pub(crate) fn failed(error: impl ToString) -> UnitError {
    UnitError::Failed(error.to_string())
}

/// Evaluates units; what units have in common is computed once.
#[derive(Default)]
pub struct Evaluator {
    references: ReferenceCache,
    models: Option<PathBuf>,
}

impl Evaluator {
    /// One that keeps the trained proposal of each unit as `folder/<key>`, if there is a folder.
    pub fn new(models: Option<PathBuf>) -> Self {
        Evaluator { references: ReferenceCache::default(), models }
    }

    /// Runs a unit on the calling thread.
    ///
    /// # Errors
    /// [`UnitError::Failed`] with the reason, [`UnitError::Interrupted`] soon after `interrupt` was raised.
    pub fn evaluate(&self, unit: &UnitConfig, interrupt: &Interrupt) -> Result<Evaluation, UnitError> {
        let problem = Problem::draw(unit).map_err(failed)?;
        let references = self.references.of(unit, &problem, interrupt)?;
        let run = Run { evaluator: self, unit, problem: &problem, references: &references, interrupt };
        let evaluation = unit.method.visit(&*problem.model, run)?;
        match evaluation.metrics.iter().find(|metric| !metric.value.is_finite()) {
            Some(metric) => Err(failed(format!("the metric {} is {}", metric.name, metric.value))),
            None => Ok(evaluation),
        }
    }
}

/// A unit being run.
#[derive(Clone, Copy)]
struct Run<'a> {
    evaluator: &'a Evaluator,
    unit: &'a UnitConfig,
    problem: &'a Problem,
    references: &'a References,
    interrupt: &'a Interrupt,
}

impl Visitor for Run<'_> {
    type Output = Evaluation;

    fn designed(self, proposal: impl Proposal<Model>) -> Result<Evaluation, UnitError> {
        self.judge(&*self.problem.model, proposal)
    }

    fn learned<F: Family + Proposal<Model>>(
        self,
        family: &F::Config,
        training: &Training,
        steps: usize,
        backend: config::Backend,
    ) -> Result<Evaluation, UnitError> {
        let config = train_config(training, self.unit.filter.particles, steps);
        let (proposal, history, seconds) = self.train::<F>(family, &config, backend)?;
        if let Some(models) = &self.evaluator.models {
            let folder = models.join(self.unit.key());
            save(&folder, &proposal, &*self.problem.model, &config)
                .map_err(|error| UnitError::NotKept(error.to_string()))?;
        }
        let mut evaluation = self.judge(&*self.problem.model, proposal)?;
        let ends = [("loss_first", history.losses.first()), ("loss_last", history.losses.last())];
        for (name, loss) in ends {
            evaluation.metrics.extend(loss.map(|&loss| Metric::new(name, loss)));
        }
        evaluation.timings.insert(0, Metric::new("train_seconds", seconds));
        Ok(evaluation)
    }

    fn frames(&self, settings: &FrameSettings) -> Result<Frames, UnitError> {
        let seed = self.unit.system_seed().child("frames");
        Frames::simulated(&*self.problem.system, self.unit.system.horizon(), settings, &seed).map_err(failed)
    }

    fn reference(self, lag: usize) -> Result<Evaluation, UnitError> {
        match lag {
            0 => self.judge(&*self.problem.system, Bootstrap),
            _ => self.smooth(lag),
        }
    }
}

impl Run<'_> {
    /// Draws initial weights and trains them on the problem's measurements; the last value is the seconds that training took.
    fn train<F: Family>(
        self,
        family: &F::Config,
        config: &TrainConfig,
        backend: config::Backend,
    ) -> Result<(F, History, f64), UnitError> {
        let backend = match backend {
            config::Backend::Native => Backend::Native,
            config::Backend::Flex => Backend::Flex,
            config::Backend::Ndarray => Backend::NdArray,
        };
        let (model, seed) = (&*self.problem.model, self.unit.own_seed());
        let (horizon, weights) = (self.unit.system.horizon(), seed.child("weights"));
        let mut proposal = F::create(family, model, horizon, backend.into(), &weights).map_err(failed)?;
        let start = Instant::now();
        let mut stream = seed.child("training").stream();
        let measurements = &self.problem.trajectory.measurements;
        let watch = |_, _| self.interrupt.check();
        let history =
            train(&mut proposal, model, measurements, config, &mut stream, watch).map_err(failed)?;
        if history.losses.len() < config.steps {
            return Err(UnitError::Interrupted);
        }
        Ok((proposal, history, start.elapsed().as_secs_f64()))
    }

    /// Runs the filters of a unit with one proposal.
    fn judge<P: Proposal<Model>>(self, model: &Model, proposal: P) -> Result<Evaluation, UnitError> {
        let Run { unit, problem, .. } = self;
        let start = Instant::now();
        let (filters, n) = (unit.filter_runs, unit.system.dimension());
        let seed = unit.own_seed().child("filter");
        let settings = filter_settings(&unit.filter);
        let mut bank = FilterBank::new(model, proposal, settings, filters, &seed).map_err(failed)?;
        let mut recorded = Recorded::with_capacity(filters, unit.system.horizon(), n);
        let mut mean = vec![0.0; n];
        for measurement in problem.trajectory.measurements.rows() {
            self.go_on()?;
            bank.step(measurement).map_err(failed)?;
            for filter in 0..filters {
                bank.mean(filter, &mut mean);
                recorded.means.extend_from_slice(&mean);
                recorded.effective_sample_sizes.push(bank.weights(filter).effective_sample_size());
            }
        }
        recorded.log_evidence.extend((0..filters).map(|filter| bank.log_evidence(filter)));
        Ok(self.found(&recorded, start))
    }

    /// Smooths by `lag` later measurements, as far as there are any, under the densities that data were drawn with.
    fn smooth(self, lag: usize) -> Result<Evaluation, UnitError> {
        let Run { unit, problem, .. } = self;
        let start = Instant::now();
        let (runs, n, horizon) = (unit.filter_runs, unit.system.dimension(), unit.system.horizon());
        let seed = unit.own_seed().child("filter");
        let settings = filter_settings(&unit.filter);
        let mut recorded = Recorded::with_capacity(runs, horizon, n);
        recorded.means.resize(horizon * runs * n, 0.0);
        for run in 0..runs {
            let stream = seed.nth(run as u64).stream();
            let filter =
                ParticleFilter::new(&*problem.system, Bootstrap, settings, stream).map_err(failed)?;
            let mut smoother = FixedLagSmoother::new(filter, lag);
            for (time, measurement) in problem.trajectory.measurements.rows().enumerate() {
                self.go_on()?;
                smoother.step(measurement).map_err(failed)?;
                recorded.effective_sample_sizes.push(smoother.filter().effective_sample_size());
                // At the end there is nothing more to wait for.
                let last = if time + 1 == horizon { 0 } else { lag };
                for back in (last..=lag.min(time)).rev() {
                    let at = ((time - back) * runs + run) * n;
                    smoother.mean(back, &mut recorded.means[at..at + n]);
                }
            }
            recorded.log_evidence.push(smoother.filter().log_evidence());
        }
        Ok(self.found(&recorded, start))
    }

    fn go_on(self) -> Result<(), UnitError> {
        match self.interrupt.check() {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(UnitError::Interrupted),
        }
    }

    fn found(self, recorded: &Recorded, start: Instant) -> Evaluation {
        let timings = vec![Metric::new("filter_seconds", start.elapsed().as_secs_f64())];
        let metrics = metrics(self.problem, self.references, recorded);
        Evaluation { metrics, timings, series: Series::of(self.unit, self.problem, recorded) }
    }
}

fn filter_settings(filter: &config::Filter) -> FilterSettings {
    FilterSettings {
        particles: filter.particles,
        resampling: match filter.resampling {
            config::Resampling::Multinomial => Resampling::Multinomial,
            config::Resampling::Systematic => Resampling::Systematic,
            config::Resampling::Stratified => Resampling::Stratified,
            config::Resampling::Residual => Resampling::Residual,
        },
        resample_when: ResampleWhen::EssBelow(filter.ess_threshold),
    }
}

fn train_config(training: &config::Training, particles: usize, steps: usize) -> TrainConfig {
    TrainConfig {
        objective: match training.objective {
            config::Objective::LogLikelihood => Objective::LogLikelihood,
            config::Objective::Literal => Objective::Literal,
            config::Objective::Elbo => Objective::Elbo,
        },
        gradient: match (training.gradient, training.gradient_window) {
            (config::Gradient::Truncated, Some(window)) => GradientFlow::Truncated { window },
            _ => GradientFlow::Full,
        },
        clip_norm: training.clip_norm,
        particles,
        steps,
        adam: AdamConfig {
            learning_rate: training.learning_rate,
            beta_1: training.beta_1,
            beta_2: training.beta_2,
            epsilon: training.epsilon,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::MethodConfig;
    use crate::unit::tests::{fcnn_unit, on_graph};
    use motes_models::{Seed, Sequence};
    use motes_proposals::{Fcnn, Learnable};
    use rand::RngExt;

    #[test]
    fn the_hidden_states_have_no_influence_on_the_trained_weights() {
        let unit = fcnn_unit(6, 4, 5);
        let MethodConfig::Fcnn(fcnn) = &unit.method else { panic!("not an fcnn") };
        let weights = |problem: &Problem| {
            let (evaluator, references) = (Evaluator::default(), References::default());
            let interrupt = Interrupt::default();
            let run = Run {
                evaluator: &evaluator,
                unit: &unit,
                problem,
                references: &references,
                interrupt: &interrupt,
            };
            let config = train_config(&fcnn.training, unit.filter.particles, fcnn.steps);
            let (proposal, _, _) = run.train::<Fcnn>(&fcnn.proposal, &config, fcnn.backend).unwrap();
            let parameters = proposal.parameters();
            (0..parameters.len()).flat_map(|at| parameters.host(at)).collect::<Vec<f64>>()
        };
        let problem = Problem::draw(&unit).unwrap();
        let mut other = Problem::draw(&unit).unwrap();
        let mut stream = Seed::from_u64(99).stream();
        let nonsense = (0..4 * 6).map(|_| 1e6 * stream.random::<f64>()).collect();
        other.trajectory.states = Sequence::new(6, nonsense).unwrap();
        other.exact = None;
        let expected = weights(&problem);
        assert_eq!(weights(&other), expected);
        // The same comparison does see a change in the measurements.
        let another = Problem::draw(&UnitConfig { repetition: 1, ..unit.clone() }).unwrap();
        assert_ne!(weights(&another), expected);
    }

    #[test]
    fn an_interrupt_abandons_a_unit() {
        let interrupt = Interrupt::default();
        interrupt.raise();
        assert_eq!(
            Evaluator::default().evaluate(&fcnn_unit(6, 4, 5), &interrupt),
            Err(UnitError::Interrupted)
        );
    }

    #[test]
    fn a_collapsed_filter_is_a_failed_unit_with_its_reason() {
        // Exact uniform densities with a handful of bootstrap particles: none explains the measurement.
        let mut unit = crate::unit::tests::unit(10, 12, 2);
        let system = on_graph(&mut unit);
        system.noise = config::Noise::Uniform;
        system.densities = config::Densities::Exact;
        let Err(UnitError::Failed(reason)) = Evaluator::default().evaluate(&unit, &Interrupt::default())
        else {
            panic!("no failure")
        };
        assert!(reason.contains("all weights of filter"), "{reason}");
    }
}
