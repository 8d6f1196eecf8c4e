//! Matrices as the formulas that they stand for.

use std::collections::BTreeSet;

use faer::{Mat, MatRef, Side};

use super::arrays::{Affine, Arrays};
use super::factor::Factor;
use super::noise::{Noise, StateNoise, joint};
use crate::document::{Entry, Found, Table, Value};
use crate::error::{Fault, Problem, Section};
use crate::names::{begins_name, is_in_name};
use crate::statement::{self, Line, Statement};
use crate::tables::reserved;

/// Where the keys of a file stand that formulas are made of.
pub(super) struct Places {
    pub(super) mean: usize,
    pub(super) transition: usize,
    pub(super) measurement: usize,
    pub(super) shared_noise: usize,
}

/// The formulas of the matrices of a file, with its own sections of parameters, inputs and series.
pub(super) fn statement_of(
    text: &str,
    table: &Table,
    overrides: &[(String, f64)],
    arrays: &Arrays,
    places: &Places,
) -> Result<Statement, Fault> {
    let noise = Noise::of(arrays).ok_or_else(|| not_together(arrays, places))?;
    let names = Names::of(table, arrays, &noise);
    let sections = [
        (Section::Initial, initial(arrays, &noise, &names), places.mean),
        (Section::Draws, draws(&noise, &names), places.transition),
        (Section::Transition, transition(arrays, &noise, &names), places.transition),
        (Section::Measurement, measurement(arrays, &noise, &names), places.measurement),
    ];
    let own = [Section::Parameters, Section::Inputs, Section::Series].map(Section::name);
    let mut all: Table = table
        .iter()
        .filter(|entry| own.contains(&entry.key.as_str()) || entry.key == "name")
        .cloned()
        .collect();
    for (section, lines, at) in sections {
        let entry = |(key, text): (String, String)| Entry {
            key,
            key_at: at,
            value: Value { at, found: Found::Text { text, inner: None } },
        };
        let found = Found::Table(lines.into_iter().map(entry).collect());
        all.push(Entry { key: section.name().to_string(), key_at: at, value: Value { at, found } });
    }
    let statement = statement::read(text, &all, overrides, &[])?;
    Ok(Statement {
        initial: renamed(statement.initial, &names.shown_states()),
        transition: renamed(statement.transition, &names.shown_states()),
        measurement: renamed(statement.measurement, &names.shown_measurements),
        may_be_exact: true,
        ..statement
    })
}

/// The fault of noises that no random numbers have.
fn not_together(arrays: &Arrays, places: &Places) -> Fault {
    let all = arrays
        .shared_noise
        .as_ref()
        .map(|s| joint(&arrays.state_noise, s, &arrays.measurement_noise))
        .and_then(|all| all.self_adjoint_eigenvalues(Side::Lower).ok());
    let least = all.and_then(|all| all.first().copied()).unwrap_or(f64::NAN);
    let reason = format!(
        "with Q and R it makes the covariance [[Q, S], [Sᵀ, R]], which has the smallest eigenvalue {least:.2e}; it must be positive semi-definite"
    );
    Fault::at(places.shared_noise, Problem::Matrix(reason)).of_key("S")
}

/// Lines with the names of a file, which need not be names of formulas.
fn renamed(lines: Vec<Line>, names: &[String]) -> Vec<Line> {
    let named = lines.into_iter().zip(names);
    named.map(|(line, name)| Line { name: name.clone(), key: name.clone(), ..line }).collect()
}

/// What formulas call things.
struct Names {
    states: Vec<String>,
    inputs: Vec<String>,
    measurements: Vec<String>,
    /// For each measurement the state that has the noise that is drawn for it, if there is one.
    noise: Vec<Option<String>>,
    draw: String,
    /// What the file calls states and measurements.
    known_states: Vec<String>,
    shown_measurements: Vec<String>,
}

impl Names {
    fn of(table: &Table, arrays: &Arrays, noise: &Noise) -> Self {
        let parameters = table.iter().filter(|entry| entry.key == Section::Parameters.name());
        let parameters = parameters.flat_map(|entry| match &entry.value.found {
            Found::Table(table) => table.iter().map(|entry| entry.key.clone()).collect(),
            _ => Vec::new(),
        });
        let mut taken: BTreeSet<String> = parameters.chain(arrays.inputs.iter().cloned()).collect();
        let states = arrays.states.iter().map(|name| free(name, &mut taken)).collect();
        let measurements: Vec<String> =
            arrays.measurements.iter().map(|name| free(name, &mut taken)).collect();
        let of_noise = |(at, name): (usize, &String)| {
            noise.is_shared(at).then(|| free(&format!("noise_{name}"), &mut taken))
        };
        Names {
            states,
            noise: measurements.iter().enumerate().map(of_noise).collect(),
            measurements,
            inputs: arrays.inputs.clone(),
            draw: free("e", &mut taken),
            known_states: arrays.states.clone(),
            shown_measurements: arrays.measurements.clone(),
        }
    }

    /// What the file calls the coordinates of a state, behind which there is noise of measurements.
    fn shown_states(&self) -> Vec<String> {
        let noise = self.noise.iter().zip(&self.shown_measurements);
        let noise = noise.filter_map(|(own, name)| own.as_ref().map(|_| format!("noise({name})")));
        self.known_states.iter().cloned().chain(noise).collect()
    }

    fn draws(&self, count: usize) -> Vec<String> {
        (0..count).map(|at| format!("{}[{at}]", self.draw)).collect()
    }
}

/// A name for formulas that is as near to a name of the file as can be, and that nothing else has.
fn free(name: &str, taken: &mut BTreeSet<String>) -> String {
    let mut free: String = name.chars().map(|c| if is_in_name(c) { c } else { '_' }).collect();
    if !free.starts_with(begins_name) {
        free.insert(0, '_');
    }
    while taken.contains(&free) || reserved(&free).is_some() || free == "series" {
        free.push('_');
    }
    taken.insert(free.clone());
    free
}

/// `[initial]`: each coordinate given those before it; then the noise of the first measurement.
fn initial(arrays: &Arrays, noise: &Noise, names: &Names) -> Vec<(String, String)> {
    let mut lines = given_before(&arrays.mean, arrays.initial.as_ref(), &names.states);
    let shared = names.noise.iter().enumerate().filter(|(_, name)| name.is_some());
    let (rows, states): (Vec<usize>, Vec<String>) =
        shared.filter_map(|(row, name)| Some((row, name.clone()?))).unzip();
    let loads = Mat::from_fn(rows.len(), noise.draws(), |i, j| noise.shared[(rows[i], j)]);
    let covariance = &loads * loads.transpose();
    lines.extend(given_before(&vec![0.0; rows.len()], covariance.as_ref(), &states));
    lines
}

/// A line for each of some normal numbers, with these means and this covariance, given those before it.
fn given_before(mean: &[f64], covariance: MatRef<'_, f64>, names: &[String]) -> Vec<(String, String)> {
    // What is no covariance has been refused.
    let Some(factor) = Factor::of(covariance) else { return Vec::new() };
    let regression = factor.regression();
    let line = |i: usize| {
        let slopes = (0..i).map(|j| (regression[(i, j)], names[j].as_str()));
        let offset = (0..i).fold(mean[i], |offset, j| offset - regression[(i, j)] * mean[j]);
        (names[i].clone(), drawn(&sum(offset, slopes), factor.pivots[i].sqrt()))
    };
    (0..mean.len()).map(line).collect()
}

/// `[draws]`: standard normal numbers.
fn draws(noise: &Noise, names: &Names) -> Vec<(String, String)> {
    match noise.draws() {
        0 => Vec::new(),
        count => vec![(format!("{}[{count}]", names.draw), "normal(0, 1)".to_string())],
    }
}

/// `[transition]`: the states, then the noise of measurements.
fn transition(arrays: &Arrays, noise: &Noise, names: &Names) -> Vec<(String, String)> {
    let draws = names.draws(noise.draws());
    let of_draws = |loads: &Mat<f64>, row: usize| -> Vec<(f64, String)> {
        draws.iter().enumerate().map(|(j, draw)| (loads[(row, j)], draw.clone())).collect()
    };
    let state = |i: usize| {
        let map = affine(&arrays.transition, i, names);
        let formula = match &noise.states {
            StateNoise::Own(sds) => drawn(&sum(map.0, terms(&map.1)), sds[i]),
            StateNoise::Of(loads) => {
                let all = [map.1, of_draws(loads, i)].concat();
                sum(map.0, terms(&all))
            }
        };
        (names.states[i].clone(), formula)
    };
    let own = names.noise.iter().enumerate().filter_map(|(row, name)| {
        let all = of_draws(&noise.shared, row);
        Some((name.clone()?, sum(0.0, terms(&all))))
    });
    (0..names.states.len()).map(state).chain(own).collect()
}

/// `[measurement]`: what is measured of the states, with the noise that is drawn and that which is not.
fn measurement(arrays: &Arrays, noise: &Noise, names: &Names) -> Vec<(String, String)> {
    let line = |j: usize| {
        let (offset, mut all) = affine(&arrays.measurement, j, names);
        all.extend(names.noise[j].iter().map(|name| (1.0, name.clone())));
        (
            names.measurements[j].clone(),
            format!("normal({}, {})", sum(offset, terms(&all)), number(noise.own[j])),
        )
    };
    (0..names.measurements.len()).map(line).collect()
}

/// A row of a map: its offset, and what states and inputs are multiplied by.
fn affine(map: &Affine, row: usize, names: &Names) -> (f64, Vec<(f64, String)>) {
    let of_states = names.states.iter().enumerate().map(|(j, name)| (map.of_states[(row, j)], name.clone()));
    let of_inputs = names.inputs.iter().enumerate().map(|(j, name)| (map.of_inputs[(row, j)], name.clone()));
    (map.offset[row], of_states.chain(of_inputs).collect())
}

fn terms(all: &[(f64, String)]) -> impl Iterator<Item = (f64, &str)> {
    all.iter().map(|(factor, name)| (*factor, name.as_str()))
}

/// A normal number around a mean; the mean itself where it has no spread.
fn drawn(mean: &str, sd: f64) -> String {
    if sd > 0.0 { format!("normal({mean}, {})", number(sd)) } else { mean.to_string() }
}

/// A sum of products of numbers and names, which digits are read back to the last bit.
fn sum<'a>(offset: f64, terms: impl Iterator<Item = (f64, &'a str)>) -> String {
    let mut text = String::new();
    let mut add = |value: f64, what: String| {
        let sign = match (text.is_empty(), value < 0.0) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        };
        text += sign;
        text += &what;
    };
    for (factor, name) in terms.filter(|(factor, _)| *factor != 0.0) {
        let size = factor.abs();
        add(factor, if size == 1.0 { name.to_string() } else { format!("{}*{name}", number(size)) });
    }
    if offset != 0.0 {
        add(offset, number(offset.abs()));
    }
    if text.is_empty() { "0".to_string() } else { text }
}

/// A number as formulas have it.
fn number(value: f64) -> String {
    let text = format!("{value:?}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_string)
}
