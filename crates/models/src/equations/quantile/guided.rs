//! Counts whose noise comes from a Gaussian, many at a time.

use super::count::LARGEST;
use super::near_normal::{NONE, NearNormal, boundary, counts_at, from_normal, log_probabilities};
use super::scaled_tail::log_mass;
use crate::batch::by_widest_vectors;

/// Gaussians `N(centre, scale⁻²)` of noise, and numbers `v` that are drawn from them, or from `N(0, 1)` where counts are to have their own distribution.
pub(in crate::equations) struct GuidedNoise<'a, const W: usize> {
    pub(in crate::equations) v: &'a [f64; W],
    pub(in crate::equations) centre: &'a [f64; W],
    pub(in crate::equations) scale: &'a [f64; W],
    pub(in crate::equations) is_from_prior: &'a [bool; W],
}

/// The counts that are drawn, what the Gaussians say of them, `log Q(n) − log p(n)` with `Q(n) = P(b_{n−1} < v ≤ b_n)`, and the most likely noise between these boundaries;
/// NaN where a parameter is out of range.
///
/// Boundaries are nearly those of the transport. Since `Q` is the Gaussian's mass between just these, it is exact; and a Gaussian that is `N(0, 1)` draws by the
/// transport itself, so that `Q` is `p`.
pub(in crate::equations) fn guided<C: NearNormal, const W: usize>(
    of: impl Fn(usize) -> C,
    noise: &GuidedNoise<'_, W>,
) -> [[f64; W]; 3] {
    let GuidedNoise { v, centre, scale, is_from_prior } = noise;
    let [mut counts, mut before, mut after] = by_widest_vectors(
        #[inline(always)]
        || counts_at(&of, v),
    );
    let is_flat = |i: usize| centre[i] == 0.0 && scale[i] == 1.0;
    for i in 0..W {
        if is_from_prior[i] || is_flat(i) {
            let family = of(i);
            let n = from_normal(family, v[i]);
            (counts[i], before[i], after[i]) = (n, boundary(family, n - 1.0), boundary(family, n));
        }
    }
    let [mut ratios, mut likely] = [[0.0; W]; 2];
    by_widest_vectors(
        #[inline(always)]
        || {
            let own = log_probabilities(&of, &counts);
            for i in 0..W {
                let family = of(i);
                let (before, after) = (before[i], after[i]);
                let mass = log_mass(scale[i] * (before - centre[i]), scale[i] * (after - centre[i]));
                let ratio = if is_flat(i) { 0.0 } else { mass - own[i] };
                let above = if centre[i] > before { centre[i] } else { before };
                let inside = if above < after { above } else { after };
                // Where there is but one count, nothing is said.
                let is_certain = family.fewest() < NONE;
                ratios[i] = if is_certain { 0.0 } else { ratio };
                likely[i] = if is_certain { centre[i] } else { inside };
                counts[i] = if is_certain { (family.moments()[0] + 0.5).floor() } else { counts[i] };
                let is_right = family.is_possible()
                    & (family.fewest() >= 0.0)
                    & (family.moments()[0] <= LARGEST)
                    & !(v[i].is_nan() | centre[i].is_nan() | scale[i].is_nan());
                let nothing = if is_right { 0.0 } else { f64::NAN };
                counts[i] += nothing;
                ratios[i] += nothing;
                likely[i] += nothing;
            }
        },
    );
    [counts, ratios, likely]
}

#[cfg(test)]
mod tests {
    use super::super::near_normal::{MANY, MARGIN};
    use super::*;
    use crate::equations::distribution::{Binomial, Poisson};
    use crate::equations::family::Family;
    use crate::equations::quantile::count::{self, Count};
    use crate::equations::quantile::normal;

    /// Drawn with one Gaussian at all of these numbers.
    fn at(counts: impl NearNormal, v: [f64; 4], [centre, scale]: [f64; 2]) -> [[f64; 4]; 3] {
        let noise =
            GuidedNoise { v: &v, centre: &[centre; 4], scale: &[scale; 4], is_from_prior: &[false; 4] };
        guided(|_| counts, &noise)
    }

    fn log_probability(counts: impl Count, n: f64) -> f64 {
        Family::log_density(counts, n, || crate::equations::Scalar::ln_gamma(n + 1.0))
    }

    /// Whatever the Gaussian is, it gives all counts together the mass 1, and each of them its share of the numbers that become it.
    fn check_masses(counts: impl NearNormal + std::fmt::Debug) {
        for gaussian in [[0.0, 1.0], [1.3, 4.0], [-2.0, 0.7], [0.1, 1.0], [4.0, 1.1]] {
            let (mut sum, mut last) = (0.0, -1.0);
            for v in (0..=7000).map(|i| -14.0 + 4e-3 * f64::from(i)) {
                let [[count, ..], [log_ratio, ..], _] = at(counts, [v; 4], gaussian);
                assert!(count >= last, "{counts:?}: {count} after {last}");
                if count > last {
                    sum += (log_ratio + log_probability(counts, count)).exp();
                    last = count;
                }
            }
            assert!((sum - 1.0).abs() < 1e-9, "{counts:?} by {gaussian:?}: {sum}");
        }
    }

    #[test]
    fn masses_of_all_counts_add_up_to_one() {
        for mean in [1e-3, 0.3, 1.0, 7.0, 40.0] {
            check_masses(Poisson { mean });
        }
        for (n, p) in [(1.0, 0.9), (1.0, 1e-4), (2.0, 0.5), (15.0, 0.2), (60.0, 0.97), (300.0, 1e-3)] {
            check_masses(Binomial { n, p });
        }
    }

    /// Catches a Gaussian whose numbers become other counts than its masses say.
    #[test]
    fn counts_are_those_between_whose_boundaries_the_noise_lies() {
        for mean in [0.2, 3.0, 55.0, 4e3, 2e7, 3e12] {
            let counts = Poisson { mean };
            for v in [-5.5, -0.7, 0.2, 3.9] {
                let [[n, ..], _, [likely, ..]] = at(counts, [v; 4], [v, 1e3]);
                let (before, after) = (boundary(counts, n - 1.0), boundary(counts, n));
                assert!(before < v && v <= after && likely == v, "{mean}, {v}: {n} from {before} to {after}");
            }
        }
    }

    /// Densities are differences of logarithms of factorials, of which rounding leaves fewer digits where counts are large.
    #[test]
    fn probabilities_are_the_densities() {
        for (n, p) in [(1.0, 0.3), (12.0, 0.5), (900.0, 0.01), (5e4, 0.3)] {
            let counts = Binomial { n, p };
            for k in [0.0, 1.0, 3.0, 9.0, 11.0, 13.0, 0.3 * n, n - 1.0, n].map(f64::floor) {
                if (0.0..=n).contains(&k) {
                    let [found] = log_probabilities(|_| counts, &[k]);
                    let right = log_probability(counts, k);
                    assert!(
                        (found - right).abs() < 1e-11 * (10.0 + k + right.abs()),
                        "{counts:?} at {k}: {found}, not {right}"
                    );
                }
            }
        }
        for mean in [1e-9, 0.4, 6.0, 300.0, 1e6] {
            for k in [0.0, 1.0, 2.0, 10.0, 11.0, 270.0, mean].map(f64::floor) {
                let [found] = log_probabilities(|_| Poisson { mean }, &[k]);
                let right = log_probability(Poisson { mean }, k);
                assert!(
                    (found - right).abs() < 1e-11 * (10.0 + k + right.abs()),
                    "{mean} at {k}: {found}, not {right}"
                );
            }
        }
    }

    /// Boundaries must grow with counts, also where the approximation is at its worst.
    #[test]
    fn boundaries_grow() {
        let check = |counts: &dyn Fn(f64) -> f64, last: f64| {
            let mut before = f64::NEG_INFINITY;
            for n in 0..2000 {
                let n = f64::from(n);
                if n >= last {
                    break;
                }
                let after = counts(n);
                assert!(after > before, "{n}: {after} after {before}");
                before = after;
            }
        };
        for mean in [1e-200, 1e-12, 1e-3, 0.1, 1.0, 3.0, 30.0, 1e3, 1e6] {
            check(&|n| boundary(Poisson { mean }, n), f64::INFINITY);
        }
        for n in [1.0, 2.0, 3.0, 4.0, 7.0, 20.0, 133.0, 1500.0] {
            for p in [1e-200, 1e-12, 1e-3, 0.1, 0.5, 0.8, 1.0 - 1e-3, 1.0 - 1e-12] {
                check(&|k| boundary(Binomial { n, p }, k), n);
            }
        }
    }

    /// The bound by which exact counts are told without their distribution function has a factor of two to spare.
    #[test]
    fn boundaries_are_nearly_exact_where_many_are_expected() {
        let check = |counts: &dyn Fn(f64) -> [f64; 2], at: [f64; 2]| {
            let [mean, sd] = at;
            for step in -60..=60 {
                let n = (mean + 0.1 * f64::from(step) * sd).floor();
                let [found, log_upper] = counts(n);
                let right = normal::from_log_upper(log_upper);
                assert!(
                    right.abs() > 6.5 || (found - right).abs() < 0.5 * MARGIN,
                    "{mean} at {n}: {found}, not {right}"
                );
            }
        };
        for mean in [MANY, 400.0, 1e4] {
            let counts = Poisson { mean };
            check(&|n| [boundary(counts, n), count::log_mass(counts, n, f64::INFINITY)], [mean, mean.sqrt()]);
        }
        for (few, p) in [(MANY, 1e-4_f64), (MANY, 0.1), (MANY, 0.5), (2e3, 0.02), (2e3, 0.4)] {
            for p in [p, 1.0 - p] {
                let counts = Binomial { n: (few / p.min(1.0 - p)).ceil(), p };
                let [mean, variance] = counts.moments();
                check(
                    &|n| [boundary(counts, n), count::log_mass(counts, n, f64::INFINITY)],
                    [mean, variance.sqrt()],
                );
            }
        }
    }

    #[test]
    fn what_is_certain_or_impossible_is_so() {
        let [counts, ratios, _] = at(Binomial { n: 7.0, p: 1.0 }, [-3.0, 0.0, 2.0, 9.0], [1.0, 2.0]);
        assert_eq!([counts, ratios], [[7.0; 4], [0.0; 4]]);
        let [counts, ratios, _] = at(Poisson { mean: 0.0 }, [3.0; 4], [1.0, 2.0]);
        assert_eq!([counts, ratios], [[0.0; 4], [0.0; 4]]);
        for wrong in
            [Binomial { n: 2.5, p: 0.5 }, Binomial { n: 3.0, p: 1.5 }, Binomial { n: 3.0, p: f64::NAN }]
        {
            assert!(
                at(wrong, [0.3; 4], [0.1, 2.0]).iter().flatten().all(|found| found.is_nan()),
                "{wrong:?}"
            );
        }
        for mean in [-1.0, f64::NAN, 1e17] {
            let found = at(Poisson { mean }, [0.3; 4], [0.1, 2.0]);
            assert!(found.iter().flatten().all(|found| found.is_nan()), "{mean}");
        }
    }

    /// A Gaussian that says nothing draws by the transport itself, and so do particles of their own distribution.
    #[test]
    fn the_noises_own_distribution_is_the_transport() {
        let v = [-2.5, -0.1, 0.4, 3.3];
        for mean in [0.7, 20.0, 150.0, 1e5] {
            let counts = Poisson { mean };
            let [found, ratios, _] = at(counts, v, [0.0, 1.0]);
            assert_eq!(found, v.map(|v| count::from_normal(counts, v)));
            assert_eq!(ratios, [0.0; 4]);
            let noise = GuidedNoise { v: &v, centre: &[0.3; 4], scale: &[2.0; 4], is_from_prior: &[true; 4] };
            assert_eq!(guided(|_| counts, &noise)[0], found);
        }
    }
}
