//! Numbers in the precision that was asked for.

use std::ops::{Add, AddAssign, Mul, MulAssign, Sub};

use serde::{Deserialize, Serialize};

use crate::precision::Precision;

/// Many numbers of one precision, one after another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Values {
    /// 32 bits each.
    F32(Vec<f32>),
    /// 64 bits each.
    F64(Vec<f64>),
}

impl Values {
    /// No numbers of the given precision.
    pub fn none(precision: Precision) -> Self {
        match precision {
            Precision::F32 => Values::F32(Vec::new()),
            Precision::F64 => Values::F64(Vec::new()),
        }
    }

    /// `len` zeros in the precision of `self`.
    #[must_use]
    pub fn zeros_like(&self, len: usize) -> Self {
        match self {
            Values::F32(_) => Values::F32(vec![0.0; len]),
            Values::F64(_) => Values::F64(vec![0.0; len]),
        }
    }

    /// How many numbers there are.
    pub fn len(&self) -> usize {
        match self {
            Values::F32(values) => values.len(),
            Values::F64(values) => values.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether none is NaN or infinite.
    pub fn are_finite(&self) -> bool {
        match self {
            Values::F32(values) => values.iter().all(|value| value.is_finite()),
            Values::F64(values) => values.iter().all(|value| value.is_finite()),
        }
    }

    /// Copies of some of them in 64 bits.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn host(&self, range: std::ops::Range<usize>) -> Vec<f64> {
        match self {
            Values::F32(values) => values[range].iter().map(|&value| f64::from(value)).collect(),
            Values::F64(values) => values[range].to_vec(),
        }
    }

    /// All of them, to be changed.
    pub fn as_slice_mut(&mut self) -> SliceMut<'_> {
        match self {
            Values::F32(values) => SliceMut::F32(values),
            Values::F64(values) => SliceMut::F64(values),
        }
    }

    /// Moves by `share` of the way towards other values of the same precision and number; others change nothing.
    pub fn approach(&mut self, others: &Values, share: f64) {
        fn approach<T: Real>(values: &mut [T], others: &[T], share: T) {
            values.iter_mut().zip(others).for_each(|(value, other)| *value += share * (*other - *value));
        }
        match (self, others) {
            (Values::F32(values), Values::F32(others)) => approach(values, others, share as f32),
            (Values::F64(values), Values::F64(others)) => approach(values, others, share),
            _ => {}
        }
    }

    /// Multiplies row `r` of a matrix that lies in `range` by factor `r mod H`.
    pub(crate) fn scale_rows(&mut self, range: std::ops::Range<usize>, columns: usize, factors: &[f64]) {
        fn scale<T: Real>(values: &mut [T], columns: usize, factors: &[f64]) {
            let rows = values.chunks_exact_mut(columns.max(1));
            for (row, factor) in rows.zip(factors.iter().cycle()) {
                row.iter_mut().for_each(|value| *value *= T::of(*factor));
            }
        }
        match self {
            Values::F32(values) => scale(&mut values[range], columns, factors),
            Values::F64(values) => scale(&mut values[range], columns, factors),
        }
    }

    pub(crate) fn push_all(&mut self, more: &[f64]) {
        match self {
            Values::F32(values) => values.extend(more.iter().map(|&value| value as f32)),
            Values::F64(values) => values.extend_from_slice(more),
        }
    }

    pub(crate) fn set(&mut self, from: usize, new: &[f64]) {
        match self {
            Values::F32(values) => narrow(new, &mut values[from..from + new.len()]),
            Values::F64(values) => narrow(new, &mut values[from..from + new.len()]),
        }
    }
}

/// Some numbers of one precision, one after another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Slice<'a> {
    /// 32 bits each.
    F32(&'a [f32]),
    /// 64 bits each.
    F64(&'a [f64]),
}

/// Some numbers of one precision, one after another, to be changed.
#[derive(Debug, PartialEq)]
pub enum SliceMut<'a> {
    /// 32 bits each.
    F32(&'a mut [f32]),
    /// 64 bits each.
    F64(&'a mut [f64]),
}

impl<'a> SliceMut<'a> {
    /// How many numbers there are.
    pub fn len(&self) -> usize {
        match self {
            SliceMut::F32(values) => values.len(),
            SliceMut::F64(values) => values.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// In which precision they are.
    pub fn precision(&self) -> Precision {
        match self {
            SliceMut::F32(_) => Precision::F32,
            SliceMut::F64(_) => Precision::F64,
        }
    }

    /// The first `count` numbers, and the others.
    ///
    /// # Panics
    /// If there are fewer.
    #[must_use]
    pub fn split(self, count: usize) -> [SliceMut<'a>; 2] {
        match self {
            SliceMut::F32(values) => {
                let (first, others) = values.split_at_mut(count);
                [SliceMut::F32(first), SliceMut::F32(others)]
            }
            SliceMut::F64(values) => {
                let (first, others) = values.split_at_mut(count);
                [SliceMut::F64(first), SliceMut::F64(others)]
            }
        }
    }
}

/// The same numbers in either precision.
pub(crate) struct Both {
    narrow: Vec<f32>,
    wide: Vec<f64>,
}

impl Both {
    pub(crate) fn of(values: impl Iterator<Item = f64>) -> Self {
        let wide: Vec<f64> = values.collect();
        Both { narrow: wide.iter().map(|&value| value as f32).collect(), wide }
    }
}

/// Rounds each number to the precision of `into`.
pub(crate) fn narrow<T: Real>(values: &[f64], into: &mut [T]) {
    into.iter_mut().zip(values).for_each(|(into, &value)| *into = T::of(value));
}

/// Widens each number to 64 bits.
pub(crate) fn widen<T: Real>(values: &[T], into: &mut [f64]) {
    into.iter_mut().zip(values).for_each(|(into, &value)| *into = value.wide());
}

/// A floating-point type that networks are computed in.
pub(crate) trait Real:
    faer::traits::RealField
    + Copy
    + Default
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + AddAssign
    + MulAssign
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// ½.
    const HALF: Self;
    /// 1.
    const ONE: Self;

    /// Rounds to this type.
    fn of(value: f64) -> Self;

    /// Exact, in 64 bits.
    fn wide(self) -> f64;

    /// The hyperbolic tangent; written so that a loop over it becomes vector instructions where that pays.
    fn tanh(self) -> Self;

    /// The numbers, which are of this type.
    fn slice(values: &Values) -> &[Self];

    /// The numbers, which are of this type, to be changed.
    fn slice_mut(values: &mut Values) -> &mut Vec<Self>;

    /// The numbers, which are of this type.
    fn pick_mut<'a>(values: &'a mut SliceMut<'_>) -> &'a mut [Self];

    /// The numbers, whatever their type.
    fn wrap_slice(values: &[Self]) -> Slice<'_>;

    /// The numbers in this type.
    fn pick(values: &Both) -> &[Self];
}

/// `σ(a) = (1 + tanh(a/2)) / 2`.
#[inline(always)]
pub(crate) fn sigmoid<T: Real>(a: T) -> T {
    T::HALF * (T::HALF * a).tanh() + T::HALF
}

const MIXED: &str = "one proposal computes in one precision";

impl Real for f64 {
    const ZERO: f64 = 0.0;
    const HALF: f64 = 0.5;
    const ONE: f64 = 1.0;

    #[inline(always)]
    fn of(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }

    #[inline(always)]
    fn tanh(self) -> f64 {
        f64::tanh(self)
    }

    fn slice(values: &Values) -> &[f64] {
        match values {
            Values::F64(values) => values,
            Values::F32(_) => panic!("{MIXED}"),
        }
    }

    fn slice_mut(values: &mut Values) -> &mut Vec<f64> {
        match values {
            Values::F64(values) => values,
            Values::F32(_) => panic!("{MIXED}"),
        }
    }

    fn pick_mut<'a>(values: &'a mut SliceMut<'_>) -> &'a mut [f64] {
        match values {
            SliceMut::F64(values) => values,
            SliceMut::F32(_) => panic!("{MIXED}"),
        }
    }

    fn wrap_slice(values: &[f64]) -> Slice<'_> {
        Slice::F64(values)
    }

    fn pick(values: &Both) -> &[f64] {
        &values.wide
    }
}

impl Real for f32 {
    const ZERO: f32 = 0.0;
    const HALF: f32 = 0.5;
    const ONE: f32 = 1.0;

    #[inline(always)]
    fn of(value: f64) -> f32 {
        value as f32
    }

    #[inline(always)]
    fn wide(self) -> f64 {
        f64::from(self)
    }

    /// `tanh a = p/q` by the continued fraction of Lambert at `a/8`, and `tanh 2a = 2pq / (p² + q²)` three times: one division, no
    /// branch, and no step magnifies a relative error.
    #[inline(always)]
    fn tanh(self) -> f32 {
        // Beyond this the nearest number is ±1. NaN stays NaN.
        let a = self.clamp(-9.5, 9.5) * 0.125;
        let s = a * a;
        let mut p = a * (1.0 + s * (5.0 / 39.0 + s * (2.0 / 715.0 + s * (1.0 / 135_135.0))));
        let mut q = 1.0 + s * (6.0 / 13.0 + s * (10.0 / 429.0 + s * (4.0 / 19_305.0)));
        for _ in 0..2 {
            (p, q) = (2.0 * p * q, p * p + q * q);
        }
        (2.0 * p * q / (p * p + q * q)).clamp(-1.0, 1.0)
    }

    fn slice(values: &Values) -> &[f32] {
        match values {
            Values::F32(values) => values,
            Values::F64(_) => panic!("{MIXED}"),
        }
    }

    fn slice_mut(values: &mut Values) -> &mut Vec<f32> {
        match values {
            Values::F32(values) => values,
            Values::F64(_) => panic!("{MIXED}"),
        }
    }

    fn pick_mut<'a>(values: &'a mut SliceMut<'_>) -> &'a mut [f32] {
        match values {
            SliceMut::F32(values) => values,
            SliceMut::F64(_) => panic!("{MIXED}"),
        }
    }

    fn wrap_slice(values: &[f32]) -> Slice<'_> {
        Slice::F32(values)
    }

    fn pick(values: &Both) -> &[f32] {
        &values.narrow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units of rounding that the formula can lose: 4 in `p/q`, 3 in each of two doublings, 4 in the last with its division, none of
    /// which a later one magnifies.
    const ROUNDINGS: f64 = 14.0 * 0.5 * f32::EPSILON as f64;

    #[test]
    fn the_narrow_hyperbolic_tangent_is_that_of_64_bits_but_for_rounding() {
        for i in -120_000..=120_000 {
            let a = i as f32 * 1e-4;
            let (found, expected) = (f64::from(Real::tanh(a)), f64::from(a).tanh());
            assert!((found - expected).abs() <= ROUNDINGS * expected.abs(), "{a}: {found} for {expected}");
            assert!(found.abs() <= 1.0, "{a}: {found}");
        }
        for a in [1e-30_f32, -1e-30, 1e-10, 0.0, 1e30, f32::INFINITY, f32::NEG_INFINITY] {
            let (found, expected) = (f64::from(Real::tanh(a)), f64::from(a).tanh());
            assert!((found - expected).abs() <= ROUNDINGS * expected.abs(), "{a}: {found} for {expected}");
        }
        assert!(Real::tanh(f32::NAN).is_nan());
    }
}
