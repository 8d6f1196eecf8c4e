//! What bases are built from.

use motes_models::equations::Lanes;

/// What a measurement says of the noise `v`, at `v = 0`, for the particles of a tile.
pub(in crate::amortised) struct Site<'a> {
    /// `∂ log p(y_j | θ_j) / ∂θ_j` for each entry of the measurement.
    pub(in crate::amortised) slopes: &'a mut [Lanes],
    /// Its Fisher information.
    pub(in crate::amortised) information: &'a mut [Lanes],
    /// `∂θ_j / ∂v_i`, `M×N`.
    pub(in crate::amortised) jacobian: &'a mut [Lanes],
}
