//! Models that state their distributions for many particles at a time: numbers in, numbers out, by functions that are not generic over their scalar.

mod column;
mod gradients;
mod linearise;
mod memo;
mod model;

pub use column::{BatchDistribution, Column};

use std::sync::OnceLock;

use crate::Step;
use memo::Owner;

/// A state-space model by three functions of many particles: for who cannot state [`Equations`](super::Equations), whose formulas are generic over their
/// scalar. A function of another language is called once for a block of particles so. Coordinates are independent given the past.
///
/// [`Batched`] makes it a [`StateSpaceModel`](crate::StateSpaceModel), a [`Simulator`](crate::Simulator), and all else that [`Equations`](super::Equations) are.
/// With the same numbers for parameters draws are the same, too, to the last bit.
///
/// ```
/// use motes_models::equations::{BatchDistribution, BatchEquations, Batched, Column, Distribution, Normal};
/// use motes_models::{Seed, Step, simulate};
///
/// /// A random walk.
/// struct Walk;
///
/// fn normal(mean: Column, sd: f64) -> BatchDistribution {
///     BatchDistribution::new(Distribution::Normal(Normal { mean, sd: Column::same(sd) }))
/// }
///
/// impl BatchEquations for Walk {
///     fn dimensions(&self) -> [usize; 2] {
///         [1, 1]
///     }
///
///     fn initial(&self) -> Option<Vec<BatchDistribution>> {
///         Some(vec![normal(Column::same(0.0), 1.0)])
///     }
///
///     fn transition(&self, _: &Step<'_>, previous: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
///         Some(vec![normal(Column::each(previous.to_vec()), 1.0)])
///     }
///
///     fn measurement(&self, _: &Step<'_>, states: &[f64], _: bool) -> Option<Vec<BatchDistribution>> {
///         Some(vec![normal(Column::each(states.to_vec()), 0.5)])
///     }
/// }
///
/// let data = simulate(&Batched::new(Walk), 50, &mut Seed::from_u64(1).stream())?;
/// assert_eq!(data.measurements.len(), 50);
/// # Ok::<(), motes_models::ModelError>(())
/// ```
pub trait BatchEquations: Sync {
    /// `N` and `M`, the numbers of coordinates of a state and of a measurement.
    fn dimensions(&self) -> [usize; 2];

    /// The inputs where nobody gives others, as many as the model takes; none if it takes none.
    fn inputs(&self) -> &[f64] {
        &[]
    }

    /// Whether each coordinate of `x_0` and of `x_t` is drawn and is no count, so that states have densities. Where one is [`BatchDistribution::known`], or a count, they have none.
    fn has_density(&self) -> bool {
        true
    }

    /// The distribution of each of the `N` coordinates of `x_0`, the same for all particles. Here and below `None` says that they could not be found: draws and
    /// densities are NaN then, as they are where another number of coordinates is stated.
    fn initial(&self) -> Option<Vec<BatchDistribution>>;

    /// The distribution of each of the `N` coordinates of `x_t` given each row `x_{t−1}` of `previous` (`K×N`), in a sub-step.
    ///
    /// Where `is_padded`, some rows are no particles', and nothing is to be made of what is odd about them.
    fn transition(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>>;

    /// The distribution of each of the `M` coordinates of `y_t` given each row `x_t` of `states` (`K×N`).
    fn measurement(&self, step: &Step<'_>, states: &[f64], is_padded: bool)
    -> Option<Vec<BatchDistribution>>;

    /// Whether parameters can be had with their derivatives along the rows. Without them a measurement cannot be linearised, and there are no gradients.
    fn has_slopes(&self) -> bool {
        false
    }

    /// [`BatchEquations::transition`] with derivatives.
    fn transition_slopes(
        &self,
        step: &Step<'_>,
        previous: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.transition(step, previous, is_padded)
    }

    /// [`BatchEquations::measurement`] with derivatives.
    fn measurement_slopes(
        &self,
        step: &Step<'_>,
        states: &[f64],
        is_padded: bool,
    ) -> Option<Vec<BatchDistribution>> {
        self.measurement(step, states, is_padded)
    }
}

/// What [`BatchEquations`] are as a model.
pub struct Batched {
    // Called by blocks of particles: all above is compiled once, whosever equations they are.
    equations: Box<dyn BatchEquations + Send>,
    owner: Owner,
    /// Whether all coordinates of states are normal, once that was looked at.
    is_affine: OnceLock<bool>,
}

impl Batched {
    /// The model of these equations.
    pub fn new(equations: impl BatchEquations + Send + 'static) -> Self {
        Batched { equations: Box::new(equations), owner: Owner::new(), is_affine: OnceLock::new() }
    }
}
