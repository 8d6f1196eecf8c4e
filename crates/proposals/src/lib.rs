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
//! use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed};
//! use motes_proposals::{Backend, Family, Fcnn, FcnnConfig};
//! use motes_smc::{FilterSettings, ParticleFilter};
//!
//! let seed = Seed::from_u64(1);
//! let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
//! // Three times, and initial weights drawn from our own seed.
//! let config = FcnnConfig { widths: vec![16, 16], ..FcnnConfig::paper() };
//! let proposal = Fcnn::create(&config, &ModelShape::of(&system), 3, Backend::Native.into(), &seed.child("weights"))?;
//! let stream = seed.child("filter").stream();
//! let mut filter = ParticleFilter::new(&system, proposal, FilterSettings::new(50), stream)?;
//! filter.step(&[1.0, 0.8, 1.2, 0.9])?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod amortised;
mod family;
mod fcnn;
mod gaussian;
mod gnn;
mod lanes;
mod learnable;
mod over_time;
mod potentials;
mod psi;
mod rnn;
mod saved;
mod settings;
mod standardised;

pub use amortised::{
    Amortised, AmortisedBatch, AmortisedConfig, AmortisedScratch, Base, Covariance, DrawnStage, Draws,
    Examples, FlowHead, GaussianHead, Head, HeadConfig, KernelHead, MixtureHead, Reparametrised, Sees, Stage,
    Times,
};
pub use family::{Family, Parametric};
pub use fcnn::{Fcnn, FcnnConfig, FcnnNetworks};
pub use gaussian::{
    GaussianNetworks, GaussianProposal, GaussianScratch, Hidden, HiddenRows, KernelCovariance,
};
pub use gnn::{Adapter, Gnn, GnnConfig, GnnNetworks};
pub use learnable::{Learnable, Tape};
pub use motes_networks as networks;
pub use motes_networks::layers::Cell;
pub use motes_networks::{
    Backend, Compute, GradientPart, Gradients, HiddenReader, Parameters, Precision, Slice, Values, Workspace,
};
pub use over_time::OverTime;
pub use potentials::{
    LearnedPotentials, LearnedPotentialsConfig, OnLinePotentials, PathBatch, PotentialStandards, StepFeatures,
};
pub use psi::{Psi, PsiConfig, PsiScratch};
pub use rnn::{Rnn, RnnConfig, RnnNetworks};
pub use saved::{
    Fingerprint, OtherSystem, SAVED_FORMAT, SavedError, SavedFiles, holds, load, load_to_tune, notes, save,
    save_both,
};
pub use standardised::{Frame, Frames, Origin, Standardised, StandardisedConfig, StandardisedScratch};
