//! A block of eight rows and eight coordinates, and what copies many of them.

/// Rows and coordinates that are transposed together.
pub(crate) const BLOCK: usize = 8;

/// A block of a batch, before or after it is transposed.
pub(crate) type Block = [[f64; BLOCK]; BLOCK];

/// A copy between rows and a tile, by blocks and what is left beside them.
pub(crate) trait MoveBlocks {
    fn run(self, transposed: impl Fn(Block) -> Block);
}
