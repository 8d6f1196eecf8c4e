//! The formulas of a section as one graph, in which what is computed twice stands once.

mod build;
mod compound;
mod coordinate;
mod linear;
mod nodes;
mod parts;

pub(crate) use build::{Built, build};
pub(crate) use coordinate::{Coordinate, Made, Output, Part};
pub(crate) use linear::Degree;
pub(crate) use nodes::{Graph, Id, Operation};
