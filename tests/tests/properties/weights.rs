//! Log-weights.

use motes_smc::{LogWeights, PARETO_K_LIMIT, WeightFault, pareto_k};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cases;

/// Increments as filters have them: finite, far apart at times, and now and then impossible.
fn increments() -> impl Strategy<Value = Vec<f64>> {
    let increment = prop_oneof![
        8 => -30.0..30.0,
        2 => -1e5..1e5,
        1 => Just(f64::NEG_INFINITY),
    ];
    // Beyond one block of 1024.
    prop_oneof![9 => vec(increment.clone(), 1..100), 1 => vec(increment, 1000..2500)]
}

/// `log Σ exp`, term by term.
fn log_sum(logs: &[f64]) -> f64 {
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    largest + logs.iter().map(|log| (log - largest).exp()).sum::<f64>().ln()
}

fn near(found: f64, expected: f64) -> bool {
    found == expected || (found - expected).abs() <= 1e-9 * expected.abs().max(1.0)
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn updates_normalise_and_say_what_they_divided_by(increments in increments()) {
        let mut weights = LogWeights::uniform(increments.len());
        let k = increments.len() as f64;
        match weights.update(&increments) {
            Err(fault) => {
                prop_assert_eq!(fault, WeightFault::AllZero);
                prop_assert!(increments.iter().all(|increment| *increment == f64::NEG_INFINITY));
            }
            Ok(found) => {
                prop_assert!(near(found, log_sum(&increments) - k.ln()), "{}", found);
                prop_assert!(near(weights.normalised().iter().sum(), 1.0));
                let ess = weights.effective_sample_size();
                prop_assert!((1.0 - 1e-9..=k * (1.0 + 1e-9)).contains(&ess), "ESS {}", ess);
                // A logarithm is the difference of numbers as large as increments are, each rounded.
                let finite = increments.iter().filter(|increment| increment.is_finite());
                let largest = finite.fold(1.0_f64, |largest, increment| largest.max(increment.abs()));
                for (log, weight) in weights.log().iter().zip(weights.normalised()) {
                    prop_assert!((log.exp() - weight).abs() <= 8.0 * f64::EPSILON * largest);
                }
            }
        }
    }

    #[test]
    fn two_updates_are_one_by_the_sum(pairs in vec((-50.0..50.0, -50.0..50.0), 1..200)) {
        let (first, second): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
        let (mut twice, mut once) = (LogWeights::uniform(first.len()), LogWeights::uniform(first.len()));
        let in_two = twice.update(&first).unwrap() + twice.update(&second).unwrap();
        let sums: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + b).collect();
        prop_assert!(near(in_two, once.update(&sums).unwrap()));
        for (a, b) in twice.normalised().iter().zip(once.normalised()) {
            prop_assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn no_bits_make_them_panic_or_lie(increments in vec(any::<u64>().prop_map(f64::from_bits), 1..300)) {
        let mut weights = LogWeights::uniform(increments.len());
        let faulty = increments.iter().any(|log| log.is_nan() || *log == f64::INFINITY);
        match weights.update(&increments) {
            Err(WeightFault::NotANumber { particle, .. }) => {
                prop_assert!(increments[particle].is_nan() || increments[particle] == f64::INFINITY);
            }
            Err(WeightFault::AllZero) => prop_assert!(!faulty),
            Ok(_) => {
                prop_assert!(!faulty);
                prop_assert!(near(weights.normalised().iter().sum(), 1.0));
            }
        }
        if let Some(index) = pareto_k(&increments) {
            prop_assert!(index.is_finite());
        }
    }

    #[test]
    fn the_tail_index_depends_on_no_order_and_no_scale(
        mut logs in vec(-20.0..20.0, 25..400),
        shift in -1e3..1e3,
    ) {
        let index = pareto_k(&logs);
        logs.reverse();
        prop_assert_eq!(pareto_k(&logs), index);
        logs.iter_mut().for_each(|log| *log += shift);
        if let (Some(index), Some(shifted)) = (index, pareto_k(&logs)) {
            prop_assert!((index - shifted).abs() < 1e-6 || index.min(shifted) > 10.0 * PARETO_K_LIMIT);
        }
    }
}
