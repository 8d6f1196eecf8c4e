//! Distributions, equations, batches, exact inference: what models are held against.

mod batched;
mod batched_counts;
mod batches;
mod distributions;
mod equations;
mod exact_inference;
mod experiments_as_transports;
mod gradients;
mod normals;
mod quantiles;
mod sub_steps;
mod transports;
mod wrapped;
