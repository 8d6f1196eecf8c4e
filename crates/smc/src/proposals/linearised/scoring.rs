//! One step of Fisher scoring for the particles of a tile, and whether there is anything to score.

use motes_models::batch::LANES;
use motes_models::equations::{Lanes, Linearise};

use super::factor::{at, factor, solve_lower, solve_upper};

/// Whether the location of an entry of `measurement` depends on the state near `state`.
pub(super) fn depends_on_state(
    model: &(impl Linearise + ?Sized),
    time: usize,
    state: &[f64],
    measurement: &[f64],
) -> bool {
    let (n, m) = (state.len(), measurement.len());
    let measurement: Vec<Option<Lanes>> = measurement.iter().map(|entry| Some(Lanes::from(*entry))).collect();
    let states: Vec<f64> = state.iter().flat_map(|value| [*value; LANES]).collect();
    let mut found = vec![0.0; (2 + n) * m * LANES];
    let (slopes, rest) = found.split_at_mut(m * LANES);
    let (information, jacobian) = rest.split_at_mut(m * LANES);
    model.tile_scores(time, &states, &measurement, slopes, information, jacobian);
    // NaN says that it depends on something.
    jacobian.iter().any(|entry| *entry != 0.0)
}

/// Leaves out, for each particle, an entry of the measurement that says nothing finite there.
#[inline(always)]
fn keep_finite(slope: &mut Lanes, information: &mut Lanes, jacobian: &mut [Lanes]) {
    let mut is_kept = [true; LANES];
    for (lane, kept) in is_kept.iter_mut().enumerate() {
        *kept = slope.0[lane].is_finite() && information.0[lane].is_finite() && information.0[lane] > 0.0;
    }
    for entry in &*jacobian {
        for (kept, entry) in is_kept.iter_mut().zip(entry.0) {
            *kept &= entry.is_finite();
        }
    }
    for values in jacobian.iter_mut().chain([slope, information]) {
        for (value, kept) in values.0.iter_mut().zip(is_kept) {
            *value = if kept { *value } else { 0.0 };
        }
    }
}

/// `m + Λ⁻¹ g` into `mean`, which holds `m`, and `L` into `lower`; `variances` become scratch.
#[inline(always)]
pub(super) fn score(
    mean: &mut [Lanes],
    variances: &mut [Lanes],
    slopes: &mut [Lanes],
    information: &mut [Lanes],
    jacobian: &mut [Lanes],
    lower: &mut [Lanes],
) {
    let n = mean.len();
    lower.fill(Lanes::from(0.0));
    for (i, variance) in variances.iter().enumerate() {
        lower[at(i, i)] = Lanes::from(1.0) / *variance;
    }
    // From here on they hold g.
    variances.fill(Lanes::from(0.0));
    for ((slope, information), jacobian) in
        slopes.iter_mut().zip(information).zip(jacobian.chunks_exact_mut(n))
    {
        keep_finite(slope, information, jacobian);
        for (i, of_row) in jacobian.iter().enumerate() {
            // Most measurements depend on few coordinates.
            if of_row.0.iter().all(|entry| *entry == 0.0) {
                continue;
            }
            let weighted = *of_row * *information;
            variances[i] = variances[i] + *of_row * *slope;
            for (j, of_column) in jacobian[..=i].iter().enumerate() {
                lower[at(i, j)] = lower[at(i, j)] + weighted * *of_column;
            }
        }
    }
    factor(n, lower);
    solve_lower(n, lower, variances);
    solve_upper(n, lower, variances);
    for (mean, step) in mean.iter_mut().zip(&*variances) {
        *mean = *mean + *step;
    }
}
