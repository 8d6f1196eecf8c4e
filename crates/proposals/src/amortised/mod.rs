//! Proposals that are learned once and filter any sequence of a model.

mod base;
mod batch;
mod config;
mod draws;
mod evidence;
mod examples;
mod heads;
mod hidden;
mod inclusive;
mod inputs;
mod networks;
mod noise;
mod proposal;
mod propose;
mod scratch;
mod theta;
mod tiles;
mod units;

pub use base::Base;
pub use batch::AmortisedBatch;
pub use config::{AmortisedConfig, Sees};
pub use draws::{DrawnStage, Draws};
pub use examples::{Examples, Stage};
pub use heads::{
    Covariance, FlowHead, GaussianHead, Head, HeadConfig, KernelHead, MixtureHead, Reparametrised,
};
pub use inclusive::Times;
pub use proposal::Amortised;
pub use scratch::AmortisedScratch;
