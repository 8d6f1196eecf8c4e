//! The keys of a file of matrices.

use faer::Mat;
use motes_models::{CovarianceFault, Gaussian, LinearGaussian, ModelError};

use super::arrays::{Affine, Arrays};
use super::factor::Factor;
use super::formulas::{Places, statement_of};
use super::values::{Entries, count, names};
use crate::document::{Found, Table, Value};
use crate::error::{Fault, Problem, Section, nearest};
use crate::statement::{Constants, Parameters, Statement};

/// What a file of matrices says.
#[derive(Debug)]
pub(crate) struct Matrices {
    pub(crate) name: Option<String>,
    pub(crate) states: Vec<String>,
    pub(crate) measurements: Vec<String>,
    pub(crate) model: Model,
}

/// The model that matrices make.
#[derive(Debug)]
pub(crate) enum Model {
    /// One by its matrices alone, all of whose covariances are positive definite.
    Plain(LinearGaussian),
    /// One by formulas: with intercepts, inputs, parameters, or noise that has no density.
    Formulas(Box<Statement>),
}

/// The keys that it must have, each with what it is.
const KEYS: [(&str, &str); 8] = [
    ("states", "the names of the state's coordinates, as in states = [\"x\"]"),
    ("measurements", "the names of the measurements, as in measurements = [\"y\"]"),
    ("m0", "the mean of x_0, as in m0 = [0.0]"),
    ("P0", "the covariance of x_0, as in P0 = [[1.0]]"),
    ("A", "the matrix of x_t = A x_{t-1} + noise, as in A = [[0.9]]"),
    ("Q", "the covariance of the state's noise, as in Q = [[1.0]]"),
    ("C", "the matrix of y_t = C x_t + noise, as in C = [[1.0]]"),
    ("R", "the covariance of the measurement's noise, as in R = [[1.0]]"),
];

/// Those that it may have.
const MORE: [&str; 5] = ["b", "B", "d", "D", "S"];
const SECTIONS: [Section; 3] = [Section::Parameters, Section::Inputs, Section::Series];

/// Most states or measurements: beyond, the factors of dense matrices are no work for a filter's step.
const MOST: usize = 2000;

/// Reads the file of matrices `table` of a `text`.
pub(crate) fn read(text: &str, table: &Table, overrides: &[(String, f64)]) -> Result<Matrices, Fault> {
    check_keys(table)?;
    let find = |key: &str| table.iter().find(|entry| entry.key == key).map(|entry| &entry.value);
    let section = |section: Section| match find(section.name()).map(|value| (&value.found, value)) {
        Some((Found::Table(table), _)) => Ok(table.clone()),
        Some((_, value)) => {
            let expected = format!("a section: a line {}, and lines below it", section.title());
            Err(Fault::at(value.at, Problem::Value { found: value.words(), expected }).of_key(section.name()))
        }
        None => Ok(Table::new()),
    };
    let (inputs, parameters) = (section(Section::Inputs)?, section(Section::Parameters)?);
    if let (Some((name, _)), true) = (overrides.first(), parameters.is_empty()) {
        let advice = "a file of kind \"linear-gaussian\" has none".to_string();
        return Err(Fault::new(Problem::UnknownParameter { name: name.clone(), advice }));
    }
    let parameters = Parameters::read(&parameters, overrides)?;
    let meanings = parameters.meanings();
    let constants = Constants { names: &meanings, lists: &parameters.lists };
    let inputs = inputs.iter().map(|entry| entry.key.clone()).collect();
    let arrays = arrays(&find, inputs, constants)?;
    let name = find("name").map(|value| value.text("name")).transpose()?.map(str::to_string);
    let is_plain = table.iter().all(|entry| {
        !MORE.contains(&entry.key.as_str()) && SECTIONS.iter().all(|section| section.name() != entry.key)
    });
    let (states, measurements) = (arrays.states.clone(), arrays.measurements.clone());
    let covariances = [("P0", &arrays.initial), ("Q", &arrays.state_noise), ("R", &arrays.measurement_noise)];
    let mut definite = true;
    for (key, matrix) in covariances {
        definite &= is_definite(find(key), key, matrix)?;
    }
    if is_plain && definite {
        let model = plain(arrays)?;
        return Ok(Matrices { name, states, measurements, model: Model::Plain(model) });
    }
    let at = |key: &str| find(key).map_or(0, |value| value.at);
    let places = Places { mean: at("m0"), transition: at("A"), measurement: at("C"), shared_noise: at("S") };
    let made = statement_of(text, table, overrides, &arrays, &places)?;
    let states = made.states();
    Ok(Matrices { name, states, measurements, model: Model::Formulas(Box::new(made)) })
}

/// Refuses keys that there are not.
fn check_keys(table: &Table) -> Result<(), Fault> {
    for entry in table {
        let sections = SECTIONS.iter().map(|section| section.name());
        let known = KEYS.iter().map(|(key, _)| *key).chain(MORE).chain(sections).chain(["name", "kind"]);
        if known.clone().any(|key| key == entry.key) {
            continue;
        }
        let advice = match nearest(&entry.key, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => {
                let keys: Vec<&str> = KEYS.iter().map(|(key, _)| *key).chain(MORE).collect();
                let sections: Vec<&str> = SECTIONS.iter().map(|section| section.title()).collect();
                format!(
                    "of kind \"linear-gaussian\" it has name, {}, {}",
                    keys.join(", "),
                    sections.join(", ")
                )
            }
        };
        return Err(Fault::at(entry.key_at, Problem::UnknownKey { name: entry.key.clone(), advice }));
    }
    Ok(())
}

/// The matrices, whose shapes fit.
fn arrays<'t>(
    find: &dyn Fn(&str) -> Option<&'t Value>,
    inputs: Vec<String>,
    constants: Constants<'_>,
) -> Result<Arrays, Fault> {
    let needed = |name: &'static str| {
        let example = KEYS.iter().find(|(key, _)| *key == name).map_or("", |(_, example)| example);
        find(name).ok_or_else(|| Fault::new(Problem::Missing { name, example }))
    };
    KEYS.iter().try_for_each(|(key, _)| needed(key).map(drop))?;
    let named = |key: &'static str| -> Result<Vec<String>, Fault> {
        let value = needed(key)?;
        let names = names(value).map_err(|fault| fault.of_key(key))?;
        if names.len() <= MOST {
            Ok(names)
        } else {
            Err(Fault::at(value.at, Problem::TooMany(MOST)).of_key(key))
        }
    };
    let (states, measurements) = (named("states")?, named("measurements")?);
    if let Some(both) = measurements.iter().find(|name| states.contains(name)) {
        let problem = Problem::Twice { name: both.clone(), other: "states" };
        return Err(Fault { at: find("measurements").map(|value| value.at), ..Fault::new(problem) }
            .of_key("measurements"));
    }
    for key in ["B", "D"] {
        if let (Some(value), true) = (find(key), inputs.is_empty()) {
            let example = "it names what B and D multiply, column by column, as in u = \"hold\"";
            return Err(Fault::at(value.at, Problem::Missing { name: "[inputs]", example }).of_key(key));
        }
    }
    if !inputs.is_empty() && find("B").is_none() && find("D").is_none() {
        let (name, example) = ("B or D", "what an input adds to states or measurements, as in D = [[1.0]]");
        return Err(Fault::new(Problem::Missing { name, example }));
    }
    let (n, m, k) = (states.len(), measurements.len(), inputs.len());
    let more = if k > 0 { format!(", and {}", count(k, "input")) } else { String::new() };
    let why = format!("as there are {} and {}{more}", count(n, "state"), count(m, "measurement"));
    let entries = Entries { why: &why, constants };
    let matrix = |key: &'static str, shape| match find(key) {
        None => Ok(Mat::zeros(shape, k)),
        Some(value) => entries.matrix(value, [shape, k]).map_err(|fault| fault.of_key(key)),
    };
    let square = |key: &'static str, [rows, columns]: [usize; 2]| {
        entries.matrix(needed(key)?, [rows, columns]).map_err(|fault| fault.of_key(key))
    };
    let vector = |key: &'static str, length: usize| match find(key) {
        None => Ok(vec![0.0; length]),
        Some(value) => entries.vector(value, length).map_err(|fault| fault.of_key(key)),
    };
    let shared = |value| entries.matrix(value, [n, m]).map_err(|fault| fault.of_key("S"));
    Ok(Arrays {
        mean: vector("m0", n)?,
        initial: square("P0", [n, n])?,
        transition: Affine {
            of_states: square("A", [n, n])?,
            offset: vector("b", n)?,
            of_inputs: matrix("B", n)?,
        },
        measurement: Affine {
            of_states: square("C", [m, n])?,
            offset: vector("d", m)?,
            of_inputs: matrix("D", m)?,
        },
        state_noise: square("Q", [n, n])?,
        measurement_noise: square("R", [m, m])?,
        shared_noise: find("S").map(shared).transpose()?,
        states,
        measurements,
        inputs,
    })
}

/// Whether a covariance has an inverse; it must at least be one.
fn is_definite(value: Option<&Value>, key: &str, matrix: &Mat<f64>) -> Result<bool, Fault> {
    let reason = match Gaussian::new("it", vec![0.0; matrix.nrows()], matrix.clone()) {
        Ok(_) => return Ok(true),
        Err(ModelError::Covariance {
            fault: CovarianceFault::NotPositiveDefinite { smallest_eigenvalue: least },
            ..
        }) => match Factor::of(matrix.as_ref()) {
            Some(_) => return Ok(false),
            None => {
                format!("it has the smallest eigenvalue {least:.2e}; it must be positive semi-definite")
            }
        },
        Err(error) => error.to_string(),
    };
    let fault = Fault::new(Problem::Matrix(reason)).of_key(key);
    Err(Fault { at: value.map(|value| value.at), ..fault })
}

/// The model of matrices alone.
fn plain(arrays: Arrays) -> Result<LinearGaussian, Fault> {
    let Arrays { mean, initial, transition, measurement, state_noise, measurement_noise, .. } = arrays;
    Gaussian::new("P0", mean, initial)
        .and_then(|initial| {
            let (a, c) = (transition.of_states, measurement.of_states);
            LinearGaussian::new(initial, a, state_noise, c, measurement_noise)
        })
        .map_err(|error| Fault::new(Problem::Matrix(error.to_string())))
}
