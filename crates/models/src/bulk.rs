//! Random bits in bulk: many ChaCha blocks side by side, and what turns bits into numbers of a distribution.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};
use rand::Rng;

use crate::Stream;

/// 64-bit numbers in one batch of blocks.
const BATCH: usize = 128;
/// What is taken from the stream itself is a multiple of this many 64-bit numbers.
const GROUP: usize = 16;
/// Up to so many numbers come from the stream itself: for fewer, a batch would cost more than it gives.
const SHORT: usize = 2 * GROUP;

/// Turns uniform bits into pairs of independent numbers of a distribution.
pub(crate) trait Transform {
    /// Makes `x[i]` and `y[i]` of `a[i]` and `b[i]`, for each `i`, without a branch.
    fn pairs<const L: usize>(a: Bits<'_, L>, b: Bits<'_, L>, x: &mut [f64; L], y: &mut [f64; L]);
}

/// Uniform 64-bit numbers, as they come out of ChaCha: in halves that lie apart.
#[derive(Clone, Copy)]
pub(crate) struct Bits<'a, const L: usize> {
    pub(crate) low: &'a [u32; L],
    pub(crate) high: &'a [u32; L],
}

impl<const L: usize> Bits<'_, L> {
    #[inline(always)]
    pub(crate) fn at(&self, i: usize) -> u64 {
        u64::from(self.low[i]) | u64::from(self.high[i]) << 32
    }
}

/// Fills `out` with independent numbers.
///
/// Up to 32 numbers, rounded up to 16 or 32, take 8 bytes of the stream each. More take 32 bytes together, which are
/// the key of a ChaCha8 keystream of their own: sixteen of its blocks are computed side by side.
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
        let (mut low, mut high) = ([0; BATCH], [0; BATCH]);
        if self.out.len() <= SHORT {
            for out in self.out.chunks_mut(GROUP) {
                for i in 0..GROUP {
                    (low[i], high[i]) = (self.stream.next_u32(), self.stream.next_u32());
                }
                group::<T>(&low[..GROUP], &high[..GROUP], out);
            }
            return;
        }
        let mut key = [0; 8];
        key.fill_with(|| self.stream.next_u32());
        let mut counter = 0;
        let (batches, rest) = self.out.as_chunks_mut::<BATCH>();
        for out in batches {
            keystream(&key, &mut counter, &mut low, &mut high);
            pairs::<T, { BATCH / 2 }>(&low, &high, out);
        }
        if !rest.is_empty() {
            keystream(&key, &mut counter, &mut low, &mut high);
            for (i, out) in rest.chunks_mut(GROUP).enumerate() {
                let at = i * GROUP..(i + 1) * GROUP;
                group::<T>(&low[at.clone()], &high[at], out);
            }
        }
    }
}

/// Fills up to sixteen places.
#[inline(always)]
fn group<T: Transform>(low: &[u32], high: &[u32], out: &mut [f64]) {
    match out.as_mut_array::<GROUP>() {
        Some(out) => pairs::<T, { GROUP / 2 }>(low, high, out),
        None => {
            let mut all = [0.0; GROUP];
            pairs::<T, { GROUP / 2 }>(low, high, &mut all);
            out.copy_from_slice(&all[..out.len()]);
        }
    }
}

/// The first half of the bits with the second, into the first half of the places and the second.
#[inline(always)]
fn pairs<T: Transform, const L: usize>(low: &[u32], high: &[u32], out: &mut [f64]) {
    let bits = |from: usize| {
        let at = from..from + L;
        Some(Bits::<L> { low: low[at.clone()].as_array()?, high: high[at].as_array()? })
    };
    let (x, y) = out.split_at_mut(L);
    if let (Some(a), Some(b), Some(x), Some(y)) = (bits(0), bits(L), x.as_mut_array(), y.as_mut_array()) {
        T::pairs::<L>(a, b, x, y);
    }
}

/// The next sixteen blocks of the ChaCha8 keystream with this key and nonce 0.
///
/// Block follows block in the lanes, so the numbers are those of the keystream in another order.
#[inline(always)]
fn keystream(key: &[u32; 8], counter: &mut u64, low: &mut [u32; BATCH], high: &mut [u32; BATCH]) {
    const LANES: usize = BATCH / 8;
    for lane in 0..LANES {
        let block = counter.wrapping_add(lane as u64);
        let start = [
            0x6170_7865,
            0x3320_646e,
            0x7962_2d32,
            0x6b20_6574,
            key[0],
            key[1],
            key[2],
            key[3],
            key[4],
            key[5],
            key[6],
            key[7],
            block as u32,
            (block >> 32) as u32,
            0,
            0,
        ];
        let mut words = start;
        // Written out, because only a loop without a loop inside becomes vector instructions.
        double_round(&mut words);
        double_round(&mut words);
        double_round(&mut words);
        double_round(&mut words);
        for pair in 0..8 {
            low[pair * LANES + lane] = words[2 * pair].wrapping_add(start[2 * pair]);
            high[pair * LANES + lane] = words[2 * pair + 1].wrapping_add(start[2 * pair + 1]);
        }
    }
    *counter = counter.wrapping_add(LANES as u64);
}

#[inline(always)]
fn double_round(words: &mut [u32; 16]) {
    quarter_round(words, 0, 4, 8, 12);
    quarter_round(words, 1, 5, 9, 13);
    quarter_round(words, 2, 6, 10, 14);
    quarter_round(words, 3, 7, 11, 15);
    quarter_round(words, 0, 5, 10, 15);
    quarter_round(words, 1, 6, 11, 12);
    quarter_round(words, 2, 7, 8, 13);
    quarter_round(words, 3, 4, 9, 14);
}

#[inline(always)]
fn quarter_round(words: &mut [u32; 16], a: usize, b: usize, c: usize, d: usize) {
    words[a] = words[a].wrapping_add(words[b]);
    words[d] = (words[d] ^ words[a]).rotate_left(16);
    words[c] = words[c].wrapping_add(words[d]);
    words[b] = (words[b] ^ words[c]).rotate_left(12);
    words[a] = words[a].wrapping_add(words[b]);
    words[d] = (words[d] ^ words[a]).rotate_left(8);
    words[c] = words[c].wrapping_add(words[d]);
    words[b] = (words[b] ^ words[c]).rotate_left(7);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn the_keystream_is_that_of_the_generator() {
        let seed: [u8; 32] = std::array::from_fn(|i| 7 * i as u8 + 1);
        let key = std::array::from_fn(|i| u32::from_le_bytes(std::array::from_fn(|j| seed[4 * i + j])));
        let (mut low, mut high, mut counter) = ([0; BATCH], [0; BATCH], 0);
        let mut generator = Stream::from_seed(seed);
        for _ in 0..3 {
            keystream(&key, &mut counter, &mut low, &mut high);
            let bits = Bits { low: &low, high: &high };
            for lane in 0..16 {
                for pair in 0..8 {
                    assert_eq!(bits.at(pair * 16 + lane), generator.next_u64());
                }
            }
        }
    }

    /// Everything that a distribution is made of.
    struct Mixed;

    impl Transform for Mixed {
        #[inline(always)]
        fn pairs<const L: usize>(a: Bits<'_, L>, b: Bits<'_, L>, x: &mut [f64; L], y: &mut [f64; L]) {
            for i in 0..L {
                (x[i], y[i]) = crate::elementary::sin_cos(a.at(i) as f64 * 2.0_f64.powi(-65));
                y[i] = crate::elementary::ln(((b.at(i) >> 11) + 1) as f64).mul_add(x[i], y[i]);
            }
        }
    }

    #[test]
    fn numbers_do_not_depend_on_the_machines_vectors() {
        for count in [1, 20, 40, 128, 1000] {
            let (mut narrow, mut wide) = (vec![0.0; count], vec![0.0; count]);
            let mut streams = [Stream::from_seed([5; 32]), Stream::from_seed([5; 32])];
            let [first, second] = &mut streams;
            fill::<Mixed>(first, &mut wide);
            let op = Fill::<Mixed> { stream: second, out: &mut narrow, transform: PhantomData };
            pulp::Scalar::new().vectorize(op);
            assert_eq!(narrow, wide);
        }
    }
}
