//! Blocks of the taps of a graph filter in the order in which products read them.

use prefetch_index::prefetch_index;
use pulp::Simd;

use super::turn::turn;
use super::vectors::{load_two, store_two};
use crate::graph::Shape;

/// Lines of memory in which a row of a block of one tap may lie.
const LINES: usize = 3;

/// A block of the same place of every tap.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
}

impl Block {
    /// All blocks of a size, those beside each other first; the last ones may be smaller.
    #[inline(always)]
    pub(super) fn all(shape: Shape, [tall, wide]: [usize; 2]) -> impl Iterator<Item = Self> {
        let Shape { inputs, outputs, .. } = shape;
        let beside = outputs.div_ceil(wide);
        (0..inputs.div_ceil(tall) * beside).map(move |number| {
            let (row, column) = (number / beside * tall, number % beside * wide);
            Block { row, column, rows: tall.min(inputs - row), columns: wide.min(outputs - column) }
        })
    }
}

/// `W_d` on top of each other.
#[derive(Clone, Copy)]
pub(super) struct Taps<'a> {
    pub(super) values: &'a [f32],
    pub(super) shape: Shape,
}

impl<'a> Taps<'a> {
    /// Of each row of a block all taps one after another, with zeros up to two vectors.
    #[inline(always)]
    pub(super) fn copied<S: Simd>(self, simd: S, block: Block, panel: &mut [f32]) {
        let width = 2 * S::F32_LANES;
        for (at, row) in panel.chunks_exact_mut(self.shape.taps * width).enumerate() {
            for (tap, into) in row.chunks_exact_mut(width).enumerate() {
                let from = &self.values[self.place(block, tap, at)..][..block.columns];
                store_two::<S>(simd, into, load_two::<S>(simd, from));
            }
        }
    }

    /// Of each column of a block all taps one after another, with zeros up to `width` numbers.
    #[inline(always)]
    pub(super) fn turned(self, block: Block, width: usize, panel: &mut [f32]) {
        let Shape { outputs, taps, .. } = self.shape;
        if block.rows < width {
            panel.fill(0.0);
        }
        for tap in 0..taps {
            let from = &self.values[self.place(block, tap, 0)..];
            turn(from, outputs, [block.rows, block.columns], &mut panel[tap * width..], taps * width);
        }
    }

    /// A block that is wanted soon, of which one of so many parts is fetched.
    #[inline(always)]
    pub(super) fn ahead(self, block: Block, part: usize, parts: usize) -> Ahead<'a> {
        let lines = LINES * self.shape.taps;
        let place = |line: usize| {
            let line = line.min(lines - 1);
            self.place(block, line / LINES, 0) + line % LINES * (block.columns - 1) / (LINES - 1)
        };
        let (first, end) = (part * lines / parts, (part + 1) * lines / parts);
        Ahead {
            values: self.values,
            places: [place(first), place(end.max(first + 1) - 1)],
            apart: self.shape.outputs,
        }
    }

    /// Where a row of a block of a tap begins.
    #[inline(always)]
    fn place(&self, block: Block, tap: usize, at: usize) -> usize {
        (tap * self.shape.inputs + block.row + at) * self.shape.outputs + block.column
    }
}

/// Lines of memory that come near while others are worked on: of each row of a block as many as two, because more at a time would wait
/// for each other.
#[derive(Clone, Copy)]
pub(super) struct Ahead<'a> {
    values: &'a [f32],
    places: [usize; 2],
    apart: usize,
}

impl Ahead<'_> {
    /// Fetches those of one row.
    #[inline(always)]
    pub(super) fn fetch(self, row: usize) {
        self.places.into_iter().for_each(|place| prefetch_index(self.values, place + row * self.apart));
    }
}
