//! The report card as tables and as JSON.

mod json;
mod tables;

pub use json::card_json;
pub(super) use tables::{
    ABOUT_ERRORS, about, about_differences, about_gains, about_reaching, differences, errors, figures,
};

use super::table::markdown;
use crate::comparing::Comparison;

/// The card as tables for a person.
pub fn card_text(comparison: &Comparison, particles: usize) -> String {
    let gains = about_gains(comparison).map_or(String::new(), |gains| gains + "\n\n");
    let mut text = format!("{gains}{}\n\n{}", about(comparison, particles), markdown(&figures(comparison)));
    if let Some((baseline, table)) = differences(comparison) {
        text += &format!("\n{}\n\n{}", about_differences(&baseline), markdown(&table));
    }
    if !comparison.equal_time.points.is_empty() {
        text += &format!("\n{ABOUT_ERRORS}\n\n{}", markdown(&errors(comparison)));
        text += &format!("\n{}\n{}\n", comparison.equal_time, about_reaching(comparison));
    }
    text
}
