//! What measurements say on average over the smoothed states, in place of what they say at the most likely ones.

use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper, times_upper};

use super::backward::LinearisedPath;
use super::dense::{add_product_of_transposed, add_times, product};
use super::local::{Local, LocalSite};
use super::path::{Path, Policy};
use super::recorded::RecordedStep;

/// How many standard deviations points lie from the mean: with weights of 1/6 there, sums of polynomials of the fifth degree along the axes have their mean.
const AWAY: f64 = 1.732_050_807_568_877_2;

/// A share of the trace by which a matrix may fail to be positive semidefinite by rounding.
const ROUNDING: f64 = 1e-10;

/// The Gaussian of a smoothed state, and memory for the averages over it.
///
/// Of all quadratics the one with the slope `E[∂ log p(y | x)/∂x]` at `m` and the curvature `−E[∂² log p(y | x)/∂x²]` is nearest to `log p(y | x)` in mean square under `x ~ N(m, P)`, so that
/// it leaves the least variance to weights (García-Fernández, Svensson and Särkkä, Iterated posterior linearization smoother, IEEE Transactions on Automatic Control 62, 2017).
#[derive(Debug, Default)]
pub(super) struct Averages {
    /// `m − x̂`, `N`.
    deviation: Vec<f64>,
    /// `P`, `N×N`.
    covariance: Vec<f64>,
    /// `P = L Lᵀ`.
    lower: Vec<f64>,
    /// The transposed of `F − G C`, `N×N`.
    turned: Vec<f64>,
    /// `(2N+1)×N`.
    points: Vec<f64>,
    /// The scores at the points.
    scores: Vec<f64>,
    spare: [Vec<f64>; 2],
}

fn zeros(memory: &mut Vec<f64>, count: usize) -> &mut [f64] {
    memory.clear();
    memory.resize(count, 0.0);
    memory
}

impl Averages {
    /// Replaces the sites of a path by their averages over smoothed states: those that noise moved by this policy makes.
    pub(super) fn find(
        &mut self,
        local: &mut Local<'_>,
        recorded: &[RecordedStep],
        path: &Path,
        policy: &Policy,
        linearised: &mut LinearisedPath,
    ) {
        let n = path.width;
        zeros(&mut self.deviation, n);
        zeros(&mut self.covariance, n * n);
        for (index, RecordedStep { step, measurement }) in recorded.iter().enumerate() {
            self.advance(index, path, policy, linearised);
            if measurement.iter().all(Option::is_none) || !self.place(path.state(index)) {
                continue;
            }
            zeros(&mut self.scores, self.points.len());
            local.scores(&step.step(), &self.points, measurement, &mut self.scores);
            self.average(&mut linearised.sites[index]);
        }
    }

    /// To the smoothed state of a step from that of the step before.
    fn advance(&mut self, index: usize, path: &Path, policy: &Policy, linearised: &LinearisedPath) {
        let n = path.width;
        let (map, begin, q) = (&linearised.maps[index], path.starts[index], path.noise(index).len());
        let Averages { deviation, covariance, turned, spare: [first, second], .. } = self;
        // v − v̂ = w − C δ.
        let moved = zeros(first, q);
        moved.copy_from_slice(&policy.moves[begin..begin + q]);
        let feedback = &policy.feedback[begin * n..(begin + q) * n];
        let next = zeros(second, n);
        if index > 0 {
            for (moved, row) in moved.iter_mut().zip(feedback.chunks_exact(n)) {
                *moved -= row.iter().zip(&*deviation).map(|(gain, d)| gain * d).sum::<f64>();
            }
            add_times(&map.along_previous, deviation, next);
        }
        add_times(&map.along_noise, moved, next);
        for ((next, value), state) in next.iter_mut().zip(&map.value).zip(path.state(index)) {
            *next += value - state;
        }
        std::mem::swap(deviation, second);
        // P = (F − G C) P (F − G C)ᵀ + G Λ⁻¹ Gᵀ.
        let half = zeros(first, (n * n).max(q * n));
        let sum = zeros(second, n * n);
        if index > 0 {
            let turned = zeros(turned, n * n);
            product(&map.along_noise, feedback, [n, q, n], half);
            for (place, entry) in turned.iter_mut().enumerate() {
                let along = place % n * n + place / n;
                *entry = map.along_previous[along] - half[along];
            }
            product(covariance, turned, [n, n, n], half);
            add_product_of_transposed(turned, half, [n, n, n], sum);
        }
        let lower = &policy.factors[index * path.factor_place()..][..at(q, 0)];
        let mut row = vec![0.0; q];
        for i in 0..n {
            row.copy_from_slice(&map.along_noise[i * q..][..q]);
            solve_lower(q, lower, &mut row);
            row.iter().enumerate().for_each(|(k, entry)| half[k * n + i] = *entry);
        }
        add_product_of_transposed(half, half, [n, q, n], sum);
        std::mem::swap(covariance, second);
    }

    /// Puts points around the mean; whether there is a density of such states.
    fn place(&mut self, state: &[f64]) -> bool {
        let n = state.len();
        let Averages { deviation, covariance, lower, points, .. } = self;
        lower.clear();
        lower.extend((0..n).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| covariance[i * n + j]));
        factor(n, lower);
        let is_regular = |i: usize| lower[at(i, i)].powi(2) > ROUNDING * covariance[i * n + i];
        if !(0..n).all(is_regular) {
            return false;
        }
        points.clear();
        points.extend(state.iter().zip(deviation).map(|(x, d)| x + *d));
        for i in 0..n {
            for side in [AWAY, -AWAY] {
                let of_column = |row: usize| if row < i { 0.0 } else { side * lower[at(row, i)] };
                points.extend_from_within(..n);
                let begin = points.len() - n;
                points[begin..].iter_mut().enumerate().for_each(|(row, x)| *x += of_column(row));
            }
        }
        true
    }

    /// The averages of the scores and of what they change by, where the second is positive semidefinite.
    fn average(&mut self, site: &mut LocalSite) {
        let Averages { deviation, lower, scores, spare: [slope, curvature], .. } = self;
        let n = deviation.len();
        if !scores.iter().all(|score| score.is_finite()) {
            return;
        }
        let (middle, around) = scores.split_at_mut(n);
        let (slope, curvature) = (zeros(slope, n), zeros(curvature, n * n));
        slope.copy_from_slice(middle);
        for (i, pair) in around.chunks_exact_mut(2 * n).enumerate() {
            let (above, below) = pair.split_at_mut(n);
            for (row, slope) in slope.iter_mut().enumerate() {
                *slope += (above[row] + below[row] - 2.0 * middle[row]) / 6.0;
                above[row] = (below[row] - above[row]) / (2.0 * AWAY);
            }
            // Column i in units of L.
            times_upper(n, lower, above);
            above.iter().enumerate().for_each(|(row, entry)| {
                curvature[row * n + i] += 0.5 * entry;
                curvature[i * n + row] += 0.5 * entry;
            });
        }
        let trace: f64 = (0..n).map(|i| curvature[i * n + i].abs()).sum();
        let mut check: Vec<f64> = Vec::with_capacity(at(n, 0));
        for i in 0..n {
            for j in 0..=i {
                let rounding = if i == j { ROUNDING * trace + f64::MIN_POSITIVE } else { 0.0 };
                check.push(curvature[i * n + j] + rounding);
            }
        }
        factor(n, &mut check);
        if check.iter().any(|entry| entry.is_nan()) {
            return;
        }
        // L⁻ᵀ A L⁻¹, by rows and then, as it is symmetric, by columns.
        for row in curvature.chunks_exact_mut(n) {
            solve_upper(n, lower, row);
        }
        let mut column = vec![0.0; n];
        for j in 0..n {
            column.iter_mut().enumerate().for_each(|(i, entry)| *entry = curvature[i * n + j]);
            solve_upper(n, lower, &mut column);
            column.iter().enumerate().for_each(|(i, entry)| curvature[i * n + j] = *entry);
        }
        // The score at x̂ of a quadratic about m.
        add_times(curvature, deviation, slope);
        site.slope.copy_from_slice(slope);
        site.curvature.copy_from_slice(curvature);
    }
}
