//! How likely a potential makes the state that was simulated.

use motes_models::equations::triangle::{at, factor, solve_lower, solve_upper};

use super::decoded::{LOG_ROOT, Layout};

/// A step of a sequence in units of the spreads of the state, seen from its noise: `x ≈ c + J v`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transition<'a> {
    /// The state that was drawn, `N`.
    pub(super) state: &'a [f64],
    /// `c`, `N`.
    pub(super) centre: &'a [f64],
    /// `S = J Jᵀ`, `N×N`.
    pub(super) spread: &'a [f64],
}

/// Room to work in.
#[derive(Debug, Default)]
pub(super) struct LossScratch {
    root: Vec<f64>,
    lower: Vec<f64>,
    /// `S L`, then other products.
    products: [Vec<f64>; 2],
    vectors: [Vec<f64>; 4],
    /// Of each quadratic: `log w ψ(x)` and `log w Z`.
    logs: Vec<[f64; 2]>,
    /// Of each quadratic, derivatives of both.
    derivatives: [Vec<f64>; 2],
}

/// `log ψ(x) − log Z(x')` of the potential that `outputs` mean, by which its proposal is better than the transition, and its derivatives (as many as outputs) times `factor` into
/// `d_outputs`.
///
/// With `u = Lᵀ(c − r)`, `W = I + LᵀSL`, `k = W⁻¹u` and `G = ½(kkᵀ − W⁻¹)`, a quadratic has `log Z = −½ log|W| − ½ uᵀk`, whose derivatives are `L k` along `r` and
/// `2SLG − (c − r)kᵀ` along `L`.
pub(super) fn log_ratio(
    layout: Layout,
    outputs: &[f64],
    transition: Transition<'_>,
    factor_of_derivatives: f64,
    d_outputs: &mut [f64],
    scratch: &mut LossScratch,
) -> f64 {
    let (n, width, count) = (layout.n, layout.width(), layout.components);
    scratch.logs.clear();
    scratch.derivatives.iter_mut().for_each(|derivatives| {
        derivatives.clear();
        derivatives.resize(count * width, 0.0);
    });
    for (number, of_one) in outputs.chunks_exact(width).take(count).enumerate() {
        let logs = of_quadratic(layout, of_one, transition, number * width, scratch);
        scratch.logs.push(logs.map(|log| of_one[0] + log));
    }
    let flat = outputs[layout.outputs() - 1];
    scratch.logs.push([flat; 2]);
    let sums = [0, 1].map(|side| {
        let most = scratch.logs.iter().map(|logs| logs[side]).fold(f64::NEG_INFINITY, f64::max);
        most + scratch.logs.iter().map(|logs| (logs[side] - most).exp()).sum::<f64>().ln()
    });
    let shares = |logs: &[f64; 2]| [0, 1].map(|side| (logs[side] - sums[side]).exp());
    for (number, logs) in scratch.logs[..count].iter().enumerate() {
        let [of_state, of_past] = shares(logs);
        let d = &mut d_outputs[number * width..][..width];
        d[0] = factor_of_derivatives * (of_state - of_past);
        let [of_psi, of_z] = scratch.derivatives.each_ref().map(|all| &all[number * width..][..width]);
        for i in 1..width {
            d[i] = factor_of_derivatives * (of_state * of_psi[i] - of_past * of_z[i]);
        }
        // The diagonal is given by its logarithms, within bounds.
        for i in 0..n {
            let place = 1 + n + at(i, i);
            let log = outputs[number * width + place];
            let is_within = (LOG_ROOT[0]..LOG_ROOT[1]).contains(&log);
            d[place] *= if is_within { log.exp() } else { 0.0 };
        }
    }
    let [of_state, of_past] = shares(&scratch.logs[count]);
    d_outputs[layout.outputs() - 1] = factor_of_derivatives * (of_state - of_past);
    sums[0] - sums[1]
}

/// `log ψ(x)` and `log Z` of a quadratic without its weight, and their derivatives along `r` and `L`.
fn of_quadratic(
    layout: Layout,
    of_one: &[f64],
    transition: Transition<'_>,
    place: usize,
    scratch: &mut LossScratch,
) -> [f64; 2] {
    let n = layout.n;
    let LossScratch { root, lower, products: [spread, inverse], vectors, derivatives, .. } = scratch;
    layout.root(of_one, root);
    let Transition { state, centre, spread: s } = transition;
    let [of_psi, of_z] = derivatives.each_mut().map(|all| &mut all[place..][..layout.width()]);
    let [d, u, k, column] = vectors;
    for vector in [&mut *d, &mut *u, &mut *k, &mut *column] {
        vector.clear();
        vector.resize(n, 0.0);
    }
    // Lᵀ d into u.
    let pull = |d: &[f64], u: &mut [f64]| {
        for (j, u) in u.iter_mut().enumerate() {
            *u = (j..n).map(|i| root[at(i, j)] * d[i]).sum();
        }
    };
    let r = &of_one[1..=n];
    for i in 0..n {
        d[i] = state[i] - r[i];
    }
    pull(d, u);
    let log_psi = -0.5 * u.iter().map(|u| u * u).sum::<f64>();
    for i in 0..n {
        of_psi[1 + i] = (0..=i).map(|j| root[at(i, j)] * u[j]).sum();
        for j in 0..=i {
            of_psi[1 + n + at(i, j)] = -d[i] * u[j];
        }
    }
    // S L, and W = I + Lᵀ S L.
    spread.clear();
    spread.resize(n * n, 0.0);
    for i in 0..n {
        for j in 0..n {
            spread[i * n + j] = (j..n).map(|l| s[i * n + l] * root[at(l, j)]).sum();
        }
    }
    lower.clear();
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (i..n).map(|l| root[at(l, i)] * spread[l * n + j]).sum();
            lower.push(if i == j { 1.0 + sum } else { sum });
        }
    }
    factor(n, lower);
    for i in 0..n {
        d[i] = centre[i] - r[i];
    }
    pull(d, u);
    k.copy_from_slice(u);
    solve_lower(n, lower, k);
    solve_upper(n, lower, k);
    let log_z = -(0..n).map(|i| lower[at(i, i)].ln()).sum::<f64>()
        - 0.5 * u.iter().zip(&*k).map(|(u, k)| u * k).sum::<f64>();
    // 2G = k kᵀ − W⁻¹, column by column.
    inverse.clear();
    inverse.resize(n * n, 0.0);
    for j in 0..n {
        column.fill(0.0);
        column[j] = 1.0;
        solve_lower(n, lower, column);
        solve_upper(n, lower, column);
        for i in 0..n {
            inverse[i * n + j] = k[i] * k[j] - column[i];
        }
    }
    for i in 0..n {
        of_z[1 + i] = (0..=i).map(|j| root[at(i, j)] * k[j]).sum();
        for j in 0..=i {
            let through: f64 = (0..n).map(|l| spread[i * n + l] * inverse[l * n + j]).sum();
            of_z[1 + n + at(i, j)] = through - d[i] * k[j];
        }
    }
    [log_psi, log_z]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives against differences, of two quadratics of two coordinates.
    #[test]
    fn derivatives_are_those_of_the_value() {
        let layout = Layout { n: 2, components: 2 };
        let outputs: Vec<f64> =
            (0..layout.outputs()).map(|at| ((at * 37 % 11) as f64 - 5.0) * 0.17).collect();
        let transition =
            Transition { state: &[0.4, -0.7], centre: &[0.1, 0.3], spread: &[0.9, 0.2, 0.2, 0.5] };
        let mut scratch = LossScratch::default();
        let mut value =
            |outputs: &[f64], d: &mut [f64]| log_ratio(layout, outputs, transition, 1.0, d, &mut scratch);
        let mut found = vec![0.0; outputs.len()];
        value(&outputs, &mut found);
        let mut spare = found.clone();
        for at in 0..outputs.len() {
            let mut at_side = |side: f64| {
                let mut moved = outputs.clone();
                moved[at] += side * 1e-5;
                value(&moved, &mut spare)
            };
            let expected = (at_side(1.0) - at_side(-1.0)) / 2e-5;
            assert!((found[at] - expected).abs() < 1e-8, "{at}: {} instead of {expected}", found[at]);
        }
    }

    /// `log Z` of a quadratic against a sum over a grid of noise.
    #[test]
    fn the_expectation_is_that_over_noise() {
        let layout = Layout { n: 1, components: 1 };
        let outputs = [0.3, 0.8, 0.4, -1.0];
        let (centre, sd) = (-0.2, 0.7);
        let transition = Transition { state: &[0.0], centre: &[centre], spread: &[sd * sd] };
        let mut scratch = LossScratch::default();
        let ratio = log_ratio(layout, &outputs, transition, 1.0, &mut [0.0; 4], &mut scratch);
        let psi = |x: f64| {
            let root = 0.4_f64.exp();
            0.3_f64.exp() * (-0.5 * (root * (x - 0.8)).powi(2)).exp() + (-1.0_f64).exp()
        };
        let (mut sum, mut mass) = (0.0, 0.0);
        for at in -8000..=8000 {
            let v = f64::from(at) * 1e-3;
            let weight = (-0.5 * v * v).exp();
            sum += weight * psi(centre + sd * v);
            mass += weight;
        }
        assert!((ratio - (psi(0.0).ln() - (sum / mass).ln())).abs() < 1e-9);
    }
}
