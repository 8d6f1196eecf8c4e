//! Running one unit: draw its problem, train its proposal, run its filters, measure.

use std::path::PathBuf;
use std::time::Instant;

use motes_cli::Interrupt;
use motes_models::Simulations;
use motes_proposals::{Backend, Family, Frames, Learnable, Psi, Rnn, save};
use motes_smc::{Bootstrap, LookAhead, Proposal};

use super::dispatch::{Visitor, visit};
use super::evaluation::Evaluation;
use super::learning::{TrainingResult, train_config};
use super::proposal_store::{Notes, ProposalStore};
use super::run::Run;
use crate::checkpoint::Checkpoints;
use crate::config::{Estimand, Training};
use crate::learned_once::{LearnedOnce, OnceFamily};
use crate::method_config::FrameSettings;
use crate::metric::Metric;
use crate::problem::{Model, Problem};
use crate::reference::ReferenceCache;
use crate::threads;
use crate::unit::UnitConfig;
use crate::unit_error::{UnitError, failed};

/// Evaluates units; what units have in common is computed once.
#[derive(Default)]
pub struct Evaluator {
    references: ReferenceCache,
    models: Option<PathBuf>,
    checkpoints: Option<Checkpoints>,
    kept: ProposalStore,
}

impl Evaluator {
    /// One that keeps the trained proposal of each unit as `folder/<key>`, if there is a folder.
    pub fn new(models: Option<PathBuf>) -> Self {
        Evaluator { models, ..Evaluator::default() }
    }

    /// Keeps proposals that are learned once in `folder`, where later runs find them.
    #[must_use]
    pub(crate) fn keeping(self, folder: PathBuf) -> Self {
        Evaluator { kept: ProposalStore::new(folder), ..self }
    }

    /// Checkpoints long trainings now and then, and when the run is being stopped, and resumes them.
    #[must_use]
    pub(crate) fn with_checkpoints(self, checkpoints: Checkpoints) -> Self {
        Evaluator { checkpoints: Some(checkpoints), ..self }
    }

    /// Runs a unit on the calling thread, and on the others of its rayon pool, if it is one of a pool.
    ///
    /// # Errors
    /// [`UnitError::Failed`] with the reason, [`UnitError::Interrupted`] soon after `interrupt` was raised.
    pub fn evaluate(&self, unit: &UnitConfig, interrupt: &Interrupt) -> Result<Evaluation, UnitError> {
        let problem = Problem::draw(unit).map_err(failed)?;
        let references = self.references.of(unit, &problem, interrupt)?;
        let (models, checkpoints) = (self.models.as_deref(), self.checkpoints.as_ref());
        let kept = &self.kept;
        let run =
            Run { unit, problem: &problem, references: &references, models, checkpoints, kept, interrupt };
        let mut evaluation = visit(&unit.method, &*problem.model, run)?;
        evaluation.timings.push(Metric::new("threads", threads::here() as f64));
        match evaluation.metrics.iter().find(|metric| !metric.value.is_finite()) {
            Some(metric) => Err(failed(format!("the metric {} is {}", metric.name, metric.value))),
            None => Ok(evaluation),
        }
    }
}

impl Visitor for Run<'_> {
    type Output = Evaluation;

    fn designed(self, proposal: impl Proposal<Model> + Clone) -> Result<Evaluation, UnitError> {
        self.estimate(proposal)
    }

    fn learned<F: Family + Learnable + Proposal<Model> + Clone>(
        self,
        family: &F::Config,
        training: &Training,
        steps: usize,
        backend: Backend,
    ) -> Result<Evaluation, UnitError> {
        let config = train_config(training, self.unit.filter.particles, steps);
        let TrainingResult { proposal, history, seconds, earlier } =
            self.train::<F>(family, &config, backend)?;
        if let Some(models) = self.models {
            let folder = models.join(self.unit.key());
            save(&folder, &proposal, &*self.problem.model, &self.problem.shape, &config)
                .map_err(|error| UnitError::NotKept(error.to_string()))?;
        }
        let mut evaluation = self.estimate(proposal)?;
        let ends = [("loss_first", history.losses.first()), ("loss_last", history.losses.last())];
        for (name, loss) in ends {
            evaluation.metrics.extend(loss.map(|&loss| Metric::new(name, loss)));
        }
        evaluation.timings.insert(0, Metric::new("train_seconds", seconds));
        evaluation.earlier = earlier;
        Ok(evaluation)
    }

    fn once(self, method: &LearnedOnce) -> Result<Evaluation, UnitError> {
        match &method.family {
            OnceFamily::Fcnn(config) | OnceFamily::Gnn(config) => {
                self.judge(self.amortised(self.kept, config, method)?)
            }
            OnceFamily::Rnn(config, training) => {
                self.judge(self.by_elbo::<Rnn>(self.kept, config, training, method)?)
            }
            OnceFamily::Psi(config, training) => {
                self.judge(self.by_elbo::<Psi>(self.kept, config, training, method)?)
            }
        }
    }

    fn frames(&self, settings: &FrameSettings) -> Result<Frames, UnitError> {
        let FrameSettings { origin, trajectories, largest_state } = *settings;
        let (system, seed) = (&*self.problem.system, self.unit.system_seed().child("frames"));
        let horizon = self.unit.system.horizon();
        let simulations =
            Simulations::draw(system, horizon, trajectories, largest_state, &seed).map_err(failed)?;
        Frames::of(&simulations, origin).map_err(failed)
    }

    fn reference(self, lag: usize) -> Result<Evaluation, UnitError> {
        match lag {
            0 => self.run_filters(&*self.problem.system, Bootstrap),
            _ => self.smooth(&*self.problem.system, &Bootstrap, lag),
        }
    }

    fn look_ahead(self, learned: Option<usize>) -> Result<Evaluation, UnitError> {
        let model = self.problem.equations()?;
        let recorded = self.problem.recorded();
        let learned = learned.map(|steps| self.potentials(steps)).transpose()?;
        let start = Instant::now();
        let ahead = match &learned {
            None => LookAhead::new(model, &recorded),
            Some((potentials, _)) => potentials.look_ahead(model, &recorded),
        };
        let seconds = start.elapsed().as_secs_f64();
        let lag = self.unit.system.horizon() - 1;
        let mut evaluation = self.smooth(model, &ahead.map_err(failed)?, lag)?;
        evaluation.timings.push(Metric::new("setup_seconds", seconds));
        if let Some((_, notes)) = learned {
            evaluation.metrics.extend(notes.metrics());
            evaluation.timings.push(notes.timings());
        }
        Ok(evaluation)
    }
}

impl Run<'_> {
    /// Estimates what the unit asks for with a proposal for the filter's model.
    fn estimate<P: Proposal<Model> + Clone>(self, proposal: P) -> Result<Evaluation, UnitError> {
        let model = &*self.problem.model;
        match self.unit.estimand {
            Estimand::Filtering => self.run_filters(model, proposal),
            Estimand::Smoothing => self.smooth(model, &proposal, self.unit.system.horizon() - 1),
        }
    }

    /// Runs the filters of a proposal that was learned once.
    fn judge<P: Proposal<Model> + Clone>(
        self,
        (proposal, notes): (P, Notes),
    ) -> Result<Evaluation, UnitError> {
        let mut evaluation = self.estimate(proposal)?;
        evaluation.metrics.extend(notes.metrics());
        evaluation.timings.insert(0, notes.timings());
        Ok(evaluation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Densities;
    use crate::method_config::MethodConfig;
    use crate::provenance::Provenance;
    use crate::reference::References;
    use crate::unit::tests::{fcnn_unit, on_graph};
    use motes_models::{Noise, Seed, Sequence};
    use motes_proposals::{Fcnn, Parametric};
    use motes_train::Training;
    use rand::RngExt;

    #[test]
    fn the_hidden_states_have_no_influence_on_the_trained_weights() {
        let unit = fcnn_unit(6, 4, 5);
        let MethodConfig::Fcnn(fcnn) = &unit.method else { panic!("not an fcnn") };
        let weights = |problem: &Problem| {
            let (references, interrupt, kept) =
                (References::default(), Interrupt::default(), ProposalStore::default());
            let run = Run {
                unit: &unit,
                problem,
                references: &references,
                models: None,
                checkpoints: None,
                kept: &kept,
                interrupt: &interrupt,
            };
            let config = train_config(&fcnn.training, unit.filter.particles, fcnn.steps);
            let trained = run.train::<Fcnn>(&fcnn.proposal, &config, fcnn.backend).unwrap();
            let parameters = trained.proposal.parameters();
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
    fn a_training_goes_on_from_its_checkpoint() {
        let unit = fcnn_unit(6, 4, 5);
        let MethodConfig::Fcnn(fcnn) = &unit.method else { panic!("not an fcnn") };
        let expected = Evaluator::default().evaluate(&unit, &Interrupt::default()).unwrap().metrics;

        // Three of its five steps, by hand.
        let folder = tempfile::tempdir().unwrap();
        let (problem, seed) = (Problem::draw(&unit).unwrap(), unit.own_seed());
        let checkpoints = |revision: &str| Checkpoints {
            folder: folder.path().into(),
            provenance: Provenance { revision: revision.into(), processor: "x86_64".into() },
        };
        let write_checkpoint = |seed: &Seed| {
            let weights = seed.child("weights");
            let mut proposal =
                Fcnn::create(&fcnn.proposal, &problem.shape, 4, Backend::Native.into(), &weights).unwrap();
            let mut stream = seed.child("training").stream();
            let config = train_config(&fcnn.training, unit.filter.particles, fcnn.steps);
            let measurements = &problem.trajectory.measurements;
            let mut training =
                Training::new(&proposal, &*problem.model, measurements, &config, &mut stream).unwrap();
            (0..3).for_each(|_| assert!(training.step(&mut proposal).is_ok()));
            let bytes = training.checkpoint(&proposal).unwrap();
            checkpoints("earlier").of(&unit.key()).write(7.0, &[], &bytes).unwrap();
        };
        write_checkpoint(&seed);
        let evaluator = Evaluator::new(None).with_checkpoints(checkpoints("now"));
        let found = evaluator.evaluate(&unit, &Interrupt::default()).unwrap();
        assert_eq!(found.metrics, expected);
        assert_eq!(found.earlier, [checkpoints("earlier").provenance]);
        assert!(found.timings[0].value > 7.0, "the seconds of both parts");

        // It was used: the checkpoint of another training leads elsewhere.
        write_checkpoint(&seed.child("another"));
        let found = evaluator.evaluate(&unit, &Interrupt::default()).unwrap();
        assert_ne!(found.metrics, expected);

        // A damaged one is not.
        let path = folder.path().join(format!("{}.checkpoint", unit.key()));
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        for damaged in [bytes.as_slice(), &bytes[..30], &[]] {
            std::fs::write(&path, damaged).unwrap();
            let found = evaluator.evaluate(&unit, &Interrupt::default()).unwrap();
            assert_eq!(found.metrics, expected);
            assert!(found.earlier.is_empty());
        }
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
        system.noise = Noise::Uniform;
        system.densities = Densities::Exact;
        let Err(UnitError::Failed(reason)) = Evaluator::default().evaluate(&unit, &Interrupt::default())
        else {
            panic!("no failure")
        };
        assert!(reason.contains("all weights of filter"), "{reason}");
    }
}
