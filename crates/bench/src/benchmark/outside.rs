//! What others found beside what was found here.

use motes::{Card, Comparison, Figure};

use super::file::Outside;

/// One of the card's figures by its key.
pub(super) fn figure(card: &Card, key: &str) -> Option<Figure> {
    match key {
        "ess_fraction" => card.ess_fraction,
        "log_evidence_gap" => card.log_evidence_gap,
        "e_l" => card.e_l,
        "e_x" => card.e_x,
        _ => None,
    }
}

/// A table of a figure: what others report, and then each proposal of the card. Nothing where others report nothing.
pub(super) fn table(outside: &[Outside], comparison: &Comparison) -> String {
    let mut keys: Vec<&str> = outside.iter().map(|found| found.figure.as_str()).collect();
    keys.sort_unstable();
    keys.dedup();
    let mut text = String::new();
    for key in keys {
        text += &format!("\n`{key}` beside what others report:\n\n| | {key} | source |\n|---|---:|---|\n");
        for found in outside.iter().filter(|found| found.figure == key) {
            text += &format!("| {} | {} | {} |\n", found.method, found.value, found.source);
        }
        for (name, card) in &comparison.cards {
            let ours = match figure(card, key) {
                Some(Figure { mean, half_width: Some(width) }) => format!("{mean:.4} ± {width:.4}"),
                Some(Figure { mean, half_width: None }) => format!("{mean:.4}"),
                None => "–".into(),
            };
            text += &format!("| **{name}** | {ours} | this run |\n");
        }
    }
    text
}
