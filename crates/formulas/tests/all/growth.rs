//! The growth model of a file is the one written in Rust, to the last bit.

use motes_formulas::{FileModel, FormulaModel, parse};
use motes_models::batch::Rows;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, StateGradients, StateSpaceModel, Step, simulate};

const FILE: &str = r#"
name = "growth"

[parameters]
q = 10.0

[initial]
x = "normal(0, sqrt(5))"

[definitions]
drift = "x/2 + 25*x/(1 + x^2) + 8*cos(1.2*t)"

[transition]
x = "normal(drift, sqrt(q))"

[measurement]
y = "normal(x^2/20, 1)"
"#;

/// The same by hand.
struct Growth {
    q: f64,
}

impl Equations for Growth {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * Scalar::cos(1.2 * step.time);
        state[0] = draws.draw(normal(drift, self.q.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

fn model(overrides: &[(String, f64)]) -> FormulaModel {
    match parse(FILE, "growth.toml", overrides).unwrap().model {
        FileModel::Formulas(model) => model,
        FileModel::LinearGaussian(_) => panic!("the file has formulas"),
    }
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

/// Catches an operation in another order, a constant that is rounded otherwise, and noise that is taken otherwise.
#[test]
fn it_draws_the_same_bits() {
    for (overrides, q) in [(vec![], 10.0), (vec![("q".to_string(), 2.0)], 2.0)] {
        let [found, expected] = [
            simulate(&model(&overrides), 30, &mut Seed::from_u64(1).stream()).unwrap(),
            simulate(&Growth { q }, 30, &mut Seed::from_u64(1).stream()).unwrap(),
        ];
        assert_eq!(bits(found.states.values()), bits(expected.states.values()));
        assert_eq!(bits(found.measurements.values()), bits(expected.measurements.values()));
    }
}

/// Catches the same in batches, where 70 particles are three tiles, and in derivatives.
#[test]
fn it_weighs_the_same_bits() {
    let (found, expected) = (model(&[]), Growth { q: 10.0 });
    let previous: Vec<f64> = (0..70).map(|k| 0.4 * f64::from(k) - 13.0).collect();
    let states: Vec<f64> = previous.iter().map(|x| 9.0 - 0.7 * x).collect();
    let all = |model: &dyn Fn(&mut [f64], &mut [f64])| {
        let (mut a, mut b) = (vec![0.0; 70], vec![0.0; 70]);
        model(&mut a, &mut b);
        [bits(&a), bits(&b)]
    };
    fn densities<M: StateSpaceModel>(
        model: &M,
        previous: &[f64],
        states: &[f64],
        a: &mut [f64],
        b: &mut [f64],
    ) {
        model.density().unwrap().log_densities(&Step::of_index(3), Some(Rows::all(previous, 1)), states, a);
        model.log_likelihoods(&Step::of_index(3), states, &[Some(1.5)], b).unwrap();
    }
    fn slopes<M: StateGradients>(model: &M, previous: &[f64], states: &[f64], a: &mut [f64], b: &mut [f64]) {
        model.transition_gradients(&Step::of_index(3), previous, states, a, b);
        model.likelihood_gradients(&Step::of_index(3), states, &[1.5], b);
    }
    assert_eq!(
        all(&|a, b| densities(&found, &previous, &states, a, b)),
        all(&|a, b| densities(&expected, &previous, &states, a, b))
    );
    assert_eq!(
        all(&|a, b| slopes(&found, &previous, &states, a, b)),
        all(&|a, b| slopes(&expected, &previous, &states, a, b))
    );
}
