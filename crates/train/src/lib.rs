//! Unsupervised training of proposals: from measurements and a model, never from states.
//!
//! [`train`] draws particles from a proposal along sequences of measurements. The model says how likely they are. The
//! reparametrised gradient of an [`Objective`] then moves the proposal's weights. [`TrainingData`] says which sequences.
//!
//! Nothing in this crate takes or returns the states of a system. It takes [`motes_models::Measurements`] only.
//!
//! ```
//! use motes_models::{GraphDiffusion, GraphDiffusionConfig, ModelShape, Seed, simulate};
//! use motes_proposals::{Backend, Family, Fcnn, FcnnConfig};
//! use motes_train::{TrainConfig, train};
//! use std::ops::ControlFlow;
//!
//! let seed = Seed::from_u64(1);
//! let system = GraphDiffusion::random(&GraphDiffusionConfig::new(6), &mut seed.child("graph").stream())?;
//! let measurements = simulate(&system, 4, &mut seed.child("data").stream())?.measurements;
//!
//! let config = FcnnConfig { widths: vec![16, 16], ..FcnnConfig::paper() };
//! let mut proposal = Fcnn::create(&config, &ModelShape::of(&system), 4, Backend::Native.into(), &seed.child("weights"))?;
//! let config = TrainConfig { steps: 20, ..TrainConfig::paper(10) };
//! let mut stream = seed.child("training").stream();
//! let history = train(&mut proposal, &system, &measurements, &config, &mut stream, |_, _| ControlFlow::Continue(()))?;
//! assert!(history.losses[19] < history.losses[0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod adam;
mod checkpoint;
mod data;
mod dropout;
mod error;
mod fit;
mod gradient_flow;
mod gradient_sum;
mod learning;
mod objective;
mod penalty;
mod potentials;
mod rollout;
mod schedule;
mod training;

pub use adam::{Adam, AdamConfig};
pub use data::TrainingData;
pub use error::TrainError;
pub use gradient_flow::GradientFlow;
pub use learning::{LearnConfig, LearnObjective, Learned, check_recorded, learn};
pub use objective::Objective;
pub use potentials::{
    PathRequest, PathSampler, PathSource, PotentialHistory, PotentialLearnConfig, learn_potentials,
};
pub use rollout::{Rollout, rollout};
pub use schedule::Schedule;
pub use training::{History, TrainConfig, Training, train};
