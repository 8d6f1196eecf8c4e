//! Walks that become shorter from pass to pass.

use crate::likelihood::RandomWalk;

/// How far a coordinate goes in the first pass of a search and in the last one, in standard deviations of the prior.
pub(super) const SPREADS: [f64; 2] = [0.6, 0.06];

/// The walk of a pass of so many, of which the first begins with one spread and the last ends with the other.
pub(super) fn between([first, last]: [f64; 2], pass: usize, passes: usize) -> RandomWalk<'static> {
    let cooling = (last / first).powf(1.0 / passes as f64);
    RandomWalk { spread: first * cooling.powi(pass as i32), cooling, directions: None, fixed: None }
}

/// The variance of a walk over a pass, in that of its steps.
pub(super) fn variance(walk: RandomWalk<'_>) -> f64 {
    walk.spread * walk.spread * walk.cooling
}
