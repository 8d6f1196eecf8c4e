//! Proposals that are learned once, of models that are stated once: gradient steps, and filters with them.

mod filtering;
mod folder;
mod learning;
mod models;
mod sizes;

pub(crate) use folder::write;
pub(crate) use models::{MODELS, operations, operations_of_step};
pub(crate) use sizes::{HORIZON, ROWS};

use filtering::Filtering;
use learning::Learning;
use models::{Growth, Tracking};

use crate::task::{LearnTask, LearnedTask};
use crate::work::Work;

/// Gets ready to filter.
pub(crate) fn filtering(task: &LearnedTask) -> Result<Box<dyn Work>, String> {
    match task.model.as_str() {
        "growth" => Ok(Box::new(Filtering::of(Growth, task)?)),
        "tracking" => Ok(Box::new(Filtering::of(Tracking, task)?)),
        other => Err(format!("there is no model {other}")),
    }
}

/// Gets ready to learn.
pub(crate) fn learning(task: &LearnTask) -> Result<Box<dyn Work>, String> {
    match task.model.as_str() {
        "growth" => Ok(Box::new(Learning::of(Growth, task)?)),
        "tracking" => Ok(Box::new(Learning::of(Tracking, task)?)),
        other => Err(format!("there is no model {other}")),
    }
}
