//! What a smoother says where its trajectories rest on few particles, and where they do not.

use std::ops::ControlFlow;

use crate::common::{Workplace, stderr};
use motes::{Data, FilterOptions, Model, MotesError, Smoothed, smooth};
use serde_json::Value;

/// A level that wanders, and a cycle of 12 times that hardly changes: only its own ancestor leads to a state.
const CYCLE: &str = include_str!("../cycle/model.toml");
const CYCLE_DATA: &str = include_str!("../cycle/data.csv");

fn cycle() -> Workplace {
    let place = Workplace::new();
    place.write("cycle.toml", CYCLE);
    // Months from 1985 on are what the data call their times.
    let rows = CYCLE_DATA.lines().skip(1).enumerate();
    let rows = rows.map(|(at, y)| format!("{}-{:02},{y}\n", 1985 + at / 12, at % 12 + 1));
    place.write("cycle.csv", format!("month,y\n{}", rows.collect::<String>()));
    place
}

fn found(place: &Workplace, model: &str, data: &str, particles: usize, paths: usize) -> Smoothed {
    let model = Model::read(&place.path(model), &[]).unwrap();
    let data = Data::open(&place.path(data), &model).unwrap();
    let options = FilterOptions { particles, ..FilterOptions::default() };
    smooth(&model, &data, &options, paths, |_| ControlFlow::Continue(())).unwrap()
}

fn warnings(smoothed: &Smoothed) -> Vec<String> {
    smoothed.filtered.warnings.iter().map(ToString::to_string).collect()
}

#[test]
fn trajectories_through_one_particle_are_said_and_have_no_standard_deviation() {
    let place = cycle();
    let command = ["smooth", "cycle.toml", "cycle.csv", "--particles", "2000", "-o", "s.csv"];
    let output = place.motes(&command).output().unwrap();
    let said = stderr(&output);
    let line = said.lines().find(|line| line.contains("pass through fewer than")).unwrap();
    assert!(line.contains("up to t = ") && line.contains(" all 200 paths "), "{line}");
    assert!(line.contains("fewer than 20 particles (1 at t = 0)"), "{line}");
    assert!(
        line.contains("standard deviations and quantiles cannot be given; take more particles"),
        "{line}"
    );
    let last: usize = line.split("up to t = ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    assert!(line.contains(&format!("t = {last} ({}-{:02})", 1985 + last / 12, last % 12 + 1)), "{line}");

    let table = place.read("s.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][2..7], ["level_mean", "level_sd", "level_q05", "level_q50", "level_q95"]);
    for coordinate in 0..3 {
        let cells = &rows[1][2 + 5 * coordinate..][..5];
        assert!(cells[0].parse::<f64>().unwrap().is_finite() && cells[1..] == [""; 4], "{cells:?}");
        let cells = &rows[180][2 + 5 * coordinate..][..5];
        assert!(cells.iter().all(|cell| cell.parse::<f64>().is_ok_and(f64::is_finite)), "{cells:?}");
    }

    let json: Value =
        serde_json::from_str(&place.printed(&["smooth", "cycle.toml", "cycle.csv", "--json", "-o", "j.csv"]))
            .unwrap();
    assert!(
        json["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .any(|warning| warning.as_str().unwrap().contains("pass through fewer than"))
    );
    let strict = place.motes(&["smooth", "cycle.toml", "cycle.csv", "--strict", "-q"]).output().unwrap();
    assert_eq!(strict.status.code(), Some(1));
}

#[test]
fn no_standard_deviation_comes_from_one_particle() {
    let place = cycle();
    let smoothed = found(&place, "cycle.toml", "cycle.csv", 500, 100);
    let paths = &smoothed.paths[0];
    let mut missing = 0;
    for (time, estimate) in smoothed.estimates.iter().enumerate() {
        for (number, coordinate) in estimate.state.iter().enumerate() {
            let is_missing = coordinate.sd.is_nan();
            assert_eq!(is_missing, paths.distinct_particles(time) == 1, "t = {time}");
            assert_eq!(is_missing, coordinate.quantiles.iter().all(|quantile| quantile.is_nan()));
            // Particles differ by their levels; what follows without noise may be that of one ancestor, of which a warning tells.
            let has_spread = coordinate.sd > 0.0 || (number > 0 && coordinate.sd == 0.0);
            assert!(coordinate.mean.is_finite() && (is_missing || has_spread));
            missing += usize::from(is_missing);
        }
    }
    assert!(missing > 0);
    let said = warnings(&smoothed);
    assert!(said.iter().any(|text| text.starts_with("state a hardly moves by itself")), "{said:?}");
    // It is said of few paths, too.
    let few = warnings(&found(&place, "cycle.toml", "cycle.csv", 500, 5));
    assert!(few.iter().any(|text| text.contains("all 5 paths pass") && text.contains("or paths")), "{few:?}");
}

#[test]
fn nothing_is_said_of_sound_trajectories() {
    let place = Workplace::new();
    let data = place.printed(&["simulate", "walk.toml", "--steps", "60", "-q"]);
    place.write("w.csv", &data);
    // A coordinate that is honestly narrow, and one that has no noise at all, beside it.
    let narrow = "[initial]\nx = \"normal(0, 1)\"\nz = \"normal(0, 1e-9)\"\n[transition]\nx = \"normal(0.9*x, 1)\"\n\
                  z = \"normal(0, 1e-9)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    place.write("narrow.toml", narrow);
    for (particles, paths) in
        [(1000, 200), (1000, 20), (1000, 10), (1000, 3), (1000, 1), (500, 200), (500, 30)]
    {
        for model in ["walk.toml", "narrow.toml"] {
            let smoothed = found(&place, model, "w.csv", particles, paths);
            let said = warnings(&smoothed);
            assert!(!said.iter().any(|text| text.contains("pass through")), "{particles}, {paths}: {said:?}");
            let sds = smoothed.estimates.iter().flat_map(|estimate| &estimate.state).map(|state| state.sd);
            assert!(sds.into_iter().all(|sd| if paths == 1 { sd.is_nan() } else { sd > 0.0 }));
        }
    }
}

#[test]
fn both_passes_are_told_and_either_can_be_stopped() {
    let place = Workplace::new();
    place.write("s.csv", "series,y\na,1\na,2\na,0\nb,1\nb,2\n");
    let model = Model::read(&place.path("walk.toml"), &[]).unwrap();
    let data = Data::open(&place.path("s.csv"), &model).unwrap();
    let until = |most: usize| {
        let mut shares = vec![];
        let smoothed = smooth(&model, &data, &FilterOptions::default(), 50, |share| {
            shares.push(share);
            if shares.len() < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        (smoothed, shares)
    };
    let (smoothed, shares) = until(usize::MAX);
    assert!(smoothed.is_ok() && shares.is_sorted_by(|a, b| a < b), "{shares:?}");
    // A row of the data is heard of when it is filtered, and when trajectories are drawn at it.
    assert_eq!(shares.len(), 2 * data.rows.len());
    assert!(shares[0] > 0.0 && (shares[9] - 1.0).abs() < 1e-12, "{shares:?}");
    for most in [1, 4, 10] {
        let (stopped, shares) = until(most);
        assert!(matches!(stopped, Err(MotesError::Interrupted)) && shares.len() == most);
    }
}
