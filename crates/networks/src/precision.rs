//! In which precision networks are computed.

/// The floating-point type of network weights and activations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32 bits, for work.
    #[default]
    F32,
    /// 64 bits, for tests against finite differences.
    F64,
}
