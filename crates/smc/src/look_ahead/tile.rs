//! What potentials say of the noise of the particles of a tile.

use motes_models::Step;
use motes_models::batch::{LANES, by_widest_vectors};
use motes_models::equations::triangle::{at, factor_from_last, solve_lower, solve_upper};
use motes_models::equations::{Lanes, Linearise, NoiseSpace, Scalar};

use super::ahead::{Diagonal, StepAhead};
use super::potential::Potential;
use super::scratch::TileGuide;
use crate::proposals::lanes;

/// The least logarithm of an expectation: one that is 0 for a particle far away would be divided by.
const LEAST: f64 = -1e250;

impl TileGuide {
    /// Finds the Gaussian of the noise of each particle, `N(v; m, Λ⁻¹)`, and the logarithm of `Z̃(x')`.
    pub(super) fn find<M: Linearise + ?Sized>(
        &mut self,
        model: &M,
        noise_space: &dyn NoiseSpace,
        ahead: &StepAhead,
        step: &Step<'_>,
        previous: Option<&[f64]>,
    ) -> Lanes {
        let (n, q) = (model.state_dim(), ahead.draws());
        self.centres.resize(n * LANES, 0.0);
        self.mean.resize(q * LANES, 0.0);
        self.lower.resize(q * (q + 1) / 2 * LANES, 0.0);
        let log = match &ahead.diagonal {
            Some(diagonal) => {
                self.jacobian.resize(n * LANES, 0.0);
                self.spare.resize(2 * n * LANES, 0.0);
                model.tile_moments(step, previous, &mut self.centres, &mut self.jacobian);
                by_widest_vectors(
                    #[inline(always)]
                    || self.of_diagonal(&ahead.potential, diagonal),
                )
            }
            None => {
                self.jacobian.resize(n * q * LANES, 0.0);
                self.spare.resize((2 * n + n * q) * LANES, 0.0);
                self.points.clear();
                self.points.extend(ahead.noise.iter().flat_map(|v| [*v; LANES]));
                let (states, jacobian) = (&mut self.centres, &mut self.jacobian);
                noise_space.tile_linearised(step, previous, &self.points, LANES, states, jacobian);
                by_widest_vectors(
                    #[inline(always)]
                    || self.of_map(ahead),
                )
            }
        };
        log.max(Lanes::from(LEAST))
    }

    /// Where `x = c + S v`; what stands for `S²` becomes `S`.
    #[inline(always)]
    fn of_diagonal(&mut self, potential: &Potential, diagonal: &Diagonal) -> Lanes {
        let TileGuide { centres, jacobian, spare, mean, lower, .. } = self;
        let (centres, sds) = (lanes(centres), lanes(jacobian));
        let n = centres.len();
        let (d, pull) = lanes(spare).split_at_mut(n);
        let (mean, lower) = (lanes(mean), lanes(lower));
        for ((d, centre), reference) in d.iter_mut().zip(&*centres).zip(&potential.reference) {
            *d = *centre - *reference;
        }
        let mut log = pull_of(potential, d, pull);
        let mut is_known = true;
        for (sd, variance) in sds.iter_mut().zip(&diagonal.variances) {
            is_known &= sd.0.iter().all(|found| found == variance);
            *sd = sd.sqrt();
        }
        for ((mean, sd), pull) in mean.iter_mut().zip(&*sds).zip(&*pull) {
            *mean = *sd * *pull;
        }
        if is_known {
            for (entry, known) in lower.iter_mut().zip(&diagonal.lower) {
                *entry = Lanes::from(*known);
            }
        } else {
            for i in 0..n {
                for j in 0..=i {
                    let scaled = sds[i] * potential.curvature[i * n + j] * sds[j];
                    lower[at(i, j)] = if i == j { scaled + 1.0 } else { scaled };
                }
            }
            factor_from_last(n, lower);
        }
        log = log + completed(mean, lower);
        log
    }

    /// Where `x = c + J (v − v̂)`.
    #[inline(always)]
    fn of_map(&mut self, ahead: &StepAhead) -> Lanes {
        let TileGuide { centres, jacobian, spare, mean, lower, .. } = self;
        let potential = &ahead.potential;
        let (centres, jacobian) = (lanes(centres), lanes(jacobian));
        let (n, q) = (centres.len(), ahead.draws());
        let (d, rest) = lanes(spare).split_at_mut(n);
        let (pull, curved) = rest.split_at_mut(n);
        let (mean, lower) = (lanes(mean), lanes(lower));
        // A derivative that is no number says nothing.
        for entry in jacobian.iter_mut() {
            for value in &mut entry.0 {
                *value = if value.is_finite() { *value } else { 0.0 };
            }
        }
        for (i, d) in d.iter_mut().enumerate() {
            *d = centres[i] - potential.reference[i];
            for (entry, v) in jacobian[i * q..][..q].iter().zip(&ahead.noise) {
                *d = *d - *entry * *v;
            }
        }
        let log = pull_of(potential, d, pull);
        // A J, of what is not 0.
        let curved = &mut curved[..n * q];
        curved.fill(Lanes::from(0.0));
        for i in 0..n {
            for l in 0..n {
                let curvature = potential.curvature[i * n + l];
                if curvature == 0.0 {
                    continue;
                }
                for k in 0..q {
                    curved[i * q + k] = curved[i * q + k] + jacobian[l * q + k] * curvature;
                }
            }
        }
        mean.fill(Lanes::from(0.0));
        lower.fill(Lanes::from(0.0));
        for i in 0..n {
            for k in 0..q {
                let entry = jacobian[i * q + k];
                if entry.0.iter().all(|entry| *entry == 0.0) {
                    continue;
                }
                mean[k] = mean[k] + entry * pull[i];
                for j in 0..=k {
                    lower[at(k, j)] = lower[at(k, j)] + entry * curved[i * q + j];
                }
            }
        }
        for k in 0..q {
            lower[at(k, k)] = lower[at(k, k)] + 1.0;
        }
        factor_from_last(q, lower);
        log + completed(mean, lower)
    }
}

/// `b − A d` into `pull`, and `log ψ` at `d`.
#[inline(always)]
fn pull_of(potential: &Potential, d: &[Lanes], pull: &mut [Lanes]) -> Lanes {
    let n = d.len();
    let mut log = Lanes::from(0.0);
    for (i, pull) in pull.iter_mut().enumerate() {
        let mut curved = Lanes::from(0.0);
        for (entry, d) in potential.curvature[i * n..][..n].iter().zip(d) {
            if *entry != 0.0 {
                curved = curved + *d * *entry;
            }
        }
        let slope = potential.slope[i];
        log = log + d[i] * (curved * -0.5 + slope);
        *pull = -curved + slope;
    }
    log
}

/// `½ hᵀ Λ⁻¹ h − ½ log |Λ|` of the `h` in `mean`, which becomes `Λ⁻¹ h`.
#[inline(always)]
fn completed(mean: &mut [Lanes], lower: &[Lanes]) -> Lanes {
    let q = mean.len();
    let mut log = Lanes::from(0.0);
    solve_upper(q, lower, mean);
    for (i, entry) in mean.iter().enumerate() {
        log = log + *entry * *entry * 0.5 - lower[at(i, i)].ln();
    }
    solve_lower(q, lower, mean);
    log
}
