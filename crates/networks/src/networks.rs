//! Networks that advance step by step: what they are asked, what they answer, and what each particle carries.

use smallvec::SmallVec;

use crate::arithmetic::Arithmetic;
use crate::hidden_reader::HiddenReader;

/// Networks of one kind, from what a particle knows to a few rows of numbers.
///
/// They say what is computed, in the terms of [`Arithmetic`]; [`crate::Inference`] and [`crate::NetworkTape`] compute it.
pub trait Networks: Clone + Send + Sync {
    /// How many times there are networks for; `None` if any number.
    fn horizon(&self) -> Option<usize>;

    /// The widths of what a particle carries from step to step; none for networks without memory.
    fn hidden_widths(&self) -> Vec<usize> {
        Vec::new()
    }

    /// The matrices that read units of hidden layers; none for networks whose units cannot be left out.
    fn hidden_readers(&self) -> Vec<HiddenReader> {
        Vec::new()
    }

    /// Computes the outputs of `R` particles at time `t`.
    fn forward<A: Arithmetic>(
        &self,
        arithmetic: &mut A,
        time: usize,
        known: Known<'_, A::Rows>,
    ) -> Outputs<A::Rows>;
}

/// What a backend hands to the networks about `R` particles.
pub struct Known<'a, Rows> {
    /// `x_{t−1}`, `R×N`; zeros at `t = 0`.
    pub previous: Rows,
    /// `y_t`, `1×M`.
    pub measurement: Rows,
    /// What the particles carry, `R×width` each.
    pub hidden: &'a [Rows],
}

/// What the networks say of `R` particles.
pub struct Outputs<Rows> {
    pub(crate) values: Few<Rows>,
    pub(crate) hidden: Few<Rows>,
}

/// So few that they take no memory of their own.
pub(crate) type Few<Rows> = SmallVec<[Rows; 2]>;

impl<Rows> Outputs<Rows> {
    /// One matrix of `R` rows for each output, in the order that the owner of the networks expects, and what the particles carry on, in the order of
    /// [`Networks::hidden_widths`].
    pub fn new(values: impl IntoIterator<Item = Rows>, hidden: impl IntoIterator<Item = Rows>) -> Self {
        Outputs { values: values.into_iter().collect(), hidden: hidden.into_iter().collect() }
    }
}

/// What networks are asked about a batch of `R` particles, on the host.
#[derive(Debug, Clone, Copy)]
pub struct Inputs<'a> {
    /// `t`.
    pub time: usize,
    /// `N`, the coordinates of a state.
    pub width: usize,
    /// `x_{t−1}`, row-major `R×N`; `None` at `t = 0`, where networks see zeros.
    pub previous: Option<&'a [f64]>,
    /// `y_t`, `M` numbers, the same for all particles.
    pub measurement: &'a [f64],
    /// `R`.
    pub particles: usize,
}
