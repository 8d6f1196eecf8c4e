//! The log-evidence of a linear model and nothing else: what a fit asks for thousands of times.

use motes_models::kalman::{LinearMap, LinearSystem};
use motes_models::{LN_2PI, Step};
use motes_smc::RecordedStep;

/// States from which on blocked products of matrices are the faster ones.
const MOST_STATES: usize = 12;

/// A linear map with Gaussian noise, its matrices row after row.
struct FlatMap {
    /// `F` (`rows×N`).
    matrix: Vec<f64>,
    /// `b` (`rows`).
    offset: Vec<f64>,
    /// `Q` (`rows×rows`).
    covariance: Vec<f64>,
}

/// Entries row after row.
fn flat(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    (0..rows * columns).map(|at| entry(at / columns, at % columns)).collect()
}

impl FlatMap {
    fn of(map: &LinearMap) -> Self {
        let (rows, n) = (map.matrix.nrows(), map.matrix.ncols());
        FlatMap {
            matrix: flat(rows, n, |i, j| map.matrix[(i, j)]),
            offset: map.offset.iter().copied().collect(),
            covariance: flat(rows, rows, |i, j| map.covariance[(i, j)]),
        }
    }

    /// Whether each entry has noise of its own.
    fn is_diagonal(&self) -> bool {
        let n = self.offset.len();
        (0..n * n).all(|at| at / n == at % n || self.covariance[at] == 0.0)
    }
}

/// A Gaussian belief about `N` coordinates.
struct FlatBelief {
    n: usize,
    mean: Vec<f64>,
    covariance: Vec<f64>,
    /// Room for products.
    left: Vec<f64>,
    right: Vec<f64>,
}

impl FlatBelief {
    /// `F m + b`, `F P Fᵀ + Q`.
    fn predict(&mut self, map: &FlatMap) {
        let mean = map.matrix.chunks_exact(self.n).zip(&map.offset).map(|(row, b)| b + dot(row, &self.mean));
        self.right.clear();
        self.right.extend(mean);
        std::mem::swap(&mut self.mean, &mut self.right);
        self.sandwich(&map.matrix);
        self.covariance.iter_mut().zip(&map.covariance).for_each(|(p, q)| *p += q);
    }

    /// `F P Fᵀ` in the place of `P`.
    fn sandwich(&mut self, matrix: &[f64]) {
        let n = self.n;
        self.left.clear();
        for row in matrix.chunks_exact(n) {
            // P is symmetric.
            self.left.extend(self.covariance.chunks_exact(n).map(|p| dot(row, p)));
        }
        for (i, left) in self.left.chunks_exact(n).enumerate() {
            for (j, row) in matrix.chunks_exact(n).enumerate().skip(i) {
                let entry = dot(left, row);
                (self.covariance[i * n + j], self.covariance[j * n + i]) = (entry, entry);
            }
        }
    }

    /// Takes in a number that is `cᵀx + d` with noise of that variance, by Joseph's form; its log density, none where it has no variance.
    fn correct(&mut self, c: &[f64], d: f64, noise: f64, measured: f64, kept: &mut Vec<f64>) -> Option<f64> {
        let n = self.n;
        self.right.clear();
        self.right.extend(self.covariance.chunks_exact(n).map(|row| dot(row, c)));
        let variance = dot(&self.right, c) + noise;
        if !(variance > 0.0 && variance.is_finite()) {
            return None;
        }
        let innovation = measured - dot(c, &self.mean) - d;
        let gain: Vec<f64> = self.right.iter().map(|value| value / variance).collect();
        self.mean.iter_mut().zip(&gain).for_each(|(mean, gain)| *mean += gain * innovation);
        kept.clear();
        kept.extend((0..n * n).map(|at| f64::from(at / n == at % n) - gain[at / n] * c[at % n]));
        self.sandwich(kept);
        for (i, row) in self.covariance.chunks_exact_mut(n).enumerate() {
            row.iter_mut().zip(&gain).for_each(|(p, other)| *p += gain[i] * noise * other);
        }
        Some(-0.5 * (LN_2PI + variance.ln() + innovation * innovation / variance))
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `log p(y)` of a series by the Kalman filter, entry by entry of each measurement. None where measurements have correlated noise, or none at all, and where there are many
/// states: the filter itself answers there.
pub(super) fn log_evidence(
    linear: &dyn LinearSystem,
    is_invariant: bool,
    steps: &[RecordedStep],
) -> Option<f64> {
    let n = linear.state_dim();
    if n > MOST_STATES {
        return None;
    }
    let first = linear.initial_belief(&steps.first()?.step.step());
    let mut belief = FlatBelief {
        n,
        mean: first.mean.iter().copied().collect(),
        covariance: flat(n, n, |i, j| first.covariance[(i, j)]),
        left: Vec::new(),
        right: Vec::new(),
    };
    let (mut transition, mut measured, mut kept, mut sum) = (None, None, Vec::new(), 0.0);
    let of_step = |known: &mut Option<FlatMap>, map: &dyn Fn(&Step<'_>) -> LinearMap, step: &Step<'_>| {
        let new = known.take().filter(|_| is_invariant);
        *known = Some(new.unwrap_or_else(|| FlatMap::of(&map(step))));
    };
    for (number, RecordedStep { step, measurement }) in steps.iter().enumerate() {
        let step = step.step();
        if number > 0 {
            of_step(&mut transition, &|step| linear.transition_map(step), &step);
            belief.predict(transition.as_ref()?);
        }
        if measurement.iter().all(Option::is_none) {
            continue;
        }
        of_step(&mut measured, &|step| linear.measurement_map(step), &step);
        let map: &FlatMap = measured.as_ref()?;
        if !map.is_diagonal() {
            return None;
        }
        let m = measurement.len();
        for (i, value) in measurement.iter().enumerate() {
            let Some(value) = value else { continue };
            let (c, noise) = (&map.matrix[i * n..(i + 1) * n], map.covariance[i * m + i]);
            sum += belief.correct(c, map.offset[i], noise, *value, &mut kept)?;
        }
    }
    sum.is_finite().then_some(sum)
}
