//! The way uphill on quadratics that are like estimates nearby.

use faer::Mat;
use faer::linalg::solvers::Solve;
use motes_models::{Seed, fill_standard_normal};

use super::quadratic::{Quadratic, coefficients};
use crate::likelihood::{Estimator, Likelihood};
use crate::parallel::map_on_threads;

/// Points of a round, for each coefficient of a quadratic, and at least.
const POINTS: (usize, usize) = (4, 40);

/// How far a round goes, in units of the spread.
const RADIUS: f64 = 1.5;

/// Points farther than this from the centre, in units of the spread, say nothing of what is near.
const NEAR: f64 = 2.5;

/// Estimates so far below the highest near the centre, in nats, and more for each coordinate, say nothing of the shape near the top: a few would tilt the whole quadratic.
const LOW: (f64, f64) = (8.0, 3.0);

/// A direction is no longer than the prior's standard deviation: where the data say nothing, a way without end would follow the noise.
const WIDEST: f64 = 1.0;

/// Curvatures are taken to be at least this, in units of the spread: along a flat direction a step is not long.
const FLAT: f64 = 0.05;

/// A way uphill: a centre, and the spread in whose units a quadratic is fitted.
pub(super) struct Hill {
    pub(super) centre: Vec<f64>,
    /// `L` (`D×D`), row after row.
    pub(super) spread: Vec<f64>,
    /// All points that were asked, with the estimates there.
    asked: Vec<(Vec<f64>, f64)>,
}

impl Hill {
    pub(super) fn new(centre: Vec<f64>, spread: Vec<f64>) -> Self {
        Hill { centre, spread, asked: Vec::new() }
    }

    /// `centre + L u`.
    fn place(&self, u: &[f64]) -> Vec<f64> {
        let d = self.centre.len();
        let row = |i: usize| (0..d).map(|j| self.spread[i * d + j] * u[j]).sum::<f64>();
        (0..d).map(|i| self.centre[i] + row(i)).collect()
    }

    /// Asks for estimates around the centre, fits a quadratic to all that are near, and goes where it is largest.
    pub(super) fn climb<L: Likelihood>(
        &mut self,
        likelihood: &L,
        estimator: Estimator,
        seed: &Seed,
    ) -> Result<(), L::Error> {
        let d = self.centre.len();
        let count = (POINTS.0 * coefficients(d)).max(POINTS.1);
        let mut noise = vec![0.0; count * d];
        fill_standard_normal(&mut seed.child("points").stream(), &mut noise);
        let points: Vec<Vec<f64>> = noise.chunks(d).map(|u| self.place(u)).collect();
        let found = map_on_threads(&points, |number, v| {
            likelihood.log_likelihood(v, estimator, &seed.nth(number as u64))
        });
        let found = found.into_iter().collect::<Result<Vec<f64>, L::Error>>()?;
        self.asked.extend(points.into_iter().zip(found));
        if let Some(inverse) = inverse(&self.spread, d) {
            self.step(&inverse);
        }
        Ok(())
    }

    fn step(&mut self, inverse: &Mat<f64>) {
        let d = self.centre.len();
        let near = self.asked.iter().filter(|(_, value)| value.is_finite()).filter_map(|(v, value)| {
            let row = |i: usize| (0..d).map(|j| inverse[(i, j)] * (v[j] - self.centre[j])).sum::<f64>();
            let u: Vec<f64> = (0..d).map(row).collect();
            let distance = u.iter().map(|value| value * value).sum::<f64>() / d as f64;
            (distance < NEAR * NEAR).then(|| (u, *value, (-0.5 * distance).exp()))
        });
        let mut near: Vec<(Vec<f64>, f64, f64)> = near.collect();
        let top = near.iter().map(|(_, value, _)| *value).fold(f64::NEG_INFINITY, f64::max);
        near.retain(|(_, value, _)| top - value <= LOW.0 + LOW.1 * d as f64);
        let Some(quadratic) = Quadratic::fit(&near) else { return };
        let Some((step, values, vectors)) = quadratic.ascend(RADIUS, FLAT) else { return };
        self.centre = self.place(&step);
        // New units: curvature 1 in each direction, as far as one round can tell.
        let factor = |k: usize| (1.0 / values[k].sqrt()).clamp(0.4, 2.5);
        let old = self.spread.clone();
        let entry =
            |i: usize, k: usize| (0..d).map(|j| old[i * d + j] * vectors[(j, k)]).sum::<f64>() * factor(k);
        let mut columns: Vec<Vec<f64>> = (0..d).map(|k| (0..d).map(|i| entry(i, k)).collect()).collect();
        for column in &mut columns {
            let length = column.iter().map(|value| value * value).sum::<f64>().sqrt();
            column.iter_mut().for_each(|value| *value *= (WIDEST / length).min(1.0));
        }
        self.spread = (0..d * d).map(|at| columns[at % d][at / d]).collect();
    }
}

/// The inverse of a matrix (`D×D`, row after row); none where it has none.
fn inverse(matrix: &[f64], d: usize) -> Option<Mat<f64>> {
    let matrix = Mat::from_fn(d, d, |i, j| matrix[i * d + j]);
    let inverse = matrix.partial_piv_lu().solve(&Mat::<f64>::identity(d, d));
    let is_finite = (0..d).all(|i| (0..d).all(|j| inverse[(i, j)].is_finite()));
    is_finite.then_some(inverse)
}
