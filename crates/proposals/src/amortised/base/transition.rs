//! The transition as a base.

use motes_models::equations::Lanes;
use motes_models::equations::triangle::at;

/// `b = 0`, `L = I`.
#[inline(always)]
pub(super) fn place(shift: &mut [Lanes], lower: &mut [Lanes]) {
    shift.fill(Lanes::from(0.0));
    lower.fill(Lanes::from(0.0));
    for i in 0..shift.len() {
        lower[at(i, i)] = Lanes::from(1.0);
    }
}
