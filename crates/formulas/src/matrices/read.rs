//! The keys of a file of matrices.

use faer::Mat;
use motes_models::{Gaussian, LinearGaussian};

use super::values::{count, matrix, names, vector};
use crate::document::{Table, Value};
use crate::error::{Fault, Problem, nearest};

/// What a file of matrices says.
#[derive(Debug)]
pub(crate) struct Matrices {
    pub(crate) name: Option<String>,
    pub(crate) states: Vec<String>,
    pub(crate) measurements: Vec<String>,
    pub(crate) model: LinearGaussian,
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

/// Most states or measurements: beyond, the factors of dense matrices are no work for a filter's step.
const MOST: usize = 2000;

/// Reads a file of matrices.
pub(crate) fn read(table: &Table, overrides: &[(String, f64)]) -> Result<Matrices, Fault> {
    for entry in table {
        let known = KEYS.iter().map(|(key, _)| *key).chain(["name", "kind"]);
        if known.clone().all(|key| key != entry.key) {
            let advice = match nearest(&entry.key, known) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "of kind \"linear-gaussian\" it has name, states, measurements, m0, P0, A, Q, C, R"
                    .to_string(),
            };
            let problem = Problem::UnknownKey { name: entry.key.clone(), advice };
            return Err(Fault::at(entry.key_at, problem));
        }
    }
    if let Some((name, _)) = overrides.first() {
        let advice = "a file of kind \"linear-gaussian\" has none".to_string();
        return Err(Fault::new(Problem::UnknownParameter { name: name.clone(), advice }));
    }
    let find = |key: &str| table.iter().find(|entry| entry.key == key).map(|entry| &entry.value);
    let [states, measurements, m0, p0, a, q, c, r] =
        KEYS.map(|(name, example)| find(name).ok_or_else(|| Fault::new(Problem::Missing { name, example })));
    let named = |value: Result<_, Fault>, key: &str| -> Result<Vec<String>, Fault> {
        let value: &Value = value?;
        let names = names(value).map_err(|fault| fault.of_key(key))?;
        if names.len() <= MOST {
            Ok(names)
        } else {
            Err(Fault::at(value.at, Problem::TooMany(MOST)).of_key(key))
        }
    };
    let (states, measurements) = (named(states, "states")?, named(measurements, "measurements")?);
    if let Some(both) = measurements.iter().find(|name| states.contains(name)) {
        let problem = Problem::Twice { name: both.clone(), other: "states" };
        return Err(Fault { at: find("measurements").map(|value| value.at), ..Fault::new(problem) }
            .of_key("measurements"));
    }
    let (n, m) = (states.len(), measurements.len());
    let why = format!("as there are {} and {}", count(n, "state"), count(m, "measurement"));
    let of = |value: Result<&Value, Fault>, key, shape| {
        matrix(value?, shape, &why).map_err(|fault| fault.of_key(key))
    };
    let mean = vector(m0?, n, &why).map_err(|fault| fault.of_key("m0"))?;
    let initial = covariance(find("P0"), "P0", mean, of(p0, "P0", [n, n])?)?;
    let (a, c) = (of(a, "A", [n, n])?, of(c, "C", [m, n])?);
    let q = covariance(find("Q"), "Q", vec![0.0; n], of(q, "Q", [n, n])?)?;
    let r = covariance(find("R"), "R", vec![0.0; m], of(r, "R", [m, m])?)?;
    let model = LinearGaussian::new(initial, a, q.covariance().to_owned(), c, r.covariance().to_owned())
        .map_err(|error| Fault::new(Problem::Matrix(error.to_string())))?;
    let name = find("name").map(|value| value.text("name")).transpose()?.map(str::to_string);
    Ok(Matrices { name, states, measurements, model })
}

/// A Gaussian, if its covariance is one.
fn covariance(value: Option<&Value>, key: &str, mean: Vec<f64>, matrix: Mat<f64>) -> Result<Gaussian, Fault> {
    Gaussian::new("it", mean, matrix).map_err(|error| {
        let fault = Fault::new(Problem::Matrix(error.to_string())).of_key(key);
        Fault { at: value.map(|value| value.at), ..fault }
    })
}
