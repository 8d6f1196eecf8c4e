//! Small networks on batches of particles, and their derivatives.
//!
//! A network is written once, in the terms of [`Arithmetic`]: affine maps with their activation, recurrent cells, graph filters. Whoever
//! implements [`Networks`] says what is computed; [`Inference`] computes it forward, as a filter does, and [`NetworkTape`] forward and back, as
//! training does. Nothing here knows of probability.
//!
//! The native backend is this crate's own. The feature `burn` adds two of burn's, [`Backend::Flex`] and [`Backend::NdArray`], which tests hold it
//! against; `wgpu` and `cuda` add burn on graphics processors, [`Backend::Wgpu`] and [`Backend::Cuda`].
//!
//! ```
//! use motes_models::Seed;
//! use motes_networks::layers::Mlp;
//! use motes_networks::{Arithmetic, Backend, Inference, Inputs, Known, Networks, Outputs, Parameters};
//!
//! /// A fully connected network on `[x_{t−1}; y_t]`.
//! #[derive(Clone)]
//! struct OfBoth(Mlp);
//!
//! impl Networks for OfBoth {
//!     fn horizon(&self) -> Option<usize> {
//!         None
//!     }
//!
//!     fn forward<A: Arithmetic>(&self, arithmetic: &mut A, _: usize, known: Known<'_, A::Rows>) -> Outputs<A::Rows> {
//!         let inputs = arithmetic.stacked(&known.previous, &known.measurement);
//!         Outputs::new([self.0.forward(arithmetic, inputs)], [])
//!     }
//! }
//!
//! let mut weights = Parameters::new(Backend::Native.into());
//! let networks = OfBoth(Mlp::draw(&mut weights, "net", &[3, 16, 2], &Seed::from_u64(1)));
//! let inputs = Inputs { time: 1, width: 2, previous: Some(&[0.1, 0.2, 0.3, 0.4]), measurement: &[1.0], particles: 2 };
//! let mut output = [0.0; 4];
//! Inference::default().run(&networks, &weights, &inputs, &mut [], &mut [&mut output])?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arithmetic;
mod backend;
#[cfg(feature = "burn")]
mod by_burn;
mod device;
mod error;
mod fit;
mod gradients;
mod graph;
mod hidden_reader;
mod inference;
mod initial_weights;
pub mod layers;
mod native;
mod networks;
mod parameters;
mod precision;
mod tape;
mod values;
mod workspace;

/// The version of burn that the feature `burn` brings; results of its backends depend on it.
pub const BURN_VERSION: &str = "0.22.1";

pub use arithmetic::{Activation, Arithmetic};
pub use backend::{Backend, Compute};
pub use device::open_device;
pub use error::NetworkError;
pub use gradients::Gradients;
pub use graph::{Graph, Shape};
pub use hidden_reader::HiddenReader;
pub use inference::Inference;
pub use initial_weights::fan_in_bound;
pub use networks::{Inputs, Known, Networks, Outputs};
pub use parameters::Parameters;
pub use precision::Precision;
pub use tape::NetworkTape;
pub use values::{Slice, SliceMut, Values};
pub use workspace::{GradientPart, Workspace};
