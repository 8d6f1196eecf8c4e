//! What a head is.

use motes_models::equations::Lanes;

/// A density `h(u | θ)` on ℝᴺ whose parameters `θ` a network emits; `u` is the state in units of the base.
///
/// Numbers of 32 particles stand side by side in [`Lanes`]; a matrix has one of them for each entry.
pub trait Head: Send + Sync {
    /// How many numbers `θ` are.
    fn outputs(&self) -> usize;

    /// The `θ` that an untrained network emits (as many as [`Head::outputs`]).
    fn start(&self) -> Vec<f64>;

    /// How many uniform numbers a draw takes beside `N` normal ones.
    fn uniforms(&self) -> usize {
        0
    }

    /// Replaces standard normal numbers by a draw of `u` (`N`).
    fn draw(&self, theta: &[Lanes], uniforms: &[Lanes], normals: &mut [Lanes]);

    /// `log h(u | θ)`; `scratch` has [`Head::scratch`] entries.
    fn log_density(&self, theta: &[Lanes], u: &[Lanes], scratch: &mut [Lanes]) -> Lanes;

    /// The same, with `∂ log h / ∂θ` into `d_theta`.
    fn gradient(&self, theta: &[Lanes], u: &[Lanes], d_theta: &mut [Lanes], scratch: &mut [Lanes]) -> Lanes;

    /// How many entries of scratch a density takes.
    fn scratch(&self) -> usize;
}
