//! What a filter needs of each step to look ahead.

use motes_models::batch::LANES;
use motes_models::equations::{Draw, Linearise};
use motes_models::{Step, StepRecord};

use super::backward::local;
use super::component::{Component, PotentialComponent};
use super::error::LookAheadError;
use super::local::{Local, LocalMap};
use super::potential::Numbers;
use super::recorded::RecordedStep;
use super::smoother::{Smoothed, smooth};
use crate::proposals::{log_add, noise_share};

/// One step.
#[derive(Debug, Clone)]
pub(super) struct StepAhead {
    pub(super) step: StepRecord,
    pub(super) measurement: Vec<Option<f64>>,
    /// The quadratics that its potential is the sum of, at least one.
    pub(super) components: Vec<Component>,
    /// `v̂`, about which the map is linearised, `Q`.
    pub(super) noise: Numbers,
    /// The share of particles that is drawn from the noise's own distribution where nobody says another.
    pub(super) share: f64,
    /// Where each coordinate is a normal draw of its own, in order, its variances near the path: the squares of `S`, `N`.
    pub(super) variances: Option<Numbers>,
}

impl StepAhead {
    /// `Q`.
    pub(super) fn draws(&self) -> usize {
        self.noise.len()
    }

    /// What its first quadratic is about, `N`.
    pub(super) fn centre(&self) -> &[f64] {
        &self.components[0].potential.reference
    }

    /// `log ψ(x)`.
    pub(super) fn log_potential(&self, state: &[f64]) -> f64 {
        let log = |component: &Component| component.log_weight + component.potential.log(state);
        let sum = |sum: f64, component| log_add(sum, log(component));
        self.components[1..].iter().fold(log(&self.components[0]), sum)
    }
}

/// All steps of a recorded sequence, and whether the smoother has converged.
///
/// # Errors
/// [`LookAheadError`] if the model has no such map, the steps are none, or the smoother does not come through.
pub(super) fn look<M: Linearise + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
) -> Result<(Vec<StepAhead>, bool), LookAheadError> {
    let draws = draws_of_all(model, recorded)?;
    let counts: Vec<usize> = draws.iter().map(Vec::len).collect();
    let Smoothed { path, potentials, linearised, has_converged, .. } = smooth(model, recorded, &counts)?;
    let maps = &linearised.maps;
    let mut steps = Vec::with_capacity(recorded.len());
    for (index, potential) in potentials.into_iter().enumerate() {
        let RecordedStep { step, measurement } = &recorded[index];
        let variances =
            normal_variances(model, &step.step(), path.previous(index), &draws[index], &maps[index]);
        steps.push(StepAhead {
            step: step.clone(),
            measurement: measurement.clone(),
            components: vec![Component::new(0.0, potential, variances.as_deref())],
            noise: Numbers::from_slice(path.noise(index)),
            share: noise_share(&draws[index]),
            variances,
        });
    }
    Ok((steps, has_converged))
}

/// Steps with potentials that came from elsewhere. The map of noise is linearised where there is none, `v̂ = 0`.
///
/// # Errors
/// [`LookAheadError`] if the model has no such map, the steps are none, or potentials do not fit them.
pub(super) fn look_by<M: Linearise + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
    potentials: &[Vec<PotentialComponent>],
) -> Result<Vec<StepAhead>, LookAheadError> {
    let draws = draws_of_all(model, recorded)?;
    if potentials.len() != recorded.len() {
        let (found, expected) = (potentials.len(), recorded.len());
        return Err(LookAheadError::Step {
            index: 0,
            what: "the number of steps with potentials",
            found,
            expected,
        });
    }
    let mut local = local(model)?;
    let mut steps: Vec<StepAhead> = Vec::with_capacity(recorded.len());
    for ((recorded, components), draws) in recorded.iter().zip(potentials).zip(&draws) {
        let near = steps.last().map(StepAhead::centre);
        steps.push(step_by(model, &mut local, recorded, draws, near, components)?);
    }
    Ok(steps)
}

/// A step with these quadratics, linearised `near` a previous state.
///
/// # Errors
/// [`LookAheadError`] if quadratics do not fit it.
pub(super) fn step_by<M: Linearise + ?Sized>(
    model: &M,
    local: &mut Local<'_>,
    RecordedStep { step, measurement }: &RecordedStep,
    draws: &[Draw],
    near: Option<&[f64]>,
    components: &[PotentialComponent],
) -> Result<StepAhead, LookAheadError> {
    let (index, n) = (step.step().index, model.state_dim());
    if components.is_empty() {
        return Err(LookAheadError::Step { index, what: "the number of quadratics", found: 0, expected: 1 });
    }
    let (noise, mut map) = (Numbers::from_elem(0.0, draws.len()), LocalMap::default());
    local.map(&step.step(), near, &noise, &mut map);
    let variances = normal_variances(model, &step.step(), near, draws, &map);
    let of_one = |component: &PotentialComponent| {
        let potential = component.potential(index, n)?;
        Ok(Component::new(component.log_weight, potential, variances.as_deref()))
    };
    Ok(StepAhead {
        step: step.clone(),
        measurement: measurement.clone(),
        components: components.iter().map(of_one).collect::<Result<_, LookAheadError>>()?,
        noise,
        share: noise_share(draws),
        variances,
    })
}

/// The draws of each step of a sequence that is as one of the model is.
///
/// # Errors
/// [`LookAheadError`] if the model has no map of noise, there is no step, or one does not fit.
fn draws_of_all<M: Linearise + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
) -> Result<Vec<Vec<Draw>>, LookAheadError> {
    let noise_space = model.noise_space().ok_or(LookAheadError::NoNoise)?;
    if recorded.is_empty() {
        return Err(LookAheadError::Empty);
    }
    let width = model.measurement_dim();
    for (index, RecordedStep { step, measurement }) in recorded.iter().enumerate() {
        let wrong = |what, found, expected| Err(LookAheadError::Step { index, what, found, expected });
        if step.step().index != index {
            return wrong("its index", step.step().index, index);
        }
        if measurement.len() != width {
            return wrong("the number of entries of its measurement", measurement.len(), width);
        }
    }
    Ok(recorded.iter().map(|row| draws_of(noise_space, &row.step.step())).collect())
}

/// The draws of a step: none where no time passes.
pub(super) fn draws_of(model: &dyn motes_models::equations::NoiseSpace, step: &Step<'_>) -> Vec<Draw> {
    if step.index > 0 && step.sub_steps == 0 { Vec::new() } else { model.draws(step) }
}

/// The variances of normal draws that are the coordinates themselves, near a state.
fn normal_variances<M: Linearise + ?Sized>(
    model: &M,
    step: &Step<'_>,
    previous: Option<&[f64]>,
    draws: &[Draw],
    map: &LocalMap,
) -> Option<Numbers> {
    let n = model.state_dim();
    let is_plain = draws.len() == n && draws.iter().all(|draw| *draw == Draw::Normal);
    let is_diagonal = |place: usize| place / n == place % n || map.along_noise[place] == 0.0;
    if !is_plain || model.density().is_none() || !(0..n * n).all(is_diagonal) {
        return None;
    }
    let tile: Option<Vec<f64>> = previous.map(|previous| previous.iter().flat_map(|x| [*x; LANES]).collect());
    let (mut means, mut variances) = (vec![0.0; n * LANES], vec![0.0; n * LANES]);
    model.tile_moments(step, tile.as_deref(), &mut means, &mut variances);
    Some(variances.iter().step_by(LANES).copied().collect())
}
