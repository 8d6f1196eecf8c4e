//! Running one unit: what it needs, how it goes on, and what it finds.

mod dispatch;
mod evaluation;
mod evaluator;
mod learning;
mod once;
mod proposal_store;
mod run;
mod run_filters;

pub use evaluation::Evaluation;
pub use evaluator::Evaluator;
