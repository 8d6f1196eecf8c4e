//! `motes fit` as a command: what it writes, what it refuses, and how it goes on after it was stopped.

use std::process::Stdio;

use crate::common::{Workplace, stderr};
use crate::fitting::NILE;
use rand::RngExt;

/// Catches a state that is written by halves, and work that depends on where it was stopped.
#[test]
fn killed_at_ten_random_moments_a_fit_ends_with_the_same_bytes() {
    let place = place();
    let arguments = |folder| ["fit", "nile.toml", "nile.csv", "-o", folder, "--draws", "20000", "--quiet"];
    let start = std::time::Instant::now();
    let table = place.printed(&arguments("whole"));
    let whole = start.elapsed();
    let mut stream = motes::models::Seed::from_u64(7).stream();
    let (mut killed, mut kept) = (0, 0);
    while killed < 10 {
        let written =
            || std::fs::metadata(place.path("parts/progress.cbor")).and_then(|file| file.modified()).ok();
        let before = written();
        let mut child = place.motes(&arguments("parts")).stdout(Stdio::null()).spawn().unwrap();
        // Each second one has written something down; some of the others are killed while they start.
        while killed % 2 == 1 && written() == before && child.try_wait().unwrap().is_none() {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        std::thread::sleep(whole.mul_f64(0.05 * stream.random::<f64>()));
        if child.try_wait().unwrap().is_some() {
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        killed += 1;
        kept += usize::from(place.path("parts/progress.cbor").exists());
    }
    assert!(killed >= 3 && kept > 0, "killed {killed} times, {kept} of them with something to go on from");
    assert_eq!(place.printed(&arguments("parts")), table);
    for name in ["draws.csv", "summary.json", "fit.toml"] {
        assert_eq!(place.read(&format!("parts/{name}")), place.read(&format!("whole/{name}")), "{name}");
    }
    assert!(!place.path("parts/progress.cbor").exists());
}

/// Catches a signal that loses what was done, and a message that does not say how to go on.
#[cfg(unix)]
#[test]
fn stopped_by_a_signal_a_fit_says_how_to_go_on_and_does() {
    for method in ["posterior", "maximum"] {
        let place = place();
        let mut arguments = vec!["fit", "nile.toml", "nile.csv", "-o", "fit", "--method", method];
        arguments.extend(match method {
            "posterior" => ["--draws", "50000"],
            _ => ["--chains", "300"],
        });
        let child = place.motes(&arguments).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_millis(1500));
        let signalled = std::process::Command::new("kill").arg(child.id().to_string()).status().unwrap();
        assert!(signalled.success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(143), "{}", stderr(&output));
        let said = "motes: stopped; fit keeps where it stood: the same command goes on from there";
        assert_eq!(stderr(&output), said);
        let files = std::fs::read_dir(place.path("fit")).unwrap().map(|entry| entry.unwrap().file_name());
        assert_eq!(files.collect::<Vec<_>>(), ["progress.cbor"]);
        // Another fit begins anew, and what is there is none of it.
        let small = ["fit", "nile.toml", "nile.csv", "-o", "fit", "--draws", "4", "--seed", "2"];
        assert!(!stderr(&place.run(&small)).contains("going on"));
    }
}

#[test]
fn what_a_budget_ended_can_go_on() {
    let place = place();
    let arguments = ["fit", "nile.toml", "nile.csv", "-o", "fit", "--draws", "1000000", "--budget", "3"];
    let output = place.run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let said = "motes: --budget ended it; fit keeps where it stood: the same command goes on from there";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let first = place.read("fit/draws.csv");
    let again = place.run(&arguments);
    assert!(stderr(&again).contains("motes: fit: going on from where it was stopped"), "{}", stderr(&again));
    // Draws of the first chain are the same as far as they go.
    let second = place.read("fit/draws.csv");
    let of_chain = |text: &str| text.lines().take_while(|line| !line.starts_with("1,")).count();
    assert!(of_chain(&second) > of_chain(&first));
    assert!(second.lines().zip(first.lines()).take(of_chain(&first)).all(|(a, b)| a == b));
    let short = place.run(&["fit", "nile.toml", "nile.csv", "-o", "short", "--budget", "1e-6"]);
    assert_eq!(short.status.code(), Some(2));
    let said = "motes: --budget: 0.000001 seconds ended while starts were sought, before there were draws to keep; take more seconds; short keeps where it \
                stood: the same command goes on from there";
    assert_eq!(stderr(&short), said);
}

/// Catches a folder that is there though nothing was fitted.
#[test]
fn a_folder_is_made_when_something_is_written() {
    let place = place();
    let output = place.run(&["fit", "walk.toml", "d.csv", "-o", "fit"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(!place.path("fit").exists());
}

#[test]
fn a_maximum_has_the_profiles_that_are_asked_for() {
    let place = place();
    let fit = ["fit", "nile.toml", "nile.csv", "-o", "fit", "--method", "maximum", "--json"];
    let all: serde_json::Value = serde_json::from_str(&place.printed(&fit)).unwrap();
    for name in ["measurement_variance", "level_variance"] {
        let of = &all["parameters"][name];
        let [low, estimate, high] = ["low", "estimate", "high"].map(|key| of[key].as_f64().unwrap());
        assert!(low < estimate && estimate < high, "{of}");
    }
    // The maximum and five points on either side; more where the profile is not low enough by then.
    let points = || {
        let table = place.read("fit/profile.csv");
        let count = |name: &str| table.lines().filter(|line| line.starts_with(name)).count();
        ["measurement_variance", "level_variance"].map(count)
    };
    assert!(points().iter().all(|count| *count >= 11), "{:?}", points());
    let page = ["--profile", "level_variance", "--report", "maximum.html"];
    let one: serde_json::Value = serde_json::from_str(&place.printed(&[&fit[..], &page].concat())).unwrap();
    assert_eq!(one["parameters"]["level_variance"], all["parameters"]["level_variance"]);
    assert!(one["parameters"]["measurement_variance"]["low"].is_null(), "{one}");
    assert!(points()[0] == 0 && points()[1] >= 11, "{:?}", points());
    let page = place.read("maximum.html");
    assert!(page.contains("log-likelihood") && page.contains("States and measurements at the maximum"));
    let refused =
        |more: &[&str]| stderr(&place.run(&[&["fit", "nile.toml", "nile.csv", "-o", "fit"], more].concat()));
    assert_eq!(
        refused(&["--method", "maximum", "--profile", "width"]),
        "motes: --profile width: that is no free parameter; there are measurement_variance, level_variance"
    );
    assert_eq!(
        refused(&["--profile", "level_variance"]),
        "motes: --profile: draws of the posterior have no profiles; take --method maximum"
    );
    assert_eq!(refused(&["--passes", "2"]), "motes: --passes: they seek a maximum; take --method maximum");
}

#[test]
fn a_maximum_by_passes_says_so_and_has_intervals_where_they_are_asked_for() {
    let place = place();
    let fit = ["fit", "nile.toml", "nile.csv", "-o", "fit", "--method", "maximum", "--chains", "2"];
    let by = ["--proposal", "bootstrap", "--passes", "3", "--particles", "50"];
    let output = place.run(&[&fit[..], &by].concat());
    let said = stderr(&output);
    assert!(said.contains("of 2 came as high by 3 passes of iterated filtering"), "{said}");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(table.starts_with("|                      | estimate |\n"), "{table}");
    assert_eq!(place.read("fit/profile.csv").lines().count(), 1);
}

/// Catches marginal likelihoods of other folders, and scores of rows that are not the same.
#[test]
fn two_fitted_models_are_held_beside_each_other() {
    let place = place();
    // A level that stands still.
    place.write("still.toml", NILE.replace("nile", "still").replace("log(1000), 1.5", "log(1e-6), 0.1"));
    for (model, folder) in [("nile.toml", "nile"), ("still.toml", "still")] {
        place.printed(&["fit", model, "nile.csv", "-o", folder, "--draws", "500", "--quiet"]);
    }
    let set = ["smooth", "nile.toml", "nile.csv", "--parameters", "nile", "--set", "level_variance=1"];
    let expected = "motes: --set level_variance: nile has values of it; leave out --set, or --parameters";
    assert_eq!(stderr(&place.run(&set)), expected);
    let compare = |more: &[&str]| {
        let both = [
            "compare",
            "nile.toml",
            "still.toml",
            "nile.csv",
            "--parameters",
            "nile",
            "--parameters",
            "still",
        ];
        place.printed(&[&both[..], more].concat())
    };
    let json: serde_json::Value = serde_json::from_str(&compare(&["--json"])).unwrap();
    let summary = |folder: &str| -> serde_json::Value {
        serde_json::from_str(&place.read(&format!("{folder}/summary.json"))).unwrap()
    };
    let of = |folder: &str, key: &str| summary(folder)[key].as_f64().unwrap();
    let marginal = ["nile", "still"].map(|folder| of(folder, "log_marginal_likelihood"));
    let errors = ["nile", "still"].map(|folder| of(folder, "log_marginal_likelihood_error"));
    assert_eq!(json["log_bayes_factor"].as_f64().unwrap(), marginal[0] - marginal[1]);
    assert_eq!(json["log_bayes_factor_error"].as_f64().unwrap(), errors[0].hypot(errors[1]));
    assert_eq!(json["rows"], 10);
    // Of so few draws of a narrow posterior the score at the mean is not far.
    let at_mean = [
        "filter",
        "still.toml",
        "nile.csv",
        "--parameters",
        "still",
        "--at",
        "mean",
        "--json",
        "--proposal",
        "exact",
    ];
    let at_mean: serde_json::Value = serde_json::from_str(&place.printed(&at_mean)).unwrap();
    let [score, plain] =
        [&json["models"]["still"]["log_score"], &at_mean["log_evidence"]].map(|of| of.as_f64().unwrap());
    assert!((score - plain).abs() < 1.0, "{score} beside {plain}");
    let table = compare(&[]);
    assert!(
        table.contains("| log marginal likelihood ") && table.contains("| one-step-ahead log score "),
        "{table}"
    );
    let refused = |arguments: &[&str]| stderr(&place.run(arguments));
    let one = refused(&["compare", "nile.toml", "still.toml", "nile.csv", "--parameters", "nile"]);
    assert!(
        one.starts_with(
            "motes: --parameters: two models are held beside each other by what was fitted of both"
        ),
        "{one}"
    );
    place.write("other.csv", "flow\n1120\n1160\n");
    let other = refused(&[
        "compare",
        "nile.toml",
        "still.toml",
        "other.csv",
        "--parameters",
        "nile",
        "--parameters",
        "still",
    ]);
    assert_eq!(other, "motes: --parameters nile: it is a fit to other data; fit it to these");
}

pub(crate) fn place() -> Workplace {
    let place = Workplace::new();
    place.write("nile.toml", NILE);
    place.write("nile.csv", "flow\n1120\n1160\n963\n1210\n1160\n1160\n813\n1230\n1370\n1140\n");
    place
}

#[test]
fn a_fit_is_a_table_a_folder_and_parameters_for_other_commands() {
    let place = place();
    let fit = ["fit", "nile.toml", "nile.csv", "-o", "fit", "--draws", "200"];
    let table = place.printed(&fit);
    assert!(table.contains("| measurement_variance |") && table.contains("ESS bulk"), "{table}");
    let draws = place.read("fit/draws.csv");
    assert!(
        draws.starts_with("chain,draw,log_evidence,measurement_variance,level_variance\n0,0,"),
        "{draws}"
    );
    assert_eq!(draws.lines().count(), 801);
    let json: serde_json::Value = serde_json::from_str(&place.read("fit/summary.json")).unwrap();
    for key in ["mean", "sd", "q05", "q50", "q95", "rhat", "ess_bulk", "ess_tail", "mcse"] {
        assert!(json["parameters"]["level_variance"][key].is_number(), "{key}: {json}");
    }
    for key in ["log_likelihood", "log_likelihood_error", "log_marginal_likelihood", "acceptance"] {
        assert!(json[key].is_number(), "{key}: {json}");
    }
    // The same seed on another number of threads.
    let threads = place.printed(&[&fit[..4], &["other", "--draws", "200", "--threads", "1"]].concat());
    assert_eq!((threads, place.read("other/draws.csv")), (table, draws));
    let over = ["filter", "nile.toml", "nile.csv", "--parameters", "fit", "--json"];
    let over: serde_json::Value = serde_json::from_str(&place.printed(&over)).unwrap();
    assert!(over["log_evidence"].is_null() && over["draws"] == 100, "{over}");
    let at_mean = ["filter", "nile.toml", "nile.csv", "--parameters", "fit", "--at", "mean", "--json"];
    let at_mean: serde_json::Value = serde_json::from_str(&place.printed(&at_mean)).unwrap();
    assert!(at_mean["log_evidence"].is_number(), "{at_mean}");
    let table = place.printed(&["filter", "nile.toml", "nile.csv", "--parameters", "fit", "--forecast", "3"]);
    assert_eq!(table.lines().count(), 14, "{table}");
    let smoothed = place.printed(&["smooth", "nile.toml", "nile.csv", "--parameters", "fit"]);
    assert_eq!(smoothed.lines().count(), 11, "{smoothed}");
    let simulated =
        place.printed(&["simulate", "nile.toml", "--steps", "2", "--series", "3", "--parameters", "fit"]);
    let header = "series,t,level,flow,measurement_variance,level_variance";
    assert!(simulated.starts_with(header), "{simulated}");
}

#[test]
fn what_cannot_be_fitted_is_refused_in_one_line() {
    let place = place();
    place.write(
        "known.toml",
        NILE.replace("\"log_normal(log(10000), 1.5)\"", "10000")
            .replace("\"log_normal(log(1000), 1.5)\"", "1000"),
    );
    place.write(
        "uniform.toml",
        NILE.replace("normal(level, sqrt(measurement_variance))", "uniform(level, level + 1e-9)"),
    );
    let refused = |arguments: &[&str]| {
        let output = place.run(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", stderr(&output));
        stderr(&output)
    };
    assert_eq!(
        refused(&["fit", "known.toml", "nile.csv", "-o", "fit"]),
        "motes: no parameter of known has a prior, so there is nothing to fit; write what is known of one before the data instead of its value, as in \
         measurement_variance = \"log_normal(log(10000), 1)\""
    );
    assert_eq!(
        refused(&["fit", "walk.toml", "d.csv", "-o", "fit", "--set", "noise=2"]),
        "motes: no parameter of walk has a prior, so there is nothing to fit; write what is known of one before the data instead of its value, as in \
         noise = \"log_normal(log(2), 1)\""
    );
    let all = [
        "fit",
        "nile.toml",
        "nile.csv",
        "-o",
        "fit",
        "--set",
        "measurement_variance=1",
        "--set",
        "level_variance=1",
    ];
    assert_eq!(
        refused(&all),
        "motes: every parameter that has a prior was given a value by --set; leave one of them free"
    );
    let impossible = refused(&["fit", "uniform.toml", "nile.csv", "-o", "fit"]);
    assert!(
        impossible.starts_with("motes: the likelihood is 0 at every draw from the prior: the model cannot give these data; the first time: nile.csv, line 2"),
        "{impossible}"
    );
    place.printed(&["fit", "nile.toml", "nile.csv", "-o", "fit", "--draws", "100"]);
    place.write("other.toml", NILE.replace("1000, 1000", "1000, 900"));
    assert_eq!(
        refused(&["filter", "other.toml", "nile.csv", "--parameters", "fit"]),
        "motes: --parameters fit: it is a fit of nile, or of this model before its file was changed; fit it again"
    );
    let nothing = refused(&["filter", "nile.toml", "nile.csv", "--parameters", "nowhere"]);
    assert_eq!(
        nothing,
        "motes: --parameters nowhere: there is no fit.toml in it; motes fit writes such folders with -o"
    );
    place.write("other-folder", "");
    std::fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/thesis.tex", "");
    let output = place.run(&["fit", "nile.toml", "nile.csv", "-o", "mine"]);
    assert_eq!(output.status.code(), Some(3));
    assert!(stderr(&output).contains("it has files in it, and none of a fit"), "{}", stderr(&output));
    // What was drawn before stays.
    let before = place.read("fit/draws.csv");
    place.write("fewer.csv", place.read("nile.csv").lines().take(5).collect::<Vec<_>>().join("\n") + "\n");
    std::fs::create_dir(place.path("changed")).unwrap();
    place.write("changed/nile.toml", NILE.replace("1000, 1000", "1000, 900"));
    for (model, data, other) in [
        ("changed/nile.toml", "nile.csv", "a fit of nile as its file was before it was changed"),
        ("uniform.toml", "nile.csv", "a fit of another model, nile"),
        ("nile.toml", "fewer.csv", "a fit of nile to other data"),
    ] {
        let output = place.run(&["fit", model, data, "-o", "fit", "--draws", "100"]);
        assert_eq!(output.status.code(), Some(2));
        let line = format!("motes: fit: it has {other}; name another folder, or remove this one");
        assert_eq!(stderr(&output), line);
    }
    assert_eq!(place.read("fit/draws.csv"), before);
    let exactly = refused(&["fit", "uniform.toml", "nile.csv", "-o", "exact", "--proposal", "exact"]);
    assert!(exactly.starts_with("motes: --proposal exact:"), "{exactly}");
}

#[test]
fn what_data_say_nothing_about_and_what_lies_at_an_edge_is_said() {
    let place = place();
    let unknown = NILE.replace("[initial]", "idle = \"normal(0, 1)\"\n[initial]");
    place.write("unknown.toml", unknown);
    let output = place.run(&["fit", "unknown.toml", "nile.csv", "-o", "fit", "--draws", "400", "--strict"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let said = "motes: warning: the data say nothing about idle: its posterior is its prior normal(0, 1)";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let edge = NILE.replace("log_normal(log(10000), 1.5)", "log_normal(log(300), 0.5)");
    let edge = edge.replace("log_normal(log(1000), 1.5)", "log_normal(log(10), 0.3)");
    place.write("edge.toml", edge);
    let output = place.run(&["fit", "edge.toml", "nile.csv", "-o", "edge", "--draws", "400"]);
    let said = "measurement_variance lies at the upper edge of its prior log_normal(log(300), 0.5): the prior and the data disagree";
    assert!(stderr(&output).contains(said), "{}", stderr(&output));
    let few = place.run(&["fit", "nile.toml", "nile.csv", "-o", "few", "--draws", "20", "--strict"]);
    assert_eq!(few.status.code(), Some(1));
    assert!(stderr(&few).contains("the chains have not converged: "), "{}", stderr(&few));
}
