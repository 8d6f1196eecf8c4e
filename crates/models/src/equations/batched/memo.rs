//! What a thread was told last: a proposal asks a block's tiles one by one for what one call has answered.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::column::BatchDistribution;
use crate::batch::LANES;

/// Whose answers they are: a number that no other model of the process has.
#[derive(Debug)]
pub(super) struct Owner(u64);

impl Owner {
    pub(super) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Owner(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Which function was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asked {
    Transition,
    Measurement,
    /// The measurement with derivatives.
    Slopes,
}

/// An answer, which may be that there is none.
pub(super) type Answer = Option<Rc<Vec<BatchDistribution>>>;

struct Memo {
    owner: u64,
    time: usize,
    /// `K×N`.
    rows: Vec<f64>,
    answer: Answer,
}

thread_local! {
    /// The last answer of each function.
    static MEMOS: RefCell<[Option<Memo>; 3]> = const { RefCell::new([None, None, None]) };
}

/// The answer for these rows: the one that is known, or what `ask` says, which is then known.
pub(super) fn of_rows(
    owner: &Owner,
    asked: Asked,
    time: usize,
    rows: &[f64],
    ask: impl FnOnce() -> Option<Vec<BatchDistribution>>,
) -> Answer {
    let known = MEMOS.with_borrow(|memos| {
        let memo = memos[asked as usize].as_ref();
        let memo = memo.filter(|memo| memo.owner == owner.0 && memo.time == time && memo.rows == rows)?;
        Some(memo.answer.clone())
    });
    if let Some(answer) = known {
        return answer;
    }
    let answer = ask().map(Rc::new);
    let memo = Memo { owner: owner.0, time, rows: rows.to_vec(), answer: answer.clone() };
    MEMOS.with_borrow_mut(|memos| memos[asked as usize] = Some(memo));
    answer
}

/// The answer that is known for the particles of a tile (`N × LANES`), and which of its particles is the first of the tile; lanes beyond the last particle
/// may hold anything.
pub(super) fn of_tile(owner: &Owner, asked: Asked, time: usize, tile: &[f64]) -> Option<(Answer, usize)> {
    let n = tile.len() / LANES;
    MEMOS.with_borrow(|memos| {
        let memo = memos[asked as usize].as_ref();
        let memo = memo.filter(|memo| memo.owner == owner.0 && memo.time == time)?;
        let is_here = |rows: &[f64]| {
            let mut rows = rows.chunks_exact(n).enumerate();
            rows.all(|(lane, row)| row.iter().enumerate().all(|(i, value)| *value == tile[i * LANES + lane]))
        };
        let found = memo.rows.chunks(n * LANES).position(is_here)?;
        Some((memo.answer.clone(), found * LANES))
    })
}
