//! What is committed is what this program would find again: keys of units, and experiments that are to differ in one thing.

use std::path::{Path, PathBuf};

use motes_bench::config::{ReproduceArgs, plans};
use motes_bench::{Record, UnitConfig};

fn experiments() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments")
}

/// Every file below a folder with this ending.
fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, ending, found);
        } else if path.extension().is_some_and(|extension| extension == ending) {
            found.push(path);
        }
    }
}

#[test]
fn committed_units_have_the_keys_that_this_program_gives_them() {
    let mut units = Vec::new();
    files(&experiments().join("reference"), "jsonl", &mut units);
    assert!(units.len() >= 7, "{units:?}");
    let mut count = 0;
    for path in units {
        for line in std::fs::read_to_string(&path).unwrap().lines() {
            let line: serde_json::Value = serde_json::from_str(line).unwrap();
            let record: Record = serde_json::from_value(line["unit"].clone()).unwrap();
            assert_eq!(record.config.key(), line["key"].as_str().unwrap(), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 5048, "{count} units");
}

#[test]
fn the_paper_profile_plans_the_committed_units() {
    for figure in ["fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "table1"] {
        let plan = plans(&ReproduceArgs {
            profile: "paper".into(),
            experiments: experiments(),
            ..ReproduceArgs::of(figure)
        });
        let plan = plan.unwrap().remove(0);
        let path = experiments().join("reference").join(figure).join("paper/units.jsonl");
        let planned: Vec<String> =
            plan.points().iter().map(|point| UnitConfig::at(&plan, point).unwrap().key()).collect();
        for line in std::fs::read_to_string(&path).unwrap().lines() {
            let line: serde_json::Value = serde_json::from_str(line).unwrap();
            let key = line["key"].as_str().unwrap();
            assert!(planned.iter().any(|planned| planned == key), "{figure} has no unit {key}");
        }
    }
}

fn read(path: PathBuf) -> toml::Table {
    toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn experiments_on_the_epidemic_differ_from_table_1_in_what_they_say() {
    let table1 = read(experiments().join("table1.toml"));
    for (name, training, origin) in [
        ("plain", "", None),
        ("full", "", Some("mean")),
        ("each-time", "", Some("mean-at-each-time")),
        ("window-20", "gradient = \"truncated\"\ngradient_window = 20", Some("mean")),
        ("detached", "gradient = \"truncated\"\ngradient_window = 1", Some("mean")),
        ("clipped", "clip_norm = 100.0", Some("mean")),
    ] {
        let found = read(experiments().join(format!("why/epidemic-{name}.toml")));
        for table in ["epidemic", "filter", "panels"] {
            assert_eq!(found[table], table1[table], "{name}: {table}");
        }
        let mut expected = table1["training"].as_table().unwrap().clone();
        expected.extend(toml::from_str::<toml::Table>(training).unwrap());
        assert_eq!(found["training"].as_table(), Some(&expected), "{name}");
        let mut expected = table1["proposals"].as_table().unwrap().clone();
        match origin {
            Some(origin) => expected["standardised"]["origin"] = origin.into(),
            None => drop(expected.remove("standardised")),
        }
        assert_eq!(found["proposals"].as_table(), Some(&expected), "{name}");
    }
}

#[test]
fn experiments_on_gnn_differ_from_figure_1_in_what_they_say() {
    let mut fig1 = read(experiments().join("fig1.toml"));
    assert!(fig1["proposals"].as_table_mut().unwrap().remove("gnn-short-steps").is_some());
    for (name, training) in [
        ("rate-3e-4", "learning_rate = 3e-4"),
        ("rate-1e-4", "learning_rate = 1e-4"),
        ("rate-3e-5", "learning_rate = 3e-5"),
        ("falls-1e-3", "schedule = \"cosine\""),
        ("falls-3e-4", "learning_rate = 3e-4\nschedule = \"cosine\""),
        ("clipped", "clip_norm = 1.0"),
    ] {
        let found = read(experiments().join(format!("why/gnn-{name}.toml")));
        for table in ["system", "filter", "proposals"] {
            assert_eq!(found[table], fig1[table], "{name}: {table}");
        }
        let mut expected = fig1["training"].as_table().unwrap().clone();
        expected.extend(toml::from_str::<toml::Table>(training).unwrap());
        assert_eq!(found["training"].as_table(), Some(&expected), "{name}");
        let (found, paper) = (&found["profiles"]["paper-size"], &fig1["profiles"]["paper"]);
        for key in ["training_steps", "filter_runs", "sizes"] {
            assert_eq!(found[key], paper[key], "{name}: {key}");
        }
    }
}
