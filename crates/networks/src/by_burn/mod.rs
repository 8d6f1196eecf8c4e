//! Networks computed by burn, operation by operation, with its automatic differentiation: what the native backend is held against.

mod library;
mod operations;
mod tape;

pub(crate) use library::Library;
pub(crate) use operations::infer;
pub(crate) use tape::BurnTape;
