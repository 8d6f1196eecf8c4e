//! Learned proposals for particle filters: networks that emit a sampling distribution.
