//! Models in Python functions of many particles at a time.

mod distributions;
mod equations;
mod failure;
mod stated;
mod step;

pub(crate) use failure::Failure;
pub(crate) use stated::{Frame, Functions};
