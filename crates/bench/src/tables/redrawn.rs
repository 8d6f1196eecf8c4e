//! How many trajectories ran away.

use std::collections::BTreeMap;

use crate::store::{Outcome, Record};

/// Says how many trajectories were drawn in vain; nothing where none ever is.
pub(crate) fn redrawn(records: &[Record]) -> Option<String> {
    // All methods and numbers of particles share the trajectory of a repetition.
    let mut by_repetition = BTreeMap::new();
    for record in records {
        if let Outcome::Metrics(metrics) = &record.outcome
            && let Some(metric) = metrics.iter().find(|metric| metric.name == "trajectories_redrawn")
        {
            by_repetition.insert(record.point.repetition, metric.value);
        }
    }
    if by_repetition.is_empty() {
        return None;
    }
    let (kept, left) = (by_repetition.len(), by_repetition.values().sum::<f64>());
    let all = kept as f64 + left;
    Some(format!("Of {all} trajectories that were drawn, {left} ran away and {kept} were kept."))
}
