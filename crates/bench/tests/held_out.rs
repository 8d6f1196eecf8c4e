//! Proposals that are learned once: experiments on sequences that they never saw, and benchmarks.

mod common;

use std::path::Path;

use common::{TINY, Workplace, stderr};

/// A small experiment of the second protocol, with densities of both kinds.
fn held_out() -> String {
    let learning = r#"
[learning]
horizon = 4
learning_rate = 0.005
rows = 100
base = "transition"
head = { kind = "gaussian", covariance = "shared" }
exact_head = { kind = "flow", pieces = 3, covariance = "shared" }

[learning.elbo]
particles = 5
sequences = 2
steps_for_one = 2
trajectories = 100

[training]"#;
    TINY.replace(
        "[\"min-degeneracy\", \"bootstrap\", \"fcnn\"]",
        "[\"bootstrap\", \"linearised\", \"fcnn\", \"rnn\", \"gnn\", \"psi\"]",
    )
    .replace("noise = \"gaussian\"", "noise = \"uniform\"")
    .replace("\n[training]", learning)
    .replace("name = \"N8\"\ndimension = 8", "name = \"N6-exact\"\ndimension = 6\ndensities = \"exact\"")
}

#[test]
fn each_family_is_learned_once_for_all_particles_and_sequences() {
    let place = Workplace::new(&held_out());
    let run = |arguments: &[&str]| {
        let output = place.run(&[&["tiny"], arguments].concat());
        stderr(&output)
    };
    let said = run(&["--jobs", "2"]);
    assert!(said.contains("96 units to run"), "{said}");
    // Four families under each densities, but for the two whose bound does not exist where densities can be 0.
    let kept = || {
        let entries = std::fs::read_dir(place.path("runs/learned")).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    let learned = kept();
    assert!((4..=8).contains(&learned.len()), "{learned:?}");
    let expected = place.tables("runs");
    let units = String::from_utf8(expected[0].1.clone()).unwrap();
    let value = |method: &str, metric: &str| {
        let line =
            |line: &&str| line.contains(&format!(",{method},")) && line.contains(&format!(",{metric},"));
        units
            .lines()
            .filter(line)
            .map(|line| line.rsplit(',').next().unwrap().to_string())
            .collect::<Vec<_>>()
    };
    // One gain for all units of a panel.
    let mut gains = value("fcnn", "gain");
    assert_eq!(gains.len(), 16);
    gains.dedup();
    assert_eq!(gains.len(), 2, "{gains:?}");
    // Some filters lose all weight under exact densities, and count.
    assert!(value("bootstrap", "lost_runs").iter().any(|lost| lost != "0.0"));

    // A run that begins anew on other threads, with the proposals or without, finds the same.
    for forget in [false, true] {
        if forget {
            std::fs::remove_dir_all(place.path("runs/learned")).unwrap();
        }
        run(&["--fresh", "--jobs", "1"]);
        assert_eq!(place.tables("runs"), expected, "proposals learned anew: {forget}");
        assert_eq!(kept(), learned);
    }
    // A damaged proposal is learned again.
    let weights = place.path("runs/learned").join(&learned[0]).join("weights.safetensors");
    std::fs::write(&weights, b"nonsense").unwrap();
    run(&["--fresh"]);
    assert_eq!(place.tables("runs"), expected);
}

#[test]
fn what_cannot_be_learned_once_is_refused_in_one_line() {
    for (from, to, expected) in [
        ("horizon = 4\nlearning_rate", "horizon = 3\nlearning_rate", "key `learning.horizon` is 3"),
        ("rows = 100", "rows = 0", "key `learning.rows` is 0"),
        ("pieces = 3", "pieces = 1", "key `learning.exact_head`"),
        ("base = \"transition\"", "base = \"transiton\"", "did you mean transition?"),
        ("dimension = 6\ndensities = \"exact\"", "dimension = 6", "key `panels.*.dimension`"),
    ] {
        let place = Workplace::new(&held_out().replacen(from, to, 1));
        let output = place.run(&["tiny"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.lines().count() == 1 && said.contains(expected), "{said}");
    }
}

/// A workplace with the project's own benchmarks and models.
fn benchmarks() -> Workplace {
    let place = Workplace::new(TINY);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for folder in
        ["experiments/learned", "experiments/learned/models", "experiments/models/whiskers", "examples"]
    {
        std::fs::create_dir_all(place.path(folder)).unwrap();
        for entry in std::fs::read_dir(root.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                std::fs::copy(&path, place.path(folder).join(path.file_name().unwrap())).unwrap();
            }
        }
    }
    place
}

#[test]
fn every_benchmark_runs_and_a_finished_one_is_not_run_again() {
    let place = benchmarks();
    let output = place.run(&["learned", "--profile", "smoke"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let card = |name: &str| {
        let path = place.path("runs").join(name).join("smoke/card.json");
        let text = std::fs::read_to_string(&path).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()
    };
    let growth = card("learned-growth");
    for method in ["bootstrap", "linearised", "learned"] {
        assert!(growth["card"]["methods"][method]["ess_fraction"].as_f64().unwrap() > 0.05, "{growth}");
    }
    assert!(growth["card"]["reference_errors"].as_array().unwrap().len() == 2);
    for method in ["look-ahead", "learned, ahead"] {
        assert!(growth["card"]["gains"]["methods"][method]["ratio"].as_f64().unwrap() > 0.0, "{growth}");
    }
    let table = std::fs::read_to_string(place.path("runs/learned-linear25/smoke/table.md")).unwrap();
    assert!(table.contains("| best learned, soft resampling | 0.395 |"), "{table}");
    assert!(card("learned-wrong-parameters")["card"]["methods"]["fivo"].is_object());

    let again = place.run(&["learned-growth", "--profile", "smoke"]);
    assert!(String::from_utf8_lossy(&again.stdout).contains("was run before"));
    // Proposals that are there are not learned again; the card is the same but for times.
    std::fs::remove_file(place.path("runs/learned-growth/smoke/card.json")).unwrap();
    // Neither are references made again: one that is altered is believed.
    let folder = place.path("runs/learned-growth/smoke/references");
    let folder = std::fs::read_dir(folder).unwrap().next().unwrap().unwrap().path();
    let kept = folder.join("0.json");
    let text = std::fs::read_to_string(&kept).unwrap();
    let again = place.run(&["learned-growth", "--profile", "smoke"]);
    assert!(!stderr(&again).contains("learning"), "{}", stderr(&again));
    let evidence = |card: &serde_json::Value| card["card"]["methods"]["learned"]["log_evidence_gap"].clone();
    assert_eq!(evidence(&card("learned-growth")), evidence(&growth));
    let mut altered: serde_json::Value = serde_json::from_str(&text).unwrap();
    altered["log_evidence"] = (altered["log_evidence"].as_f64().unwrap() - 1000.0).into();
    std::fs::write(&kept, altered.to_string()).unwrap();
    std::fs::remove_file(place.path("runs/learned-growth/smoke/card.json")).unwrap();
    assert!(place.run(&["learned-growth", "--profile", "smoke"]).status.success());
    let gap = |card: &serde_json::Value| evidence(card).as_f64().unwrap();
    assert!((gap(&card("learned-growth")) - gap(&growth) - 500.0).abs() < 1e-6);
}

#[test]
fn what_is_no_benchmark_is_refused_in_one_line() {
    let place = benchmarks();
    let refused = |arguments: &[&str], expected: &str| {
        let output = place.run(arguments);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.lines().count() == 1 && said.contains(expected), "{said}");
    };
    refused(&["learned-grwth"], "did you mean learned-growth?");
    refused(&["learned-growth", "--profile", "papr"], "did you mean paper?");
    refused(&["learned-growth", "--methods", "fcnn"], "--methods");
    let file = place.path("experiments/learned/growth.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    for (from, to, expected) in [
        ("\"linearised\"", "\"linearized\"", "did you mean linearised?"),
        ("growth.toml", "groth.toml", "groth.toml"),
        ("name = \"learned\"", "name = \"bootstrap\"", "designed and learned"),
        ("name = \"learned\"", "name = \"learned\"\nobjective = \"wake\"", "it needs"),
        ("name = \"learned\"", "name = \"learned\"\nfrom = \"lerned\"", "learned.learned.from"),
        ("particles = 50", "particles = 0", "profiles.smoke.particles"),
    ] {
        assert!(text.contains(from), "nothing of the benchmark is altered: {from}");
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        let expected = if expected == "it needs" { "the file needs [recorded]" } else { expected };
        refused(&["learned-growth", "--profile", "smoke"], expected);
    }
}
