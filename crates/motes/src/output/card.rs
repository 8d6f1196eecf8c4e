//! The report card as a table and as JSON.

use std::fmt::Write;

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::comparing::{Card, Comparison, Figure};

/// The keys of a proposal's figures.
#[derive(Serialize)]
struct CardObject {
    ess_fraction: Option<f64>,
    ess_fraction_q01: f64,
    log_evidence_gap: Option<f64>,
    e_l: Option<f64>,
    e_x: Option<f64>,
    pareto_k: Option<f64>,
    coverage_50: Option<f64>,
    coverage_90: Option<f64>,
    particle_steps_per_second: f64,
    ms_per_step: f64,
    lost: usize,
}

impl From<&Card> for CardObject {
    fn from(card: &Card) -> Self {
        let mean = |figure: Option<Figure>| figure.map(|figure| figure.mean);
        CardObject {
            ess_fraction: mean(card.ess_fraction),
            ess_fraction_q01: card.ess_fraction_q01,
            // One that collapsed has no evidence.
            log_evidence_gap: mean(card.log_evidence_gap).filter(|_| card.lost == 0),
            e_l: mean(card.e_l),
            e_x: mean(card.e_x),
            pareto_k: card.pareto_k,
            coverage_50: card.coverage_50,
            coverage_90: card.coverage_90,
            particle_steps_per_second: card.particle_steps_per_second,
            ms_per_step: card.ms_per_step,
            lost: card.lost,
        }
    }
}

/// The object of a comparison: the figures of each method by its name, error against time, and how long it took to learn.
pub fn card_json(comparison: &Comparison, training_seconds: Option<f64>) -> String {
    let mut methods = Map::new();
    for (proposal, card) in &comparison.cards {
        methods.insert(
            proposal.to_string(),
            serde_json::to_value(CardObject::from(card)).unwrap_or(Value::Null),
        );
    }
    let points = comparison.equal_time.points.iter().map(|point| {
        json!({
            "method": point.proposal.to_string(),
            "particles": point.particles,
            "ms_per_step": point.ms_per_step,
            "log_evidence_rmse": point.error,
        })
    });
    let object = json!({
        "methods": methods,
        "training_seconds": training_seconds,
        "reference": comparison.reference,
        "equal_time": points.collect::<Vec<_>>(),
    });
    object.to_string() + "\n"
}

/// The card as tables for a person.
pub fn card_text(comparison: &Comparison, particles: usize) -> String {
    let [sequences, times] = comparison.size;
    let mut text = format!(
        "{sequences} sequences, {times} times in all, K = {particles}. Reference: {}.\n\n",
        comparison.reference
    );
    let header = [
        "",
        "ESS/K",
        "1 % quantile",
        "evidence gap",
        "e_l",
        "e_x",
        "Pareto k",
        "in 50 %",
        "in 90 %",
        "lost",
        "ms a step",
    ];
    let plain = |value: Option<f64>| value.map_or("–".to_string(), |value| format!("{value:.2}"));
    let rows = comparison.cards.iter().map(|(proposal, card)| {
        vec![
            proposal.to_string(),
            figure(card.ess_fraction),
            format!("{:.3}", card.ess_fraction_q01),
            figure(card.log_evidence_gap),
            figure(card.e_l),
            figure(card.e_x),
            plain(card.pareto_k),
            plain(card.coverage_50),
            plain(card.coverage_90),
            card.lost.to_string(),
            format!("{:.4}", card.ms_per_step),
        ]
    });
    text += &table(&header.map(String::from), &rows.collect::<Vec<_>>());
    text += "\nRoot mean square error of the log-evidence, and ms a step:\n\n";
    let mut counts: Vec<usize> = comparison.equal_time.points.iter().map(|point| point.particles).collect();
    counts.sort_unstable();
    counts.dedup();
    let header: Vec<String> =
        std::iter::once(String::new()).chain(counts.iter().map(|k| format!("K = {k}"))).collect();
    let rows = comparison.cards.iter().map(|(proposal, _)| {
        let cell = |k: &usize| {
            let point =
                comparison.equal_time.points.iter().find(|p| p.proposal == *proposal && p.particles == *k);
            point.map_or(String::new(), |point| {
                let error = point.error.map_or("lost".to_string(), |error| format!("{error:.3}"));
                format!("{error} ({:.4})", point.ms_per_step)
            })
        };
        std::iter::once(proposal.to_string()).chain(counts.iter().map(cell)).collect()
    });
    text += &table(&header, &rows.collect::<Vec<_>>());
    let _ = writeln!(text, "\n{}", comparison.equal_time);
    text
}

/// A mean with its interval.
fn figure(figure: Option<Figure>) -> String {
    match figure {
        None => "–".into(),
        Some(Figure { mean, half_width: None }) => format!("{mean:.3}"),
        Some(Figure { mean, half_width: Some(width) }) => format!("{mean:.3} ± {width:.3}"),
    }
}

/// Cells in columns, as Markdown has them.
fn table(header: &[String], rows: &[Vec<String>]) -> String {
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
