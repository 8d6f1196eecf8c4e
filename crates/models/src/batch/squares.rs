//! Squares of eight rows and eight coordinates, turned over by the widest instructions that the machine has.

/// Rows and coordinates that are turned over together.
pub(super) const SIDE: usize = 8;

/// A square of a batch, turned over or to be.
pub(super) type Square = [[f64; SIDE]; SIDE];

/// A movement between rows and a tile, by squares and what is left beside them.
pub(super) trait Turn {
    fn by(self, transposed: impl Fn(Square) -> Square);
}

/// Moves, all of it compiled for the instructions that squares are turned over with.
pub(super) fn turn(work: impl Turn) {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = pulp::x86::V4::try_new() {
            return pulp::Simd::vectorize(simd, x86::With { simd, work });
        }
        if let Some(simd) = pulp::x86::V3::try_new() {
            return pulp::Simd::vectorize(simd, x86::With { simd, work });
        }
    }
    work.by(
        #[inline(always)]
        |square| transposed(&square),
    );
}

#[inline(always)]
fn transposed(square: &Square) -> Square {
    let mut turned = [[0.0; SIDE]; SIDE];
    for (i, row) in square.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            turned[j][i] = *value;
        }
    }
    turned
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use std::arch::x86_64::{__m256d, __m512d};

    use pulp::x86::{V3, V4};
    use pulp::{Simd, WithSimd, cast};

    use super::{Square, Turn};

    /// Instructions that can turn a square over.
    pub(super) trait Transpose: Copy {
        fn transposed(self, square: Square) -> Square;
    }

    pub(super) struct With<S, T> {
        pub(super) simd: S,
        pub(super) work: T,
    }

    impl<I: Transpose, T: Turn> WithSimd for With<I, T> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, _simd: S) {
            let With { simd, work } = self;
            work.by(
                #[inline(always)]
                |square| simd.transposed(square),
            );
        }
    }

    /// Quarter by quarter.
    impl Transpose for V3 {
        #[inline(always)]
        fn transposed(self, square: Square) -> Square {
            // Each row in two halves.
            let [a, b, c, d, e, f, g, h]: [[__m256d; 2]; 8] = cast(square);
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

    /// Turns pairs of rows over within pairs of coordinates, then halves.
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

    /// Turns pairs of rows over within pairs of coordinates, then pairs of pairs, then halves.
    impl Transpose for V4 {
        #[inline(always)]
        fn transposed(self, square: Square) -> Square {
            let avx = self.avx512f;
            let [a, b, c, d, e, f, g, h]: [__m512d; 8] = cast(square);
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
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Once<'a>(&'a mut Square);

    impl Turn for Once<'_> {
        fn by(self, transposed: impl Fn(Square) -> Square) {
            *self.0 = transposed(*self.0);
        }
    }

    /// The number of each entry; turned over, that of its mirror image.
    fn numbered(turned: bool) -> Square {
        std::array::from_fn(|i| std::array::from_fn(|j| if turned { 8 * j + i } else { 8 * i + j } as f64))
    }

    #[test]
    fn squares_are_turned_over_by_all_instructions_that_this_machine_has() {
        let mut square = numbered(false);
        turn(Once(&mut square));
        assert_eq!(square, numbered(true));
        assert_eq!(transposed(&numbered(false)), numbered(true));
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            let mut square = numbered(false);
            pulp::Simd::vectorize(simd, x86::With { simd, work: Once(&mut square) });
            assert_eq!(square, numbered(true));
        }
    }
}
