//! The report card as a page.

use super::error_figure::error_figure;
use super::page::Page;
use crate::comparing::Comparison;
use crate::output::card::{
    ABOUT_ERRORS, about, about_differences, about_gains, about_reaching, differences, errors, figures,
};
use crate::output::table::Table;

/// What a page of a report card shows.
pub struct CardReport<'a> {
    /// What was done, and with which model.
    pub title: &'a str,
    /// The figures.
    pub comparison: &'a Comparison,
    /// The particles of the card.
    pub particles: usize,
    /// What was done before, a sentence each.
    pub notes: &'a [String],
    /// Reasons not to trust a proposal.
    pub warnings: &'a [String],
    /// Settings, a name and a value each.
    pub settings: &'a [(String, String)],
    /// The command that made the report.
    pub command: &'a str,
}

/// The card as HTML: its tables, and a figure of error against time.
///
/// # Errors
/// What the drawing library says.
pub fn card_report(report: &CardReport<'_>) -> Result<String, Box<dyn std::error::Error>> {
    let comparison = report.comparison;
    let mut page = Page::new(report.title);
    report.notes.iter().for_each(|note| page.note(note));
    page.warnings(report.warnings);
    if !comparison.equal_time.points.is_empty() {
        page.heading("Error at equal time");
        about_gains(comparison).iter().for_each(|gains| page.note(gains));
        page.figure(&error_figure(&comparison.equal_time)?, "Each point is a number of particles.");
        page.note(&comparison.equal_time.to_string());
        page.note(&about_reaching(comparison));
        page.note(ABOUT_ERRORS);
        table(&mut page, errors(comparison));
    }
    page.heading("Report card");
    page.note(&about(comparison, report.particles));
    table(&mut page, figures(comparison));
    if let Some((baseline, differences)) = differences(comparison) {
        page.note(&about_differences(&baseline));
        table(&mut page, differences);
    }
    page.heading("Settings");
    page.table(&["", ""], report.settings.iter().map(|(name, value)| vec![name.clone(), value.clone()]));
    page.command(report.command);
    Ok(page.finish())
}

fn table(page: &mut Page, Table { header, rows }: Table) {
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(&header, rows.into_iter());
}
