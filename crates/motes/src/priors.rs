//! Parameters that have a prior: their starts, until they are fitted, and draws of them.

use motes_formulas::{Origin, Prior};
use motes_models::Seed;

use crate::model::Model;
use crate::warning::Warning;

/// Values are shown with so many digits behind the first.
const DIGITS: usize = 5;

/// The priors of parameters that were given no value from outside, in the order of the file.
pub(crate) fn free(model: &Model) -> impl Iterator<Item = &Prior> {
    model.priors().iter().filter(|prior| prior.origin() != Origin::Set)
}

/// What is to be said of parameters that have a prior and no value of their own: that they begin with its centre.
pub fn of_starts(model: &Model) -> Option<Warning> {
    let starts: Vec<&Prior> = free(model).collect();
    let value = |prior: &Prior| {
        prior.start().iter().map(|value| rounded(*value).to_string()).collect::<Vec<_>>().join(", ")
    };
    let origin = |prior: &Prior| match prior.origin() {
        Origin::Median => " (its median)",
        Origin::Mean => " (its mean)",
        Origin::Given | Origin::Set => "",
    };
    let text = match starts.as_slice() {
        [] => return None,
        [one] => {
            let (name, value, origin) = (one.name(), value(one), origin(one));
            let entry = &one.entries()[0];
            let is = if one.start().len() == 1 { "is" } else { "are" };
            format!(
                "{name} has a prior; its start {value} {is} used{origin}; give another by --set {entry}=…"
            )
        }
        several => {
            let names: Vec<&str> = several.iter().map(|prior| prior.name()).collect();
            let values =
                several.iter().map(|prior| format!("{} = {}{}", prior.name(), value(prior), origin(prior)));
            let values: Vec<String> = values.collect();
            let (last, entry) = (names.len() - 1, &several[0].entries()[0]);
            format!(
                "{} and {} have priors; their starts are used: {}; give others by --set {entry}=…",
                names[..last].join(", "),
                names[last],
                values.join("; ")
            )
        }
    };
    Some(Warning { series: None, text })
}

/// A number with a few digits, as people write it.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS).parse().unwrap_or(value)
}

/// The value of a parameter that is nearest to a mean of its draws: between two counts there is none.
pub(crate) fn nearest_value(model: &Model, name: &String, mean: f64) -> f64 {
    let is_count = |prior: &Prior| prior.is_discrete() && prior.entries().contains(name);
    if model.priors().iter().any(is_count) { mean.round() } else { mean }
}

/// How far from its middle a prior has all but 0.3 % of its mass, in standard deviations of its noise.
const FAR: f64 = 3.0;

/// The first of these parameters whose value its prior hardly ever has, in words; none where there is none.
pub(crate) fn outside(model: &Model, names: &[&str]) -> Option<String> {
    let of_names = model.priors().iter().filter(|prior| names.contains(&prior.name()));
    of_names.filter(|prior| prior.entries().len() == 1).find_map(|prior| {
        let entry = &prior.entries()[0];
        let (_, value) = model.parameters().iter().find(|(name, _)| name == entry)?;
        let [low, high] = [-FAR, FAR].map(|noise| prior.at(&[noise])[0]);
        let is_outside = *value < low || *value > high;
        let [low, high] = [low, high].map(rounded);
        is_outside.then(|| {
            format!(
                "{entry} = {} lies outside of {low} to {high}, where 99.7 % of its mass lies",
                rounded(*value)
            )
        })
    })
}

/// The model at a draw from its priors; none where it is no model there.
pub fn at_prior_draw(model: &Model, number: u64) -> Option<Model> {
    model.with_parameters(&drawn(model, &Seed::from_u64(number).child("prior draw"))).ok()
}

/// Values of the parameters that have a prior and were not set from outside, drawn from their priors.
pub(crate) fn drawn(model: &Model, seed: &Seed) -> Vec<(String, f64)> {
    let mut stream = seed.stream();
    let values = free(model).flat_map(|prior| prior.entries().iter().cloned().zip(prior.sample(&mut stream)));
    values.collect()
}
