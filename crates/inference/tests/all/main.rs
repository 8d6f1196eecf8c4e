//! Posteriors that are known, and chains whose diagnostics are known.

mod diagnostics;
mod known;
mod maximum;
mod posterior;
