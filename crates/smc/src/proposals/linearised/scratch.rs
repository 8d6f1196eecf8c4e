//! What a block of linearised distributions is kept in.

use bytemuck::TransparentWrapper;
use motes_models::batch::LANES;
use motes_models::equations::Lanes;

/// What conditioning a block of particles computes in, tile after tile.
#[derive(Debug, Clone, Default)]
pub struct LinearisedScratch {
    /// The mean, `m + Λ⁻¹ g` of a linearised proposal: `N × LANES` of each tile.
    pub(crate) means: Vec<f64>,
    /// The lower triangle of `L`, `Λ = L Lᵀ`, `N(N+1)/2 × LANES` of each tile.
    pub(crate) factors: Vec<f64>,
    /// What one tile is computed in, at least `N × LANES`.
    pub(crate) tile: Vec<f64>,
    /// `R×N`, or `R×Q`.
    pub(crate) noise: Vec<f64>,
    /// Of each particle, where the noise is drawn from a mixture.
    pub(crate) uniforms: Vec<f64>,
}

/// Memory of numbers lent as lanes.
pub(crate) fn lanes(numbers: &mut [f64]) -> &mut [Lanes] {
    let (rows, _) = numbers.as_chunks_mut::<LANES>();
    Lanes::wrap_slice_mut(rows)
}
