//! Resampling schemes.

use motes_models::Seed;
use motes_smc::Resampling;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cases;

fn schemes() -> impl Strategy<Value = Resampling> {
    prop_oneof![
        Just(Resampling::Multinomial),
        Just(Resampling::Systematic),
        Just(Resampling::Stratified),
        Just(Resampling::Residual),
    ]
}

/// Normalised weights over many orders of magnitude, some of them 0.
fn weights() -> impl Strategy<Value = Vec<f64>> {
    let weight = prop_oneof![3 => 0.0..1.0, 1 => (-300.0..0.0).prop_map(f64::exp), 1 => Just(0.0)];
    let many = prop_oneof![9 => vec(weight.clone(), 1..60), 1 => vec(weight, 1000..3000)];
    many.prop_map(|mut weights| {
        // At least one particle is there.
        weights[0] += 0.5;
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|weight| *weight /= sum);
        weights
    })
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn ancestors_are_there_in_order_and_have_a_weight(
        scheme in schemes(),
        weights in weights(),
        count in 0_usize..3000,
        seed: u64,
    ) {
        let mut ancestors = vec![usize::MAX; count];
        scheme.draw(&weights, &mut Seed::from_u64(seed).stream(), &mut ancestors);
        prop_assert!(ancestors.is_sorted());
        let mut counts = vec![0.0; weights.len()];
        for &ancestor in &ancestors {
            prop_assert!(ancestor < weights.len() && weights[ancestor] > 0.0, "{:?} drew {}", scheme, ancestor);
            counts[ancestor] += 1.0;
        }
        // Sums of weights are right to some 1e-12 of the whole.
        let rounding = 1e-9 * count.max(1) as f64;
        for (drawn, weight) in counts.into_iter().zip(&weights) {
            let expected = weight * count as f64;
            let (least, most) = match scheme {
                Resampling::Multinomial => (0.0, count as f64),
                Resampling::Systematic => ((expected - rounding).floor(), (expected + rounding).ceil()),
                Resampling::Stratified => ((expected - rounding).floor() - 1.0, (expected + rounding).ceil() + 1.0),
                Resampling::Residual => ((expected - rounding).floor(), count as f64),
            };
            prop_assert!((least..=most).contains(&drawn), "{:?}: {} offspring for {}", scheme, drawn, expected);
        }
    }

    #[test]
    fn one_particle_with_all_the_weight_has_all_offspring(scheme in schemes(), at in 0_usize..50, seed: u64) {
        let mut weights = vec![0.0; 50];
        weights[at] = 1.0;
        let mut ancestors = vec![0; 70];
        scheme.draw(&weights, &mut Seed::from_u64(seed).stream(), &mut ancestors);
        prop_assert!(ancestors.iter().all(|ancestor| *ancestor == at));
    }
}
