//! Simulated series as flat arrays.

/// States, measurements, times and inputs, series after series.
pub(crate) fn flat(simulated: &motes::Simulated) -> [Vec<f64>; 4] {
    let motes::Simulated { series, rows, .. } = simulated;
    let rows = || rows.iter().flatten();
    let inputs = rows().flat_map(|row| &row.inputs);
    [
        series.iter().flat_map(|one| one.states.values().iter().copied()).collect(),
        series.iter().flat_map(|one| one.measurements.values().iter().copied()).collect(),
        rows().map(motes::SimulatedRow::time).collect(),
        inputs.map(|value| value.unwrap_or(f64::NAN)).collect(),
    ]
}

/// What the times of all rows are called, where they are no numbers but dates.
pub(crate) fn labels(simulated: &motes::Simulated) -> Option<Vec<String>> {
    let labels: Option<Vec<String>> = simulated.rows.iter().flatten().map(|row| row.label.clone()).collect();
    labels.filter(|labels| labels.iter().any(|label| label.trim().parse::<f64>().is_err()))
}
