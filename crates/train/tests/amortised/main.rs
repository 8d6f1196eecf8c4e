//! Proposals that are learned once: heads, draws, evidence, and what learning makes of them.

mod conditional;
mod evidence;
mod heads;
mod learning;
mod models;
