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
use super::runs::{Run, draws_of_all};
use super::start::filtered_means;

/// Iterations of one start at the most.
const MOST_ITERATIONS: usize = 12;

/// The root mean square of a move of noise, whose standard deviation is 1, at which a path has converged: potentials are quadratics about it, which are as good from a little further away.
const TOLERANCE: f64 = 0.1;

/// How often sites are averaged again over the smoothed states of the last path, which these averages then move a little.
const AVERAGED: usize = 2;

/// The share of what measurements say by which a second start goes.
const TEMPERED: f64 = 0.1;

/// A path and all that looking ahead needs of it.
pub(super) struct Smoothed {
    pub(super) path: Path,
    pub(super) potentials: Vec<Potential>,
    pub(super) linearised: LinearisedPath,
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

/// The smoothed path of a sequence with these runs: from an extended Kalman filter, and from elsewhere if that does not converge.
///
/// # Errors
/// [`LookAheadError`] if no start leads to finite potentials.
pub(super) fn smooth<M: StateSpaceModel + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
    runs: &[Run],
) -> Result<Smoothed, LookAheadError> {
    let starts =
        [Start::Filtered { tempered: 1.0 }, Start::Filtered { tempered: TEMPERED }, Start::Undisturbed];
    let mut best: Option<Smoothed> = None;
    let mut failure = LookAheadError::Empty;
    for start in starts {
        match from_start(model, recorded, runs, start) {
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
    best.ok_or(failure)
}

/// Iterations from one start.
fn from_start<M: StateSpaceModel + ?Sized>(
    model: &M,
    recorded: &[RecordedStep],
    runs: &[Run],
    start: Start,
) -> Result<Smoothed, LookAheadError> {
    let noise_space = model.noise_space().ok_or(LookAheadError::NoNoise)?;
    let mut smoother = Smoother { recorded, runs, local: local(model)?, averages: Averages::default() };
    let mut path = Path::without_noise(model.state_dim(), draws_of_all(runs).map(<[_]>::len));
    match start {
        Start::Filtered { tempered } => {
            path = filtered_means(model, &mut smoother.local, recorded, path, tempered)?;
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
    let (mut linearised, mut last) = (LinearisedPath::default(), None);
    let (mut objective, mut has_converged) = (f64::NEG_INFINITY, false);
    for _ in 0..MOST_ITERATIONS {
        let (_, mut policy) = smoother.linearise(&path, last.as_ref(), &mut linearised)?;
        let moved = roll(model, noise_space, recorded, &path, &policy)?;
        if moved.objective == f64::NEG_INFINITY {
            break;
        }
        has_converged = moved.change < TOLERANCE;
        let is_stuck = moved.objective <= objective && !has_converged;
        Rollout { path, objective, .. } = moved;
        // The path has been moved.
        policy.moves.fill(0.0);
        last = Some(policy);
        if has_converged || is_stuck {
            break;
        }
    }
    let (mut potentials, mut policy) = smoother.linearise(&path, last.as_ref(), &mut linearised)?;
    for _ in 0..AVERAGED {
        if !smoother.average(&path, &policy, &mut linearised) {
            break;
        }
        // Where averages are too large, what there was stays.
        let Ok(averaged) = linearised.potentials(&path) else { break };
        (potentials, policy) = averaged;
    }
    if !has_converged && smoother.take_back(&path, &policy, &mut linearised)? {
        (potentials, _) = linearised.potentials(&path)?;
    }
    Ok(Smoothed { path, potentials, linearised, objective, has_converged })
}

/// What a model and the measurements say about paths.
struct Smoother<'a> {
    recorded: &'a [RecordedStep],
    runs: &'a [Run],
    local: Local<'a>,
    averages: Averages,
}

impl Smoother<'_> {
    /// The potentials of a path and its next move, with the model linearised along it and sites averaged over the Gaussians of a policy, if there is one.
    fn linearise(
        &mut self,
        path: &Path,
        gaussians: Option<&Policy>,
        linearised: &mut LinearisedPath,
    ) -> Result<(Vec<Potential>, Policy), LookAheadError> {
        linearised.along(&mut self.local, self.recorded, self.runs, path)?;
        if gaussians.is_some_and(|policy| self.average(path, policy, linearised)) {
            let averaged = linearised.potentials(path);
            if averaged.is_ok() {
                return averaged;
            }
            // Where averages are too large, sites are those of the path.
            linearised.along(&mut self.local, self.recorded, self.runs, path)?;
        }
        linearised.potentials(path)
    }

    /// Where a policy leads far from the path, makes sites those of the path again: averages over states there can be wrong by thousands of nats. Whether there are such steps.
    fn take_back(
        &mut self,
        path: &Path,
        policy: &Policy,
        linearised: &mut LinearisedPath,
    ) -> Result<bool, LookAheadError> {
        let far = self.averages.far_steps(path, policy, linearised);
        if far.is_empty() {
            return Ok(false);
        }
        let mut averaged = std::mem::take(&mut linearised.sites);
        linearised.along(&mut self.local, self.recorded, self.runs, path)?;
        for index in far {
            std::mem::swap(&mut averaged[index], &mut linearised.sites[index]);
        }
        linearised.sites = averaged;
        Ok(true)
    }

    /// Averages the sites over the Gaussians of a policy; whether that changes one.
    fn average(&mut self, path: &Path, policy: &Policy, linearised: &mut LinearisedPath) -> bool {
        self.averages.find(&mut self.local, self.recorded, self.runs, (path, policy), linearised)
    }
}
