//! Squares of eight rows and eight coordinates, turned over by the widest instructions that the machine has.

mod square;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(super) use square::{SIDE, Square, Turn};

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
