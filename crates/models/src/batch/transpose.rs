//! Blocks of eight rows and eight coordinates, transposed by the widest instructions that the machine has.

mod block;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(super) use block::{BLOCK, Block, MoveBlocks};

/// Moves, all of it compiled for the instructions that transpose blocks.
pub(super) fn with_transpose(work: impl MoveBlocks) {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(simd) = pulp::x86::V4::try_new() {
            return pulp::Simd::vectorize(simd, x86::With { simd, work });
        }
        if let Some(simd) = pulp::x86::V3::try_new() {
            return pulp::Simd::vectorize(simd, x86::With { simd, work });
        }
    }
    work.run(
        #[inline(always)]
        |block| transposed(&block),
    );
}

#[inline(always)]
fn transposed(block: &Block) -> Block {
    let mut result = [[0.0; BLOCK]; BLOCK];
    for (i, row) in block.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            result[j][i] = *value;
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Once<'a>(&'a mut Block);

    impl MoveBlocks for Once<'_> {
        fn run(self, transposed: impl Fn(Block) -> Block) {
            *self.0 = transposed(*self.0);
        }
    }

    /// The number of each entry; transposed, that of its mirror image.
    fn numbered(transposed: bool) -> Block {
        std::array::from_fn(|i| {
            std::array::from_fn(|j| if transposed { 8 * j + i } else { 8 * i + j } as f64)
        })
    }

    #[test]
    fn blocks_are_transposed_by_all_instructions_that_this_machine_has() {
        let mut block = numbered(false);
        with_transpose(Once(&mut block));
        assert_eq!(block, numbered(true));
        assert_eq!(transposed(&numbered(false)), numbered(true));
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            let mut block = numbered(false);
            pulp::Simd::vectorize(simd, x86::With { simd, work: Once(&mut block) });
            assert_eq!(block, numbered(true));
        }
    }
}
