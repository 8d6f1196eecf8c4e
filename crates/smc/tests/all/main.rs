//! Filters, proposals, smoothers and diagnostics: what they are held against.

mod evidence;
mod failed;
mod fixed_lag;
mod forecast;
mod linearised;
mod min_degeneracy;
mod missing;
mod perturbed;
mod second_opinion;
mod smoothing;
mod snapshot;
mod steps;
mod threads;
