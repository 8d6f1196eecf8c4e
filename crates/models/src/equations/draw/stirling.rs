//! What logarithms of factorials are beyond Stirling's formula.

/// So many small counts are looked up.
const KNOWN: usize = 10;

/// [`beyond_stirling`] of the counts 0, 1, 2, …
const FIRST: [f64; KNOWN] = [
    0.081_061_466_795_327_26,
    0.041_340_695_955_409_29,
    0.027_677_925_684_998_34,
    0.020_790_672_103_765_09,
    0.016_644_691_189_821_19,
    0.013_876_128_823_070_75,
    0.011_896_709_945_891_77,
    0.010_411_265_261_972_096,
    0.009_255_462_182_712_733,
    0.008_330_563_433_362_87,
];

/// `log k!` less `(k + ½) log(k + 1) − (k + 1) + ½ log 2π`, of a count.
#[inline(always)]
pub(super) fn beyond_stirling(k: f64) -> f64 {
    // From ten on the series has all digits.
    if let Some(known) = FIRST.get(k as usize) {
        return *known;
    }
    of_large(1.0 / (k + 1.0))
}

/// [`beyond_stirling`] of many counts; of −1 it is any number.
#[inline(always)]
pub(in crate::equations) fn beyond_stirling_of_all<const W: usize>(counts: &[f64; W]) -> [f64; W] {
    let mut found = [0.0; W];
    for (found, k) in found.iter_mut().zip(counts) {
        *found = of_large(1.0 / (k.max(0.0) + 1.0));
    }
    for (found, k) in found.iter_mut().zip(counts) {
        if let Some(known) = FIRST.get(*k as usize) {
            *found = *known;
        }
    }
    found
}

/// The same of a count from ten on, given `1/(k + 1)`.
#[inline(always)]
pub(super) fn of_large(inverse: f64) -> f64 {
    let square = inverse * inverse;
    (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square * (1.0 / 1680.0)))) * inverse
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Against sums of logarithms.
    #[test]
    fn factorials_are_products() {
        let mut log_factorial = 0.0;
        for k in 0..60 {
            let k = f64::from(k);
            log_factorial += if k > 0.0 { k.ln() } else { 0.0 };
            let formula = (k + 0.5) * (k + 1.0).ln() - (k + 1.0) + 0.5 * (2.0 * PI).ln();
            assert!((beyond_stirling(k) - (log_factorial - formula)).abs() < 1e-12, "{k}");
        }
    }
}
