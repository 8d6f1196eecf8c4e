//! The order of tables.

use crate::config::Plan;
use crate::store::Record;

/// Sorts records as tables show them: by panel and method in the experiment's order, then x, then repetition.
pub(crate) fn sort(plan: &Plan, records: &mut [Record]) {
    let experiment = &plan.experiment;
    records.sort_by_key(|record| {
        let point = &record.point;
        let panel = experiment.panels.iter().position(|panel| panel.name == point.panel);
        let method = experiment.methods.iter().position(|method| *method == point.method);
        (panel, method, point.x, point.repetition)
    });
}
