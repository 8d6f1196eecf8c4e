//! Numbers that are the same for all particles, kept from one tile of particles to the next.

use std::cell::RefCell;
use std::sync::atomic::{AtomicU64, Ordering};

use super::instruction::Program;
use super::moment::Moment;

/// Programs with fewer steps compute them anew: to keep them would take as long.
const FEW: usize = 24;

/// How many moments are kept: more than the sub-steps that most steps have.
const PLACES: usize = 64;

/// What lies between the places of two programs, whose numbers follow each other: transition and measurement of a model would take each other's.
const SPREAD: usize = 37;

/// What a program computed for a moment.
#[derive(Default)]
struct PlainNumbers {
    program: u64,
    /// Time, length and whether it is the first sub-step, and behind them the inputs: all that the values depend on, as bits.
    moment: Vec<u64>,
    values: Vec<f64>,
}

impl PlainNumbers {
    fn is_of(&self, program: u64, moment: &Moment<'_>) -> bool {
        self.program == program && moment.bits().eq(self.moment.iter().copied())
    }
}

thread_local! {
    static KEPT: RefCell<Vec<PlainNumbers>> = const { RefCell::new(Vec::new()) };
}

/// A number that no other program has.
pub(super) fn next_program() -> u64 {
    // 0 is that of what was never computed.
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// Shows the numbers of a program that are the same for all particles at a moment, in the sub-step of this number.
#[inline(always)]
pub(super) fn with_plain<R>(
    program: &Program,
    moment: Moment<'_>,
    sub_step: usize,
    work: impl FnOnce(&[f64]) -> R,
) -> R {
    let count = program.constants.len() + program.steps.len();
    if program.steps.len() < FEW {
        return motes_models::equations::with_scalars::<f64, _>(count, |plain| {
            program.plain(moment, plain);
            work(plain)
        });
    }
    let place = (program.number as usize).wrapping_mul(SPREAD).wrapping_add(sub_step) % PLACES;
    // Taken, not borrowed: what works with them may ask for others.
    let mut kept = take(place);
    if !kept.is_of(program.number, &moment) {
        kept.program = program.number;
        kept.moment.clear();
        kept.moment.extend(moment.bits());
        kept.values.resize(count, 0.0);
        program.plain(moment, &mut kept.values);
    }
    let result = work(&kept.values);
    put(place, kept);
    result
}

#[inline(never)]
fn take(place: usize) -> PlainNumbers {
    KEPT.with_borrow_mut(|all| all.get_mut(place).map(std::mem::take).unwrap_or_default())
}

#[inline(never)]
fn put(place: usize, kept: PlainNumbers) {
    KEPT.with_borrow_mut(|all| {
        if all.len() <= place {
            all.resize_with(PLACES, PlainNumbers::default);
        }
        all[place] = kept;
    });
}
