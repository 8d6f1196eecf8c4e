//! The tail index of importance weights.

use motes_models::elementary::ln_1p;
use pulp::{Simd, WithSimd};

/// The tail index from which on averages by weights are not to be trusted: the number of particles that they need then grows beyond any
/// use (Vehtari, Simpson, Gelman, Yao and Gabry 2024, whose limit of `S` weights is `min(1 − 1/log₁₀ S, 0.7)`).
pub const PARETO_K_LIMIT: f64 = 0.7;

/// As few large weights as a distribution is fitted to.
const LEAST_TAIL: usize = 5;

/// The index `k̂` of the generalised Pareto distribution that fits the largest of the weights `exp(log_weights)` best.
///
/// Weights whose tail has the index `k` have moments up to `1/k`: above ½ no variance, above 1 no mean. A proposal narrower than what
/// it is to cover shows here, while an effective sample size may look fine by chance. It is the index of the tail as far as it was
/// seen: bounded weights, as those of likelihoods are, can have a large one too while few particles come near the bound, and averages
/// are as poor then.
///
/// Of `S` weights the largest `min(S/5, 3√S)` are taken. The estimate is Zhang's and Stephens's (2009), drawn towards ½ as by ten
/// weights more, as in Pareto-smoothed importance sampling. Weights need not be normalised.
///
/// Where weights are so far apart that all but a few of the largest vanish beside the first, Hill's estimate stands in, the mean of their
/// logarithms above those of the others, which is large then. `None` of fewer than 25 weights, and where fewer than five of the largest exceed
/// the others: there is no tail. Copies of a particle that was resampled have the same weight, and count as one.
///
/// ```
/// use motes_smc::pareto_k;
///
/// // Weights with survival function w^(−1/k) have the index k.
/// let weights = |k: f64| (1..=10_000).map(|i| -k * (i as f64 / 10_000.5).ln()).collect::<Vec<f64>>();
/// assert!((pareto_k(&weights(0.3)).unwrap() - 0.3).abs() < 0.1);
/// assert!((pareto_k(&weights(1.2)).unwrap() - 1.2).abs() < 0.1);
/// assert_eq!(pareto_k(&[0.0; 100]), None);
/// ```
pub fn pareto_k(log_weights: &[f64]) -> Option<f64> {
    tail_within(&mut log_weights.to_vec()).map(|tail| tail.index)
}

/// The index of a tail, and how many distinct weights it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tail {
    pub(crate) index: f64,
    pub(crate) weights: usize,
}

impl Tail {
    /// The standard error of the index, `(1 + k)/√n` of `n` weights, drawn towards ½ as the index is.
    pub(super) fn error(&self) -> f64 {
        let n = self.weights as f64;
        (1.0 + self.index) / n.sqrt() * n / (n + 10.0)
    }
}

/// How many of the largest of so many weights a distribution is fitted to, `min(S/5, 3√S)`.
pub(crate) fn tail_length(weights: usize) -> usize {
    (weights as f64 / 5.0).min(3.0 * (weights as f64).sqrt()) as usize
}

/// [`pareto_k`], which leaves the weights in another order: the largest [`tail_length`] of them at the end, sorted, where there are five at least.
pub(crate) fn tail_within(log: &mut [f64]) -> Option<Tail> {
    let count = tail_length(log.len());
    if count < LEAST_TAIL {
        return None;
    }
    // The weight that the largest `count` are held against, and behind it these.
    let (_, &mut threshold, tail) = log.select_nth_unstable_by(log.len() - count - 1, f64::total_cmp);
    tail.sort_unstable_by(f64::total_cmp);
    let mut distinct: Vec<f64> = tail.iter().copied().filter(|log| *log > threshold).collect();
    distinct.dedup();
    if distinct.len() < LEAST_TAIL {
        return None;
    }
    let largest = distinct[distinct.len() - 1];
    let least = (threshold - largest).exp();
    let mut exceedances: Vec<f64> = distinct.iter().map(|log| (log - largest).exp() - least).collect();
    exceedances.retain(|excess| *excess > 0.0);
    let fitted = if exceedances.len() < LEAST_TAIL { None } else { pareto_index(&exceedances) };
    let index = fitted.or_else(|| Some(hill(&distinct, threshold)).filter(|index| index.is_finite()))?;
    Some(Tail { index, weights: distinct.len() })
}

/// Hill's estimate: the mean of logarithms above a threshold, or above the least of them that is of no zero where the threshold is.
fn hill(tail: &[f64], threshold: f64) -> f64 {
    let positive = || tail.iter().filter(|log| **log > f64::NEG_INFINITY);
    let (threshold, count) = match threshold {
        f64::NEG_INFINITY => {
            (positive().copied().fold(f64::INFINITY, f64::min), positive().count().saturating_sub(1))
        }
        _ => (threshold, tail.len()),
    };
    positive().map(|log| log - threshold).sum::<f64>() / count as f64
}

/// The index of the generalised Pareto distribution of sorted, positive values.
///
/// With `θ = −k/σ` the likelihood has `k(θ) = mean log(1 − θ x)` as its best index; `θ` is averaged over a grid by its profile likelihood.
fn pareto_index(x: &[f64]) -> Option<f64> {
    let n = x.len() as f64;
    let (quartile, largest) = (x[(n / 4.0 + 0.5) as usize - 1], x[x.len() - 1]);
    let points = 30 + n.sqrt() as usize;
    let thetas: Vec<f64> = (1..=points)
        .map(|j| 1.0 / largest + (1.0 - (points as f64 / (j as f64 - 0.5)).sqrt()) / (3.0 * quartile))
        .collect();
    let grid: Vec<(f64, f64)> = thetas
        .iter()
        .zip(sums_of_logs(&thetas, x))
        .map(|(theta, sum)| {
            let k = sum / n;
            (*theta, n * ((-theta / k).ln() - k - 1.0))
        })
        .filter(|(theta, log_likelihood)| *theta != 0.0 && log_likelihood.is_finite())
        .collect();
    let best = grid.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
    let whole: f64 = grid.iter().map(|(_, log)| (log - best).exp()).sum();
    let theta = grid.iter().map(|(theta, log)| theta * (log - best).exp()).sum::<f64>() / whole;
    let index = sums_of_logs(&[theta], x)[0] / n;
    let k = (n * index + 10.0 * 0.5) / (n + 10.0);
    k.is_finite().then_some(k)
}

/// For each `θ` the sum of `log(1 − θ x)`, in the order of `x`.
fn sums_of_logs(thetas: &[f64], x: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; thetas.len()];
    pulp::Arch::new().dispatch(SumsOfLogs { thetas, x, sums: &mut sums });
    sums
}

struct SumsOfLogs<'a> {
    thetas: &'a [f64],
    x: &'a [f64],
    sums: &'a mut [f64],
}

/// Values of `θ` side by side.
const LANES: usize = 8;

impl WithSimd for SumsOfLogs<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        for (thetas, sums) in self.thetas.chunks(LANES).zip(self.sums.chunks_mut(LANES)) {
            let (mut negative, mut all) = ([0.0; LANES], [0.0; LANES]);
            for (negative, theta) in negative.iter_mut().zip(thetas) {
                *negative = -theta;
            }
            for x in self.x {
                for i in 0..LANES {
                    all[i] += ln_1p(negative[i] * x);
                }
            }
            sums.copy_from_slice(&all[..sums.len()]);
        }
    }
}

#[cfg(test)]
mod tests {
    use motes_models::{Seed, fill_standard_normal, fill_uniform};

    use super::*;

    #[test]
    fn the_index_of_pareto_weights_is_found() {
        let mut uniform = vec![0.0; 20_000];
        for k in [-0.5, 0.1, 0.5, 0.9, 1.5] {
            fill_uniform(&mut Seed::from_u64(60).stream(), &mut uniform);
            let weights: Vec<f64> =
                uniform.iter().map(|u| ((1.0 - u).powf(-k) - 1.0).abs() / f64::abs(k)).map(f64::ln).collect();
            let found = pareto_k(&weights).unwrap();
            // 424 weights: a standard error of (1 + k)/√424.
            assert!((found - k).abs() < 4.0 * (1.0 + k) / 424.0_f64.sqrt(), "{found} for {k}");
        }
    }

    #[test]
    fn a_gaussian_that_is_too_narrow_has_the_index_that_theory_gives() {
        // Weights exp(−x²/2 + x²/(2v)) under N(0, v): survival w^(−1/k) with k = 1 − v, up to logarithms.
        let mut normals = vec![0.0; 1_000_000];
        fill_standard_normal(&mut Seed::from_u64(61).stream(), &mut normals);
        for (variance, low, high) in [(0.2, 0.65, 0.85), (0.9, -0.2, 0.15), (2.0, f64::NEG_INFINITY, 0.1)] {
            let weights: Vec<f64> = normals.iter().map(|z: &f64| 0.5 * z * z * (1.0 - variance)).collect();
            let found = pareto_k(&weights).unwrap();
            assert!((low..high).contains(&found), "{found} for the variance {variance}");
        }
    }

    #[test]
    fn a_shift_changes_nothing_and_what_has_no_tail_has_no_index() {
        let weights: Vec<f64> = (1..200).map(|i| -0.8 * (f64::from(i) / 200.0).ln()).collect();
        let shifted: Vec<f64> = weights.iter().map(|log| log - 1e5).collect();
        let (found, again) = (pareto_k(&weights).unwrap(), pareto_k(&shifted).unwrap());
        assert!((found - again).abs() < 1e-6);
        assert_eq!(pareto_k(&weights[..24]), None);
        assert!(pareto_k(&weights[..25]).is_some());
        let one: Vec<f64> = (0..100).map(|i| if i == 7 { 0.0 } else { -1e4 }).collect();
        assert_eq!(pareto_k(&one), None, "the others are equal");
        assert_eq!(pareto_k(&[3.0; 100]), None);
        assert_eq!(pareto_k(&[f64::NEG_INFINITY; 100]), None);
        assert_eq!(pareto_k(&[f64::NAN; 100]), None);
    }

    #[test]
    fn weights_of_zero_hide_no_tail() {
        let of = |count: u32| -> Vec<f64> {
            (0..100).map(|i| if i < count { -1000.0 * f64::from(i) } else { f64::NEG_INFINITY }).collect()
        };
        // Fifteen weights above zero: the mean of 1000 to 14000.
        assert!((pareto_k(&of(15)).unwrap() - 7500.0).abs() < 1e-9);
        assert!(pareto_k(&of(30)).is_some_and(|index| index > 3.0));
        assert_eq!(pareto_k(&of(4)), None);
    }

    #[test]
    fn weights_too_far_apart_for_floating_point_have_a_large_index() {
        let mut normals = vec![0.0; 1000];
        for seed in 0..50 {
            fill_standard_normal(&mut Seed::from_u64(62).nth(seed).stream(), &mut normals);
            for deviation in [30.0, 300.0, 1e3, 1e5] {
                let weights: Vec<f64> = normals.iter().map(|z| deviation * z).collect();
                let found = pareto_k(&weights);
                assert!(found.is_some_and(|index| index > 3.0), "{found:?} for the deviation {deviation}");
            }
        }
    }
}
