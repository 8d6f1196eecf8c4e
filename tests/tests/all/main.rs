//! Tests across the crates, in one program: a program each would compile the same generic code twenty times.

mod adam;
mod amortised;
mod asymmetric;
mod bad_input;
mod bank;
mod collapse;
mod convergence;
mod evidence;
mod fcnn;
mod gnn;
mod gradients;
mod house;
mod maps;
mod modules;
mod parity;
mod planted;
mod psi;
mod resamplers;
mod resume;
mod rnn;
mod saved;
mod sequences;
mod standardised;
mod uniform_optimum;
