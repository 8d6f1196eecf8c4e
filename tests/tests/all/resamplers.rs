//! Offspring counts of every scheme, at a count that divides the weights and at one that does not.

use motes_models::Seed;
use motes_smc::Resampling;
use motes_tests::{OFFSPRING_WEIGHTS as WEIGHTS, Offspring, systematic_bounds, systematic_variance};

/// Checks means, variances and bounds of the offspring counts against what the scheme promises.
fn check(scheme: Resampling, variance_of: impl Fn(usize, usize) -> f64, bounds: impl Fn(f64) -> (f64, f64)) {
    for count in [8, 10] {
        let offspring = Offspring::of(count, |stream, ancestors| scheme.draw(&WEIGHTS, stream, ancestors));
        let checked = offspring.check(&variance_of, &bounds);
        assert!(checked.is_ok(), "{scheme:?}, {count} offspring: {checked:?}");
    }
}

/// The fraction of each of `count` strata of the unit interval that a particle's stretch of it covers.
fn covered(count: usize, particle: usize) -> Vec<f64> {
    let start: f64 = WEIGHTS[..particle].iter().sum();
    let end = start + WEIGHTS[particle];
    let stratum = |k: usize| (k as f64 / count as f64, (k + 1) as f64 / count as f64);
    (0..count).map(|k| (end.min(stratum(k).1) - start.max(stratum(k).0)).max(0.0) * count as f64).collect()
}

/// K·W with rounding of the weights' decimals taken off, so that 0.5·10 is 5 and not a hair less.
fn floor(expected: f64) -> f64 {
    (expected + 1e-9).floor()
}

fn ceil(expected: f64) -> f64 {
    (expected - 1e-9).ceil()
}

#[test]
fn multinomial_counts_are_binomial() {
    let variance =
        |count: usize, particle: usize| count as f64 * WEIGHTS[particle] * (1.0 - WEIGHTS[particle]);
    check(Resampling::Multinomial, variance, |_| (0.0, 10.0));
}

#[test]
fn systematic_counts_are_floor_or_ceiling() {
    check(Resampling::Systematic, systematic_variance, systematic_bounds);
}

#[test]
fn stratified_counts_are_sums_of_one_draw_in_each_stratum() {
    let variance =
        |count: usize, particle: usize| covered(count, particle).iter().map(|p| p * (1.0 - p)).sum();
    check(Resampling::Stratified, variance, |expected| (floor(expected) - 1.0, ceil(expected) + 1.0));
}

#[test]
fn residual_counts_are_the_floor_and_a_binomial_rest() {
    let variance = |count: usize, particle: usize| {
        let rests = WEIGHTS.map(|weight| count as f64 * weight - floor(count as f64 * weight));
        let left: f64 = rests.iter().sum();
        let share = if left > 1e-6 { rests[particle] / left } else { 0.0 };
        left * share * (1.0 - share)
    };
    check(Resampling::Residual, variance, |expected| (floor(expected), 10.0));
}

#[test]
fn equal_weights_leave_residual_draws_nothing_to_chance() {
    let mut stream = Seed::from_u64(42).stream();
    for count in 1..=300 {
        let (weights, expected) = (vec![1.0 / count as f64; count], (0..count).collect::<Vec<_>>());
        let mut ancestors = vec![0; count];
        Resampling::Residual.draw(&weights, &mut stream, &mut ancestors);
        assert_eq!(ancestors, expected, "residual, {count} particles");
    }
}

#[test]
fn particles_without_weight_have_no_offspring() {
    let mut stream = Seed::from_u64(41).stream();
    let mut ancestors = [9; 7];
    for scheme in
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual]
    {
        scheme.draw(&[0.0, 0.4, 0.0, 0.6, 0.0], &mut stream, &mut ancestors);
        assert!(
            ancestors.iter().all(|&ancestor| ancestor == 1 || ancestor == 3),
            "{scheme:?}: {ancestors:?}"
        );
    }
}
