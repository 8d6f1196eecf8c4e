//! Models of files, from outside.

mod arithmetic;
mod choices;
mod closed_form;
mod distributions;
mod examples;
mod explain;
mod fuzz;
mod growth;
mod helpers;
mod matrices;
mod pages;
mod random_formulas;
mod refusals;
mod refused;
mod support;
mod vectors;
mod wrapped;
