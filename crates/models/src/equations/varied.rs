//! Points of a few particles side by side that carry derivatives along some of their coordinates.

use super::dual::Dual;
use super::lanes::Lanes;

/// Particles side by side where numbers carry derivatives: so few that such a number stays in registers.
pub(super) const SIDE: usize = 8;

/// One number of each of [`SIDE`] particles.
pub(super) type Side = Lanes<SIDE>;

/// A number with derivatives along `E − 1` directions, for each of [`SIDE`] particles.
pub(super) type Varied<const E: usize> = Dual<Side, E>;

/// The numbers of [`SIDE`] particles, from `lane` on.
#[inline(always)]
pub(super) fn side(lanes: &Lanes, lane: usize) -> Side {
    let mut side = [0.0; SIDE];
    side.copy_from_slice(&lanes.0[lane..lane + SIDE]);
    Lanes(side)
}

/// Puts the numbers of [`SIDE`] particles in their place, from `lane` on.
#[inline(always)]
pub(super) fn put(side: Side, lane: usize, lanes: &mut Lanes) {
    lanes.0[lane..lane + SIDE].copy_from_slice(&side.0);
}

/// Makes `point` of the particles of `tile` from `lane` on, with the coordinates from `first` on as directions, as many as there are.
#[inline(always)]
pub(super) fn vary<const E: usize>(tile: &[Lanes], lane: usize, first: usize, point: &mut [Varied<E>]) {
    for (coordinate, (varied, value)) in point.iter_mut().zip(tile).enumerate() {
        let value = side(value, lane);
        let direction = coordinate.checked_sub(first).filter(|direction| *direction < E - 1);
        *varied = match direction {
            Some(direction) => Varied::variable(value, direction),
            None => Varied::constant(value),
        };
    }
}
