//! Files of kind "linear-gaussian": the matrices of a model, with names for its coordinates.

mod arrays;
mod factor;
mod formulas;
mod noise;
mod read;
mod values;

pub(crate) use read::{Matrices, Model, read};
