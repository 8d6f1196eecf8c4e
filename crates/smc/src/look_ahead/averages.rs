//! What measurements say on average over the smoothed states, in place of what they say at the most likely ones.

use motes_models::batch::LANES;
use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper, times_upper};
use smallvec::SmallVec;

use super::backward::{LinearisedPath, Site};
use super::dense::{add_product_of_transposed, add_times, dot, product};
use super::local::Local;
use super::path::{Path, Policy};
use super::potential::Numbers;
use super::recorded::RecordedStep;
use super::runs::Run;

/// How many standard deviations points lie from the mean: with weights of 1/6 there, sums of polynomials of the fifth degree along the axes have their mean.
const AWAY: f64 = 1.732_050_807_568_877_2;

/// How many standard deviations of its Gaussian a mean lies from the path where a model linearised along that says nothing of it.
const FAR: f64 = 3.0;

/// What rounding may do to numbers, as a share of their size.
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
    /// The transposed of `F − G C`, `N×N`.
    turned: Vec<f64>,
    /// Of each step of a run.
    clouds: [Cloud; LANES],
    /// The points of all clouds of a run, `(2N+1)×N` each.
    points: Vec<f64>,
    /// The scores at the points.
    scores: Vec<f64>,
    /// A triangle whose factor says whether a matrix is positive semidefinite.
    check: Vec<f64>,
    /// Whether all log-densities were seen to be quadratic, which are their own averages.
    is_quadratic: bool,
    spare: [Vec<f64>; 2],
}

/// Points around the mean of a smoothed state.
#[derive(Debug, Default)]
struct Cloud {
    /// Whether the mean has `dᵀ P⁻¹ d` from the path of more than [`FAR`]² for each coordinate.
    is_far: bool,
    /// Whether the state has a density, and its mean is not far; else there are no points.
    is_regular: bool,
    /// `m − x̂`, `N`.
    deviation: Vec<f64>,
    /// `P = L Lᵀ`.
    lower: Vec<f64>,
}

impl Cloud {
    /// Takes the Gaussian of a state, where `deviation` is from the path.
    fn centre(&mut self, deviation: &[f64], covariance: &[f64]) {
        let n = deviation.len();
        self.deviation.clear();
        self.deviation.extend_from_slice(deviation);
        self.lower.clear();
        self.lower.extend(lower_entries(n).map(|(i, j)| covariance[i * n + j]));
        factor(n, &mut self.lower);
        let has_density = |i: usize| self.lower[at(i, i)].powi(2) > ROUNDING * covariance[i * n + i];
        let mut scaled = Numbers::from_slice(deviation);
        solve_lower(n, &self.lower, &mut scaled);
        self.is_far = dot(&scaled, &scaled) > FAR * FAR * n as f64;
        self.is_regular = (0..n).all(has_density) && !self.is_far;
    }
}

fn zeros(memory: &mut Vec<f64>, count: usize) -> &mut [f64] {
    memory.clear();
    memory.resize(count, 0.0);
    memory
}

/// Where the entries of a lower triangle stand, row after row.
fn lower_entries(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// The largest size of some numbers; NaN or infinite where one is.
fn largest(numbers: &[f64]) -> f64 {
    numbers.iter().fold(
        0.0,
        |largest, number| if number.abs() > largest || number.is_nan() { number.abs() } else { largest },
    )
}

impl Averages {
    /// Replaces the sites of a path by their averages over smoothed states: those that noise moved by this policy makes. Whether one of them has changed.
    pub(super) fn find(
        &mut self,
        local: &mut Local<'_>,
        recorded: &[RecordedStep],
        runs: &[Run],
        (path, policy): (&Path, &Policy),
        linearised: &mut LinearisedPath,
    ) -> bool {
        if self.is_quadratic {
            return false;
        }
        let (n, mut has_changed, mut has_refused) = (path.width, false, false);
        zeros(&mut self.deviation, n);
        zeros(&mut self.covariance, n * n);
        for Run { steps: run, .. } in runs {
            self.clouds.iter_mut().for_each(|cloud| cloud.is_regular = false);
            self.points.clear();
            let is_measured = recorded[run.start].measurement.iter().any(Option::is_some);
            for (at, index) in run.clone().enumerate() {
                self.advance(index, path, policy, linearised);
                if is_measured {
                    self.place(at, path.state(index));
                }
            }
            has_refused |= is_measured && self.clouds[..run.len()].iter().any(|cloud| !cloud.is_regular);
            let placed: SmallVec<[usize; LANES]> =
                (0..run.len()).filter(|at| self.clouds[*at].is_regular).collect();
            zeros(&mut self.scores, self.points.len());
            let measurement =
                |row: usize| recorded[run.start + placed[row / (2 * n + 1)]].measurement.as_slice();
            local.scores(&recorded[run.start].step.step(), &self.points, measurement, &mut self.scores);
            for (number, at) in placed.into_iter().enumerate() {
                match self.average(number, at, &mut linearised.sites[run.start + at]) {
                    Some(is_new) => has_changed |= is_new,
                    None => has_refused = true,
                }
            }
        }
        self.is_quadratic = !has_changed && !has_refused;
        has_changed
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
                *moved -= dot(row, deviation);
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
        // By the rows of G L⁻ᵀ, where Λ = L Lᵀ.
        let factor = &policy.factors[index * (policy.factors.len() / path.len())..];
        let rows = &mut half[..n * q];
        rows.copy_from_slice(&map.along_noise);
        rows.chunks_exact_mut(q.max(1)).for_each(|row| solve_lower(q, factor, row));
        for i in 0..n {
            for j in 0..n {
                sum[i * n + j] += dot(&rows[i * q..][..q], &rows[j * q..][..q]);
            }
        }
        std::mem::swap(covariance, second);
    }

    /// The steps whose smoothed means, where noise is moved by this policy, are far from the path.
    pub(super) fn far_steps(
        &mut self,
        path: &Path,
        policy: &Policy,
        linearised: &LinearisedPath,
    ) -> Vec<usize> {
        let n = path.width;
        zeros(&mut self.deviation, n);
        zeros(&mut self.covariance, n * n);
        let mut cloud = Cloud::default();
        let is_far = |index: &usize| {
            self.advance(*index, path, policy, linearised);
            cloud.centre(&self.deviation, &self.covariance);
            cloud.is_far
        };
        (0..path.len()).filter(is_far).collect()
    }

    /// Puts points around the mean of a step of the run, if there is a density of such states.
    fn place(&mut self, at_step: usize, state: &[f64]) {
        let n = state.len();
        let Averages { deviation, covariance, clouds, points, .. } = self;
        let cloud = &mut clouds[at_step];
        cloud.centre(deviation, covariance);
        let Cloud { is_regular, lower, .. } = cloud;
        if !*is_regular {
            return;
        }
        let middle = points.len();
        points.extend(state.iter().zip(deviation).map(|(x, d)| x + *d));
        for i in 0..n {
            for side in [AWAY, -AWAY] {
                let of_column = |row: usize| if row < i { 0.0 } else { side * lower[at(row, i)] };
                points.extend_from_within(middle..middle + n);
                let begin = points.len() - n;
                points[begin..].iter_mut().enumerate().for_each(|(row, x)| *x += of_column(row));
            }
        }
    }

    /// The averages of the scores of a cloud, which is the one of this number that has any, and of what they change by, where the second is positive semidefinite; whether they differ from
    /// what the site had, and none where there are no such averages.
    fn average(&mut self, number: usize, at_step: usize, site: &mut Site) -> Option<bool> {
        let Averages { clouds, scores, check, spare: [slope, curvature], .. } = self;
        let Cloud { deviation, lower, .. } = &clouds[at_step];
        let n = deviation.len();
        let count = (2 * n + 1) * n;
        let scores = &mut scores[number * count..][..count];
        let size = largest(scores);
        if !size.is_finite() {
            return None;
        }
        let (middle, around) = scores.split_at_mut(n);
        let (slope, curvature) = (zeros(slope, n), zeros(curvature, n * n));
        slope.copy_from_slice(middle);
        let mut skewness = 0.0;
        for (i, pair) in around.chunks_exact_mut(2 * n).enumerate() {
            let (above, below) = pair.split_at_mut(n);
            let mut third_derivative = 0.0;
            for (row, slope) in slope.iter_mut().enumerate() {
                let bend = (above[row] + below[row] - 2.0 * middle[row]) / (AWAY * AWAY);
                *slope += 0.5 * bend;
                third_derivative += if row < i { 0.0 } else { lower[at(row, i)] * bend };
                above[row] = (below[row] - above[row]) / (2.0 * AWAY);
            }
            // The variance of the third Hermite polynomial is 6.
            skewness += third_derivative * third_derivative / 6.0;
            // Column i in units of L.
            times_upper(n, lower, above);
            for (row, entry) in above.iter().enumerate() {
                curvature[row * n + i] += 0.5 * entry;
                curvature[i * n + row] += 0.5 * entry;
            }
        }
        site.skewness = skewness;
        let trace: f64 = (0..n).map(|i| curvature[i * n + i].abs()).sum();
        check.clear();
        check.extend(lower_entries(n).map(|(i, j)| curvature[i * n + j]));
        (0..n).for_each(|i| check[at(i, i)] += ROUNDING * trace + f64::MIN_POSITIVE);
        factor(n, check);
        if check.iter().any(|entry| entry.is_nan()) {
            return None;
        }
        // L⁻ᵀ A L⁻¹ by rows, twice, as A is symmetric.
        for _ in 0..2 {
            curvature.chunks_exact_mut(n).for_each(|row| solve_upper(n, lower, row));
            for (i, j) in lower_entries(n) {
                curvature.swap(i * n + j, j * n + i);
            }
        }
        // The score at x̂ of a quadratic about m.
        add_times(curvature, deviation, slope);
        let is_same = |now: &[f64], before: &[f64], size: f64| {
            now.iter().zip(before).all(|(now, before)| (now - before).abs() <= ROUNDING * size)
        };
        // A quadratic is its own average, but for rounding.
        if is_same(slope, &site.slope, size) && is_same(curvature, &site.curvature, largest(curvature)) {
            return Some(false);
        }
        site.slope.copy_from_slice(slope);
        site.curvature.copy_from_slice(curvature);
        Some(true)
    }
}
