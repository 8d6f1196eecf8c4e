//! The arbitrary proposal of the paper: an invertible transform of uniform noise.
//!
//! Here the network *is* the distribution, so the transform, its inverse and its determinants are computed on the host in
//! `f64`; only the weights live where those of the other families do.

mod inverse;
mod map;
mod propose;
mod tape;
mod transform;

pub use propose::PsiScratch;
pub use transform::{Psi, PsiConfig};
