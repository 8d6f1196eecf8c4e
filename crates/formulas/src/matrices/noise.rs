//! The noise of matrices as independent draws, and what is left to each measurement.

use faer::{Mat, MatRef};

use super::arrays::Arrays;
use super::factor::{Factor, split};

/// Below such a share of two standard deviations a covariance is what rounding left of 0.
const ROUNDED: f64 = 1e-12;

/// `v_t = V e`, and `w_t = W e` and noise of its own to each entry, for standard normal numbers `e`.
#[derive(Debug)]
pub(super) struct Noise {
    pub(super) states: StateNoise,
    /// `W`, with a column for each draw.
    pub(super) shared: Mat<f64>,
    /// The standard deviation that each measurement has to itself.
    pub(super) own: Vec<f64>,
}

/// How the noise of states is drawn.
#[derive(Debug)]
pub(super) enum StateNoise {
    /// Each coordinate has its own, with this standard deviation.
    Own(Vec<f64>),
    /// `V`, with a column for each draw.
    Of(Mat<f64>),
}

impl Noise {
    /// The noise of these covariances; none where they are not positive semi-definite together.
    pub(super) fn of(arrays: &Arrays) -> Option<Noise> {
        let (q, r) = (&arrays.state_noise, &arrays.measurement_noise);
        let (n, m) = (q.nrows(), r.nrows());
        let factor = match &arrays.shared_noise {
            None => Factor::of(q.as_ref())?,
            Some(s) => Factor::of(joint(q, s, r).as_ref())?,
        };
        let from: Vec<usize> = (0..n).filter(|j| factor.pivots[*j] > 0.0).collect();
        let loads = |first: usize, rows: usize| {
            Mat::from_fn(rows, from.len(), |i, j| {
                factor.unit[(first + i, from[j])] * factor.pivots[from[j]].sqrt()
            })
        };
        let (of_states, with_states) = match arrays.shared_noise {
            None => (loads(0, n), Mat::zeros(m, from.len())),
            Some(_) => (loads(0, n), loads(n, m)),
        };
        let alone = left(r.as_ref(), &with_states);
        let (own, rest) = split(alone.as_ref());
        let rest = Factor::of(rest.as_ref())?.loads();
        let own = own.into_iter().map(f64::sqrt).collect();
        let is_apart = arrays.shared_noise.is_none() && factor.is_diagonal();
        let states = match is_apart {
            true => StateNoise::Own(factor.pivots.iter().map(|pivot| pivot.sqrt()).collect()),
            false => StateNoise::Of(padded(&of_states, 0, rest.ncols())),
        };
        let before = if is_apart { 0 } else { from.len() };
        let mut shared = padded(&rest, before, 0);
        if !is_apart {
            shared += padded(&with_states, 0, rest.ncols());
        }
        Some(Noise { states, shared, own })
    }

    /// How many numbers are drawn in a step.
    pub(super) fn draws(&self) -> usize {
        self.shared.ncols()
    }

    /// Whether a measurement has noise that is drawn.
    pub(super) fn is_shared(&self, measurement: usize) -> bool {
        (0..self.draws()).any(|j| self.shared[(measurement, j)] != 0.0)
    }
}

/// The covariance of `v_t` and `w_t` together.
pub(super) fn joint(q: &Mat<f64>, s: &Mat<f64>, r: &Mat<f64>) -> Mat<f64> {
    let n = q.nrows();
    let all = n + r.nrows();
    Mat::from_fn(all, all, |i, j| match (i < n, j < n) {
        (true, true) => q[(i, j)],
        (true, false) => s[(i, j - n)],
        (false, true) => s[(j, i - n)],
        (false, false) => r[(i - n, j - n)],
    })
}

/// What is left of the covariance of the measurements' noise beside what comes of the states' draws.
fn left(r: MatRef<'_, f64>, loads: &Mat<f64>) -> Mat<f64> {
    let known = loads * loads.transpose();
    Mat::from_fn(r.nrows(), r.ncols(), |i, j| {
        let left = r[(i, j)] - known[(i, j)];
        if left.abs() <= ROUNDED * (r[(i, i)] * r[(j, j)]).sqrt() { 0.0 } else { left }
    })
}

/// The same with columns of zeros before and behind.
fn padded(matrix: &Mat<f64>, before: usize, behind: usize) -> Mat<f64> {
    let columns = matrix.ncols();
    Mat::from_fn(matrix.nrows(), before + columns + behind, |i, j| {
        if (before..before + columns).contains(&j) { matrix[(i, j - before)] } else { 0.0 }
    })
}
