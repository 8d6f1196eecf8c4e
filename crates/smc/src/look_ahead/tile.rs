//! What potentials say of the noise of the particles of a tile.

use motes_models::Step;
use motes_models::batch::{LANES, by_widest_vectors};
use motes_models::equations::triangle::{at, factor_from_last, solve_lower, solve_upper};
use motes_models::equations::{Lanes, Linearise, NoiseSpace, Scalar};

use super::ahead::StepAhead;
use super::component::Component;
use super::potential::Potential;
use super::scratch::TileGuide;
use crate::proposals::{NEGLIGIBLE, lanes};

/// The least logarithm of an expectation: one that is 0 for a particle far away would be divided by.
pub(super) const LEAST: f64 = -1e250;

impl TileGuide {
    /// Finds the Gaussians of the noise of each particle, `N(v; m_j, Λ_j⁻¹)`, and the logarithm of `Z̃(x') = Σ_j w_j Z̃_j(x')`.
    pub(super) fn find<M: Linearise + ?Sized>(
        &mut self,
        model: &M,
        noise_space: &dyn NoiseSpace,
        ahead: &StepAhead,
        step: &Step<'_>,
        previous: Option<&[f64]>,
    ) -> Lanes {
        let (n, q, count) = (model.state_dim(), ahead.draws(), ahead.components.len());
        self.centres.resize(n * LANES, 0.0);
        self.mean.resize(count * q * LANES, 0.0);
        self.lower.resize(count * q * (q + 1) / 2 * LANES, 0.0);
        self.shares.resize(count * LANES, 0.0);
        match &ahead.variances {
            Some(variances) => {
                self.jacobian.resize(n * LANES, 0.0);
                self.spare.resize(2 * n * LANES, 0.0);
                model.tile_moments(step, previous, &mut self.centres, &mut self.jacobian);
                by_widest_vectors(
                    #[inline(always)]
                    || self.of_normal_draws(&ahead.components, variances),
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
                    || self.of_map(&ahead.components, &ahead.noise),
                )
            }
        }
    }

    /// Where `x = c + S v`; what stands for `S²` becomes `S`.
    #[inline(always)]
    fn of_normal_draws(&mut self, components: &[Component], variances: &[f64]) -> Lanes {
        let sds = lanes(&mut self.jacobian);
        let mut is_known = true;
        for (sd, variance) in sds.iter_mut().zip(variances) {
            is_known &= sd.0.iter().all(|found| found == variance);
            *sd = sd.sqrt();
        }
        self.of_all(components, |guide, number, component| guide.of_diagonal(number, component, is_known))
    }

    /// Of one quadratic, where `x = c + S v`; `is_known` says whether the `L` of the step is that of these particles.
    #[inline(always)]
    fn of_diagonal(&mut self, number: usize, component: &Component, is_known: bool) -> Lanes {
        let TileGuide { centres, jacobian, spare, mean, lower, .. } = self;
        let Component { log_weight, potential, lower: known, log_determinant, .. } = component;
        let (centres, sds) = (lanes(centres), lanes(jacobian));
        let n = centres.len();
        let (d, pull) = lanes(spare).split_at_mut(n);
        let mean = &mut lanes(mean)[number * n..][..n];
        let lower = &mut lanes(lower)[number * at(n, 0)..][..at(n, 0)];
        for ((d, centre), reference) in d.iter_mut().zip(&*centres).zip(&potential.reference) {
            *d = *centre - *reference;
        }
        let log = pull_of(potential, d, pull);
        for ((mean, sd), pull) in mean.iter_mut().zip(&*sds).zip(&*pull) {
            *mean = *sd * *pull;
        }
        if is_known {
            for (entry, known) in lower.iter_mut().zip(known) {
                *entry = Lanes::from(*known);
            }
            log + completed(mean, lower) + (*log_weight - *log_determinant)
        } else {
            for i in 0..n {
                for j in 0..=i {
                    let scaled = sds[i] * potential.curvature[i * n + j] * sds[j];
                    lower[at(i, j)] = if i == j { scaled + 1.0 } else { scaled };
                }
            }
            factor_from_last(n, lower);
            log + completed(mean, lower) - log_diagonal(n, lower) + *log_weight
        }
    }

    /// Where `x = c + J (v − v̂)`; `c` becomes what the line is at `v = 0`.
    #[inline(always)]
    fn of_map(&mut self, components: &[Component], noise: &[f64]) -> Lanes {
        let (centres, jacobian) = (lanes(&mut self.centres), lanes(&mut self.jacobian));
        // A derivative that is no number says nothing.
        for entry in jacobian.iter_mut() {
            for value in &mut entry.0 {
                *value = if value.is_finite() { *value } else { 0.0 };
            }
        }
        let q = noise.len();
        for (i, centre) in centres.iter_mut().enumerate() {
            for (entry, v) in jacobian[i * q..][..q].iter().zip(noise) {
                *centre = *centre - *entry * *v;
            }
        }
        self.of_all(components, |guide, number, component| guide.of_line(number, component, q))
    }

    /// Of one quadratic, where `x = c + J v` with `q` numbers of noise.
    #[inline(always)]
    fn of_line(&mut self, number: usize, component: &Component, q: usize) -> Lanes {
        let TileGuide { centres, jacobian, spare, mean, lower, .. } = self;
        let Component { log_weight, potential, .. } = component;
        let (centres, jacobian) = (lanes(centres), lanes(jacobian));
        let n = centres.len();
        let (d, rest) = lanes(spare).split_at_mut(n);
        let (pull, curved) = rest.split_at_mut(n);
        let mean = &mut lanes(mean)[number * q..][..q];
        let lower = &mut lanes(lower)[number * at(q, 0)..][..at(q, 0)];
        for ((d, centre), reference) in d.iter_mut().zip(&*centres).zip(&potential.reference) {
            *d = *centre - *reference;
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
        log + completed(mean, lower) - log_diagonal(q, lower) + *log_weight
    }

    /// `log Z̃` of all quadratics, each by `of_one`, and their shares of it.
    #[inline(always)]
    fn of_all(
        &mut self,
        components: &[Component],
        of_one: impl Fn(&mut Self, usize, &Component) -> Lanes,
    ) -> Lanes {
        if let [one] = components {
            return of_one(self, 0, one).max(Lanes::from(LEAST));
        }
        for (number, component) in components.iter().enumerate() {
            let log = match component.is_flat() {
                true => self.of_flat(number, component),
                false => of_one(self, number, component),
            };
            lanes(&mut self.shares)[number] = log.max(Lanes::from(LEAST));
        }
        let (sum, total) = exponentials(lanes(&mut self.shares));
        for share in lanes(&mut self.shares) {
            *share = *share / total;
        }
        sum
    }

    /// Of a flat one, which says nothing of the noise.
    #[inline(always)]
    fn of_flat(&mut self, number: usize, component: &Component) -> Lanes {
        let count = self.shares.len() / LANES;
        let (mean, lower) = (lanes(&mut self.mean), lanes(&mut self.lower));
        let (q, entries) = (mean.len() / count, lower.len() / count);
        mean[number * q..][..q].fill(Lanes::from(0.0));
        let lower = &mut lower[number * entries..][..entries];
        lower.fill(Lanes::from(0.0));
        (0..q).for_each(|i| lower[at(i, i)] = Lanes::from(1.0));
        Lanes::from(component.log_weight)
    }
}

/// Replaces logarithms by numbers that are as large as each other, with `log Σ` of what the logarithms stand for and the sum of the numbers.
#[inline(always)]
pub(super) fn exponentials(logs: &mut [Lanes]) -> (Lanes, Lanes) {
    let most = logs.iter().skip(1).fold(logs[0], |most, log| most.max(*log));
    let mut total = Lanes::from(0.0);
    for log in logs.iter_mut() {
        *log = (*log - most).max(Lanes::from(NEGLIGIBLE)).exp();
        total = total + *log;
    }
    (most + total.ln(), total)
}

/// `b − A d` into `pull`, and `log ψ` at `d`.
#[inline(always)]
pub(super) fn pull_of(potential: &Potential, d: &[Lanes], pull: &mut [Lanes]) -> Lanes {
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

/// `½ hᵀ Λ⁻¹ h` of the `h` in `mean`, which becomes `Λ⁻¹ h`.
#[inline(always)]
fn completed(mean: &mut [Lanes], lower: &[Lanes]) -> Lanes {
    let q = mean.len();
    let mut half = Lanes::from(0.0);
    solve_upper(q, lower, mean);
    for entry in mean.iter() {
        half = half + *entry * *entry * 0.5;
    }
    solve_lower(q, lower, mean);
    half
}

/// `½ log |Λ|` of `Λ = Lᵀ L`.
#[inline(always)]
fn log_diagonal(q: usize, lower: &[Lanes]) -> Lanes {
    (0..q).fold(Lanes::from(0.0), |log, i| log + lower[at(i, i)].ln())
}
