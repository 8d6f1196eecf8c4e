//! Proposals that were learned.

use motes::train::LearnObjective;
use motes::{LearnOptions, LearnedProposal, LearnedWorth, base_named, head_named, network_named};
use pyo3::prelude::*;

use crate::arguments::{integer, seed_of, share_of};
use crate::errors::refused;

/// A proposal that was learned for a model.
#[pyclass(frozen, module = "motes._motes")]
pub(crate) struct Proposal(pub(crate) LearnedProposal);

#[pymethods]
impl Proposal {
    #[getter]
    fn name(&self) -> &str {
        self.0.name()
    }

    /// What it was chosen as, in a sentence.
    #[getter]
    fn choice(&self) -> &str {
        &self.0.notes().choice
    }

    /// Gradient steps that were taken.
    #[getter]
    fn updates(&self) -> usize {
        self.0.notes().updates
    }

    /// How long they took.
    #[getter]
    fn seconds(&self) -> f64 {
        self.0.notes().seconds
    }

    /// The root-mean-square error of the log-evidence of simulated sequences with 100 particles, of each that was judged.
    #[getter]
    fn evidence_errors(&self) -> Vec<(String, f64)> {
        let worth = self.0.potential_notes().and_then(|notes| notes.worth.as_ref());
        let all = worth.into_iter().flat_map(LearnedWorth::all);
        all.map(|worth| (worth.proposal.clone(), worth.error)).collect()
    }

    /// The designed proposal that did better on validation sequences, if one did.
    #[getter]
    fn worse_than(&self) -> Option<&str> {
        self.0.notes().worse_than.as_deref()
    }
}

/// The arguments of learning, as the Python function has them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct LearnArguments<'py> {
    objective: String,
    start: Option<Bound<'py, Proposal>>,
    dropout: f64,
    penalty: f64,
    updates: i64,
    budget: Option<f64>,
    steps: i64,
    base: Option<String>,
    head: Option<String>,
    network: String,
    widths: Option<Vec<i64>>,
    seed: i128,
}

impl LearnArguments<'_> {
    /// The options that they ask for.
    pub(crate) fn options(&self) -> PyResult<LearnOptions> {
        let objective =
            LearnObjective::ALL.into_iter().find(|objective| objective.to_string() == self.objective);
        let named = |argument: &'static str, text: &str, reason: String| {
            pyo3::exceptions::PyValueError::new_err(format!("{argument}: {text}: {reason}"))
        };
        if let Some(budget) = self.budget
            && !(budget > 0.0 && budget.is_finite())
        {
            return Err(refused("budget", budget, "a number of seconds above 0"));
        }
        if !(0.0..f64::INFINITY).contains(&self.penalty) {
            return Err(refused("penalty", self.penalty, "a number of at least 0"));
        }
        let base = |text: &String| base_named(text).map_err(|reason| named("base", text, reason));
        let head = |text: &String| head_named(text).map_err(|reason| named("head", text, reason));
        let widths =
            |widths: &Vec<i64>| widths.iter().map(|width| integer("widths", *width, 1, 65536)).collect();
        Ok(LearnOptions {
            objective: objective
                .ok_or_else(|| refused("objective", &self.objective, "inclusive, wake or fivo"))?,
            start: self.start.as_ref().map(|start| start.get().0.clone()),
            dropout: share_of("dropout", self.dropout)?,
            weight_penalty: self.penalty,
            updates: integer("updates", self.updates, 1, 1_000_000_000)?,
            seconds: self.budget,
            steps: integer("steps", self.steps, 2, 1_000_000)?,
            base: self.base.as_ref().map(base).transpose()?,
            head: self.head.as_ref().map(head).transpose()?,
            sees: network_named(&self.network).map_err(|reason| named("network", &self.network, reason))?,
            widths: self.widths.as_ref().map(widths).transpose()?,
            seed: seed_of(self.seed)?,
        })
    }
}
