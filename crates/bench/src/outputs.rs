//! The files of a figure, made of all its units.

use crate::config::Plan;
use crate::figure::{figure, series_figure};
use crate::manifest::{manifest, processors, revisions};
use crate::store::{Record, Store, StoreError};
use crate::tables::{
    equal_time, failures_csv, markdown, redrawn, series_csv, summarise, summary_csv, timings_csv, units_csv,
};
use motes_cli::{result, status};

/// Writes every table and the figure of these units, and prints the table.
pub(crate) fn write_outputs(plan: &Plan, store: &Store, records: &[Record]) -> Result<(), StoreError> {
    let figure_name = &plan.figure;
    let rows = summarise(records);
    let (axis, title) = (plan.experiment.axis.symbol(), &plan.experiment.title);
    let title = format!("{title} ({figure_name}, profile {})", plan.profile_name);
    let mut table = markdown(&title, axis, &rows, &plan.experiment.printed);
    if let Some(note) = redrawn(records) {
        table += &format!("\n{note}\n");
    }
    if let Some(costs) = equal_time(axis, records) {
        table += &format!("\n{costs}");
    }
    store.write_file("units.csv", &units_csv(figure_name, records))?;
    store.write_file("timings.csv", &timings_csv(figure_name, records))?;
    store.write_file("failures.csv", &failures_csv(figure_name, records))?;
    store.write_file("summary.csv", &summary_csv(figure_name, &rows))?;
    store.write_file("table.md", &table)?;
    store.write_file("manifest.json", &manifest(plan, records))?;
    if !rows.is_empty() {
        let svg = match &plan.experiment.series {
            None => figure(plan, &title, &rows),
            Some(shown) => series_figure(shown, &title, records),
        };
        store.write_file("figure.svg", &svg.map_err(|error| StoreError::Figure(error.to_string()))?)?;
    }
    if plan.experiment.series.is_some() {
        store.write_file("series.csv", &series_csv(figure_name, records))?;
    }
    let of =
        [(revisions(records).len(), "source revisions"), (processors(records).len(), "kinds of processors")];
    for (count, kind) in of.into_iter().filter(|(count, _)| *count > 1) {
        status(&format!("these units are of {count} {kind}; manifest.json lists them"));
    }
    result(&table);
    result(&format!("written to {}", store.folder().display()));
    Ok(())
}
