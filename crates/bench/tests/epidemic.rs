//! The epidemic from its experiment file to tables, series and figure; and files of epidemics that cannot be run.

mod common;

use std::collections::BTreeMap;

use common::{Workplace, stderr};

const TABLE1: &str = include_str!("../../../experiments/table1.toml");

/// A workplace in which `table1.toml` is the only experiment.
fn place(experiment: &str) -> Workplace {
    let place = Workplace::new(experiment);
    let folder = place.path("experiments");
    std::fs::rename(folder.join("tiny.toml"), folder.join("table1.toml")).unwrap();
    place
}

#[test]
fn table_1_and_figure_7_are_one_run() {
    let place = place(TABLE1);
    let run = |figure: &str| {
        let output = place.run(&[figure, "--profile", "smoke"]);
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    assert!(run("table1").contains("9 units to run"));
    assert!(run("fig7").contains("9 units are there, 0 to run"));

    let folder = place.path("runs/table1/smoke");
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let table = read("table.md");
    // Ours beside the paper's, and a dash where the paper prints nothing.
    let line = |method: &str| {
        let start = format!("| all | 30 | {method} |");
        table.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("{table}")).to_string()
    };
    assert!(line("psi").contains("| 339.8 |") && line("psi").contains("| 154.6 |"));
    assert!(line("psi-anchored").contains("| – |"));
    assert!(table.contains("ran away"), "{table}");

    // Every time of every state of every method, the band around the mean, and one truth for all.
    let mut truths: BTreeMap<(String, usize), Vec<f64>> = BTreeMap::new();
    let mut reader = csv::Reader::from_path(folder.join("series.csv")).unwrap();
    for row in reader.deserialize() {
        type Row = (String, String, usize, usize, String, f64, f64, f64, f64);
        let (_, _, repetition, t, state, truth, mean, lo, hi): Row = row.unwrap();
        assert!(repetition == 0 && lo <= hi);
        assert!(mean.is_finite());
        truths.entry((state, t)).or_default().push(truth);
    }
    assert_eq!(truths.len(), 3 * 200);
    assert!(truths.values().all(|all| all.len() == 9 && all.iter().all(|truth| *truth == all[0])));

    let svg = read("figure.svg");
    for name in ["truth", "min-degeneracy", "rnn-anchored", "reference-smoother"] {
        assert!(svg.contains(name), "{name} is not in the figure");
    }
    assert_eq!(svg.matches("I(t)").count(), 2 * 3, "two rows of three windows");

    // What waits for later measurements with the densities that data were drawn with knows most of S and R.
    let value = |method: &str, metric: &str| -> f64 {
        let start = format!("table1,all,{method},30,0,{metric},");
        let units = read("units.csv");
        let line = units.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("{start}"));
        line[start.len()..].parse().unwrap()
    };
    for metric in ["mse_S", "mse_R"] {
        let (smoother, filter) = (value("reference-smoother", metric), value("reference-filter", metric));
        assert!(
            smoother < filter && filter < value("min-degeneracy", metric),
            "{metric}: {smoother} {filter}"
        );
    }
}

#[test]
fn a_training_that_diverges_is_a_failed_unit_with_its_step() {
    let wild = TABLE1.replace("learning_rate = 0.001", "learning_rate = 1e30");
    let place = place(&wild);
    let output = place.run(&["table1", "--profile", "smoke", "--methods", "fcnn-anchored"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let failures = std::fs::read_to_string(place.path("runs/table1/smoke/failures.csv")).unwrap();
    assert!(failures.contains("step") && failures.contains("loss"), "{failures}");
    let units = std::fs::read_to_string(place.path("runs/table1/smoke/units.csv")).unwrap();
    assert_eq!(units.lines().count(), 1, "{units}");
}

#[test]
fn files_that_cannot_be_run_are_refused() {
    let cases = [
        (
            "time_step = 0.7",
            "time_step = -0.7",
            "`epidemic.time_step` is -0.7; it must be at least 0 and finite",
        ),
        (
            "state_variance = 200.0",
            "state_variance = 0.0",
            "`epidemic.state_variance` is 0; it must be positive and finite",
        ),
        (
            "largest_state = 2000.0",
            "largest_state = nan",
            "`epidemic.largest_state` is NaN; it must be positive and finite",
        ),
        (
            "initial_means = [997.0, 3.0, 0.0]",
            "initial_means = [997.0, inf, 0.0]",
            "`epidemic.initial_means` is inf; it must be finite",
        ),
        ("horizon = 200", "horizon = 0", "`epidemic.horizon` is 0; it must be at least 1"),
        ("state = \"I\"", "state = \"infected\"", "`series.state` is infected; there are S, I, R"),
        (
            "x = [300]",
            "x = [100, 300]",
            "`profiles.paper.x` is [100, 300]; it must be one number of particles where there are reference methods or a [series]",
        ),
        ("smoother_lag = 30", "smoother_lag = 0", "`reference.smoother_lag` is 0; it must be from 1 to 200"),
        (
            "mse_S = 64.1",
            "mse_s = 64.1",
            "`printed.fcnn` is mse_s; did you mean mse_S? there are mse_S, mse_I, mse_R",
        ),
        (
            "[printed.psi]",
            "[printed.bootstrap]",
            "`printed.bootstrap` is there; the experiment does not have this method",
        ),
        (
            "[20, 50]",
            "[50, 20]",
            "`series.windows` is [50, 20]; it must be two times, the first before the last, up to 200",
        ),
        (
            "axis = \"particles\"",
            "axis = \"dimension\"",
            "`axis` is dimension; the x axis of an epidemic is the number of particles",
        ),
        ("\"psi\", ", "\"psi\", \"gnn\", ", "`methods` is gnn; an epidemic has no graph, which gnn needs"),
        (
            "trajectories = 1000",
            "trajectories = 0",
            "`proposals.standardised.trajectories` is 0; it must be from 1 to 100000",
        ),
        (
            "origin = \"mean\"",
            "origin = \"prediction\"",
            "`proposals.standardised.origin` is prediction; methods with -anchored have that origin; there are mean, mean-at-each-time",
        ),
        ("[reference]\nsmoother_lag = 30", "", "`reference` is absent; reference methods need it"),
        (
            "name = \"all\"",
            "name = \"all\"\ndimension = 4",
            "`panels.all.dimension` is 4; an epidemic has three coordinates",
        ),
    ];
    for (from, to, line) in cases {
        assert!(TABLE1.contains(from), "{from}");
        let place = place(&TABLE1.replace(from, to));
        let output = place.run(&["table1"]);
        let expected = format!("error: experiments/table1.toml: key {line}");
        assert_eq!(stderr(&output), expected);
        assert_eq!(output.status.code(), Some(2));
        assert!(!place.path("runs").exists());
    }
}

#[test]
fn an_unknown_figure_is_told_of_other_names_too() {
    let output = place(TABLE1).run(&["fig8"]);
    assert_eq!(
        stderr(&output),
        "error: figure fig8: did you mean fig7? there are table1, fig7, all, heldout, hindsight"
    );
}
