//! The iterated linearised smoother: the most likely noise of a whole sequence, and potentials along its path.

use motes_models::StateSpaceModel;

use super::averages::Averages;
use super::backward::{LinearisedPath, local};
use super::error::LookAheadError;
use super::local::Local;
use super::path::{Path, Policy};
use super::potential::Potential;
use super::recorded::RecordedStep;
use super::rollout::{Rollout, roll};
use super::start::filtered_means;

/// Iterations of one start at the most.
const MOST_ITERATIONS: usize = 12;

/// The largest change of a number of noise, whose standard deviation is 1, at which a path has converged: potentials are quadratics about it, which are as good from a little further away.
const TOLERANCE: f64 = 0.03;

/// The share of what measurements say by which a second start goes.
const TEMPERED: f64 = 0.1;

/// How often sites are averaged over smoothed states, which these averages then move a little.
const AVERAGED: usize = 2;

/// A path and all that looking ahead needs of it.
pub(super) struct Smoothed {
    pub(super) path: Path,
    pub(super) potentials: Vec<Potential>,
    pub(super) linearised: LinearisedPath,
    policy: Policy,
    /// `Σ_t log p(y_t | x_t) − ½ |v_t|²`.
    objective: f64,
    pub(super) has_converged: bool,
}

/// Where a path may begin.
#[derive(Clone, Copy)]
enum Start {
    /// At the means of an extended Kalman filter.
    Filtered { tempered: f64 },
    /// Without noise.
    Undisturbed,
}

/// The smoothed path of a sequence with so many draws in each step: from an extended Kalman filter, and from elsewhere if that does not converge.
///
/// # Errors
/// [`LookAheadError`] if no start leads to finite potentials.
pub(super) fn smooth<M: StateSpaceModel + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
    draws: &[usize],
) -> Result<Smoothed, LookAheadError> {
    let starts =
        [Start::Filtered { tempered: 1.0 }, Start::Filtered { tempered: TEMPERED }, Start::Undisturbed];
    let mut best: Option<Smoothed> = None;
    let mut failure = LookAheadError::Empty;
    for start in starts {
        match from_start(model, recorded, draws, start) {
            Ok(found) => {
                let is_better = best.as_ref().is_none_or(|best| found.objective > best.objective);
                let is_done = found.has_converged;
                best = if is_better { Some(found) } else { best };
                if is_done {
                    break;
                }
            }
            Err(error) => failure = error,
        }
    }
    let mut best = best.ok_or(failure)?;
    let (mut averages, mut local) = (Averages::default(), local(model)?);
    for _ in 0..AVERAGED {
        if !averages.find(&mut local, recorded, &best.path, &best.policy, &mut best.linearised) {
            break;
        }
        // Where averages are too large, what there was stays.
        let Ok((potentials, policy)) = best.linearised.potentials(&best.path) else { break };
        (best.potentials, best.policy) = (potentials, policy);
    }
    Ok(best)
}

/// Iterations from one start.
fn from_start<M: StateSpaceModel + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
    draws: &[usize],
    start: Start,
) -> Result<Smoothed, LookAheadError> {
    let noise_space = model.noise_space().ok_or(LookAheadError::NoNoise)?;
    let mut local: Local<'_> = local(model)?;
    let mut path = Path::without_noise(model.state_dim(), draws.iter().copied());
    match start {
        Start::Filtered { tempered } => {
            path = filtered_means(model, &mut local, recorded, path, tempered)?;
        }
        Start::Undisturbed => {
            let still = Policy {
                moves: vec![0.0; path.noise.len()],
                feedback: vec![0.0; path.noise.len() * path.width],
                factors: Vec::new(),
            };
            path = roll(model, noise_space, recorded, &path, &still)?.path;
        }
    }
    let mut linearised = LinearisedPath::default();
    let (mut objective, mut has_converged) = (f64::NEG_INFINITY, false);
    for _ in 0..MOST_ITERATIONS {
        linearised.along(&mut local, recorded, &path)?;
        let (_, policy) = linearised.potentials(&path)?;
        let Rollout { path: moved, objective: found } = roll(model, noise_space, recorded, &path, &policy)?;
        if found == f64::NEG_INFINITY {
            break;
        }
        let changes = moved.noise.iter().zip(&path.noise).map(|(now, before)| (now - before).abs());
        has_converged = changes.fold(0.0, f64::max) < TOLERANCE;
        let is_stuck = found <= objective && !has_converged;
        (path, objective) = (moved, found);
        if has_converged || is_stuck {
            break;
        }
    }
    linearised.along(&mut local, recorded, &path)?;
    let (potentials, policy) = linearised.potentials(&path)?;
    Ok(Smoothed { path, potentials, policy, linearised, objective, has_converged })
}
