//! What a measurement says of a state that it depends on linearly, with independent noise of one family.

use crate::Noise;
use crate::batch::LANES;
use crate::equations::{Lanes, rows_of, rows_of_mut};

/// Writes, for `y_j = (C x)_j + w_j`, what [`Linearise::tile_scores`](crate::equations::Linearise::tile_scores) asks for. Rows of `C` are lists of
/// columns and entries.
pub(crate) fn tile_scores<'c>(
    (noise, sigma): (Noise, f64),
    rows: impl Iterator<Item = &'c [(usize, f64)]>,
    states: &[f64],
    measurement: &[Option<Lanes>],
    [slopes, information, jacobian]: [&mut [f64]; 3],
) {
    let states = rows_of(states);
    let (slopes, information) = (rows_of_mut(slopes), rows_of_mut(information));
    jacobian.fill(0.0);
    let parts = slopes.iter_mut().zip(information).zip(jacobian.chunks_exact_mut(states.len() * LANES));
    for ((row, entry), ((slope, information), jacobian)) in rows.zip(measurement).zip(parts) {
        let Some(y) = entry else {
            (*slope, *information) = (Lanes::from(0.0), Lanes::from(0.0));
            continue;
        };
        let mut location = Lanes::from(0.0);
        for &(column, entry) in row {
            location = location + states[column] * entry;
            rows_of_mut(jacobian)[column] = Lanes::from(entry);
        }
        let score = noise.around(sigma, location).score(*y);
        (*slope, *information) = (score.slope, score.information);
    }
}
