//! Learned proposals for particle filters: networks that emit a sampling distribution.
//!
//! A network maps what a particle knows, `x_{t−1}` and `y_t`, to the parameters of `q(x_t | x_{t−1}, y_t)`; from there on
//! everything probabilistic happens on the host in `f64`. The precision of the network decides how good a proposal is,
//! never whether the weights are right.
//!
//! Each family implements [`motes_smc::Proposal`], by which a filter uses it, and [`Learnable`], by which it is trained.
//! Three are Gaussian, [`Fcnn`], [`Rnn`] and [`Gnn`]: they differ in their networks alone. [`Psi`]
//! transforms uniform noise by an invertible network. [`Standardised`] is any of them in units that suit the system.
//!
//! ```
//! use motes_models::{GraphDiffusion, GraphDiffusionConfig, Seed};
//! use motes_proposals::{Backend, Fcnn, FcnnConfig};
//! use motes_smc::{FilterSettings, ParticleFilter};
//!
//! let seed = Seed::from_u64(1);
//! let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
//! // Three times, and initial weights drawn from our own seed.
//! let config = FcnnConfig { widths: vec![16, 16], ..FcnnConfig::paper() };
//! let proposal = Fcnn::new(&config, &system, 3, Backend::Native.into(), &seed.child("weights"))?;
//! let stream = seed.child("filter").stream();
//! let mut filter = ParticleFilter::new(&system, proposal, FilterSettings::new(50), stream)?;
//! filter.step(&[1.0, 0.8, 1.2, 0.9])?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod arithmetic;
mod backend;
mod family;
mod fcnn;
mod gaussian;
mod gnn;
mod gradients;
mod initial_weights;
mod lanes;
mod learnable;
mod mlp;
mod native;
mod parameters;
mod plain;
mod psi;
mod rnn;
mod saved;
mod standardised;
mod values;
mod workspace;

/// The version of burn that networks are computed with; results depend on it.
pub const BURN_VERSION: &str = "0.22.1";

pub use arithmetic::{Activation, Arithmetic};
pub use backend::{Backend, Compute, Precision};
pub use family::Family;
pub use fcnn::{Fcnn, FcnnConfig};
pub use gaussian::{GaussianBatch, GaussianProposal, Hidden, KernelCovariance};
pub use gnn::{Adapter, Gnn, GnnConfig, Graph, Shape};
pub use gradients::Gradients;
pub use learnable::{Learnable, Tape};
pub use parameters::Parameters;
pub use psi::{Psi, PsiConfig};
pub use rnn::{Cell, Rnn, RnnConfig};
pub use saved::{SAVED_FORMAT, SavedError, load, save};
pub use standardised::{Frame, Frames, Origin, Standardised, StandardisedConfig};
pub use values::{Slice, Values};
pub use workspace::{GradientPart, Workspace};
