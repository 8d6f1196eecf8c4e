//! Networks computed here, on the host, by whole layers: the backend that experiments use.
//!
//! Products of a batch of particles with weights are our own, others faer's. Around them are layers fused with their activations,
//! derivatives taken from outputs, gradients of shared weights formed once from many times, memory that is used again.

mod affine;
mod arithmetic;
mod buffers;
mod cells;
mod deduplicate;
mod derivatives;
mod gradient_accumulator;
mod graph;
mod infer;
mod memory;
mod products;
mod step;
mod tape;

pub(crate) use infer::{Memory, infer};
pub(crate) use memory::Scratch;
pub(crate) use products::Multiply;
pub(crate) use tape::NativeTape;
