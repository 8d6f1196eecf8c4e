//! What a filter needs of each step to look ahead.

use motes_models::batch::LANES;
use motes_models::equations::triangle::{at, factor_from_last};
use motes_models::equations::{Draw, Linearise};
use motes_models::{Step, StepRecord};

use super::error::LookAheadError;
use super::local::LocalMap;
use super::potential::Potential;
use super::recorded::RecordedStep;
use super::smoother::{Smoothed, smooth};
use crate::proposals::noise_share;

/// One step.
#[derive(Debug, Clone)]
pub(super) struct StepAhead {
    pub(super) step: StepRecord,
    pub(super) measurement: Vec<Option<f64>>,
    pub(super) potential: Potential,
    /// `v̂`, about which the map is linearised, `Q`.
    pub(super) noise: Vec<f64>,
    /// The share of particles that is drawn from the noise's own distribution where nobody says another.
    pub(super) share: f64,
    /// Where each coordinate is a normal draw of its own, in order.
    pub(super) diagonal: Option<Diagonal>,
}

/// `Λ = I + S A S` of normal draws with these variances.
#[derive(Debug, Clone)]
pub(super) struct Diagonal {
    /// The squares of `S`, `N`.
    pub(super) variances: Vec<f64>,
    /// The `L` with `Λ = Lᵀ L`.
    pub(super) lower: Vec<f64>,
}

impl StepAhead {
    /// `Q`.
    pub(super) fn draws(&self) -> usize {
        self.noise.len()
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
    let draws: Vec<Vec<Draw>> = recorded.iter().map(|row| draws_of(noise_space, &row.step.step())).collect();
    let counts: Vec<usize> = draws.iter().map(Vec::len).collect();
    let Smoothed { path, potentials, maps, has_converged, .. } = smooth(model, recorded, &counts)?;
    let mut steps = Vec::with_capacity(recorded.len());
    for (index, potential) in potentials.into_iter().enumerate() {
        let RecordedStep { step, measurement } = &recorded[index];
        let diagonal =
            diagonal(model, &step.step(), path.previous(index), &draws[index], &maps[index], &potential);
        steps.push(StepAhead {
            step: step.clone(),
            measurement: measurement.clone(),
            potential,
            noise: path.noise(index).to_vec(),
            share: noise_share(&draws[index]),
            diagonal,
        });
    }
    Ok((steps, has_converged))
}

/// The draws of a step: none where no time passes.
fn draws_of(model: &dyn motes_models::equations::NoiseSpace, step: &Step<'_>) -> Vec<Draw> {
    if step.index > 0 && step.sub_steps == 0 { Vec::new() } else { model.draws(step) }
}

/// What is known of normal draws that are the coordinates themselves.
fn diagonal<M: Linearise + ?Sized>(
    model: &M,
    step: &Step<'_>,
    previous: Option<&[f64]>,
    draws: &[Draw],
    map: &LocalMap,
    potential: &Potential,
) -> Option<Diagonal> {
    let n = model.state_dim();
    let is_plain = draws.len() == n && draws.iter().all(|draw| *draw == Draw::Normal);
    let is_diagonal = |place: usize| place / n == place % n || map.along_noise[place] == 0.0;
    if !is_plain || model.density().is_none() || !(0..n * n).all(is_diagonal) {
        return None;
    }
    let tile: Option<Vec<f64>> = previous.map(|previous| previous.iter().flat_map(|x| [*x; LANES]).collect());
    let (mut means, mut variances) = (vec![0.0; n * LANES], vec![0.0; n * LANES]);
    model.tile_moments(step, tile.as_deref(), &mut means, &mut variances);
    let variances: Vec<f64> = variances.iter().step_by(LANES).copied().collect();
    let mut lower = vec![0.0; n * (n + 1) / 2];
    for i in 0..n {
        for j in 0..=i {
            let scaled = variances[i].sqrt() * potential.curvature[i * n + j] * variances[j].sqrt();
            lower[at(i, j)] = if i == j { 1.0 + scaled } else { scaled };
        }
    }
    factor_from_last(n, &mut lower);
    Some(Diagonal { variances, lower })
}
