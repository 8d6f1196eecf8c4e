//! The command and its library, from files to tables.

mod another_model;
mod bounded_optimum;
mod calibration;
mod checkpoint;
mod common;
mod continuations;
mod data_as_meant;
mod evidence;
mod fit_command;
mod fitting;
mod iterated;
mod learning;
mod learning_over_prior;
mod log_evidence;
mod own_model;
mod own_sections;
mod priors;
mod quantiles;
mod refusals;
mod results;
mod small_models;
mod smoothing;
mod timeline;
mod trust;
