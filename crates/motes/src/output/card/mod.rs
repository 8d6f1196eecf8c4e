//! The report card as tables and as JSON.

mod json;
mod tables;

pub use json::card_json;
pub(super) use tables::{
    ABOUT_ERRORS, Table, about, about_differences, about_reaching, differences, errors, figures,
};

use crate::comparing::Comparison;

/// The card as tables for a person.
pub fn card_text(comparison: &Comparison, particles: usize) -> String {
    let mut text = format!("{}\n\n{}", about(comparison, particles), markdown(&figures(comparison)));
    if let Some((baseline, table)) = differences(comparison) {
        text += &format!("\n{}\n\n{}", about_differences(&baseline), markdown(&table));
    }
    if !comparison.equal_time.points.is_empty() {
        text += &format!("\n{ABOUT_ERRORS}\n\n{}", markdown(&errors(comparison)));
        text += &format!("\n{}\n{}\n", comparison.equal_time, about_reaching(comparison));
    }
    text
}

/// Cells in columns, as Markdown has them.
fn markdown(Table { header, rows }: &Table) -> String {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| &row[column]).chain([&header[column]]);
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &[String]| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        format!("| {} |\n", padded.collect::<Vec<_>>().join(" | "))
    };
    let rule = widths.iter().enumerate().map(|(column, width)| match column {
        0 => format!("{}-", "-".repeat(width + 1)),
        _ => format!("{}:", "-".repeat(width + 1)),
    });
    let rule = format!("|{}|\n", rule.collect::<Vec<_>>().join("|"));
    std::iter::once(line(header)).chain([rule]).chain(rows.iter().map(|row| line(row))).collect()
}
