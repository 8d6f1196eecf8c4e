//! The covariance head that the Gaussian families share.

use motes_proposals::KernelCovariance;
use motes_smc::ErrorKind;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::cases;

/// N, C, z of a few particles, and the ridge.
fn heads() -> impl Strategy<Value = (usize, Vec<f64>, Vec<f64>, f64)> {
    (1_usize..13, 1_usize..20, -3.0_f64..3.0, prop_oneof![1e-9_f64..1e-2, Just(0.0)]).prop_flat_map(
        |(n, particles, size, ridge)| {
            let scale = 10_f64.powf(size);
            (Just(n), vec(-scale..scale, n * n), vec(-4.0..4.0, particles * n), Just(ridge))
        },
    )
}

/// `C K(z) Cᵀ + δ I`, by its formula.
fn covariance(n: usize, mixing: &[f64], z: &[f64], ridge: f64) -> Vec<f64> {
    let kernel = |a: usize, b: usize| (-(z[a] - z[b]) * (z[a] - z[b])).exp();
    let entry = |i: usize, j: usize| {
        let sum: f64 = (0..n * n)
            .map(|at| mixing[i * n + at / n] * kernel(at / n, at % n) * mixing[j * n + at % n])
            .sum();
        sum + if i == j { ridge } else { 0.0 }
    };
    (0..n * n).map(|at| entry(at / n, at % n)).collect()
}

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn factors_multiply_back_to_the_covariance((n, mixing, z, ridge) in heads()) {
        let head = KernelCovariance::new(n, &mixing, ridge).unwrap();
        let largest = mixing.iter().fold(0.0_f64, |largest, c| largest.max(c.abs()));
        // A bound of the norm of Σ.
        let scale = (n * n * n) as f64 * largest * largest + ridge;
        match head.factors(&z) {
            Err(error) => {
                // What is not positive definite in floating point is so small a ridge that rounding hides it.
                prop_assert_eq!(error.kind(), ErrorKind::Numerical);
                prop_assert!(ridge < 1e-12 * scale, "refused a ridge of {} beside {}", ridge, scale);
            }
            Ok(lowers) => {
                for (z, lower) in z.chunks_exact(n).zip(lowers.chunks_exact(n * n)) {
                    let expected = covariance(n, &mixing, z, ridge);
                    for i in 0..n {
                        prop_assert!(lower[i * n + i] > 0.0);
                        for j in 0..=i {
                            // Column-major.
                            let product: f64 = (0..=j).map(|k| lower[k * n + i] * lower[k * n + j]).sum();
                            let difference = (product - expected[i * n + j]).abs();
                            prop_assert!(difference <= 1e-13 * scale, "({}, {}): {:e}", i, j, difference);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn neither_bits_nor_sizes_make_it_panic(
        bits in vec(any::<u64>().prop_map(f64::from_bits), 9),
        z in vec(any::<u64>().prop_map(f64::from_bits), 0..40),
        ridge in any::<u64>().prop_map(f64::from_bits),
    ) {
        if let Ok(head) = KernelCovariance::new(3, &bits, ridge) && let Ok(lowers) = head.factors(&z) {
            prop_assert_eq!(lowers.len(), 3 * z.len());
            prop_assert_eq!(z.len() % 3, 0);
            prop_assert!(lowers.iter().all(|entry| !entry.is_nan()));
        }
    }
}
