//! table.md of a benchmark: the card, what learning took, and what others found.

use motes::output::card_text;
use motes::{Comparison, LearnedProposal};

use super::outside;
use super::plan::BenchmarkPlan;

pub(super) fn table(plan: &BenchmarkPlan, learned: &[LearnedProposal], comparison: &Comparison) -> String {
    let title = &plan.benchmark.title;
    let mut text = format!("{title} ({}, profile {})\n\n", plan.name, plan.profile_name);
    text += &card_text(comparison, plan.profile.particles);
    if !learned.is_empty() {
        text += "\n| learned | updates | seconds | what it is |\n|---|---:|---:|---|\n";
    }
    for proposal in learned {
        let notes = proposal.notes();
        text += &format!(
            "| {} | {} | {:.1} | {} |\n",
            proposal.name(),
            notes.updates,
            notes.seconds,
            notes.choice
        );
    }
    text + &outside::table(&plan.benchmark.outside, comparison)
}
