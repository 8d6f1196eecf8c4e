//! A square of eight rows and eight coordinates, and what moves many of them.

/// Rows and coordinates that are turned over together.
pub(crate) const SIDE: usize = 8;

/// A square of a batch, turned over or to be.
pub(crate) type Square = [[f64; SIDE]; SIDE];

/// A movement between rows and a tile, by squares and what is left beside them.
pub(crate) trait Turn {
    fn by(self, transposed: impl Fn(Square) -> Square);
}
