//! Files of kind "linear-gaussian": the matrices of a model, with names for its coordinates.

mod read;
mod values;

pub(crate) use read::{Matrices, read};
