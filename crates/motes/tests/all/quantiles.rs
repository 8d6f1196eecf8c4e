//! Quantiles of one's own choice, and particles that are kept.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use crate::common::{WALK, Workplace, stderr};
use motes::{Data, FilterOptions, Filtered, Model, ProposalName, Quantiles, filter, smooth};

/// What standard normal numbers have at 2.5, 10, 50 and 97.5 %.
const NORMAL: [(f64, f64); 4] = [(0.025, -1.959964), (0.1, -1.281552), (0.5, 0.0), (0.975, 1.959964)];

fn quantiles() -> Quantiles {
    Quantiles::new(NORMAL.map(|(probability, _)| probability).to_vec()).unwrap()
}

fn walk() -> (Model, Data) {
    let model = Model::parse(WALK, "walk", &[]).unwrap();
    let data = Data::read("y\n0.4\n-1.2\nNA\n2\n1.1\n".as_bytes(), "d.csv", &model).unwrap();
    (model, data)
}

fn filtered(model: &Model, data: &Data, options: &FilterOptions) -> Filtered {
    filter(model, data, options, |_| ControlFlow::Continue(())).unwrap()
}

fn are_normal(found: &[f64], mean: f64, sd: f64, within: f64) {
    assert_eq!(found.len(), NORMAL.len());
    for (found, (probability, z)) in found.iter().zip(NORMAL) {
        assert!((found - (mean + z * sd)).abs() <= within * sd, "{probability}: {found} for {mean} ± {sd}");
    }
}

#[test]
fn states_measurements_and_forecasts_have_those_that_were_asked_for() {
    let (model, data) = walk();
    for (proposal, within) in [(ProposalName::Exact, 1e-5), (ProposalName::Linearised, 0.15)] {
        let options = FilterOptions {
            proposal,
            particles: 20_000,
            predictive: true,
            forecast: 2,
            quantiles: quantiles(),
            ..FilterOptions::default()
        };
        let found = filtered(&model, &data, &options);
        let ahead = found.forecasts[0].iter().map(|forecast| &forecast.estimate);
        for estimate in found.estimates.iter().chain(ahead) {
            let (state, expected) = (&estimate.state[0], &estimate.predictive[0]);
            are_normal(&state.quantiles, state.mean, state.sd, within);
            are_normal(&expected.quantiles, expected.mean, expected.sd, within);
        }
        let smoothed = smooth(&model, &data, &options, 5000, |_| ControlFlow::Continue(())).unwrap();
        for estimate in &smoothed.estimates {
            let state = &estimate.state[0];
            are_normal(&state.quantiles, state.mean, state.sd, within);
        }
        // They are beside all else, which does not change.
        let plain = filtered(&model, &data, &FilterOptions { quantiles: Quantiles::default(), ..options });
        assert_eq!(plain.log_evidence(), found.log_evidence());
        assert_eq!(plain.estimates[3].state[0].quantiles[1], found.estimates[3].state[0].quantiles[2]);
        assert_eq!(
            plain.estimates[3].predictive[0].quantiles[1],
            found.estimates[3].predictive[0].quantiles[2]
        );
    }
}

/// The columns of a table by their names.
fn columns(table: &str) -> BTreeMap<String, Vec<String>> {
    let mut rows = table.lines().map(|line| line.split(',').map(String::from).collect::<Vec<String>>());
    let header = rows.next().unwrap();
    let rows: Vec<Vec<String>> = rows.collect();
    let column = |at: usize| rows.iter().map(|row| row[at].clone()).collect();
    header.into_iter().enumerate().map(|(at, name)| (name, column(at))).collect()
}

#[test]
fn tables_have_a_column_for_each() {
    let place = Workplace::new();
    let asked = ["--quantiles", "0.025,0.5,0.9", "-q"];
    let printed = |arguments: &[&str]| place.printed(&[arguments, &asked].concat());
    let table = printed(&["filter", "walk.toml", "d.csv", "--forecast", "1", "--predictive"]);
    let header = "t,x_mean,x_sd,x_q025,x_q50,x_q90,ess,log_evidence,y_mean,y_sd,y_q025,y_q50,y_q90,y_pit";
    assert_eq!(table.lines().next(), Some(header));
    let smoothed = printed(&["smooth", "walk.toml", "d.csv", "--paths", "50"]);
    assert_eq!(smoothed.lines().next(), Some("t,x_mean,x_sd,x_q025,x_q50,x_q90"));
    // Those that both have are the same.
    let usual = place.printed(&["filter", "walk.toml", "d.csv", "--forecast", "1", "--predictive", "-q"]);
    let (usual, found) = (columns(&usual), columns(&table));
    assert_eq!(usual.len(), found.len());
    let both: Vec<&String> = usual.keys().filter(|name| found.contains_key(*name)).collect();
    assert_eq!(both.len(), usual.len() - 4);
    both.iter().for_each(|name| assert_eq!(usual[*name], found[*name], "{name}"));
    let low = |columns: &BTreeMap<String, Vec<String>>, name: &str| columns[name][0].parse::<f64>().unwrap();
    assert!(low(&found, "x_q025") < low(&usual, "x_q05"));
    // Of a table of results nobody takes a figure for what its rows are called.
    place.write("again.csv", "x_q025,y\n0.1,0.5\n");
    let output = place.run(&["filter", "walk.toml", "again.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("x_q025"), "{}", stderr(&output));
}

#[test]
fn a_report_says_which_its_bands_are() {
    let place = Workplace::new();
    let page = |asked: &str| {
        let report = ["filter", "walk.toml", "d.csv", "-q", "--report", "r.html", "--quantiles", asked];
        place.printed(&report);
        place.read("r.html")
    };
    assert!(page("0.025,0.5,0.975").contains("Band: from the 2.5 % to the 97.5 % quantile."));
    assert!(page("0.5").contains("Line: mean.<") && !page("0.5").contains("Band:"));
    assert!(page("0.05,0.5,0.95").contains("Line: mean. Band: from the 5 % to the 95 % quantile."));
}

#[test]
fn a_stream_answers_with_the_same() {
    let place = Workplace::new();
    let whole = place.printed(&["filter", "walk.toml", "d.csv", "--quantiles", "0.2,0.8", "-q"]);
    let mut command = place.motes(&["filter", "walk.toml", "-", "--quantiles", "0.2,0.8", "-q"]);
    let stream = command.stdin(std::fs::File::open(place.path("d.csv")).unwrap()).output().unwrap();
    assert_eq!(String::from_utf8(stream.stdout).unwrap(), whole);
}

#[test]
fn what_cannot_be_quantiles_is_refused_in_a_line() {
    let place = Workplace::new();
    for wrong in ["0,0.5", "0.5,1", "0.9,0.1", "0.5,0.5", "half", "0.5,NaN"] {
        let output = place.run(&["filter", "walk.toml", "d.csv", "--quantiles", wrong]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{wrong}: {said}");
        let expected = "probabilities above 0 and below 1, each above the one before, as in 0.05,0.5,0.95";
        assert_eq!(said, format!("motes: --quantiles {wrong}: it must be {expected}"));
    }
}

#[test]
fn particles_are_kept_where_they_are_asked_for() {
    let (model, data) = walk();
    for proposal in ProposalName::DESIGNED {
        let options =
            FilterOptions { proposal, particles: 300, keep_particles: true, ..FilterOptions::default() };
        let found = filtered(&model, &data, &options);
        assert_eq!(found.particles.len(), data.rows.len());
        for (kept, estimate) in found.particles.iter().zip(&found.estimates) {
            let (states, weights) = (&kept.states, &kept.weights);
            assert!(states.len() == 300 && weights.len() == 300);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let mean: f64 = states.iter().zip(weights).map(|(state, weight)| weight * state).sum();
            assert!((mean - estimate.state[0].mean).abs() < 1e-12, "{mean}: {estimate:?}");
            let size = 1.0 / weights.iter().map(|weight| weight * weight).sum::<f64>();
            assert!((size / estimate.ess.unwrap() - 1.0).abs() < 1e-9, "{size}: {estimate:?}");
        }
        let without = filtered(&model, &data, &FilterOptions { keep_particles: false, ..options });
        assert!(without.particles.is_empty());
        assert_eq!(without.estimates, found.estimates);
    }
    let options =
        FilterOptions { proposal: ProposalName::Exact, keep_particles: true, ..FilterOptions::default() };
    let refused = filter(&model, &data, &options, |_| ControlFlow::Continue(())).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "keep_particles: --proposal exact has no particles; leave one of the two out"
    );
}

#[test]
fn who_does_without_checks_is_told_why_there_is_no_standard_error() {
    let place = Workplace::new();
    let said = |more: &[&str]| {
        stderr(&place.run(&[&["filter", "walk.toml", "d.csv", "-o", "out.csv"], more].concat()))
    };
    assert!(said(&["--no-check"]).contains(" (its standard error was not asked for), "));
    assert!(said(&["--particles", "8"]).contains(" (too few particles for a standard error), "));
    assert!(said(&[]).contains(" ± "));
}
