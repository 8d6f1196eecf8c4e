//! Networks computed by burn, operation by operation, with its automatic differentiation: what the native backend is held against.
//!
//! It is written to be plain, not fast. Inference makes all weights into tensors at each block of particles; a recording does so once.

#[cfg(any(feature = "wgpu", feature = "cuda"))]
mod graphics;
mod library;
mod operations;
mod tape;

pub(crate) use library::Library;
pub(crate) use operations::infer;
pub(crate) use tape::BurnTape;
