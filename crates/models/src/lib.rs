//! State-space models for particle filters: what is known about a system before any filter runs.
//!
//! A model is the triple `p(x_0)`, `p(x_t | x_{t-1})`, `p(y_t | x_t)` of a hidden state `x_t ∈ ℝᴺ` and a
//! measurement `y_t ∈ ℝᴹ`.
//!
//! - A filter asks for a [`StateSpaceModel`].
//! - Training asks for [`StateGradients`] too, designed proposals for [`AdditiveGaussian`], graph networks for [`GraphModel`].
//! - [`check_gradients`] checks gradients that were written by hand.
//! - [`LinearGaussian`] has exact answers, by [`kalman`].
//! - [`GraphDiffusion`] and [`Epidemic`] are the paper's systems.
//! - Everything is drawn from explicit random streams, derived from a [`Seed`].
//!
//! A batch of `K` states is one row-major slice of `K·N` numbers, particle after particle.
//!
//! ```
//! use motes_models::{GraphDiffusion, GraphDiffusionConfig, Seed, kalman, simulate};
//!
//! let seed = Seed::from_u64(1);
//! let config = GraphDiffusionConfig::new(10);
//! let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream())?;
//! let trajectory = simulate(&system, 12, &mut seed.child("trajectory").stream())?;
//! let exact = kalman::filter(&system.moment_matched()?, &trajectory.measurements)?;
//! assert!(exact.log_evidence().is_finite());
//! # Ok::<(), motes_models::ModelError>(())
//! ```

pub mod batch;
mod bulk;
mod dependence;
pub mod elementary;
mod epidemic;
pub mod equations;
mod error;
pub mod forward;
mod gaussian;
mod gradient_check;
mod graph;
mod graph_diffusion;
pub mod kalman;
mod linear_gaussian;
mod linear_measurements;
mod noise;
mod noise_rows;
mod normals;
mod own_steps;
mod sequence;
mod shape;
mod simulate;
mod simulated_measurements;
mod simulations;
mod state_space;
mod step;
mod stream;
mod system_graph;

pub use epidemic::{Epidemic, EpidemicConfig};
pub use error::{CovarianceFault, ModelError};
pub use gaussian::{Gaussian, LN_2PI};
pub use gradient_check::{
    Comparison, Derivative, GradientError, GradientReport, check_gradients, check_gradients_from,
};
pub use graph::RandomGeometricGraph;
pub use graph_diffusion::{Drift, GraphDiffusion, GraphDiffusionConfig};
pub use linear_gaussian::LinearGaussian;
pub use noise::Noise;
pub use normals::{fill_standard_exponential, fill_standard_normal, fill_uniform};
pub use own_steps::{OwnModel, OwnStep, OwnSteps};
pub use sequence::{Measurements, PartialMeasurements, Sequence};
pub use shape::ModelShape;
pub use simulate::{Trajectory, simulate, simulate_while, simulate_within};
pub use simulated_measurements::{MeasurementSource, SimulatedMeasurements};
pub use simulations::{LinearPredictor, Simulations, Spread};
pub use state_space::{
    AdditiveGaussian, Propagator, Simulator, StateGradients, StateSpaceModel, TransitionDensity, check_model,
};
pub use step::{Step, StepRecord};
pub use stream::{Seed, Stream, StreamPosition, duplicate};
pub use system_graph::{GraphModel, SystemGraph};

/// The README's code, compiled and run as a documentation test.
#[doc = include_str!("../README.md")]
#[cfg(doctest)]
pub struct Readme;
