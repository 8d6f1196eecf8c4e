//! Shares: categories that are measured, shares that are drawn, and all states that categories lead to.

use motes_models::forward::{ForwardError, ForwardFilter, Limits};
use motes_models::{Seed, Simulator, StateSpaceModel, Step, simulate};

use super::helpers::{measuring, model};

/// The log probability of a category where the states are `x` and 0.
fn log_probability(formula: &str, x: f64, value: f64) -> f64 {
    measuring(formula, "").log_likelihood(&Step::of_index(0), &[x, 0.0], &[value]).unwrap()
}

/// Catches a category under another's number, numbers between categories, and probabilities that are none.
#[test]
fn measured_categories_have_their_probabilities() {
    let formula = "categorical(x, 0.25, 0.75 - x)";
    for (category, right) in [(0.0, 0.5_f64), (1.0, 0.25), (2.0, 0.25)] {
        let found = log_probability(formula, 0.5, category);
        assert!((found - right.ln()).abs() < 1e-15, "{category}: {found}");
    }
    for nothing in [-1.0, 0.5, 3.0] {
        assert_eq!(log_probability(formula, 0.5, nothing), f64::NEG_INFINITY, "{nothing}");
    }
    assert_eq!(log_probability(formula, 0.75, 2.0), f64::NEG_INFINITY);
    assert!(log_probability(formula, 1.0, 0.0).is_nan());
    assert!(log_probability("categorical(0.5, 0.25 + x)", 0.3, 0.0).is_nan());
    let found = measuring(formula, "").impossible(&Step::of_index(0), &[Some(3.0)]).unwrap().to_string();
    assert_eq!(
        found,
        "3 is no value of categorical(x, 0.25, 0.75 - x): a count is a whole number from 0 to 2"
    );
}

/// Catches a draw that is off by one, and a last category that is never drawn.
#[test]
fn measured_categories_are_drawn() {
    let model = measuring("categorical(x, 0.25, 0.75 - x)", "");
    let count = 30_000;
    let (states, mut drawn) = ([0.6, 0.0].repeat(count), vec![0.0; count]);
    let mut streams = [Seed::from_u64(1).stream()];
    model.sample_measurements(&Step::of_index(0), &states, &mut streams, &mut drawn);
    for (category, right) in [(0.0, 0.6), (1.0, 0.25), (2.0, 0.15)] {
        let share = drawn.iter().filter(|value| **value == category).count() as f64 / count as f64;
        let error = (right * (1.0 - right) / count as f64).sqrt();
        assert!((share - right).abs() < 4.0 * error, "{category}: {share}");
    }
}

/// Means, variances and covariances of Dirichlet's distribution; shares are not negative and add up to 1.
#[test]
fn shares_that_are_drawn_have_their_moments() {
    let alphas = [0.5, 1.5, 3.0];
    let of_draws = model(
        "[parameters]\na = 3\n[initial]\nx[3] = 0\n[draws]\ns = \"dirichlet(0.5, 1.5, a)\"\n[transition]\nx[3] = \"s[0]*(i == 0) + s[1]*(i == 1) + s[2]*(i == 2)\"\n[measurement]\ny = \"normal(x[0], 1)\"\n",
    );
    let count = 20_000;
    let drawn = simulate(&of_draws, count, &mut Seed::from_u64(2).stream()).unwrap();
    let rows: Vec<&[f64]> = drawn.states.rows().skip(1).collect();
    let all: f64 = alphas.iter().sum();
    for row in &rows {
        assert!(row.iter().all(|share| *share >= 0.0) && (row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }
    let mean = |of: &dyn Fn(&[f64]) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / rows.len() as f64;
    for (i, alpha) in alphas.iter().enumerate() {
        let right = alpha / all;
        let variance = right * (1.0 - right) / (all + 1.0);
        let found = mean(&|row| row[i]);
        assert!((found - right).abs() < 4.0 * (variance / count as f64).sqrt(), "{i}: {found} for {right}");
        let spread = mean(&|row| (row[i] - right).powi(2));
        assert!((spread - variance).abs() < 0.05 * variance, "{i}: {spread} for {variance}");
    }
    let covariance = mean(&|row| (row[0] - 0.1) * (row[1] - 0.3));
    let right = -0.1 * 0.3 / (all + 1.0);
    assert!((covariance - right).abs() < 0.1 * right.abs(), "{covariance} for {right}");
}

const REGIMES: &str = r#"
[parameters]
g = [[0.8, 0.15, 0.05], [0.1, 0.9, 0.0], [0.3, 0.3, 0.4]]
[initial]
k = "categorical(0.5, 0.25, 0.25)"
before = 0
[transition]
k = "categorical(g[k, 0], g[k, 1], g[k, 2])"
before = "k"
[measurement]
y = "normal(k + 10*before, 1)"
"#;

/// States are found as they are reached, those that keep what was drawn before among them, with the probabilities of all ways that lead there.
#[test]
fn all_states_are_reached() {
    let regimes = model(REGIMES);
    let finite = regimes.finite_system().unwrap();
    let mut filter = ForwardFilter::new(finite, Limits::default());
    filter.step_at(&Step::of_index(0), &[None]).unwrap();
    filter.step_at(&Step::of_index(1), &[None]).unwrap();
    let belief = filter.belief().unwrap();
    let mut found: Vec<(Vec<f64>, f64)> = belief.iter().map(|(state, p)| (state.to_vec(), p)).collect();
    found.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap());
    let (start, g) = ([0.5, 0.25, 0.25], [[0.8, 0.15, 0.05], [0.1, 0.9, 0.0], [0.3, 0.3, 0.4]]);
    let mut right = Vec::new();
    for next in 0..3_usize {
        for (before, (start, shares)) in start.iter().zip(g).enumerate() {
            if shares[next] > 0.0 {
                right.push((vec![next as f64, before as f64], start * shares[next]));
            }
        }
    }
    assert_eq!(found.len(), right.len());
    for (found, right) in found.iter().zip(&right) {
        assert!(found.0 == right.0 && (found.1 - right.1).abs() < 1e-15, "{found:?} for {right:?}");
    }
    // Of a few, all is exact; limits hold.
    assert!((belief.mean(0) - right.iter().map(|(state, p)| state[0] * p).sum::<f64>()).abs() < 1e-15);
    assert_eq!(belief.quantile(1, 0.5), 0.0);
    assert_eq!(belief.quantile(1, 0.51), 1.0);
    let few = Limits { states: 4, ..Limits::default() };
    let mut filter = ForwardFilter::new(finite, few);
    filter.step_at(&Step::of_index(0), &[None]).unwrap();
    let error = filter.step_at(&Step::of_index(1), &[None]).unwrap_err();
    assert_eq!(error, ForwardError::TooManyStates(4));
    let mut filter = ForwardFilter::new(finite, Limits { ways: 5, ..Limits::default() });
    filter.step_at(&Step::of_index(0), &[None]).unwrap();
    let error = filter.step_at(&Step::of_index(1), &[None]).unwrap_err();
    assert_eq!(error, ForwardError::TooManyWays(5));
}

#[test]
fn what_has_many_values_is_not_finite() {
    let moved = |formula: &str| {
        model(&format!(
            "[initial]\nx = \"bernoulli(0.5)\"\n[transition]\nx = \"{formula}\"\n[measurement]\ny = \"normal(x, 1)\"\n"
        ))
    };
    assert!(moved("binomial(3, 0.5)").finite_system().is_some());
    assert!(moved("1 - x").finite_system().is_some());
    assert!(moved("poisson(1)").finite_system().is_none());
    assert!(moved("normal(x, 1)").finite_system().is_none());
}
