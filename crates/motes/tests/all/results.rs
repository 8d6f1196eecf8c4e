//! What the command gives: tables, figures of the whole run, reports; the same for any number of threads.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Write};
use std::process::Stdio;

use crate::common::{Workplace, stderr};
use motes::models::{Gaussian, LinearGaussian, PartialMeasurements, kalman};
use motes::{Data, Model};
use serde_json::Value;

/// The exact log-evidence of the walk.
fn exact(values: &[Option<f64>]) -> f64 {
    let one = |value: f64| faer::Mat::from_fn(1, 1, |_, _| value);
    let initial = Gaussian::new("P_0", vec![0.0], one(1.0)).unwrap();
    let model = LinearGaussian::new(initial, one(0.9), one(1.0), one(1.0), one(1.0)).unwrap();
    let measurements = PartialMeasurements::new(1, values.to_vec()).unwrap();
    kalman::filter_partial(&model, &measurements).unwrap().log_evidence()
}

fn json(place: &Workplace, arguments: &[&str]) -> Value {
    serde_json::from_str(&place.printed(arguments)).unwrap()
}

#[test]
fn the_evidence_is_the_kalman_filters_within_its_error() {
    let place = Workplace::new();
    let values = [Some(0.4), Some(-1.2), None, Some(2.0), Some(1.1), Some(-0.7)];
    let cells: Vec<String> = values.iter().map(|v| v.map_or("NA".into(), |v: f64| v.to_string())).collect();
    place.write("d.csv", format!("y\n{}\n", cells.join("\n")));
    let exact = exact(&values);
    for model in ["walk.toml", "linear.toml"] {
        for proposal in ["bootstrap", "linearised", "optimal"] {
            let command =
                ["filter", model, "d.csv", "--json", "--particles", "20000", "--proposal", proposal];
            let found = json(&place, &command)["log_evidence"].as_f64().unwrap();
            // Six times with effective sizes of a third: an error of about sqrt(12/20000).
            assert!((found - exact).abs() < 0.1, "{model}, {proposal}: {found} for {exact}");
        }
    }
}

#[test]
fn the_table_has_the_columns_that_scripts_rely_on() {
    let place = Workplace::new();
    place.write("d.csv", "\u{feff}date,y,note\r\n\"1, may\",0.5,a\r\n2 may,NA,b\r\n");
    let table = place.printed(&["filter", "walk.toml", "d.csv", "--forecast", "2", "-q"]);
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "date,t,x_mean,x_sd,x_q05,x_q50,x_q95,ess,log_evidence,y_mean,y_sd,y_q05,y_q50,y_q95"
    );
    assert!(lines[1].starts_with("\"1, may\",0,") && lines[1].ends_with(",,,,,"));
    assert!(lines[2].starts_with("2 may,1,") && lines[2].ends_with(",0,,,,,"));
    assert!(lines[3].starts_with(",2,") && lines[4].starts_with(",3,"));
    let ahead: Vec<&str> = lines[4].split(',').collect();
    assert!(ahead[7..9].iter().all(|cell| cell.is_empty()) && ahead[9..].iter().all(|cell| !cell.is_empty()));
    assert_eq!(lines.len(), 5);
    let predicted = place.printed(&["filter", "walk.toml", "d.csv", "--predictive", "-q"]);
    let rows: Vec<&str> = predicted.lines().collect();
    assert_eq!(rows[0], "date,t,x_mean,x_sd,x_q05,x_q50,x_q95,ess,log_evidence,y_mean,y_sd,y_pit");
    // Where nothing was measured there is no place, but what was expected.
    let cells = |row: &str| row.rsplit(',').map(|cell| cell.parse().ok()).collect::<Vec<Option<f64>>>();
    assert!(cells(rows[1])[..3].iter().all(Option::is_some), "{predicted}");
    assert!(cells(rows[2])[0].is_none() && cells(rows[2])[1..3].iter().all(Option::is_some), "{predicted}");
    let smoothed = place.printed(&["smooth", "walk.toml", "d.csv", "-q"]);
    assert_eq!(smoothed.lines().next(), Some("date,t,x_mean,x_sd,x_q05,x_q50,x_q95"));
    let simulated = place.printed(&["simulate", "walk.toml", "--steps", "3", "--series", "2"]);
    let rows: Vec<&str> = simulated.lines().collect();
    assert_eq!((rows[0], rows.len()), ("series,t,x,y", 7));
    assert!(rows[6].starts_with("1,2,"));
}

#[test]
fn json_has_the_keys_that_scripts_rely_on() {
    let place = Workplace::new();
    let keys = |value: &Value| value.as_object().unwrap().keys().cloned().collect::<BTreeSet<String>>();
    let names = |all: &str| all.split(' ').map(String::from).collect::<BTreeSet<String>>();
    let filtered = json(&place, &["filter", "walk.toml", "d.csv", "--json"]);
    let expected = "log_evidence log_evidence_per_series standard_error standard_error_per_series exact_log_evidence_per_series ess_mean ess_min pareto_k warnings particles seconds";
    assert_eq!(keys(&filtered), names(expected));
    let compared = json(
        &place,
        &["compare", "walk.toml", "--json", "--sequences", "2", "--steps", "5", "--sweep", "10,20"],
    );
    assert_eq!(keys(&compared["methods"]), names("bootstrap linearised look-ahead optimal"));
    let card = keys(&compared["methods"]["bootstrap"]);
    let expected = "ess_fraction ess_fraction_q01 log_evidence_gap e_l e_x pareto_k coverage_50 coverage_90 particle_steps_per_second ms_per_step";
    assert!(names(expected).is_subset(&card), "{card:?}");
    assert!(compared.as_object().unwrap().contains_key("training_seconds"));
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let place = Workplace::new();
    let data = place.printed(&["simulate", "walk.toml", "--steps", "30", "--series", "3"]);
    place.write("d.csv", &data);
    let run = |threads: &str, command: &str| {
        place.printed(&[command, "walk.toml", "d.csv", "--particles", "5000", "--threads", threads, "-q"])
    };
    let predicted = |threads: &str| {
        let more = ["--predictive", "--forecast", "3", "--particles", "5000", "--threads", threads, "-q"];
        place.printed(&[&["filter", "walk.toml", "d.csv"], &more[..]].concat())
    };
    assert_eq!(predicted("1"), predicted("3"));
    assert_eq!(run("1", "filter"), run("3", "filter"));
    assert_eq!(run("1", "smooth"), run("3", "smooth"));
    let other = place.printed(&["filter", "walk.toml", "d.csv", "--particles", "5000", "--seed", "2", "-q"]);
    assert_ne!(other, run("1", "filter"));
}

#[test]
fn a_series_does_not_depend_on_the_others_nor_on_their_order() {
    let place = Workplace::new();
    place.write("a.csv", "series,y\na,1\na,2\na,NA\nb,5\nb,6\n");
    place.write("b.csv", "series,y\na,1\nb,5\na,2\nb,6\na,NA\n");
    let sorted = |table: String| table.lines().map(String::from).collect::<BTreeSet<String>>();
    let [first, second] =
        ["a.csv", "b.csv"].map(|data| sorted(place.printed(&["filter", "walk.toml", data, "-q"])));
    assert_eq!(first, second);
    let stream = |data: &str, more: &[&str]| {
        let mut command = place.motes(&[&["filter", "walk.toml", "-", "-q"], more].concat());
        let input = std::fs::File::open(place.path(data)).unwrap();
        String::from_utf8(command.stdin(input).output().unwrap().stdout).unwrap()
    };
    // On-line the same numbers come, in the order of the rows.
    for more in [&[][..], &["--predictive", "--forecast", "2"], &["--predictive", "--proposal", "exact"]] {
        let whole = place.printed(&[&["filter", "walk.toml", "b.csv", "-q"], more].concat());
        assert_eq!(stream("b.csv", more), whole);
    }
}

#[test]
fn a_stream_is_answered_line_by_line() {
    let place = Workplace::new();
    let mut command = place.motes(&["filter", "walk.toml", "-", "-q"]);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let (mut input, mut output) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
    let mut line = String::new();
    input.write_all(b"y\n").unwrap();
    output.read_line(&mut line).unwrap();
    assert!(line.starts_with("t,x_mean"));
    for time in 0..5 {
        input.write_all(b"0.5\n").unwrap();
        line.clear();
        // Were answers held back, this would wait for ever.
        output.read_line(&mut line).unwrap();
        assert!(line.starts_with(&format!("{time},")), "{line}");
    }
    drop(input);
    assert!(child.wait().unwrap().success());
    // A reader who leaves ends it quietly.
    let mut command = place.motes(&["filter", "walk.toml", "-", "-q"]);
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut input = child.stdin.take().unwrap();
    let _ = input.write_all(b"y\n0.5\n");
    for _ in 0..1000 {
        if input.write_all(b"0.5\n").is_err() {
            break;
        }
    }
    drop(input);
    let ended = child.wait_with_output().unwrap();
    assert_eq!((ended.status.code(), stderr(&ended)), (Some(0), String::new()));
}

#[test]
fn a_file_is_replaced_when_the_table_is_whole_and_a_device_is_written_to() {
    let place = Workplace::new();
    let table = place.printed(&["filter", "walk.toml", "d.csv", "-q"]);
    place.printed(&["filter", "walk.toml", "d.csv", "-q", "-o", "out.csv"]);
    assert_eq!(place.read("out.csv"), table);
    place.printed(&["filter", "walk.toml", "d.csv", "-q", "-o", "/dev/null"]);
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
    let names: BTreeSet<String> = std::fs::read_dir(place.folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names, ["d.csv", "linear.toml", "out.csv", "walk.toml"].map(String::from).into());
}

#[test]
fn a_report_needs_nothing_else() {
    let place = Workplace::new();
    place.printed(&[
        "filter",
        "walk.toml",
        "d.csv",
        "-q",
        "--report",
        "out.html",
        "-o",
        "out.csv",
        "--forecast",
        "3",
    ]);
    let report = place.read("out.html");
    for part in ["<svg", "log-evidence", "effective sample size", "Settings", "motes filter walk.toml d.csv"]
    {
        assert!(report.contains(part), "{part}");
    }
    // A namespace is a name; anything else would be fetched.
    assert!(!report.replace("http://www.w3.org/2000/svg", "").contains("http"));
}

#[test]
fn strict_says_by_its_status_that_a_warning_fired() {
    let place = Workplace::new();
    // Far from anything likely: few particles are near.
    place.write("d.csv", "y\n0\n9\n-9\n9\n");
    let options =
        ["filter", "walk.toml", "d.csv", "--set", "noise=0.01", "--particles", "100", "-o", "out.csv"];
    let plain = place.run(&options);
    assert_eq!(plain.status.code(), Some(0), "{}", stderr(&plain));
    assert!(stderr(&plain).contains("motes: warning: "), "{}", stderr(&plain));
    assert_eq!(place.run(&[&options[..], &["--strict"]].concat()).status.code(), Some(1));
}

#[test]
fn check_says_what_a_model_is_and_whether_data_fit() {
    let place = Workplace::new();
    let said = place.printed(&["check", "walk.toml", "d.csv"]);
    for part in [
        "x ~ normal(0.9*x, 1)",
        "noise = 1",
        "proposals: bootstrap, linearised, optimal, look-ahead (of recorded data)",
        "learned: a proposal of the states",
        "smoothed: backward simulation, or exactly by --proposal exact",
        "a bootstrap filter gets through",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    place.write("counts.toml", crate::common::WALK.replace("normal(x, noise)", "poisson(exp(x)*noise)"));
    let output = place.run(&["check", "counts.toml", "d.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("d.csv, line 2, column y: 0.5 is no value of poisson(exp(x)*noise)"),
        "{}",
        stderr(&output)
    );
    place.write("edges.toml", crate::common::WALK.replace("normal(x, noise)", "uniform(x, x + noise)"));
    place.write("d.csv", "y\n500\n");
    let output = place.run(&["check", "edges.toml", "d.csv"]);
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        said.contains("problem: data, line 2: t = 0: no particle explains the measurement: y is 500"),
        "{said}"
    );
}

#[test]
fn what_rust_computes_is_what_the_command_prints() {
    let place = Workplace::new();
    let model = Model::read(&place.path("walk.toml"), &[]).unwrap();
    let data = Data::open(&place.path("d.csv"), &model).unwrap();
    let proceed = |_| std::ops::ControlFlow::Continue(());
    let filtered = motes::filter(&model, &data, &motes::FilterOptions::default(), proceed).unwrap();
    let printed = json(&place, &["filter", "walk.toml", "d.csv", "--json"])["log_evidence"].as_f64().unwrap();
    assert_eq!(filtered.log_evidence().to_bits(), printed.to_bits());
}

#[test]
fn help_completions_and_the_manual_page_are_there() {
    let place = Workplace::new();
    assert!(place.printed(&["filter", "--help"]).contains("Examples:"));
    assert!(place.printed(&["completions", "bash"]).contains("_motes"));
    assert!(place.printed(&["man"]).contains(".TH motes"));
}

#[test]
fn a_second_opinion_changes_no_other_result() {
    let place = Workplace::new();
    let data = place.printed(&["simulate", "walk.toml", "--steps", "40", "--series", "2"]);
    place.write("d.csv", data);
    let run = |more: &[&str]| {
        let command = ["filter", "walk.toml", "d.csv", "--proposal", "linearised", "-o", "out.csv"];
        let output = place.run(&[&command, more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        (place.read("out.csv"), stderr(&output))
    };
    let (with, said) = run(&[]);
    let (without, alone) = run(&["--no-check"]);
    assert_eq!(with, without);
    assert!(said.contains("second opinion agrees"), "{said}");
    assert!(!alone.contains("second opinion"), "{alone}");
    assert_eq!(run(&["--no-check", "--check", "--threads", "1"]).1, said);
    // A bootstrap filter needs none.
    let output = place.run(&["filter", "walk.toml", "d.csv", "-o", "out.csv"]);
    assert!(!stderr(&output).contains("second opinion"), "{}", stderr(&output));
}
