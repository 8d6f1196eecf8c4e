//! From the last step to the first: potentials of a path, and how it is to be moved.

use motes_models::StateSpaceModel;
use motes_models::batch::LANES;

use super::dense::{product, product_of_transposed, subtract_times};
use super::error::LookAheadError;
use super::local::{Local, LocalMap, LocalSite, LocalTiles};
use super::path::{Path, Policy};
use super::potential::{Guidance, Numbers, Potential};
use super::recorded::RecordedStep;
use super::runs::Run;

/// A quadratic of a state in the place of the log-density of a measurement.
#[derive(Debug, Clone, Default)]
pub(super) struct Site {
    /// Its score at the state of the path, `N`.
    pub(super) slope: Vec<f64>,
    /// Minus its second derivatives, `N×N`, positive semidefinite.
    pub(super) curvature: Vec<f64>,
    /// The variance of the logarithm of weights that no quadratic accounts for, by third derivatives of the log-density along the axes of the smoothed Gaussian; 0 where it is not known.
    pub(super) skewness: f64,
}

impl Site {
    /// That of the score and the Fisher information at the state.
    fn at(&mut self, LocalSite { slope, roots }: &LocalSite) {
        let n = slope.len();
        self.skewness = 0.0;
        self.slope.clone_from(slope);
        self.curvature.resize(n * n, 0.0);
        product_of_transposed(roots, roots, [n, roots.len() / n, n], &mut self.curvature);
    }
}

/// A path with its model linearised along it.
#[derive(Debug, Clone, Default)]
pub(super) struct LinearisedPath {
    /// Of each step.
    pub(super) maps: Vec<LocalMap>,
    pub(super) sites: Vec<Site>,
}

impl LinearisedPath {
    /// Linearises a model along a path, of which these are the runs of alike steps.
    ///
    /// # Errors
    /// [`LookAheadError::NotFinite`] with the step where that cannot be done.
    pub(super) fn along(
        &mut self,
        local: &mut Local<'_>,
        recorded: &[RecordedStep],
        runs: &[Run],
        path: &Path,
    ) -> Result<(), LookAheadError> {
        let n = path.width;
        self.maps.resize_with(path.len(), LocalMap::default);
        self.sites.resize_with(path.len(), Site::default);
        let mut sites: [LocalSite; LANES] = Default::default();
        for Run { steps: run, .. } in runs {
            let step = recorded[run.start].step.step();
            let previous = (run.start > 0).then(|| &path.states[(run.start - 1) * n..(run.end - 1) * n]);
            let noise = &path.noise[path.starts[run.start]..path.starts[run.end]];
            if let Some(at) = local.maps(&step, previous, noise, &mut self.maps[run.clone()]) {
                return Err(LookAheadError::NotFinite { index: run.start + at });
            }
            let states = &path.states[run.start * n..run.end * n];
            let measurement = |row: usize| recorded[run.start + row].measurement.as_slice();
            let found = &mut sites[..run.len()];
            local.sites(&step, states, measurement, found);
            self.sites[run.clone()].iter_mut().zip(found).for_each(|(site, found)| site.at(found));
        }
        Ok(())
    }

    /// The potentials of a path, the first first, and how the path is to be moved.
    ///
    /// # Errors
    /// [`LookAheadError::NotFinite`] where numbers are too large.
    pub(super) fn potentials(&self, path: &Path) -> Result<(Vec<Potential>, Policy), LookAheadError> {
        let (n, steps) = (path.width, path.len());
        let mut potentials: Vec<Potential> = Vec::with_capacity(steps);
        let place = path.factor_place();
        let mut policy = Policy {
            moves: vec![0.0; path.noise.len()],
            feedback: vec![0.0; path.noise.len() * n],
            factors: vec![0.0; place * steps],
        };
        let (mut guidance, mut at_zero) = (Guidance::default(), vec![0.0; n]);
        for index in (0..steps).rev() {
            let Site { slope, curvature, .. } = &self.sites[index];
            let mut potential = Potential {
                reference: Numbers::from_slice(path.state(index)),
                curvature: Numbers::from_slice(curvature),
                slope: Numbers::from_slice(slope),
            };
            if let Some(next) = self.maps.get(index + 1) {
                // Of the step after this one, from the turn before.
                guidance.add_through(&next.along_previous, &at_zero, &mut potential);
            }
            if !potential.is_finite() {
                return Err(LookAheadError::NotFinite { index });
            }
            let (map, noise) = (&self.maps[index], path.noise(index));
            let q = noise.len();
            for ((at_zero, value), reference) in at_zero.iter_mut().zip(&map.value).zip(&potential.reference)
            {
                *at_zero = value - reference;
            }
            subtract_times(&map.along_noise, noise, &mut at_zero);
            guidance.find(&potential, &map.along_noise);
            policy.factors[index * place..][..guidance.lower.len()].copy_from_slice(&guidance.lower);
            // w = κ − K d₀ − v̂, and C = K F.
            let begin = path.starts[index];
            let moves = &mut policy.moves[begin..begin + q];
            subtract_times(&guidance.gain, &at_zero, moves);
            for ((moved, offset), noise) in moves.iter_mut().zip(&guidance.offset).zip(noise) {
                *moved += offset - noise;
            }
            if index > 0 {
                let feedback = &mut policy.feedback[begin * n..(begin + q) * n];
                product(&guidance.gain, &map.along_previous, [q, n, n], feedback);
            }
            potentials.push(potential);
        }
        potentials.reverse();
        Ok((potentials, policy))
    }
}

/// What a model says of itself as a map of noise.
///
/// # Errors
/// [`LookAheadError::NoNoise`].
pub(super) fn local<M: StateSpaceModel + ?Sized>(model: &M) -> Result<Local<'_>, LookAheadError> {
    let noise = model.noise_space().ok_or(LookAheadError::NoNoise)?;
    Ok(Local::new(noise, model.state_dim(), LocalTiles::default()))
}
