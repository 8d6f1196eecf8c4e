//! Particle filters: log-weights, resampling, log-evidence, and designed proposals.
