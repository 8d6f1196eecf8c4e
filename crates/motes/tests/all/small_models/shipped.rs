//! The model files of the project: each is read, checked with its data, and filtered.

use std::fs::read_dir;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use motes::formulas::FileError;
use motes::output::simulated_table;
use motes::{Data, FilterOptions, Model, check, filter, simulate};

/// A page that people read at once.
const LINES: usize = 45;
const COLUMNS: usize = 100;

/// Models whose data nobody may ship; `fetch.py` gets them.
const FETCHED: [&str; 2] = ["dacca-cholera", "london-measles"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What is in a folder, in order.
fn listed(folder: &Path) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    found
}

fn is_model(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
}

/// A line that is longer counts as several.
fn check_size(path: &Path) {
    let text = std::fs::read_to_string(path).unwrap();
    let lines: usize = text.lines().map(|line| line.chars().count().div_ceil(COLUMNS).max(1)).sum();
    assert!(lines <= LINES, "{}: {lines} lines of {COLUMNS} columns", path.display());
}

/// Reads a model, looks at it with its data, and filters them, with 200 particles.
fn go_through(path: &Path, model: &Model, data: &Data) {
    let checked = check(model, Some(data), 1, || ControlFlow::Continue(())).unwrap();
    assert!(checked.problems.is_empty(), "{}: {:?}", path.display(), checked.problems);
    let options = FilterOptions { particles: 200, check: false, predictive: true, ..Default::default() };
    let found = filter(model, data, &options, |_| ControlFlow::Continue(()));
    let found = found.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    assert!(found.log_evidence().is_finite(), "{}: {}", path.display(), found.log_evidence());
    // Of what is measured in each row its place is known, too.
    for (row, estimate) in data.rows.iter().zip(&found.estimates) {
        for (measured, predictive) in row.measurement.iter().zip(&estimate.predictive) {
            let is_share = predictive.pit.is_some_and(|pit| (0.0..=1.0).contains(&pit));
            assert_eq!(measured.is_some(), is_share, "{}, {}: {predictive:?}", path.display(), row.line);
            assert!(
                predictive.mean.is_finite() && predictive.sd >= 0.0,
                "{}: {predictive:?}",
                path.display()
            );
        }
    }
}

#[test]
fn models_of_other_packages_are_checked_and_filtered() {
    let mut models = 0;
    for folder in listed(&root().join("experiments/models")) {
        let path = folder.join("model.toml");
        if !path.exists() {
            continue;
        }
        listed(&folder).iter().filter(|path| is_model(path)).for_each(|path| check_size(path));
        models += 1;
        let name = folder.file_name().unwrap().to_str().unwrap();
        let model = match Model::read(&path, &[]) {
            Ok(model) => model,
            Err(FileError::Inputs { .. }) if FETCHED.contains(&name) => continue,
            Err(error) => panic!("{error}"),
        };
        let own = folder.join("data.csv");
        let data = if name == "leverage" { root().join("examples/returns.csv") } else { own };
        if data.exists() {
            let data = Data::open(&data, &model).unwrap_or_else(|error| panic!("{error}"));
            go_through(&path, &model, &data);
        } else {
            assert!(FETCHED.contains(&name), "{name} has no data");
        }
    }
    assert!(models >= 23, "{models}");
}

#[test]
fn examples_are_checked_and_filtered() {
    let folder = root().join("examples");
    let mut models = 0;
    for path in listed(&folder).iter().filter(|path| is_model(path)) {
        check_size(path);
        let model = Model::read(path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let name = path.file_stem().unwrap().to_str().unwrap();
        // Of two models of the same data one is named after the other.
        let file = folder.join(format!("{}.csv", name.split('_').next().unwrap()));
        let data = match file.exists() {
            true => Data::open(&file, &model).unwrap_or_else(|error| panic!("{error}")),
            false => {
                let drawn = simulate(&model, 50, 1, 1, |_| ControlFlow::Continue(())).unwrap();
                Data::read(simulated_table(&model, &drawn).as_bytes(), "simulated.csv", &model).unwrap()
            }
        };
        go_through(path, &model, &data);
        models += 1;
    }
    assert!(models >= 14, "{models}");
}
