//! How a model is stated.

use std::ops::Range;

use super::distribution::Distribution;
use super::scalar::Scalar;
use crate::Step;

/// A state-space model by its three equations: `p(x_0)`, `p(x_t | x_{t−1})`, `p(y_t | x_t)`. Coordinates are independent given the past.
///
/// All else follows: what states a model here is a [`StateSpaceModel`](crate::StateSpaceModel), a [`Simulator`](crate::Simulator), has
/// [`StateGradients`](crate::StateGradients), weighs measurements with gaps, can be linearised, and makes its states of standard normal noise
/// ([`Transport`](super::Transport)).
///
/// Formulas are generic over their scalar: a number, many side by side, or one that carries derivatives. Which family a coordinate has may depend on the
/// time, never on states.
///
/// `#[inline(always)]` on `transition` and `measurement` lets their formulas be compiled for the widest vectors of the machine: a filter of the
/// growth model then takes a fifth less time. The numbers are the same.
///
/// ```
/// use motes_models::equations::{Coordinates, Equations, Scalar, normal};
/// use motes_models::{Seed, Step, simulate};
///
/// /// The growth model of Netto, Gimeno and Mendes (1978).
/// struct Growth;
///
/// impl Equations for Growth {
///     fn dimensions(&self) -> [usize; 2] {
///         [1, 1]
///     }
///
///     fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
///         state.push(normal(0.0, 5.0_f64.sqrt()));
///     }
///
///     #[inline(always)]
///     fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], state: &mut impl Coordinates<S>) {
///         let x = x[0];
///         let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
///         state.push(normal(drift, 10.0_f64.sqrt()));
///     }
///
///     #[inline(always)]
///     fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
///         measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
///     }
/// }
///
/// let data = simulate(&Growth, 50, &mut Seed::from_u64(1).stream())?;
/// assert_eq!(data.measurements.len(), 50);
/// # Ok::<(), motes_models::ModelError>(())
/// ```
pub trait Equations: Sync {
    /// `N` and `M`, the numbers of coordinates of a state and of a measurement.
    fn dimensions(&self) -> [usize; 2];

    /// The inputs where nobody gives others, as many as the model takes; none if it takes none.
    fn inputs(&self) -> &[f64] {
        &[]
    }

    /// The parameters where nobody gives others, as many as the model takes; none if it takes none.
    fn parameters(&self) -> &[f64] {
        &[]
    }

    /// Pushes the distribution of each of the `N` coordinates of `x_0`, in order.
    ///
    /// Where another number of coordinates is pushed, here or below, draws and densities are NaN.
    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>);

    /// Pushes the distribution of each of the `N` coordinates of `x_t` given `x_{t−1}` (`N`).
    fn transition<S: Scalar>(&self, step: &Step<'_, S>, previous: &[S], state: &mut impl Coordinates<S>);

    /// Pushes the distribution of each of the `M` coordinates of `y_t` given `x_t` (`N`).
    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>);

    /// [`Equations::measurement`], of which only derivatives along the states in `along` are wanted: coordinates that depend on none of these states may be
    /// passed over ([`Coordinates::pass_over`]). A model of many states of which each coordinate sees few is linearised sooner so; all are pushed unless a
    /// model says otherwise.
    #[inline(always)]
    fn measurement_along<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        state: &[S],
        _along: Range<usize>,
        measurement: &mut impl Coordinates<S>,
    ) {
        self.measurement(step, state, measurement);
    }
}

/// What takes the distributions of a vector's coordinates, one after another.
pub trait Coordinates<S> {
    /// Takes the distribution of the next coordinate.
    fn push(&mut self, distribution: Distribution<S>);

    /// Passes over the next coordinate, of which nothing is wanted.
    #[inline(always)]
    fn pass_over(&mut self) {}
}
