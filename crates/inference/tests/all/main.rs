//! Posteriors that are known, and chains whose diagnostics are known.

mod diagnostics;
mod exactness;
mod iterated;
mod known;
mod log_mean;
mod maximum;
mod posterior;
