//! What a block of particles is conditioned in.

use motes_networks::Inference;

/// What conditioning a block of particles computes in.
#[derive(Default)]
pub struct AmortisedScratch {
    /// The units of each tile.
    pub(super) units: Vec<f64>,
    /// `x_{t−1}` of each tile, where the transport asks for it again.
    pub(super) previous: Vec<f64>,
    /// `θ`, `R×P`.
    pub(super) theta: Vec<f64>,
    /// What a tile is computed in.
    pub(super) tile: Vec<f64>,
    /// `R×N` or `R×Q` normal numbers, and `R×U` uniform ones.
    pub(super) noise: Vec<f64>,
    pub(super) uniforms: Vec<f64>,
    /// Inputs of the networks, `R×F`.
    pub(super) inputs: Vec<f64>,
    pub(super) inference: Inference,
}
