//! Files of matrices are the model of these matrices.

use faer::{Col, Mat, mat};
use motes_formulas::{FileModel, FormulaModel, parse};
use motes_models::kalman::Belief;
use motes_models::{Gaussian, LinearGaussian, Seed, StateSpaceModel, Step, simulate};

use super::helpers::bits;

/// The formulas that a file of matrices stands for.
fn formulas(text: &str, set: &[(String, f64)]) -> FormulaModel {
    let FileModel::Formulas(model) = parse(text, "m.toml", set).unwrap().model else {
        panic!("they are matrices alone")
    };
    model
}

/// What its noise is, and what `y` says of `x`: means, and the covariance of a state and a measurement at a step, from the system that the Kalman filter has.
fn joint(model: &FormulaModel, inputs: &[f64], states: usize) -> (Vec<f64>, Mat<f64>) {
    let linear = model.linear_system().unwrap();
    let step = Step { inputs, ..Step::of_index(1) };
    let n = linear.state_dim();
    let still = Belief { mean: Col::zeros(n), covariance: Mat::zeros(n, n) };
    let x = linear.transition_map(&step).of_belief(&still);
    let map = linear.measurement_map(&step);
    let y = map.of_belief(&x);
    let cross = &x.covariance * map.matrix.transpose();
    let m = y.mean.nrows();
    let all = Mat::from_fn(states + m, states + m, |i, j| match (i < states, j < states) {
        (true, true) => x.covariance[(i, j)],
        (true, false) => cross[(i, j - states)],
        (false, true) => cross[(j, i - states)],
        (false, false) => y.covariance[(i - states, j - states)],
    });
    (x.mean.iter().take(states).chain(y.mean.iter()).copied().collect(), all)
}

const WHOLE: &str = r#"
kind = "linear-gaussian"
states = ["the level", "w"]
measurements = ["y[0]", "y[1]"]
m0 = [1, 2]
P0 = [[1, 0.5], [0.5, 0.25]]
A = [["phi", 0.1], [0, 0]]
b = [0.5, "-1/4"]
B = [[2], [0]]
Q = [[1, "phi"], ["phi", 1]]
C = [[1, 0], [0.5, "a[1]"]]
d = [0, 1]
D = [[0], [3]]
R = [[0.5, 0.2], [0.2, 0.4]]
S = [[0.1, -0.2], [0, 0.1]]

[parameters]
phi = 0.8
a = [1, 0.25]

[inputs]
u = "next"
"#;

/// Catches a matrix that is lost, exchanged or transposed, noise that is shared with the wrong sign or counted twice, and a parameter that is not set.
#[test]
fn they_have_intercepts_inputs_parameters_and_shared_noise() {
    for phi in [0.8, 0.3] {
        let (mean, all) = joint(&formulas(WHOLE, &[("phi".into(), phi)]), &[10.0], 2);
        let c = mat![[1.0, 0.0], [0.5, 0.25]];
        let (q, r) = (mat![[1.0, phi], [phi, 1.0]], mat![[0.5, 0.2], [0.2, 0.4]]);
        let s = mat![[0.1, -0.2], [0.0, 0.1]];
        let x = [0.5 + 20.0, -0.25];
        let expected = [x[0], x[1], x[0], 1.0 + 30.0 + 0.5 * x[0] + 0.25 * x[1]];
        let cross = &q * c.transpose() + &s;
        let y = &c * &q * c.transpose() + &c * &s + s.transpose() * c.transpose() + &r;
        for i in 0..4 {
            assert!((mean[i] - expected[i]).abs() < 1e-12, "{i}: {mean:?}");
            for j in 0..4 {
                let right = match (i < 2, j < 2) {
                    (true, true) => q[(i, j)],
                    (true, false) => cross[(i, j - 2)],
                    (false, true) => cross[(j, i - 2)],
                    (false, false) => y[(i - 2, j - 2)],
                };
                assert!((all[(i, j)] - right).abs() < 1e-8, "{i}, {j}: {} for {right}", all[(i, j)]);
            }
        }
    }
    let file = parse(WHOLE, "m.toml", &[]).unwrap();
    assert_eq!(file.states, ["the level", "w", "noise(y[0])", "noise(y[1])"]);
    assert_eq!(file.measurements, ["y[0]", "y[1]"]);
    assert_eq!(file.parameters, [("phi".into(), 0.8), ("a[0]".into(), 1.0), ("a[1]".into(), 0.25)]);
    assert_eq!(formulas(WHOLE, &[]).measured_exactly(), None);
}

/// The first state and the first measurement: `P0` need not have an inverse, and the noise of a measurement is as large there as anywhere.
#[test]
fn they_start_as_they_say() {
    let model = formulas(WHOLE, &[]);
    let linear = model.linear_system().unwrap();
    let step = Step { inputs: &[0.0], ..Step::of_index(0) };
    let start = linear.initial_belief(&step);
    let of_state = |i, j| start.covariance[(i, j)];
    assert_eq!([start.mean[0], start.mean[1]], [1.0, 2.0]);
    for (found, right) in [(of_state(0, 0), 1.0), (of_state(0, 1), 0.5), (of_state(1, 1), 0.25)] {
        assert!((found - right).abs() < 1e-12, "{found} for {right}");
    }
    let map = linear.measurement_map(&step);
    let still = Belief { mean: start.mean.clone(), covariance: noise_alone(&start.covariance) };
    let y = map.of_belief(&still).covariance;
    for (found, right) in [(y[(0, 0)], 0.5), (y[(0, 1)], 0.2), (y[(1, 1)], 0.4)] {
        assert!((found - right).abs() < 1e-8, "{found} for {right}");
    }
}

/// A covariance of which the first two coordinates have none.
fn noise_alone(covariance: &Mat<f64>) -> Mat<f64> {
    let n = covariance.nrows();
    Mat::from_fn(n, n, |i, j| if i < 2 || j < 2 { 0.0 } else { covariance[(i, j)] })
}

/// Independent noise stays with each coordinate, so that such a model has a density and a closed form; a variance of 0 is none.
#[test]
fn independent_noise_keeps_the_density() {
    let text = "kind = 'linear-gaussian'\nstates = ['x']\nmeasurements = ['y']\nA = [[0.8]]\nb = [0.5]\nQ = [[0.25]]\nC = [[1]]\nR = [[4]]\nm0 = [2.5]\nP0 = [[9]]";
    let model = formulas(text, &[]);
    assert!(model.density().is_some() && model.closed_form().is_ok());
    insta::assert_snapshot!(parse(text, "m.toml", &[]).unwrap().describe(), @r"
    p(x_0)
      x ~ normal(2.5, 3)
    p(x_t | x_{t-1})
      x ~ normal(0.8*x + 0.5, 0.5)
    p(y_t | x_t)
      y ~ normal(x, 2)
    ");
    let exact = formulas(&text.replace("R = [[4]]", "R = [[0]]"), &[]);
    assert_eq!(exact.measured_exactly(), Some(0));
}

/// Catches matrices that are exchanged or transposed, and a mean that is lost.
#[test]
fn they_draw_the_same_bits() {
    let text = r#"
        name = "spring"
        kind = "linear-gaussian"
        states = ["position", "speed"]
        measurements = ["y", "z", "w"]
        m0 = [1, -2.5]
        P0 = [[1.0, 0.5], [0.5, 2]]
        A = [[1.0, 0.1], [-0.3, 0.9]]
        Q = [[0.1, 0.02], [0.02, 0.2]]
        C = [[1, 0], [0.5, 0.25], [0, 1]]
        R = [[0.5, 0, 0.1], [0, 0.25, 0], [0.1, 0, 1]]
    "#;
    let file = parse(text, "spring.toml", &[]).unwrap();
    assert_eq!((file.name.as_str(), file.parameters.len()), ("spring", 0));
    assert_eq!(
        (file.states.join(" "), file.measurements.join(" ")),
        ("position speed".into(), "y z w".into())
    );
    let FileModel::LinearGaussian(found) = file.model else { panic!("the file has matrices") };
    let expected = LinearGaussian::new(
        Gaussian::new("P_0", vec![1.0, -2.5], mat![[1.0, 0.5], [0.5, 2.0]]).unwrap(),
        mat![[1.0, 0.1], [-0.3, 0.9]],
        mat![[0.1, 0.02], [0.02, 0.2]],
        mat![[1.0, 0.0], [0.5, 0.25], [0.0, 1.0]],
        mat![[0.5, 0.0, 0.1], [0.0, 0.25, 0.0], [0.1, 0.0, 1.0]],
    )
    .unwrap();
    let draw = |model| simulate(model, 20, &mut Seed::from_u64(3).stream()).unwrap();
    let (found, expected) = (draw(&*found), draw(&expected));
    assert_eq!(bits(found.states.values()), bits(expected.states.values()));
    assert_eq!(bits(found.measurements.values()), bits(expected.measurements.values()));
}
