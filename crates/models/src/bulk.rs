//! Random bits in bulk: many generators side by side, and what turns bits into numbers of a distribution.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};
use rand::Rng;

use crate::Stream;

/// Generators side by side.
const GENERATORS: usize = 8;
/// Numbers that all generators together give at a time.
const BATCH: usize = 128;
/// What is taken from the stream itself is a multiple of this many numbers.
const GROUP: usize = 16;
/// Up to so many numbers come from the stream itself: more take no more of it than these do.
const SHORT: usize = 4 * GENERATORS;

/// Turns uniform bits into pairs of independent numbers of a distribution.
pub(crate) trait Transform {
    /// Makes `x[i]` and `y[i]` of the uniform `a[i]` and `b[i]`, for each `i`, without a branch.
    fn pairs<const L: usize>(a: &[u64; L], b: &[u64; L], x: &mut [f64; L], y: &mut [f64; L]);
}

/// Fills `out` with independent numbers.
///
/// Up to 32 numbers, rounded up to 16 or 32, take 8 bytes of the stream each. More numbers take 256 bytes together, whatever
/// their count. These bytes are the states of eight xoshiro256++ generators. ChaCha decides where they start, and their
/// period of `2²⁵⁶ − 1` keeps them apart.
pub(crate) fn fill<T: Transform>(stream: &mut Stream, out: &mut [f64]) {
    pulp::Arch::new().dispatch(Fill::<T> { stream, out, transform: PhantomData });
}

struct Fill<'a, T> {
    stream: &'a mut Stream,
    out: &'a mut [f64],
    transform: PhantomData<T>,
}

impl<T: Transform> WithSimd for Fill<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let mut bits = [0; BATCH];
        if self.out.len() <= SHORT {
            for out in self.out.chunks_mut(GROUP) {
                let (bits, _) = bits.split_at_mut(GROUP);
                bits.fill_with(|| self.stream.next_u64());
                group::<T>(bits, out);
            }
            return;
        }
        let mut generators = Generators::seeded(self.stream);
        let (batches, rest) = self.out.as_chunks_mut::<BATCH>();
        for out in batches {
            generators.next(&mut bits);
            pairs::<T, { BATCH / 2 }>(&bits, out);
        }
        if !rest.is_empty() {
            generators.next(&mut bits);
            for (bits, out) in bits.chunks_exact(GROUP).zip(rest.chunks_mut(GROUP)) {
                group::<T>(bits, out);
            }
        }
    }
}

/// Fills up to sixteen places.
#[inline(always)]
fn group<T: Transform>(bits: &[u64], out: &mut [f64]) {
    match out.as_mut_array::<GROUP>() {
        Some(out) => pairs::<T, { GROUP / 2 }>(bits, out),
        None => {
            let mut all = [0.0; GROUP];
            pairs::<T, { GROUP / 2 }>(bits, &mut all);
            out.copy_from_slice(&all[..out.len()]);
        }
    }
}

/// The first half of the bits with the second, into the first half of the places and the second.
#[inline(always)]
fn pairs<T: Transform, const L: usize>(bits: &[u64], out: &mut [f64]) {
    let ((a, b), (x, y)) = (bits.split_at(L), out.split_at_mut(L));
    if let (Some(a), Some(b), Some(x), Some(y)) =
        (a.as_array(), b.as_array(), x.as_mut_array(), y.as_mut_array())
    {
        T::pairs::<L>(a, b, x, y);
    }
}

/// Eight xoshiro256++ generators of Blackman and Vigna (2021), word by word of their states.
struct Generators([[u64; GENERATORS]; 4]);

impl Generators {
    /// Starts them where the next 256 bytes of the stream say, one after the other.
    #[inline(always)]
    fn seeded(stream: &mut Stream) -> Self {
        let mut words = [[0; GENERATORS]; 4];
        for generator in 0..GENERATORS {
            for word in &mut words {
                word[generator] = stream.next_u64();
            }
        }
        Generators(words)
    }

    /// The next sixteen numbers of each, interleaved.
    #[inline(always)]
    fn next(&mut self, out: &mut [u64; BATCH]) {
        let [a, b, c, d] = &mut self.0;
        for i in 0..GENERATORS {
            let mut state = [a[i], b[i], c[i], d[i]];
            let mut at = i;
            // Written out, because only a loop without a loop inside becomes vector instructions.
            four(&mut state, out, &mut at);
            four(&mut state, out, &mut at);
            four(&mut state, out, &mut at);
            four(&mut state, out, &mut at);
            [a[i], b[i], c[i], d[i]] = state;
        }
    }
}

/// Four numbers of one generator, into every eighth place.
#[inline(always)]
fn four(state: &mut [u64; 4], out: &mut [u64; BATCH], at: &mut usize) {
    out[*at] = next(state);
    out[*at + GENERATORS] = next(state);
    out[*at + 2 * GENERATORS] = next(state);
    out[*at + 3 * GENERATORS] = next(state);
    *at += 4 * GENERATORS;
}

/// The next number of xoshiro256++.
#[inline(always)]
fn next(state: &mut [u64; 4]) -> u64 {
    let result = state[0].wrapping_add(state[3]).rotate_left(23).wrapping_add(state[0]);
    let shifted = state[1] << 17;
    state[2] ^= state[0];
    state[3] ^= state[1];
    state[1] ^= state[2];
    state[0] ^= state[3];
    state[2] ^= shifted;
    state[3] = state[3].rotate_left(45);
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn a_generator_is_the_published_one() {
        // The numbers that the authors' implementation in C gives from the state 1, 2, 3, 4.
        let expected = [
            41_943_041,
            58_720_359,
            3_588_806_011_781_223,
            3_591_011_842_654_386,
            9_228_616_714_210_784_205,
            9_973_669_472_204_895_162,
            14_011_001_112_246_962_877,
            12_406_186_145_184_390_807,
            15_849_039_046_786_891_736,
            10_450_023_813_501_588_000,
        ];
        let mut state = [1, 2, 3, 4];
        assert_eq!(expected.map(|_| next(&mut state)), expected);
    }

    #[test]
    fn generators_side_by_side_are_generators_alone() {
        let (mut stream, mut same) = (Stream::from_seed([9; 32]), Stream::from_seed([9; 32]));
        let mut together = Generators::seeded(&mut stream);
        let mut alone: [[u64; 4]; GENERATORS] = Default::default();
        alone.as_flattened_mut().fill_with(|| same.next_u64());
        let mut bits = [0; BATCH];
        for _ in 0..3 {
            together.next(&mut bits);
            for numbers in bits.chunks_exact(GENERATORS) {
                for (number, state) in numbers.iter().zip(&mut alone) {
                    assert_eq!(*number, next(state));
                }
            }
        }
        assert_eq!(stream.next_u64(), same.next_u64());
    }

    /// Everything that a distribution is made of.
    struct PairTransform;

    impl Transform for PairTransform {
        #[inline(always)]
        fn pairs<const L: usize>(a: &[u64; L], b: &[u64; L], x: &mut [f64; L], y: &mut [f64; L]) {
            for i in 0..L {
                (x[i], y[i]) = crate::elementary::sin_cos(a[i] as f64 * 2.0_f64.powi(-65));
                y[i] = crate::elementary::ln(((b[i] >> 11) + 1) as f64).mul_add(x[i], y[i]);
            }
        }
    }

    #[test]
    fn numbers_do_not_depend_on_the_machines_vectors() {
        for count in [1, 20, 40, 128, 1000] {
            let (mut narrow, mut wide) = (vec![0.0; count], vec![0.0; count]);
            let mut streams = [Stream::from_seed([5; 32]), Stream::from_seed([5; 32])];
            let [first, second] = &mut streams;
            fill::<PairTransform>(first, &mut wide);
            let op = Fill::<PairTransform> { stream: second, out: &mut narrow, transform: PhantomData };
            pulp::Scalar::new().vectorize(op);
            assert_eq!(narrow, wide);
        }
    }
}
