//! Offspring counts of every scheme, at a count that divides the weights and at one that does not.

use motes_models::Seed;
use motes_smc::Resampling;

const WEIGHTS: [f64; 5] = [0.1, 0.5, 0.1, 0.15, 0.15];
const REPETITIONS: usize = 20_000;

fn offspring(scheme: Resampling, count: usize) -> Vec<[usize; 5]> {
    let mut stream = Seed::from_u64(40).nth(count as u64).stream();
    let mut ancestors = vec![0; count];
    (0..REPETITIONS)
        .map(|_| {
            scheme.draw(WEIGHTS.into_iter(), &mut stream, &mut ancestors);
            assert!(ancestors.is_sorted());
            let mut counts = [0; 5];
            ancestors.iter().for_each(|&ancestor| counts[ancestor] += 1);
            counts
        })
        .collect()
}

fn check(scheme: Resampling, bounds: impl Fn(f64) -> (f64, f64)) {
    for count in [8, 10] {
        let offspring = offspring(scheme, count);
        for (particle, weight) in WEIGHTS.into_iter().enumerate() {
            let expected = count as f64 * weight;
            let n = REPETITIONS as f64;
            let counts: Vec<f64> = offspring.iter().map(|counts| counts[particle] as f64).collect();
            let mean = counts.iter().sum::<f64>() / n;
            let variance = counts.iter().map(|c| (c - mean).powi(2)).sum::<f64>() / (n - 1.0);
            // A scheme may give a count that never varies; then it has to be right to rounding.
            let error = (variance / n).sqrt().max(1e-9);
            assert!(((mean - expected) / error).abs() < 4.0, "{scheme:?}, {count}: {mean} for {expected}");
            let (least, most) = bounds(expected);
            assert!(counts.iter().all(|c| (least..=most).contains(c)), "{scheme:?}, {count}, {expected}");
        }
    }
}

/// K·W with rounding of the weights' decimals taken off, so that 0.5·10 is 5 and not a hair less.
fn floor(expected: f64) -> f64 {
    (expected + 1e-9).floor()
}

fn ceil(expected: f64) -> f64 {
    (expected - 1e-9).ceil()
}

#[test]
fn multinomial() {
    check(Resampling::Multinomial, |_| (0.0, 10.0));
}

#[test]
fn systematic_counts_are_floor_or_ceiling() {
    // On a boundary of the cumulative sum a rounding error of the weights may move one point.
    check(Resampling::Systematic, |expected| (floor(expected), ceil(expected + 2e-9)));
}

#[test]
fn stratified_counts_are_within_one_of_floor_and_ceiling() {
    check(Resampling::Stratified, |expected| (floor(expected) - 1.0, ceil(expected) + 1.0));
}

#[test]
fn residual_counts_are_at_least_the_floor() {
    check(Resampling::Residual, |expected| (floor(expected), 10.0));
}

#[test]
fn particles_without_weight_have_no_offspring() {
    let mut stream = Seed::from_u64(41).stream();
    let mut ancestors = [9; 7];
    for scheme in
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual]
    {
        scheme.draw([0.0, 0.4, 0.0, 0.6, 0.0].into_iter(), &mut stream, &mut ancestors);
        assert!(
            ancestors.iter().all(|&ancestor| ancestor == 1 || ancestor == 3),
            "{scheme:?}: {ancestors:?}"
        );
    }
}
