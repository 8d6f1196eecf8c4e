//! What several tests use: models of texts, and what they state at a point.

use motes_formulas::{FileModel, FormulaModel, parse};
use motes_models::Step;
use motes_models::equations::{Coordinates, Distribution, Draws, Equations, Scalar};

/// The model of a text.
pub fn model(text: &str) -> FormulaModel {
    match parse(text, "m.toml", &[]).unwrap_or_else(|error| panic!("{error}\n{text}")).model {
        FileModel::Formulas(model) => model,
        FileModel::LinearGaussian(_) => panic!("the file has matrices"),
    }
}

/// A model of two states, `x` and `y`, with a measurement `z` that is distributed so; more sections may follow.
pub fn measuring(formula: &str, more: &str) -> FormulaModel {
    model(&format!(
        "[initial]\nx = \"normal(0, 1)\"\ny = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\ny = \"normal(y, 1)\"\n\
         [measurement]\nz = \"{formula}\"\n{more}"
    ))
}

/// Keeps the distributions that are stated.
pub struct Kept<S>(pub Vec<Distribution<S>>);

impl<S: Scalar> Draws<S> for Kept<S> {
    fn draw(&mut self, distribution: Distribution<S>) -> S {
        self.0.push(distribution);
        distribution.moments()[0]
    }
}

impl<S> Coordinates<S> for Kept<S> {
    fn push(&mut self, distribution: Distribution<S>) {
        self.0.push(distribution);
    }
}

/// `p(y_t | x_t)`.
pub fn measurement<S: Scalar>(model: &FormulaModel, time: usize, state: &[S]) -> Vec<Distribution<S>> {
    let mut kept = Kept(Vec::new());
    Step::of_index(time).lift(|step| model.equations().measurement(step, state, &mut kept));
    kept.0
}

/// `p(x_t | x_{t−1})`.
pub fn transition<S: Scalar>(model: &FormulaModel, time: usize, previous: &[S]) -> Vec<Distribution<S>> {
    let mut kept = Kept(Vec::new());
    let mut state = previous.to_vec();
    let equations = model.equations();
    Step::of_index(time).lift(|step| equations.transition(step, previous, &mut kept, &mut state));
    kept.0
}

/// The value of a formula of `x`, `y` and `t`.
pub fn value(formula: &str, time: usize, state: [f64; 2]) -> f64 {
    measurement(&measuring(&format!("normal({formula}, 1)"), ""), time, &state)[0].moments()[0]
}

/// The bits of numbers, which tell −0 from 0 and compare NaN.
pub fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// How many inputs a property is held against: so many, or those that PROPTEST_CASES asks for.
pub fn cases(usual: u32) -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|asked| asked.parse().ok()).unwrap_or(usual)
}
