//! What is committed is what this program would find again: keys of units, and experiments that are to differ in one thing.

use std::path::{Path, PathBuf};

use motes_bench::Record;

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
    files(&experiments().join("reference"), "json", &mut units);
    units.retain(|path| path.parent().is_some_and(|folder| folder.ends_with("units")));
    assert!(units.len() > 500, "{} units", units.len());
    for path in units {
        let text = std::fs::read_to_string(&path).unwrap();
        let file: serde_json::Value = serde_json::from_str(&text).unwrap();
        let record: Record = serde_json::from_value(file["unit"].clone()).unwrap();
        assert_eq!(record.config.key(), path.file_stem().unwrap().to_str().unwrap(), "{}", path.display());
    }
}

#[test]
fn experiments_on_the_epidemic_differ_from_table_1_in_what_they_say() {
    let read =
        |path: PathBuf| -> toml::Table { toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap() };
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
