//! Models that are linear with Gaussian noise, and those that are not.

use motes_formulas::{FileModel, FormulaModel, parse};
use motes_models::StateSpaceModel;

fn model(transition: &str, measurement: &str) -> FormulaModel {
    let text = format!(
        "[initial]\na = \"normal(1, 2)\"\nb = \"normal(a/2, 1)\"\n[draws]\ne = \"normal(1, 2)\"\n[transition]\na = \"{transition}\"\nb = \"b + 3*e\"\n[measurement]\ny = \"{measurement}\"\n"
    );
    match parse(&text, "text", &[]).unwrap().model {
        FileModel::Formulas(formulas) => formulas,
        FileModel::LinearGaussian(_) => panic!("no matrices"),
    }
}

#[test]
fn a_linear_model_has_the_matrices_of_its_formulas() {
    let model = model("0.5*a - b/3 + e + normal(t, 0.7)", "normal(2*a + b - 4, 1 + t)");
    let linear = model.linear_system().unwrap();
    let start = linear.initial_belief(&model.step_of_index(0));
    assert_eq!((start.mean[0], start.mean[1]), (1.0, 0.5));
    let covariance = [[0, 0], [0, 1], [1, 1]].map(|[i, j]| start.covariance[(i, j)]);
    assert_eq!(covariance, [4.0, 2.0, 2.0]);
    let step = model.step_of_index(3);
    let map = linear.transition_map(&step);
    assert!((map.matrix[(0, 1)] + 1.0 / 3.0).abs() < 1e-12 && map.matrix[(1, 1)] == 1.0);
    assert_eq!((map.offset[0], map.offset[1]), (4.0, 3.0));
    // Both share the draw e.
    let covariance = [[0, 0], [0, 1], [1, 1]].map(|[i, j]| map.covariance[(i, j)]);
    assert!(covariance.iter().zip([4.49, 12.0, 36.0]).all(|(a, b)| (a - b).abs() < 1e-12));
    let measured = linear.measurement_map(&step);
    assert_eq!((measured.matrix[(0, 0)], measured.matrix[(0, 1)]), (2.0, 1.0));
    assert_eq!((measured.offset[0], measured.covariance[(0, 0)]), (-4.0, 16.0));
}

#[test]
fn what_is_not_linear_has_none() {
    let right = "normal(2*a + b, 1)";
    for transition in
        ["normal(sin(a), 1)", "normal(a*b, 1)", "normal(a*e, 1)", "normal(a, exp(b))", "laplace(a, 1)", "a*e"]
    {
        assert!(model(transition, right).linear_system().is_none(), "{transition}");
    }
    assert!(model("normal(a, 1)", "student_t(4, a, 1)").linear_system().is_none());
    assert!(model("normal(a + 1, 1)", right).linear_system().is_some());
    assert!(model("if(t > 2, a*cos(t), b) + e", right).linear_system().is_some());
}
