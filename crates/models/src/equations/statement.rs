//! How a model is stated.

use std::ops::Range;

use super::distribution::Distribution;
use super::distribution::distributions::normal;
use super::scalar::Scalar;
use super::wrapped::Wrapped;
use crate::Step;

/// A state-space model by its three equations: how `x_0` is made, how `x_t` is made of `x_{t−1}`, and `p(y_t | x_t)`.
///
/// A state is made by draws and a map: each [`Draws::draw`] takes a distribution and gives a value, and the state is computed from these values and from the state
/// before. Two coordinates can share a draw, a coordinate can follow without one, and a draw can depend on those before it. A model whose coordinates are its draws,
/// one each and in order, has a transition density; that of any other says so by [`Equations::has_density`].
///
/// All else follows: what states a model here is a [`StateSpaceModel`](crate::StateSpaceModel), a [`Simulator`](crate::Simulator), has
/// [`StateGradients`](crate::StateGradients), weighs measurements with gaps, can be linearised, and makes its states of standard normal noise
/// ([`Transport`](super::Transport)).
///
/// Formulas are generic over their scalar: a number, many side by side, or one that carries derivatives. How many draws there
/// are, and of which families, may depend on the time, never on states.
///
/// `#[inline(always)]` on `transition` and `measurement` lets their formulas be compiled for the widest vectors of the machine: a filter of the
/// growth model then takes a fifth less time. The numbers are the same.
///
/// ```
/// use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
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
///     fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
///         state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
///     }
///
///     #[inline(always)]
///     fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
///         let x = x[0];
///         let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
///         state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
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

    /// Whether the coordinates of `x_0` and of `x_t` are the draws themselves, one each and in order, so that `p(x_0)` and `p(x_t | x_{t−1})` are densities that can
    /// be had.
    fn has_density(&self) -> bool {
        true
    }

    /// Whether states or measurements depend on the time or the index of a step, beside its length, its inputs and its parameters.
    fn depends_on_time(&self) -> bool {
        true
    }

    /// Makes `x_0` (`N`) of draws.
    fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]);

    /// Makes `x_t` (`N`) of `x_{t−1}` (`N`) and of draws.
    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    );

    /// Pushes the distribution of each of the `M` entries of `y_t` given `x_t` (`N`), which are independent. Where another number of entries is pushed, draws and
    /// densities are NaN.
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

/// What draws for a state, or answers as if it did: with given values, with means, with values of a transport.
pub trait Draws<S> {
    /// The next draw, from this distribution.
    fn draw(&mut self, distribution: Distribution<S>) -> S;

    /// Hears that the next draw, which is uniform on `[0, 1)`, chooses among so many things in proportion to their shares, the first of which lies at 0. Who draws does not
    /// care.
    #[inline(always)]
    fn among(&mut self, _count: usize, _share: impl Fn(usize) -> S) {}
}

/// What takes the distributions of the entries of a measurement, one after another.
pub trait Coordinates<S> {
    /// Takes the distribution of the next coordinate.
    fn push(&mut self, distribution: Distribution<S>);

    /// Takes a distribution that is made of others. Who knows only those of families gets one that is NaN.
    #[inline(always)]
    fn push_wrapped(&mut self, _wrapped: &Wrapped<'_, S>)
    where
        S: Scalar,
    {
        self.push(normal(f64::NAN, f64::NAN));
    }

    /// Passes over the next coordinate, of which nothing is wanted.
    #[inline(always)]
    fn pass_over(&mut self) {}
}
