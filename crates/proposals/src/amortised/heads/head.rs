//! What a head is.

use motes_models::equations::Lanes;

/// A density `h(u | θ)` on ℝᴺ whose parameters `θ` a network emits; `u` is the state in units of the base.
///
/// Numbers of 32 particles stand side by side in [`Lanes`]; a matrix has one of them for each entry.
pub trait Head: Send + Sync {
    /// How many numbers `θ` are.
    fn outputs(&self) -> usize;

    /// How many of them, the last ones, are the same for all particles of a time: weights of their own, that no network emits.
    fn shared(&self) -> usize {
        0
    }

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

    /// This head as one whose draws have derivatives, if they have: those of a mixture jump from one component to another.
    fn reparametrised(&self) -> Option<&dyn Reparametrised> {
        None
    }
}

/// A head whose draw is a differentiable function `u = u(θ, ε)` of its parameters and of noise whose distribution knows nothing of them.
///
/// The noise need not be kept: it is a function of `θ` and `u`.
pub trait Reparametrised: Head {
    /// `∂ log h(u | θ) / ∂u` into `d_u` (`N`); `scratch` has [`Head::scratch`] entries.
    fn slope(&self, theta: &[Lanes], u: &[Lanes], d_u: &mut [Lanes], scratch: &mut [Lanes]);

    /// `Σ_i c_i ∂u_i/∂θ` with `ε` held fixed, into `d_theta`; `pull` has the `c` (`N`) and is used up, `scratch` has [`Head::scratch`] entries.
    fn pull_back(
        &self,
        theta: &[Lanes],
        u: &[Lanes],
        pull: &mut [Lanes],
        d_theta: &mut [Lanes],
        scratch: &mut [Lanes],
    );
}
