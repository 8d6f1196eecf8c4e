//! Models of files, from outside.

mod arithmetic;
mod choices;
mod closed_form;
mod compounds;
mod distributions;
mod draws;
mod exact;
mod examples;
mod explain;
mod functions;
mod fuzz;
mod growth;
mod helpers;
mod matrices;
mod pages;
mod parameters_of_particles;
mod priors;
mod random_formulas;
mod refusals;
mod refused;
mod schedule;
mod shares;
mod support;
mod vectors;
mod wrapped;
