//! Filters that look ahead: exact where all is linear, unbiased everywhere, and right where a bootstrap filter is wrong in silence.

mod averages;
mod common;
mod exact;
mod models;
mod planted;
mod runs;
mod several;
mod silent;
mod smoothing;
mod unbiased;
