//! Diagnostics of chains that are made on purpose.

use motes_inference::{ParameterSummary, r_hat};
use motes_models::{Seed, fill_standard_normal};

/// Autoregressive chains of standard deviation 1.
fn chains(count: usize, length: usize, correlation: f64) -> Vec<Vec<f64>> {
    let of_chain = |chain: usize| {
        let mut noise = vec![0.0; length];
        fill_standard_normal(&mut Seed::from_u64(1).nth(chain as u64).stream(), &mut noise);
        let fresh = (1.0 - correlation * correlation).sqrt();
        let mut before = noise[0];
        for value in &mut noise[1..] {
            *value = correlation * before + fresh * *value;
            before = *value;
        }
        noise
    };
    (0..count).map(of_chain).collect()
}

#[test]
fn the_effective_size_of_autoregressive_chains_is_what_their_correlation_says() {
    for correlation in [-0.3, 0.0, 0.6, 0.95] {
        let summary = ParameterSummary::of(&chains(4, 20_000, correlation)).expect("there are draws");
        let expected = 80_000.0 * (1.0 - correlation) / (1.0 + correlation);
        assert!((summary.ess_bulk / expected - 1.0).abs() < 0.15, "{correlation}: {summary:?}, {expected}");
        assert!(
            (summary.mcse - 1.0 / expected.sqrt()).abs() < 0.1 * summary.mcse,
            "{correlation}: {summary:?}"
        );
        assert!(summary.mean.abs() < 4.0 * summary.mcse, "{summary:?}");
        assert!((summary.q95 - 1.645).abs() < 0.1 && (summary.q05 + 1.645).abs() < 0.1, "{summary:?}");
        assert!(summary.rhat < 1.01, "{summary:?}");
    }
}

#[test]
fn chains_that_disagree_have_a_large_r_hat() {
    let agreeing = chains(4, 1000, 0.0);
    assert!(r_hat(&agreeing) < 1.01);
    let shift = |by: f64, scale: f64| {
        let of_chain = |(number, chain): (usize, &Vec<f64>)| {
            let (by, scale) = if number == 0 { (by, scale) } else { (0.0, 1.0) };
            chain.iter().map(|value| by + scale * value).collect()
        };
        agreeing.iter().enumerate().map(of_chain).collect::<Vec<Vec<f64>>>()
    };
    assert!(r_hat(&shift(2.0, 1.0)) > 1.1, "one chain elsewhere");
    assert!(r_hat(&shift(0.0, 4.0)) > 1.1, "one chain wider, with the same centre");
    // One that drifts disagrees with itself.
    let drifts = vec![(0..1000).map(|at| at as f64 / 1000.0).collect::<Vec<f64>>()];
    assert!(r_hat(&drifts) > 1.5);
    // Infinite variances are no trouble.
    let heavy: Vec<Vec<f64>> =
        agreeing.iter().map(|chain| chain.iter().map(|v| v / (v.abs() - 0.5)).collect()).collect();
    assert!(r_hat(&heavy) < 1.02);
}

#[test]
fn chains_that_stand_still_have_no_figures() {
    let still = ParameterSummary::of(&[vec![1.0; 100], vec![1.0; 100]]).expect("there are draws");
    assert!(still.rhat.is_nan() && still.ess_bulk.is_nan() && still.ess_tail.is_nan(), "{still:?}");
    assert_eq!(ParameterSummary::of(&[vec![1.0, 2.0, 3.0]]), None);
    assert_eq!(ParameterSummary::of(&[]), None);
}
