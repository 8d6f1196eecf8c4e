//! table.md: medians ± standard deviations, ready to paste.

use std::collections::BTreeMap;

use motes_smc::{LEAST_EFFECTIVE_PARTICLES, PARETO_K_LIMIT};

use super::summary::Row;
use crate::config::Method;

/// Metrics with a column of their own, and what its head says.
const COLUMNS: [(&str, &str); 14] = [
    ("mse_S", "MSE of S"),
    ("mse_I", "MSE of I"),
    ("mse_R", "MSE of R"),
    ("log_evidence_mse", "squared error of log ẑ"),
    ("nmse_smoothed_single", "NMSE, smoothed, one run"),
    ("nmse_smoothed", "NMSE, smoothed"),
    ("nmse_final", "NMSE, last time"),
    ("nmse_final_single", "NMSE, last time, one run"),
    ("nmse_posterior", "NMSE to posterior mean"),
    ("nmse_posterior_exact", "NMSE to posterior mean, exact densities"),
    ("nmse_all", "NMSE, all times"),
    ("ess", "ESS"),
    ("lost_runs", "lost runs"),
    ("tail_index", "tail index"),
];

/// Errors from a posterior mean that may itself be an estimate, and the metric that says how far two estimates of it are apart.
const ESTIMATED: [(&str, &str); 3] = [
    ("nmse_posterior", "nmse_posterior_reference"),
    ("nmse_posterior_exact", "nmse_posterior_exact_reference"),
    ("nmse_smoothed_single", "nmse_smoothed_reference"),
];

/// An error is known well while two estimates of the posterior mean are apart by no more than this share of it.
const REFERENCE_SHARE: f64 = 0.1;

/// What the paper prints: by method and metric.
pub(crate) type Printed = BTreeMap<Method, BTreeMap<String, f64>>;

/// The summary as a Markdown table: a line for each panel, x and method, a column for each metric that is known of one, and beside it
/// what the paper prints.
pub(crate) fn markdown(title: &str, axis: &str, rows: &[Row], printed: &Printed) -> String {
    let there = |metric: &str| rows.iter().any(|row| row.metric == metric && row.n_ok > 0);
    let columns: Vec<(&str, &str)> = COLUMNS.into_iter().filter(|(metric, _)| there(metric)).collect();
    let is_printed = |metric: &str| printed.values().any(|values| values.contains_key(metric));
    let heads: Vec<String> = columns
        .iter()
        .map(|(metric, head)| match is_printed(metric) {
            true => format!("{head} | paper"),
            false => (*head).to_string(),
        })
        .collect();
    let width = columns.len() + columns.iter().filter(|(metric, _)| is_printed(metric)).count();
    let mut text = format!(
        "{title}\n\nMedian ± standard deviation over n repetitions, or over so many as stand in brackets.\n\n"
    );
    let joined = |cells: &[String]| cells.iter().map(|cell| format!(" {cell} |")).collect::<String>();
    text += &format!("| panel | {axis} | method |{} n |\n", joined(&heads));
    text += &format!("|---|---:|---|{}---:|\n", "---:|".repeat(width));
    let mut points = points(rows);
    // By x before method: methods are read against each other.
    let panels: Vec<&String> = points.iter().map(|row| &row.panel).collect();
    let order = |panel: &String| panels.iter().position(|known| *known == panel);
    points.sort_by_key(|row| (order(&row.panel), row.x));
    for point in points {
        let of = |metric: &str| rows.iter().find(|row| are_of_one_point(row, point) && row.metric == metric);
        let cells: Vec<String> = columns
            .iter()
            .map(|(metric, _)| {
                let ours = match of(metric) {
                    Some(row) if row.n_ok > 0 => {
                        let of =
                            if row.n_ok == point.n_ok { String::new() } else { format!(" ({})", row.n_ok) };
                        // One value has no deviation.
                        let deviation =
                            if row.n_ok > 1 { format!(" ± {}", short(row.std)) } else { String::new() };
                        format!("{}{deviation}{of}", short(row.median))
                    }
                    _ => "–".into(),
                };
                if !is_printed(metric) {
                    return ours;
                }
                let theirs = printed.get(&point.method).and_then(|values| values.get(*metric));
                format!("{ours} | {}", theirs.map_or("–".into(), |value| value.to_string()))
            })
            .collect();
        let (panel, x, method) = (&point.panel, point.x, point.method.name());
        text += &format!("| {panel} | {x} | {method} |{} {}/{} |\n", joined(&cells), point.n_ok, point.n);
    }
    text + &warnings(axis, rows) + &rough(axis, rows)
}

fn are_of_one_point(a: &Row, b: &Row) -> bool {
    (&a.panel, a.x, a.method) == (&b.panel, b.x, b.method)
}

/// A row of each point: of the metric that most of its repetitions have.
fn points(rows: &[Row]) -> Vec<&Row> {
    let mut points: Vec<&Row> = Vec::new();
    for row in rows {
        match points.iter_mut().find(|point| are_of_one_point(point, row)) {
            Some(point) if point.n_ok < row.n_ok => *point = row,
            Some(_) => {}
            None => points.push(row),
        }
    }
    points
}

/// Where weights cannot be trusted.
fn warnings(axis: &str, rows: &[Row]) -> String {
    let mut text = String::new();
    let mut warn = |reason: &str, metric: &str, is_bad: fn(f64) -> bool| {
        let bad = rows.iter().filter(|row| row.metric == metric && row.n_ok > 0 && is_bad(row.median));
        let bad: Vec<(&Row, String)> = bad.map(|row| (row, short(row.median))).collect();
        if !bad.is_empty() {
            text += &format!("\nWeights not to be trusted: {reason}: {}.\n", listed(axis, &bad));
        }
    };
    let heavy =
        format!("the tail index is above {PARETO_K_LIMIT}, so that averages by them need far more particles");
    warn(&heavy, "tail_index", |index| index > PARETO_K_LIMIT);
    warn("one particle has more than half, on average", "ess", |size| size < LEAST_EFFECTIVE_PARTICLES);
    let indices: Vec<&Row> = rows.iter().filter(|row| row.metric == "tail_index").collect();
    let with_index =
        |point: &Row| indices.iter().find(|row| are_of_one_point(row, point)).map_or(0, |row| row.n_ok);
    let partly = points(rows).into_iter().filter(|point| with_index(point) < point.n_ok);
    let partly: Vec<(&Row, String)> =
        partly.map(|point| (point, format!("{}/{}", with_index(point), point.n))).collect();
    if !indices.is_empty() && !partly.is_empty() {
        // Units of before there was one, and ones of too few weights.
        let listed = listed(axis, &partly);
        text += &format!("\nTail indices of a part of the repetitions only, or of none: {listed}.\n");
    }
    text
}

/// Errors that are small beside what is not known of the posterior mean. They stay in the table: to leave out repetitions in which a
/// method comes near to that mean would be to choose by outcome.
fn rough(axis: &str, rows: &[Row]) -> String {
    let of_metric = |(metric, reference): (&str, &str)| {
        let apart = |row: &Row| {
            let two =
                |other: &&Row| are_of_one_point(other, row) && other.metric == reference && other.n_ok > 0;
            rows.iter().find(two).map(|two| two.median)
        };
        let known = rows.iter().filter(|row| row.metric == metric && row.n_ok > 0);
        let rough: Vec<(&Row, String)> = known
            .filter_map(|row| Some((row, apart(row)?)))
            .filter(|(row, apart)| *apart > REFERENCE_SHARE * row.median)
            .map(|(row, apart)| (row, short(apart)))
            .collect();
        let head = COLUMNS.iter().find(|(known, _)| *known == metric).map_or(metric, |(_, head)| head);
        let listed = listed(axis, &rough);
        let reason = format!(
            "where two estimates of that mean are apart by more than {REFERENCE_SHARE} of the error, in the median"
        );
        if rough.is_empty() { String::new() } else { format!("\n{head}, {reason}: {listed}.\n") }
    };
    ESTIMATED.into_iter().map(of_metric).collect()
}

/// What is said of some rows: those of a method in a panel together, x by x.
fn listed(axis: &str, said: &[(&Row, String)]) -> String {
    let mut curves: Vec<(&Row, Vec<String>)> = Vec::new();
    for (row, of) in said {
        let of = format!("{}: {of}", row.x);
        match curves.iter_mut().find(|(first, _)| (first.method, &first.panel) == (row.method, &row.panel)) {
            Some((_, points)) => points.push(of),
            None => curves.push((*row, vec![of])),
        }
    }
    let curve = |(row, points): &(&Row, Vec<String>)| {
        format!("{} ({}, {axis} = {})", row.method.name(), row.panel, points.join(", "))
    };
    curves.iter().map(curve).collect::<Vec<_>>().join("; ")
}

/// Three digits, in scientific notation where plain decimals would be long.
pub(super) fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if !(1e-3..1e4).contains(&size) => format!("{value:.2e}"),
        size => {
            let decimals = (2 - size.log10().floor() as i32).max(0) as usize;
            format!("{value:.decimals$}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(method: Method, metric: &str, median: f64, std: f64) -> Row {
        Row {
            panel: "N10".into(),
            method,
            x: 10,
            metric: metric.into(),
            median,
            std,
            quartiles: (0.0, 0.5),
            n_ok: 2,
            n: 2,
        }
    }

    #[test]
    fn numbers_are_short() {
        let shown: Vec<String> = [0.0, 0.01234, 0.5678, 12.345, 123.4, 1.0, 2.5e-5].map(short).into();
        assert_eq!(shown, ["0", "0.0123", "0.568", "12.3", "123", "1.00", "2.50e-5"]);
    }

    #[test]
    fn weights_that_cannot_be_trusted_are_named() {
        let row = |method, metric, median| row(method, metric, median, 0.1);
        let rows = [
            row(Method::Bootstrap, "ess", 2.4),
            row(Method::Bootstrap, "tail_index", 0.31),
            row(Method::Fcnn, "ess", 1.2),
            row(Method::Fcnn, "tail_index", 1.62),
        ];
        let table = markdown("T", "K", &rows, &Printed::new());
        let lines: Vec<&str> = table.lines().skip(4).collect();
        assert_eq!(
            lines,
            [
                "| panel | K | method | ESS | tail index | n |",
                "|---|---:|---|---:|---:|---:|",
                "| N10 | 10 | bootstrap | 2.40 ± 0.100 | 0.310 ± 0.100 | 2/2 |",
                "| N10 | 10 | fcnn | 1.20 ± 0.100 | 1.62 ± 0.100 | 2/2 |",
                "",
                "Weights not to be trusted: the tail index is above 0.7, so that averages by them need far more particles: fcnn (N10, K = 10: 1.62).",
                "",
                "Weights not to be trusted: one particle has more than half, on average: fcnn (N10, K = 10: 1.20).",
            ]
        );
        assert!(!markdown("T", "K", &rows[..2], &Printed::new()).contains("not to be trusted"));
        let curves = [Row { x: 20, ..rows[3].clone() }, Row { method: Method::Psi, ..rows[3].clone() }];
        let table = markdown("T", "K", &[&rows[3..], &curves].concat(), &Printed::new());
        assert!(
            table.ends_with("more particles: fcnn (N10, K = 10: 1.62, 20: 1.62); psi (N10, K = 10: 1.62).\n")
        );
        let partly = Row { n_ok: 1, ..rows[1].clone() };
        let table = markdown("T", "K", &[rows[0].clone(), partly], &Printed::new());
        assert!(table.ends_with(
            "\nTail indices of a part of the repetitions only, or of none: bootstrap (N10, K = 10: 1/2).\n"
        ));
        assert!(table.contains("| 2.40 ± 0.100 | 0.310 (1) | 2/2 |"));
        let table = markdown("T", "K", &rows[..3], &Printed::new());
        assert!(table.ends_with("or of none: fcnn (N10, K = 10: 0/2).\n"));
    }

    #[test]
    fn errors_near_what_is_known_of_the_posterior_mean_are_named_and_kept() {
        let row = |method, metric, median| row(method, metric, median, 0.5);
        let rows = [
            row(Method::Bootstrap, "nmse_posterior", 0.2),
            row(Method::Bootstrap, "nmse_posterior_reference", 0.01),
            row(Method::Fcnn, "nmse_posterior", 0.05),
            row(Method::Fcnn, "nmse_posterior_reference", 0.01),
        ];
        let table = markdown("T", "K", &rows, &Printed::new());
        assert!(table.contains("| N10 | 10 | fcnn | 0.0500 ± 0.500 | 2/2 |"));
        assert!(table.ends_with(
            "\nNMSE to posterior mean, where two estimates of that mean are apart by more than 0.1 of the error, in the median: \
             fcnn (N10, K = 10: 0.0100).\n"
        ));
        let exact = [rows[0].clone(), rows[2].clone()];
        assert!(!markdown("T", "K", &exact, &Printed::new()).contains("apart"));
        assert!(!markdown("T", "K", &rows[..2], &Printed::new()).contains("apart"));
    }

    #[test]
    fn a_line_for_each_point_and_a_dash_where_there_is_nothing() {
        let row = |x, method, metric, n_ok| Row { x, n_ok, ..row(method, metric, 0.25, 0.5) };
        let rows = [
            row(10, Method::Bootstrap, "nmse_final", 2),
            row(20, Method::Bootstrap, "nmse_final", 0),
            row(10, Method::Fcnn, "nmse_final", 2),
        ];
        let table = markdown("T", "K", &rows, &Printed::new());
        let lines: Vec<&str> = table.lines().skip(4).collect();
        assert_eq!(
            lines,
            [
                "| panel | K | method | NMSE, last time | n |",
                "|---|---:|---|---:|---:|",
                "| N10 | 10 | bootstrap | 0.250 ± 0.500 | 2/2 |",
                "| N10 | 10 | fcnn | 0.250 ± 0.500 | 2/2 |",
                "| N10 | 20 | bootstrap | – | 0/2 |",
            ]
        );
        let failed = markdown("T", "K", &rows[1..2], &Printed::new());
        assert_eq!(
            failed.lines().skip(4).collect::<Vec<_>>(),
            ["| panel | K | method | n |", "|---|---:|---|---:|", "| N10 | 20 | bootstrap | 0/2 |"]
        );
        let printed = Printed::from([(Method::Fcnn, BTreeMap::from([("nmse_final".to_string(), 64.1)]))]);
        let table = markdown("T", "K", &rows, &printed);
        let lines: Vec<&str> = table.lines().skip(4).collect();
        assert_eq!(
            lines,
            [
                "| panel | K | method | NMSE, last time | paper | n |",
                "|---|---:|---|---:|---:|---:|",
                "| N10 | 10 | bootstrap | 0.250 ± 0.500 | – | 2/2 |",
                "| N10 | 10 | fcnn | 0.250 ± 0.500 | 64.1 | 2/2 |",
                "| N10 | 20 | bootstrap | – | – | 0/2 |",
            ]
        );
    }
}
