//! Proposals that are learned once: heads, draws, evidence, and what learning makes of them.

mod conditional;
mod evidence;
mod evidence_gradient;
mod heads;
mod learning;
mod models;
mod objectives;
mod potentials;
