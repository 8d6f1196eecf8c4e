//! The model files of the project: each is read, checked with its data, and filtered.

use std::fs::read_dir;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use motes::formulas::FileError;
use motes::output::simulated_table;
use motes::{Data, FilterOptions, Model, check, filter, simulate, simulate_along};

use crate::common::Workplace;

/// A page that people read at once.
const LINES: usize = 45;
const COLUMNS: usize = 100;

/// Models whose data nobody may ship; `fetch.py` gets them.
const FETCHED: [&str; 2] = ["dacca-cholera", "london-measles"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Where the models of other packages and papers are.
pub(super) fn home() -> PathBuf {
    root().join("experiments/models")
}

/// Where the data of one of them are, if they are.
pub(super) fn data_of(name: &str) -> PathBuf {
    match name {
        "leverage" => root().join("examples/returns.csv"),
        _ => home().join(name).join("data.csv"),
    }
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
    for folder in listed(&home()) {
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
        let data = data_of(name);
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

/// A model whose inputs nobody may ship, with made-up ones of the same columns, and data that it draws by them.
fn with_made_up_inputs(name: &str, file: &str, inputs: &str, times: &str) {
    let place = Workplace::new();
    let text = std::fs::read(home().join(name).join("model.toml")).unwrap();
    place.write("model.toml", text);
    place.write(file, inputs);
    place.write("times.csv", times);
    let path = place.path("model.toml");
    let model = Model::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
    let times = Data::open_inputs(&place.path("times.csv"), &model).unwrap();
    let drawn = simulate_along(&model, &times, 2, 1, |_| ControlFlow::Continue(())).unwrap();
    let data = Data::read(simulated_table(&model, &drawn).as_bytes(), "simulated.csv", &model).unwrap();
    assert!(data.rows.iter().flat_map(|row| &row.measurement).flatten().any(|count| *count > 0.0), "{name}");
    go_through(&path, &model, &data);
}

/// Measles and cholera without their data: formulas, inputs from files, sub-steps, totals.
#[test]
fn models_of_fetched_data_are_filtered_with_made_up_data() {
    let demography: String = (1944..1953)
        .map(|year| format!("{year},{},{}\n", 2_400_000 + 90_000 * (year - 1944), 50_000))
        .collect();
    let weeks: String =
        (0..30).map(|week| format!("{}\n", 1950.0 + (5.0 + 7.0 * f64::from(week)) / 365.25)).collect();
    with_made_up_inputs(
        "london-measles",
        "demography.csv",
        &format!("year,pop,births\n{demography}"),
        &format!("year\n{weeks}"),
    );
    let months: String = (1..=24).map(|month| format!("{}\n", 1891.0 + f64::from(month) / 12.0)).collect();
    with_made_up_inputs(
        "dacca-cholera",
        "population.csv",
        "year,pop,dpopdt\n1891,2420656,19623\n1893,2460000,19600\n",
        &format!("year\n{months}"),
    );
}
