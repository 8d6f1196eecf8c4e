//! One step of Fisher scoring for the particles of a tile, and whether there is anything to score.

use motes_models::batch::LANES;
use motes_models::equations::{Lanes, Linearise, NoiseSpace};

use motes_models::Step;
use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper};

/// Whether the location of an entry of `measurement` depends on the state near `state`.
pub(super) fn depends_on_state(
    model: &(impl Linearise + ?Sized),
    step: &Step<'_>,
    state: &[f64],
    measurement: &[f64],
) -> bool {
    let (n, m) = (state.len(), measurement.len());
    let measurement: Vec<Option<Lanes>> = measurement.iter().map(|y| Some(Lanes::from(*y))).collect();
    let states: Vec<f64> = state.iter().flat_map(|value| [*value; LANES]).collect();
    let mut found = vec![0.0; (2 + n) * m * LANES];
    let (slopes, rest) = found.split_at_mut(m * LANES);
    let (information, jacobian) = rest.split_at_mut(m * LANES);
    model.tile_scores(step, &states, &measurement, slopes, information, jacobian);
    // NaN says that it depends on something.
    jacobian.iter().any(|entry| *entry != 0.0)
}

/// Whether the location of an entry of `measurement` depends on some of so many draws after `previous`.
pub(super) fn depends_on_noise(
    model: &dyn NoiseSpace,
    step: &Step<'_>,
    previous: Option<&[f64]>,
    draws: usize,
    measurement: &[f64],
) -> bool {
    let m = measurement.len();
    let measurement: Vec<Option<Lanes>> = measurement.iter().map(|y| Some(Lanes::from(*y))).collect();
    let previous: Option<Vec<f64>> =
        previous.map(|previous| previous.iter().flat_map(|value| [*value; LANES]).collect());
    let mut found = vec![0.0; (2 + draws) * m * LANES];
    let (slopes, rest) = found.split_at_mut(m * LANES);
    let (information, jacobian) = rest.split_at_mut(m * LANES);
    model.tile_noise_scores(step, previous.as_deref(), &measurement, slopes, information, jacobian);
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
    lower.fill(Lanes::from(0.0));
    for (i, variance) in variances.iter().enumerate() {
        lower[at(i, i)] = Lanes::from(1.0) / *variance;
    }
    fisher_scoring(mean, slopes, information, jacobian, lower, variances);
}

/// One step of Fisher scoring for the particles of a tile, one particle in each lane: `Λ = P⁻¹ + Σ_j I_j J_j J_jᵀ`, `g = Σ_j s_j J_j`.
///
/// - `mean` (`N`) holds `m` and gets `m + Λ⁻¹ g`.
/// - `lower` (`N(N+1)/2`, see [`triangle`](motes_models::equations::triangle)) holds `P⁻¹` and gets `L`, `Λ = L Lᵀ`.
/// - `slopes` `s` and `information` `I` (`M` each) and `jacobian` `J` (`M×N`) are what the measurement says at `m`. An entry that says nothing finite for
///   a particle is set to 0 there.
/// - `scratch` has `N` entries.
#[inline(always)]
pub fn fisher_scoring(
    mean: &mut [Lanes],
    slopes: &mut [Lanes],
    information: &mut [Lanes],
    jacobian: &mut [Lanes],
    lower: &mut [Lanes],
    scratch: &mut [Lanes],
) {
    let n = mean.len();
    let g = scratch;
    g.fill(Lanes::from(0.0));
    add_measurement(slopes, information, jacobian, g, lower);
    factor(n, lower);
    solve_lower(n, lower, g);
    solve_upper(n, lower, g);
    for (mean, step) in mean.iter_mut().zip(&*g) {
        *mean = *mean + *step;
    }
}

/// Adds what a measurement says: `Σ_j s_j J_j` to `g` (`N`), and `Σ_j I_j J_j J_jᵀ` to `lower` (`N(N+1)/2`). An entry that says nothing finite for a particle is set to 0
/// there.
#[inline(always)]
pub(super) fn add_measurement(
    slopes: &mut [Lanes],
    information: &mut [Lanes],
    jacobian: &mut [Lanes],
    g: &mut [Lanes],
    lower: &mut [Lanes],
) {
    for ((slope, information), jacobian) in
        slopes.iter_mut().zip(information).zip(jacobian.chunks_exact_mut(g.len()))
    {
        keep_finite(slope, information, jacobian);
        for (i, of_row) in jacobian.iter().enumerate() {
            // Most measurements depend on few coordinates.
            if of_row.0.iter().all(|entry| *entry == 0.0) {
                continue;
            }
            let weighted = *of_row * *information;
            g[i] = g[i] + *of_row * *slope;
            for (j, of_column) in jacobian[..=i].iter().enumerate() {
                lower[at(i, j)] = lower[at(i, j)] + weighted * *of_column;
            }
        }
    }
}
