//! Models in Python functions of many particles at a time.

mod called;
mod distributions;
mod failure;
mod stated;
mod step;

pub(crate) use failure::Failure;
pub(crate) use stated::{Frame, Functions};
