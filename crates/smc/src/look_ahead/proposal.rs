//! The proposal that looks ahead.

use std::sync::Arc;

use motes_models::Step;
use motes_models::batch::{LANES, Rows};
use motes_models::equations::{Lanes, Linearise};

use super::ahead::{StepAhead, look, look_by};
use super::batch::LookAheadBatch;
use super::component::PotentialComponent;
use super::error::LookAheadError;
use super::recorded::RecordedStep;
use super::scratch::{LookAheadScratch, TileGuide};
use crate::proposal::{Context, Proposal};
use crate::proposal_error::ProposalError;

/// Potentials of a recorded sequence by a linearised smoother, and the proposal that draws by them. A clone shares them.
///
/// It is for a filter that takes just these steps with these measurements; its log-evidence is that of all of them after the last one alone.
///
/// ```
/// use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal, poisson};
/// use motes_models::{Seed, Step, StepRecord, simulate};
/// use motes_smc::{FilterSettings, LookAhead, ParticleFilter, RecordedStep};
///
/// /// Counts whose log-rate walks.
/// struct Counts;
///
/// impl Equations for Counts {
///     fn dimensions(&self) -> [usize; 2] {
///         [1, 1]
///     }
///
///     fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
///         x[0] = draws.draw(normal(0.0, 1.0));
///     }
///
///     fn transition<S: Scalar>(&self, _: &Step<'_, S>, before: &[S], draws: &mut impl Draws<S>, x: &mut [S]) {
///         x[0] = draws.draw(normal(before[0], 0.1));
///     }
///
///     fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
///         y.push(poisson(x[0].exp()));
///     }
/// }
///
/// let seed = Seed::from_u64(1);
/// let data = simulate(&Counts, 50, &mut seed.child("data").stream())?;
/// let recorded: Vec<RecordedStep> = data.measurements.rows().enumerate().map(|(index, row)| RecordedStep {
///     step: StepRecord::of(&Step::of_index(index)),
///     measurement: row.iter().copied().map(Some).collect(),
/// }).collect();
/// let ahead = LookAhead::new(&Counts, &recorded)?;
/// let found: Vec<f64> = (0..4).map(|run| {
///     let stream = seed.nth(run).stream();
///     let mut filter = ParticleFilter::new(&Counts, ahead.clone(), FilterSettings::new(32), stream)?;
///     for row in &recorded {
///         filter.step_at(&row.step.step(), &row.measurement)?;
///     }
///     Ok(filter.log_evidence())
/// }).collect::<Result<_, motes_smc::FilterError>>()?;
/// assert!(found.iter().all(|log| (log - found[0]).abs() < 0.1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct LookAhead {
    steps: Arc<Vec<StepAhead>>,
    has_converged: bool,
    /// The step that it was prepared for.
    at: Option<usize>,
}

impl LookAhead {
    /// Potentials of these steps of `model`, from `t = 0` on.
    ///
    /// # Errors
    /// [`LookAheadError`] if the model does not say how its states are made of noise, there is no step, or the smoother leaves the numbers.
    pub fn new<M: Linearise + ?Sized>(model: &M, recorded: &[RecordedStep]) -> Result<Self, LookAheadError> {
        let (steps, has_converged) = look(model, recorded)?;
        Ok(LookAhead { steps: Arc::new(steps), has_converged, at: None })
    }

    /// Potentials that came from elsewhere, of these steps of `model` from `t = 0` on: each the sum of at least one quadratic. Any potentials leave the evidence unbiased.
    ///
    /// # Errors
    /// [`LookAheadError`] if the model does not say how its states are made of noise, there is no step, or potentials do not fit the steps.
    pub fn from_potentials<M: Linearise + ?Sized>(
        model: &M,
        recorded: &[RecordedStep],
        potentials: &[Vec<PotentialComponent>],
    ) -> Result<Self, LookAheadError> {
        let steps = look_by(model, recorded, potentials)?;
        Ok(LookAhead { steps: Arc::new(steps), has_converged: true, at: None })
    }

    /// Whether the smoother has converged. If not, potentials are what its last iteration gave, and the evidence is as unbiased.
    pub fn has_converged(&self) -> bool {
        self.has_converged
    }

    /// What potentials are about: `x̂_t` (`N`) of each step of the smoothed path, or the centre of the first quadratic of each.
    pub fn path(&self) -> impl Iterator<Item = &[f64]> {
        self.steps.iter().map(StepAhead::centre)
    }

    /// `log ψ_t` of a state (`N`), but for a constant; none past the last step.
    pub fn log_potential(&self, index: usize, state: &[f64]) -> Option<f64> {
        self.steps.get(index).map(|step| step.log_potential(state))
    }

    /// `log Z̃_t(x_{t−1})` of each of `K` rows `x_{t−1}` (`K×N`) of the step before `index`, into `out` (`K`); 0 past the last step, beyond which nothing is measured.
    ///
    /// # Panics
    /// If `index` is 0, where there is no row before.
    pub fn log_expectations<M: Linearise + ?Sized>(
        &self,
        model: &M,
        index: usize,
        previous: &[f64],
        out: &mut [f64],
    ) {
        assert!(index > 0, "an expectation is one of a step from a state");
        let (Some(ahead), Some(noise_space)) = (self.steps.get(index), model.noise_space()) else {
            return out.fill(0.0);
        };
        let n = model.state_dim();
        let (mut guide, mut tile) = (TileGuide::default(), vec![0.0; n * LANES]);
        let (rows, step) = (Rows::all(previous, n), ahead.step.step());
        for (number, out) in out.chunks_mut(LANES).enumerate() {
            rows.load(number * LANES, &mut tile);
            let Lanes(found) = guide.find(model, noise_space, ahead, &step, Some(&tile));
            out.copy_from_slice(&found[..out.len()]);
        }
    }
}

impl<M: Linearise + ?Sized> Proposal<M> for LookAhead {
    type Memory = ();
    type Scratch = LookAheadScratch;
    type Conditional<'a>
        = LookAheadBatch<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn looks_ahead(&self) -> bool {
        true
    }

    fn prepare(
        &mut self,
        model: &M,
        step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        let (horizon, time) = (self.steps.len(), step.index);
        let ahead = self.steps.get(time).ok_or(ProposalError::PastHorizon { horizon, time })?;
        ProposalError::unless_same("the state dimension N", ahead.centre().len(), model.state_dim())?;
        if ahead.measurement != measurement || ahead.step.step() != *step {
            let reason = "it looks ahead of another step or measurement than this one".into();
            return Err(ProposalError::Measurement { time, reason });
        }
        self.at = Some(time);
        Ok(true)
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        scratch: &'a mut LookAheadScratch,
    ) -> Result<LookAheadBatch<'a, M>, ProposalError> {
        let time = context.step.index;
        let noise_space = model.noise_space().ok_or(ProposalError::NoDensity)?;
        match (self.at == Some(time), self.steps.get(time)) {
            (true, Some(now)) => {
                let next = self.steps.get(time + 1);
                Ok(LookAheadBatch { model, noise_space, context, now, next, is_alone: false, scratch })
            }
            _ => Err(ProposalError::NotPrepared { time }),
        }
    }

    fn log_look_ahead(&self, model: &M, index: usize, states: &[f64], out: &mut [f64]) -> bool {
        self.log_expectations(model, index + 1, states, out);
        true
    }
}
