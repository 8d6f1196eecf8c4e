//! Blocks transposed by the instructions of x86.

use std::arch::x86_64::{__m256d, __m512d};

use pulp::x86::{V3, V4};
use pulp::{Simd, WithSimd, cast};

use super::block::{Block, MoveBlocks};

/// Instructions that can transpose a block.
pub(crate) trait Transpose: Copy {
    fn transposed(self, block: Block) -> Block;
}

pub(crate) struct With<S, T> {
    pub(crate) simd: S,
    pub(crate) work: T,
}

impl<I: Transpose, T: MoveBlocks> WithSimd for With<I, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let With { simd, work } = self;
        work.run(
            #[inline(always)]
            |block| simd.transposed(block),
        );
    }
}

/// Quarter by quarter.
impl Transpose for V3 {
    #[inline(always)]
    fn transposed(self, block: Block) -> Block {
        // Each row in two halves.
        let [a, b, c, d, e, f, g, h]: [[__m256d; 2]; 8] = cast(block);
        let upper_left = quarter(self, [a[0], b[0], c[0], d[0]]);
        let upper_right = quarter(self, [a[1], b[1], c[1], d[1]]);
        let lower_left = quarter(self, [e[0], f[0], g[0], h[0]]);
        let lower_right = quarter(self, [e[1], f[1], g[1], h[1]]);
        cast([side_by_side(upper_left, lower_left), side_by_side(upper_right, lower_right)])
    }
}

/// Rows of two quarters, one beside the other.
#[inline(always)]
fn side_by_side([a, b, c, d]: [__m256d; 4], [e, f, g, h]: [__m256d; 4]) -> [[__m256d; 2]; 4] {
    [[a, e], [b, f], [c, g], [d, h]]
}

/// Transposes pairs of rows within pairs of coordinates, then halves.
#[inline(always)]
fn quarter(simd: V3, [a, b, c, d]: [__m256d; 4]) -> [__m256d; 4] {
    const LOWER: i32 = 0b10_00_00;
    const UPPER: i32 = 0b11_00_01;
    let avx = simd.avx;
    let (even, odd) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
    let (even_below, odd_below) = (avx._mm256_unpacklo_pd(c, d), avx._mm256_unpackhi_pd(c, d));
    [
        avx._mm256_permute2f128_pd::<LOWER>(even, even_below),
        avx._mm256_permute2f128_pd::<LOWER>(odd, odd_below),
        avx._mm256_permute2f128_pd::<UPPER>(even, even_below),
        avx._mm256_permute2f128_pd::<UPPER>(odd, odd_below),
    ]
}

/// Transposes pairs of rows within pairs of coordinates, then pairs of pairs, then halves.
impl Transpose for V4 {
    #[inline(always)]
    fn transposed(self, block: Block) -> Block {
        let avx = self.avx512f;
        let [a, b, c, d, e, f, g, h]: [__m512d; 8] = cast(block);
        let even = [(a, b), (c, d), (e, f), (g, h)].map(
            #[inline(always)]
            |(a, b)| avx._mm512_unpacklo_pd(a, b),
        );
        let odd = [(a, b), (c, d), (e, f), (g, h)].map(
            #[inline(always)]
            |(a, b)| avx._mm512_unpackhi_pd(a, b),
        );
        let ([a, c, e, g], [b, d, f, h]) = (quarters(self, even), quarters(self, odd));
        cast([a, b, c, d, e, f, g, h])
    }
}

/// Quarter `j` of each of four registers side by side, for each `j`.
#[inline(always)]
fn quarters(simd: V4, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    const EVEN: i32 = 0b10_00_10_00;
    const ODD: i32 = 0b11_01_11_01;
    let avx = simd.avx512f;
    let even = (avx._mm512_shuffle_f64x2::<EVEN>(a, b), avx._mm512_shuffle_f64x2::<EVEN>(c, d));
    let odd = (avx._mm512_shuffle_f64x2::<ODD>(a, b), avx._mm512_shuffle_f64x2::<ODD>(c, d));
    [
        avx._mm512_shuffle_f64x2::<EVEN>(even.0, even.1),
        avx._mm512_shuffle_f64x2::<EVEN>(odd.0, odd.1),
        avx._mm512_shuffle_f64x2::<ODD>(even.0, even.1),
        avx._mm512_shuffle_f64x2::<ODD>(odd.0, odd.1),
    ]
}
