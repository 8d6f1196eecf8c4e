//! `motes evidence`: what it says, what it takes, and that a choice by pilots leaves the evidence unbiased.

use std::ops::ControlFlow;

use crate::common::{WALK, Workplace, stderr};
use motes::models::Seed;
use motes::models::equations::normal;
use motes::{Data, EvidenceEstimator, EvidenceOptions, FilterOptions, Model, ProposalName, evidence, smooth};
use serde_json::Value;

const COUNTS: &str = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 0.2)\"\n[measurement]\ny = \"poisson(exp(x))\"\n";

const DATA: &str = "series,y\na,1\na,0\nb,4\na,2\na,9\nb,3\nb,\nb,7\n";

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("counts.toml", COUNTS);
    place.write("counts.csv", DATA);
    place
}

/// The object without the time it took.
fn json(place: &Workplace, arguments: &[&str]) -> Value {
    let all = [&["evidence"], arguments, &["--json", "--quiet"]].concat();
    let mut found: Value = serde_json::from_str(&place.printed(&all)).unwrap();
    assert!(found.as_object_mut().unwrap().remove("seconds").unwrap().as_f64().unwrap() >= 0.0);
    found
}

#[test]
fn the_object_has_its_keys() {
    let place = place();
    let found = json(&place, &["counts.toml", "counts.csv", "--particles", "64"]);
    let keys: Vec<&String> = found.as_object().unwrap().keys().collect();
    let mut expected = [
        "log_evidence",
        "standard_error",
        "log_evidence_per_series",
        "standard_error_per_series",
        "variance_per_run",
        "proposal",
    ];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!(found["proposal"], "look-ahead");
    let sum: f64 =
        found["log_evidence_per_series"].as_array().unwrap().iter().map(|log| log.as_f64().unwrap()).sum();
    assert_eq!(found["log_evidence"].as_f64(), Some(sum));
    assert!(found["standard_error"].as_f64().unwrap() < 0.1);
    assert!(found["variance_per_run"].as_f64().unwrap() < 0.05);
}

#[test]
fn a_linear_model_is_exact_unless_particles_are_asked_for() {
    let place = place();
    let exact = json(&place, &["walk.toml", "d.csv"]);
    assert_eq!((&exact["proposal"], &exact["standard_error"]), (&"exact".into(), &0.0.into()));
    assert_eq!(json(&place, &["linear.toml", "d.csv"])["log_evidence"], exact["log_evidence"]);
    let ahead = json(&place, &["walk.toml", "d.csv", "--proposal", "look-ahead", "--particles", "5"]);
    let difference = ahead["log_evidence"].as_f64().unwrap() - exact["log_evidence"].as_f64().unwrap();
    assert!(difference.abs() < 1e-10, "{difference}");
    let bootstrap = json(&place, &["walk.toml", "d.csv", "--proposal", "bootstrap", "--runs", "1"]);
    assert_eq!(bootstrap["standard_error"], Value::Null);
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let place = place();
    let of = |threads: &str| json(&place, &["counts.toml", "counts.csv", "--threads", threads]).to_string();
    assert_eq!(of("1"), of("2"));
    assert_ne!(of("1"), json(&place, &["counts.toml", "counts.csv", "--seed", "2"]).to_string());
}

#[test]
fn the_table_has_a_row_for_each_series() {
    let place = place();
    let table = place.printed(&["evidence", "counts.toml", "counts.csv", "--particles", "32"]);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines[0], "series,rows,log_evidence,standard_error");
    assert_eq!(lines.len(), 3);
    assert!(lines[1].starts_with("a,4,-") && lines[2].starts_with("b,4,-"), "{table}");
}

#[test]
fn what_cannot_be_had_is_refused() {
    let place = place();
    let said = |arguments: &[&str]| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2));
        stderr(&output)
    };
    assert_eq!(
        said(&["filter", "counts.toml", "counts.csv", "--proposal", "look-ahead"]),
        "motes: --proposal look-ahead: it knows all data before it starts, which a filter does not; take motes evidence or motes smooth, or --proposal linearised"
    );
    assert_eq!(
        said(&["evidence", "linear.toml", "d.csv", "--proposal", "look-ahead"]),
        "motes: --proposal look-ahead: kind = \"linear-gaussian\" has exact answers; take --proposal exact"
    );
    assert!(said(&["evidence", "counts.toml", "counts.csv", "--proposal", "ahead"]).contains("look-ahead"));
    assert!(said(&["evidence", "counts.toml", "counts.csv", "--runs", "0"]).contains("--runs"));
    let options = EvidenceOptions { runs: 0, ..EvidenceOptions::default() };
    let model = Model::parse(WALK, "walk", &[]).unwrap();
    let data = Data::read("y\n1\n".as_bytes(), "y.csv", &model).unwrap();
    let error = evidence(&model, &data, &options, || ControlFlow::Continue(())).unwrap_err();
    assert_eq!(error.to_string(), "the number of runs is 0; it must be at least 1");
}

/// A square hides the sign of the state: no proposal is without error here.
const HIDDEN: &str = "[initial]\nx = \"normal(0, 2)\"\n[transition]\nx = \"normal(0.8*x + 2*cos(t), 1.5)\"\n[measurement]\ny = \"normal(x^2/4, 0.7)\"\n";

const HIDDEN_DATA: [f64; 6] = [1.9, 0.4, 3.1, 2.2, 0.1, 4.7];

/// `log p(y)` of these data on a grid.
fn hidden_evidence() -> f64 {
    const COUNT: usize = 1201;
    let grid: Vec<f64> = (0..COUNT).map(|i| -15.0 + i as f64 * 0.025).collect();
    let density = |mean: f64, sd: f64, x: f64| normal::<f64>(mean, sd).log_density(x).exp();
    let (mut belief, mut log) = (Vec::new(), 0.0);
    for (t, y) in HIDDEN_DATA.into_iter().enumerate() {
        let predicted = |x: f64| -> f64 {
            if t == 0 {
                return density(0.0, 2.0, x);
            }
            let drift = 2.0 * (t as f64).cos();
            let terms = grid.iter().zip(&belief).filter(|(_, mass)| **mass > 1e-14);
            terms.map(|(before, mass): (&f64, &f64)| mass * density(0.8 * before + drift, 1.5, x)).sum()
        };
        let mut next: Vec<f64> =
            grid.iter().map(|x| predicted(*x) * density(x * x / 4.0, 0.7, y) * 0.025).collect();
        let total: f64 = next.iter().sum();
        log += total.ln();
        next.iter_mut().for_each(|mass| *mass /= total);
        belief = next;
    }
    log
}

/// By how many standard errors the mean of `ẑ/z` is off 1.
fn off(logs: &[f64], exact: f64) -> f64 {
    let count = logs.len() as f64;
    let ratios: Vec<f64> = logs.iter().map(|log| (log - exact).exp()).collect();
    let mean = ratios.iter().sum::<f64>() / count;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean - 1.0) / (variance / count).sqrt()
}

/// Pilots choose by random numbers of their own. What they found themselves is too large where the largest is taken: the planted bug.
#[test]
fn a_choice_by_pilots_has_random_numbers_of_its_own() {
    const SEEDS: u64 = 2000;
    let model = Model::parse(HIDDEN, "hidden", &[]).unwrap();
    let text = HIDDEN_DATA.iter().fold("y\n".to_string(), |text, y| text + &format!("{y}\n"));
    let data = Data::read(text.as_bytes(), "y.csv", &model).unwrap();
    let (mut fresh, mut reused) = (vec![], vec![]);
    for seed in 0..SEEDS {
        let options = EvidenceOptions { particles: 32, seed, ..EvidenceOptions::default() };
        let estimator = EvidenceEstimator::new(&model, &data, &options).unwrap();
        let runs = Seed::from_u64(seed).child("evidence").child("runs");
        fresh.push(estimator.log_evidence(&runs.nth(0)).unwrap());
        let pilots = estimator.pilots().iter().map(|pilot| pilot.log_evidence);
        reused.push(pilots.fold(f64::NEG_INFINITY, f64::max));
    }
    let exact = hidden_evidence();
    let (fresh, reused) = (off(&fresh, exact), off(&reused, exact));
    assert!(fresh.abs() < 4.0, "{fresh}");
    assert!(reused > 4.0, "{reused}");
}

#[test]
fn a_filter_that_looks_ahead_smooths() {
    let model = Model::parse(WALK, "walk", &[]).unwrap();
    let text =
        (0..30).fold("y\n".to_string(), |text, t| text + &format!("{}\n", (0.5 * f64::from(t)).sin() * 3.0));
    let data = Data::read(text.as_bytes(), "y.csv", &model).unwrap();
    let by = |proposal| {
        let options = FilterOptions { proposal, ..FilterOptions::default() };
        smooth(&model, &data, &options, 1000, |_| ControlFlow::Continue(())).unwrap()
    };
    let (exact, ahead) = (by(ProposalName::Exact), by(ProposalName::LookAhead));
    assert!(ahead.filtered.warnings.is_empty(), "{:?}", ahead.filtered.warnings);
    assert!((ahead.filtered.log_evidence() - exact.filtered.log_evidence()).abs() < 1e-9);
    for (time, (exact, ahead)) in exact.estimates.iter().zip(&ahead.estimates).enumerate() {
        let (exact, ahead) = (&exact.state[0], &ahead.state[0]);
        assert!(
            (exact.mean - ahead.mean).abs() < 0.16 * exact.sd,
            "t = {time}: {} and {}",
            ahead.mean,
            exact.mean
        );
        assert!((ahead.sd / exact.sd - 1.0).abs() < 0.15, "t = {time}: {} and {}", ahead.sd, exact.sd);
    }
}
