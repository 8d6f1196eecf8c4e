//! A proposal learned once: chosen, saved, used by the other commands, and refused where it does not fit.

use crate::common::{Workplace, stderr};
use serde_json::Value;

/// The square hides the sign of the state: two modes.
const SQUARE: &str = r#"
[initial]
x = "normal(0, 2)"
[transition]
x = "normal(0.9*x, 2)"
[measurement]
y = "normal(x^2/4, 1)"
"#;

const QUICK: [&str; 4] = ["--updates", "200", "--widths", "16"];

fn learned(place: &Workplace) {
    place.write("square.toml", SQUARE);
    let command = [&["learn", "square.toml", "-o", "p", "--sequences", "0"], &QUICK[..]].concat();
    let output = place.run(&command);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("chosen: a mixture of 5 around"), "{}", stderr(&output));
}

#[test]
fn it_is_learned_once_and_filters_better_than_what_it_started_from() {
    let place = Workplace::new();
    learned(&place);
    let data = place.printed(&["simulate", "square.toml", "--steps", "60", "--series", "3", "--seed", "9"]);
    place.write("data.csv", data);
    let ess = |proposal: &str| {
        let command =
            ["filter", "square.toml", "data.csv", "--particles", "200", "--proposal", proposal, "--json"];
        let found: Value = serde_json::from_str(&place.printed(&command)).unwrap();
        // Of designed ones the weights warn: that is what learning is for.
        assert!(proposal != "p" || found["warnings"].as_array().unwrap().is_empty(), "{found}");
        found["ess_mean"].as_f64().unwrap() / 200.0
    };
    let [of_learned, linearised, bootstrap] = ["p", "linearised", "bootstrap"].map(ess);
    assert!(
        of_learned > linearised + 0.05 && of_learned > bootstrap + 0.05,
        "{of_learned}, {linearised}, {bootstrap}"
    );
    // The other commands take it, too.
    let smoothed = place.printed(&["smooth", "square.toml", "data.csv", "--proposal", "p", "-q"]);
    assert_eq!(smoothed.lines().count(), 181);
    // Where nothing is measured, nothing is to be known ahead.
    place.write("none.csv", "t,y\n0,\n1,\n2,\n");
    let nothing = place.printed(&["evidence", "square.toml", "none.csv", "--proposal", "p", "-q"]);
    assert_eq!(nothing, "rows,log_evidence,standard_error\n3,0,0\n");
    let compared = place.printed(&[
        "compare",
        "square.toml",
        "--proposals",
        "bootstrap,p",
        "--json",
        "--sequences",
        "2",
        "--steps",
        "10",
        "--sweep",
        "10",
    ]);
    let compared: Value = serde_json::from_str(&compared).unwrap();
    assert!(compared["methods"]["p"]["ess_fraction"].as_f64().unwrap() > 0.2, "{compared}");
}

/// Two coordinates that hear from each other.
const PAIR: &str = r#"
[initial]
a = "normal(0, 1)"
b = "normal(0, 1)"
[transition]
a = "normal(0.5*a + sin(b), 0.5)"
b = "normal(0.9*b + 0.1*a, 0.5)"
[measurement]
y = "normal(a*b, 0.3)"
"#;

#[test]
fn networks_along_the_graph_of_what_depends_on_what_learn_are_saved_and_filter() {
    let place = Workplace::new();
    place.write("pair.toml", PAIR);
    let learning =
        ["learn", "pair.toml", "-o", "g", "--network", "graph", "--sequences", "0", "--updates", "300"];
    let output = place.run(&learning);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("by graph filters of order 2"), "{}", stderr(&output));
    let data = place.printed(&["simulate", "pair.toml", "--steps", "60", "--series", "3", "--seed", "9"]);
    place.write("pair.csv", data);
    let ess = |proposal: &str| {
        let command =
            ["filter", "pair.toml", "pair.csv", "--particles", "200", "--proposal", proposal, "--json"];
        let found: Value = serde_json::from_str(&place.printed(&command)).unwrap();
        found["ess_mean"].as_f64().unwrap() / 200.0
    };
    let [of_learned, bootstrap] = ["g", "bootstrap"].map(ess);
    assert!(of_learned > bootstrap + 0.05, "{of_learned}, {bootstrap}");
    // Its graph is a part of the model that it was learned for.
    place.write("apart.toml", PAIR.replace("0.9*b + 0.1*a", "0.9*b + 0.1"));
    let output = place.run(&["filter", "apart.toml", "pair.csv", "--proposal", "g"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

#[test]
fn the_same_seed_gives_the_same_weights_and_the_same_bytes_on_any_number_of_threads() {
    let place = Workplace::new();
    learned(&place);
    let command =
        [&["learn", "square.toml", "-o", "q", "--sequences", "0", "--threads", "1"], &QUICK[..]].concat();
    place.printed(&command);
    let weights = |folder: &str| std::fs::read(place.path(folder).join("weights.safetensors")).unwrap();
    assert_eq!(weights("p"), weights("q"));
    let data = place.printed(&["simulate", "square.toml", "--steps", "10"]);
    place.write("data.csv", data);
    let run = |folder: &str, threads: &str| {
        let of_filter = ["--particles", "3000", "--threads", threads, "-q"];
        place
            .printed(&[&["filter", "square.toml", "data.csv", "--proposal", folder], &of_filter[..]].concat())
    };
    assert_eq!(run("p", "1"), run("q", "3"));
}

#[test]
fn the_card_has_the_keys_that_scripts_rely_on() {
    let place = Workplace::new();
    place.write("square.toml", SQUARE);
    let command =
        [&["learn", "square.toml", "-o", "p", "--sequences", "3", "--steps", "20", "--json"], &QUICK[..]]
            .concat();
    let card: Value = serde_json::from_str(&place.printed(&command)).unwrap();
    let methods: Vec<&String> = card["methods"].as_object().unwrap().keys().collect();
    assert_eq!(methods, ["bootstrap", "learned", "learned, ahead", "linearised", "look-ahead"]);
    assert!(card["training_seconds"].as_f64().unwrap() > 0.0);
    for key in
        ["ess_fraction", "ess_fraction_q01", "log_evidence_gap", "e_l", "e_x", "coverage_50", "coverage_90"]
    {
        assert!(card["methods"]["learned"][key].is_number(), "{key}");
    }
    for key in ["ess_fraction", "log_evidence_gap", "e_l", "e_x"] {
        assert!(card["methods"]["learned"]["half_widths"][key].as_f64().unwrap() > 0.0, "{key}");
    }
}

const LINEAR: &str = r#"
[initial]
x = "normal(0, 1)"
[transition]
x = "normal(0.9*x, 1)"
[measurement]
y = "normal(x, 0.1)"
"#;

/// Linearised proposals are the best there are here, and a smoother has no error: a few updates learn nothing that pays.
#[test]
fn where_nothing_learned_pays_filters_take_the_designed_proposal() {
    let place = Workplace::new();
    place.write("linear.toml", LINEAR);
    let output = place.run(&["learn", "linear.toml", "-o", "p", "--updates", "5", "--sequences", "0"]);
    let said = stderr(&output);
    assert!(said.contains("filters draw by linearised, which is designed"), "{said}");
    assert!(said.contains("look-ahead 0.000"), "{said}");
    let data = place.printed(&["simulate", "linear.toml", "--steps", "30", "--seed", "9"]);
    place.write("d.csv", data);
    let filtered =
        |proposal: &str| place.printed(&["filter", "linear.toml", "d.csv", "--proposal", proposal, "-q"]);
    assert_eq!(filtered("p"), filtered("linearised"));
    let compared =
        ["--proposals", "bootstrap,linearised,p", "--sequences", "3", "--steps", "9", "--sweep", "9"];
    let card = place.printed(&[&["compare", "linear.toml"], &compared[..]].concat());
    assert!(card.lines().next().unwrap().ends_with(" p filters by linearised."), "{card}");
    assert_ne!(filtered("p"), filtered("bootstrap"));
    let file = place.path("p").join("potentials.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"linearised\"", "\"linearized\"")).unwrap();
    let output = place.run(&["filter", "linear.toml", "d.csv", "--proposal", "p", "-q"]);
    let said = stderr(&output);
    assert!(output.status.code() != Some(0) && said.lines().count() == 1, "{said}");
}

/// A linear model, whose exact evidence the reference is: a filter that looks ahead has no error.
#[test]
fn filters_that_look_ahead_are_compared_by_their_evidence_alone() {
    let place = Workplace::new();
    place.write("linear.toml", LINEAR);
    let command = ["compare", "linear.toml", "--sequences", "3", "--steps", "30", "--sweep", "10,20"];
    let card: Value = serde_json::from_str(&place.printed(&[&command[..], &["--json"]].concat())).unwrap();
    let ahead = &card["methods"]["look-ahead"];
    assert!(ahead["log_evidence_gap"].as_f64().unwrap().abs() < 1e-9, "{card}");
    assert!(card["methods"]["bootstrap"]["log_evidence_gap"].as_f64().unwrap().abs() > 1e-3, "{card}");
    for key in ["ess_fraction", "ess_fraction_q01", "e_l", "e_x", "coverage_90"] {
        assert!(ahead[key].is_null() && card["methods"]["bootstrap"][key].is_number(), "{key}: {card}");
    }
    assert!(card["gains"]["methods"]["look-ahead"]["ratio"].as_f64().unwrap() > 1e6, "{card}");
    let text = place.printed(&command);
    assert!(text.starts_with("Speed at the same error of the log-evidence"), "{text}");
    assert!(text.lines().any(|line| line.starts_with("| look-ahead") && line.contains("– |")), "{text}");
    // A matrix file has no noise to look through.
    let matrices = "kind = \"linear-gaussian\"\nstates = [\"x\"]\nmeasurements = [\"y\"]\nA = [[0.9]]\nQ = [[1.0]]\nC = [[1.0]]\nR = [[0.25]]\nm0 = [0.0]\nP0 = [[1.0]]\n";
    place.write("matrices.toml", matrices);
    let output = place.run(&["compare", "matrices.toml", "--proposals", "look-ahead", "--sequences", "2"]);
    let said = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.lines().count() == 1 && said.contains("take --proposal exact"), "{said}");
}

/// Catches pairs that are of different sequences: the mean of differences is the difference of means.
#[test]
fn proposals_are_paired_by_sequence_and_the_page_shows_all() {
    let place = Workplace::new();
    place.write("square.toml", SQUARE);
    let command =
        ["compare", "square.toml", "--sequences", "4", "--steps", "20", "--sweep", "20,100", "--json"];
    let card: Value =
        serde_json::from_str(&place.printed(&[&command[..], &["--report", "card.html"]].concat())).unwrap();
    assert_eq!(card["paired"]["less"], "linearised");
    let of = |name: &str, key: &str| card["methods"][name][key].as_f64().unwrap();
    let paired = &card["paired"]["methods"]["bootstrap"];
    for (key, own) in [("ess_fraction", "ess_fraction"), ("log_evidence", "log_evidence_gap")] {
        let expected = of("bootstrap", own) - of("linearised", own);
        let found = paired[key].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{key}: {found} for {expected}");
        assert!(paired["half_widths"][key].as_f64().unwrap() > 0.0);
    }
    let page = place.read("card.html");
    for part in
        ["<svg", "Report card", "Error at equal time", "Difference from linearised", "bootstrap", "Made by"]
    {
        assert!(page.contains(part), "{part}");
    }
    assert!(
        !page.contains("http://")
            || page.matches("http://").count() == page.matches("http://www.w3.org").count()
    );
}

#[test]
fn data_are_learned_from_in_addition() {
    let place = Workplace::new();
    place.write("square.toml", SQUARE);
    place.write("data.csv", "y\n1\n2\n\n0.5\n3\n1\n".replace("\n\n", "\nNA\n"));
    let command =
        [&["learn", "square.toml", "data.csv", "-o", "p", "--sequences", "0", "-q"], &QUICK[..]].concat();
    place.printed(&command);
}

/// The square with another parameter, and series of it.
fn other(place: &Workplace) {
    place.write("other.toml", SQUARE.replace("normal(0.9*x, 2)", "normal(0.6*x, 3)"));
    let series = ["simulate", "other.toml", "--steps", "40", "--series", "5", "--seed", "5"];
    let data = place.printed(&series);
    place.write("recorded.csv", data);
}

#[test]
fn a_proposal_for_other_parameters_is_tuned_on_data_by_the_same_bytes_each_time() {
    let place = Workplace::new();
    learned(&place);
    other(&place);
    let tune = |folder: &str, more: &[&str]| {
        let command =
            ["learn", "other.toml", "recorded.csv", "-o", folder, "--from", "p", "--sequences", "0"];
        let output = place.run(&[&command, &["--objective", "wake", "--updates", "30"][..], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        stderr(&output)
    };
    let said = tune("q", &[]);
    assert!(said.contains("chosen: p, learned further"), "{said}");
    assert!(said.contains("log-evidence of held-out data "), "{said}");
    // It is for the model that it was tuned for, which the one that it came from is not.
    let filter = |folder: &str| {
        place.run(&["filter", "other.toml", "recorded.csv", "--proposal", folder, "-q"]).status.code()
    };
    assert_eq!((filter("q"), filter("p")), (Some(0), Some(2)));
    let weights = |folder: &str| std::fs::read(place.path(folder).join("weights.safetensors")).unwrap();
    tune("r", &["--threads", "1"]);
    assert_eq!(weights("q"), weights("r"));
    tune("s", &["--dropout", "0.2", "--penalty", "0.001"]);
    assert!(place.path("s").join("proposal.toml").exists());
}

#[test]
fn the_evidence_itself_is_learned_from_data() {
    let place = Workplace::new();
    place.write("square.toml", SQUARE);
    other(&place);
    let learn = ["learn", "square.toml", "recorded.csv", "-o", "p", "--objective", "fivo"];
    let few = ["--updates", "40", "--widths", "8", "--sequences", "0", "--base", "linearised"];
    let output = place.run(&[&learn[..], &few, &["--head", "gaussian"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains("log-evidence of held-out data "), "{}", stderr(&output));
}

#[test]
fn objectives_without_what_they_need_are_refused() {
    let place = Workplace::new();
    learned(&place);
    other(&place);
    place.write("pair.toml", PAIR);
    let refused = |options: &[&str], status: i32, line: &str| {
        let output = place.run(&[&["learn"], options, &["-o", "none"]].concat());
        assert_eq!(stderr(&output), format!("motes: {line}"), "{options:?}");
        assert_eq!(output.status.code(), Some(status), "{options:?}");
        assert!(!place.path("none").exists());
    };
    for objective in ["wake", "fivo"] {
        refused(
            &["square.toml", "--objective", objective],
            2,
            &format!("--objective {objective}: it learns from data; name a file of them after the model"),
        );
    }
    refused(
        &["square.toml", "--objective", "sleep"],
        2,
        "--objective sleep: there are inclusive, wake, fivo",
    );
    refused(&["square.toml", "--dropout", "1"], 2, "--dropout 1: it must be a number from 0 to below 1");
    refused(&["square.toml", "--penalty", "-1"], 2, "--penalty -1: it must be a number of at least 0");
    let line = "the objective fivo takes a head whose draws have derivatives: gaussian, kernel or flow; those of a mixture have none";
    let fivo = ["square.toml", "recorded.csv", "-q", "--objective", "fivo"];
    refused(&[&fivo[..], &["--head", "mixture"]].concat(), 2, line);
    refused(&[&fivo[..], &["--from", "p"]].concat(), 2, line);
    place.write("short.csv", "y\n1\n2\n0.5\n");
    refused(
        &["square.toml", "short.csv", "--objective", "wake", "--from", "p"],
        2,
        "the recorded measurements cannot be filtered: the only series has 3 times; 8 are needed to hold some out",
    );
    refused(
        &["pair.toml", "--from", "p"],
        2,
        "p: this proposal was trained for another system: the state dimension N is 1 there and 2 in the model given",
    );
    refused(
        &["square.toml", "--from", "nowhere"],
        3,
        "nowhere/proposal.toml: No such file or directory (os error 2)",
    );
    refused(
        &["square.toml", "--from", "p", "--head", "gaussian"],
        2,
        "the argument '--from <FOLDER>' cannot be used with '--head <H>'; see motes --help",
    );
}

#[test]
fn what_cannot_be_learned_is_refused() {
    let place = Workplace::new();
    learned(&place);
    let refused = |arguments: &[&str], line: &str| {
        let output = place.run(arguments);
        assert_eq!(stderr(&output), format!("motes: {line}"), "{arguments:?}");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    };
    let linear = "--proposal learned: nothing is left to learn for kind = \"linear-gaussian\": take --proposal optimal, which is exact";
    refused(&["learn", "linear.toml", "-o", "r"], linear);
    refused(&["learn", "square.toml", "-o", "r", "--budget", "0"], "--budget 0: it must be a number above 0");
    refused(
        &["learn", "square.toml", "-o", "r", "--steps", "1"],
        "--steps 1: it must be an integer from 2 to 1000000",
    );
    refused(
        &["learn", "square.toml", "-o", "r", "--base", "foo"],
        "--base foo: there are transition, linearised",
    );
    refused(
        &["learn", "square.toml", "-o", "r", "--head", "round"],
        "--head round: there are gaussian, kernel, mixture, flow",
    );
    refused(
        &["learn", "square.toml", "-o", "r", "--head", "flow:1"],
        "--head flow:1: 1 is no number of pieces; it must be an integer from 2 to 100",
    );
    refused(
        &["learn", "square.toml", "-o", "r", "--network", "mesh"],
        "--network mesh: there are connected, graph",
    );
    refused(
        &["learn", "square.toml", "-o", "r", "--network", "graph:0"],
        "--network graph:0: 0 is no order of graph filters; it must be an integer from 1 to 100",
    );
    let needed = "the following required arguments were not provided: --output <FOLDER>; see motes --help";
    refused(&["learn", "square.toml"], needed);
    place.write("one.csv", "y\n1\n");
    place.write("missing.csv", "y\nNA\nNA\nNA\n");
    refused(
        &["learn", "square.toml", "one.csv", "-o", "r"],
        "the recorded measurements cannot be filtered: series 0 has 1 times; a step takes two",
    );
    refused(
        &["learn", "square.toml", "missing.csv", "-o", "r"],
        "the recorded measurements cannot be filtered: all measurements of series 0 are missing",
    );
    let runaway = "[initial]\nx = \"normal(1e300, 1)\"\n[transition]\nx = \"normal(x*x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    place.write("runaway.toml", runaway);
    refused(
        &["learn", "runaway.toml", "-o", "r"],
        "the number of drawn sequences that reach a second time is 0; it must be at least 1: the model's simulation overflows, look at its transition and noise",
    );
    place.write("gaps.toml", format!("[time]\ncolumn = \"t\"\nstep = 1\n{SQUARE}"));
    place.write("gaps.csv", "t,y\n0,1\n1,1\n4,1\n5,1\n");
    refused(
        &["learn", "gaps.toml", "gaps.csv", "-o", "r"],
        "learn: the gaps between rows have from 1 to 3 sub-steps, and a learned proposal is for one number of them; take --proposal linearised, or motes evidence, which need no learning, or data with equal gaps",
    );
    assert!(!place.path("r").exists());
    // A proposal for another model, by another parameter.
    place.write("other.toml", SQUARE.replace("0.9*x", "0.8*x"));
    let output = place.run(&["filter", "other.toml", "d.csv", "--proposal", "p"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert!(stderr(&output).contains("p"), "{}", stderr(&output));
    let output = place.run(&["filter", "linear.toml", "d.csv", "--proposal", "p"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}
