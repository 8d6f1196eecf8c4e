//! The examples of the project are models.

use std::path::Path;

use motes_formulas::{FileModel, read};
use motes_models::{Seed, simulate};

/// Catches an example that this version cannot read, and one that runs to infinity.
#[test]
fn they_simulate() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let file = read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let stream = &mut Seed::from_u64(1).stream();
        let data = match &file.model {
            FileModel::Formulas(model) => simulate(model, 50, stream),
            FileModel::LinearGaussian(model) => simulate(&**model, 50, stream),
        };
        let data = data.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert_eq!(data.states.width(), file.states.len());
        assert_eq!(data.measurements.width(), file.measurements.len());
        names.push(file.name);
    }
    assert!(names.len() >= 14, "{names:?}");
}

/// A definition may have the name of a distribution: only what is called is one.
#[test]
fn a_parameter_may_be_called_gamma() {
    let text = "[parameters]\ngamma = 2\n[initial]\nx = \"gamma(gamma, 1)\"\n[transition]\nx = \"x + gamma*gamma(1, gamma)\"\n\
                [measurement]\ny = \"normal(x, 1)\"\n";
    super::helpers::model(text);
}
