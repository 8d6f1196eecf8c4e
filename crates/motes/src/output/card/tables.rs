//! What a report card shows, cell by cell.

use crate::comparing::{Comparison, Figure, Gain};
use crate::output::table::Table;

/// What was compared, and with what.
pub(in crate::output) fn about(comparison: &Comparison, particles: usize) -> String {
    let [sequences, times] = comparison.size;
    let error = comparison.reference_errors.iter().copied().reduce(f64::max);
    let error = error.map_or(String::new(), |error| {
        format!(" The standard error of its log-evidence is at most {error:.2}.")
    });
    format!(
        "{sequences} sequences, {times} times in all, K = {particles}. Reference: {}.{error}",
        comparison.reference
    )
}

/// The figures of each proposal.
pub(in crate::output) fn figures(comparison: &Comparison) -> Table {
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
    let rows = comparison.cards.iter().map(|(contender, card)| {
        vec![
            contender.to_string(),
            figure(card.ess_fraction),
            card.ess_fraction_q01.map_or("–".into(), decimal),
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
    Table { header: header.map(String::from).to_vec(), rows: rows.collect() }
}

/// Differences from the baseline, sequence by sequence, and its name; none where there is one proposal alone.
pub(in crate::output) fn differences(comparison: &Comparison) -> Option<(String, Table)> {
    let (baseline, paired) = comparison.paired.as_ref()?;
    let header = ["", "ESS/K", "evidence"].map(String::from).to_vec();
    let rows = paired.iter().map(|paired| {
        vec![paired.contender.to_string(), figure(paired.ess_fraction), figure(paired.log_evidence)]
    });
    Some((baseline.to_string(), Table { header, rows: rows.collect() }))
}

/// Error and time of each proposal at each number of particles.
pub(in crate::output) fn errors(comparison: &Comparison) -> Table {
    let points = &comparison.equal_time.points;
    let mut counts: Vec<usize> = points.iter().map(|point| point.particles).collect();
    counts.sort_unstable();
    counts.dedup();
    let header = std::iter::once(String::new()).chain(counts.iter().map(|k| format!("K = {k}")));
    let rows = comparison.cards.iter().map(|(contender, _)| {
        let cell = |k: &usize| {
            let point = points.iter().find(|point| point.contender == *contender && point.particles == *k);
            point.map_or(String::new(), |point| {
                let error = point.error().map_or("lost".to_string(), decimal);
                format!("{error} ({:.4})", point.ms_per_step)
            })
        };
        std::iter::once(contender.to_string()).chain(counts.iter().map(cell)).collect()
    });
    Table { header: header.collect(), rows: rows.collect() }
}

/// How much faster than the best designed filter the others are, in a sentence; nothing where there is nothing to compare.
pub(in crate::output) fn about_gains(comparison: &Comparison) -> Option<String> {
    let (over, gains) = comparison.equal_time.gains()?;
    let part = |gain: &Gain| {
        let interval =
            gain.interval.map(|[low, high]| format!(" ({} to {})", two_digits(low), two_digits(high)));
        format!("{} {}{}", gain.contender, two_digits(gain.ratio), interval.unwrap_or_default())
    };
    let parts: Vec<String> = gains.iter().map(part).collect();
    let same = comparison.cards.iter().filter_map(|(contender, _)| {
        Some(format!(" {contender} filters by {}.", contender.designed_filter()?))
    });
    Some(format!(
        "Speed at the same error of the log-evidence, each with its best number of particles; {over}, the best designed on-line filter, is 1 and above 1 is faster (90 % interval): {}.{}",
        parts.join("; "),
        same.collect::<String>()
    ))
}

/// A ratio with two digits that count.
fn two_digits(value: f64) -> String {
    match value {
        0.0 => "0".into(),
        _ if !(1e-3..1e5).contains(&value) => format!("{value:.1e}"),
        _ => {
            let scale = 10_f64.powf(1.0 - value.log10().floor());
            let rounded = (value * scale).round() / scale;
            let digits = (1.0 - rounded.log10().floor()).max(0.0) as usize;
            format!("{rounded:.digits$}")
        }
    }
}

/// What an error of 1 takes, in a sentence.
pub(in crate::output) fn about_reaching(comparison: &Comparison) -> String {
    let reached = comparison.equal_time.reaching(1.0);
    let parts: Vec<String> = reached.iter().map(|(name, reached)| format!("{name} {reached}")).collect();
    format!("An error of 1 takes: {}.", parts.join("; "))
}

/// What [`differences`] are, in a sentence.
pub(in crate::output) fn about_differences(baseline: &str) -> String {
    format!("Difference from {baseline}, sequence by sequence, ± half a 95 % interval:")
}

/// What [`errors`] are, in a sentence.
pub(in crate::output) const ABOUT_ERRORS: &str =
    "Root mean square error of the log-evidence, and in brackets milliseconds a step:";

/// A mean with its interval.
fn figure(figure: Option<Figure>) -> String {
    match figure {
        None => "–".into(),
        Some(Figure { mean, half_width: None }) => decimal(mean),
        Some(Figure { mean, half_width: Some(width) }) => format!("{} ± {}", decimal(mean), decimal(width)),
    }
}

/// Three decimals, or powers of ten where nobody could read so many digits.
fn decimal(value: f64) -> String {
    if value.abs() < 1e6 { format!("{value:.3}") } else { format!("{value:.1e}") }
}
