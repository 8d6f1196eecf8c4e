//! A quadratic log-function, and what a Gaussian becomes by it.

use motes_models::batch::{LANES, Rows, by_widest_vectors, with_scratch};
use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper};
use motes_models::equations::{Lanes, Linearise, Scalar};

use crate::proposals::lanes;
use motes_models::Step;

/// `log φ(x) = −½ (x − c)ᵀ A (x − c) + bᵀ (x − c)`, with a positive semidefinite `A`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Quadratic {
    /// `c`, `N`.
    pub(super) centre: Vec<f64>,
    /// The lower triangle of `A`, `N(N+1)/2`.
    pub(super) curvature: Vec<f64>,
    /// `b`, `N`.
    pub(super) slope: Vec<f64>,
}

impl Quadratic {
    /// `log ∫ N(x; m, P) φ(x) dx` for the particles of a tile. `mean` and `lower` get those of `N(x; m, P) φ(x)`, normalised: its precision is `L Lᵀ`.
    #[inline(always)]
    fn times_gaussian(&self, mean: &mut [Lanes], variances: &[Lanes], lower: &mut [Lanes]) -> Lanes {
        let n = mean.len();
        for (entry, curvature) in lower.iter_mut().zip(&self.curvature) {
            *entry = Lanes::from(*curvature);
        }
        let mut log = Lanes::from(0.0);
        for (i, mean) in mean.iter_mut().enumerate() {
            let precision = Lanes::from(1.0) / variances[i];
            let distance = *mean - self.centre[i];
            let pull = precision * distance;
            lower[at(i, i)] = lower[at(i, i)] + precision;
            log = log + (precision.ln() - distance * pull) * 0.5;
            *mean = pull + self.slope[i];
        }
        factor(n, lower);
        solve_lower(n, lower, mean);
        for (i, entry) in mean.iter().enumerate() {
            log = log + *entry * *entry * 0.5 - lower[at(i, i)].ln();
        }
        solve_upper(n, lower, mean);
        for (mean, centre) in mean.iter_mut().zip(&self.centre) {
            *mean = *mean + *centre;
        }
        log
    }

    /// [`Quadratic::times_gaussian`] for the transitions of the particles of a tile, or for `p(x_0)`; `variances` (`N × LANES`) is scratch.
    pub(super) fn times_transition<M: Linearise + ?Sized>(
        &self,
        model: &M,
        step: &Step<'_>,
        previous: Option<&[f64]>,
        mean: &mut [f64],
        lower: &mut [f64],
        variances: &mut [f64],
    ) -> Lanes {
        model.tile_moments(step, previous, mean, variances);
        let (mean, variances, lower) = (lanes(mean), lanes(variances), lanes(lower));
        by_widest_vectors(
            #[inline(always)]
            || self.times_gaussian(mean, variances, lower),
        )
    }

    /// `log ∫ p(x_t | x_{t−1}) φ(x_t) dx_t` for each of the rows `x_{t−1}` (`K×N`), into `out` (`K`), as if the transition were a Gaussian with its moments.
    pub(super) fn log_expectations<M: Linearise + ?Sized>(
        &self,
        model: &M,
        step: &Step<'_>,
        previous: Rows<'_>,
        out: &mut [f64],
    ) {
        let n = self.centre.len();
        with_scratch((3 * n + self.curvature.len()) * LANES, |scratch| {
            // Lanes without a particle are computed, too: with numbers that are no danger.
            scratch.fill(0.0);
            let (tile, rest) = scratch.split_at_mut(n * LANES);
            let (mean, rest) = rest.split_at_mut(n * LANES);
            let (variances, lower) = rest.split_at_mut(n * LANES);
            for (number, out) in out.chunks_mut(LANES).enumerate() {
                previous.load(number * LANES, tile);
                let log = self.times_transition(model, step, Some(tile), mean, lower, variances);
                out.copy_from_slice(&log.0[..out.len()]);
            }
        });
    }
}
