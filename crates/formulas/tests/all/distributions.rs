//! Each distribution of a file is the one of the same name in Rust.

use motes_models::equations::{
    Distribution, Dual, Lanes, Scalar, bernoulli, beta, binomial, exponential, gamma, laplace, log_normal,
    negative_binomial, normal, poisson, student_t, uniform,
};

use super::helpers::{bits, measurement, measuring, transition};

/// Formulas with the same in Rust, all of a state `x` that is positive.
fn pairs<S: Scalar>(x: S) -> Vec<(&'static str, Distribution<S>)> {
    vec![
        ("normal(x, 2)", normal(x, 2.0)),
        ("student_t(4, x, 0.5*x)", student_t(4.0, x, x * 0.5)),
        ("laplace(x, 2)", laplace(x, 2.0)),
        ("log_normal(x, 0.3)", log_normal(x, 0.3)),
        ("exponential(x)", exponential(x)),
        ("gamma(2, x)", gamma(2.0, x)),
        ("beta(2, x)", beta(2.0, x)),
        ("uniform(-x, 4*x)", uniform(-x, x * 4.0)),
        ("poisson(x)", poisson(x)),
        ("negative_binomial(x, 3)", negative_binomial(x, 3.0)),
        ("binomial(9, x/4)", binomial(9.0, x / 4.0)),
        ("bernoulli(x/4)", bernoulli(x / 4.0)),
        ("x + 3*exponential(1) - 3", exponential(1.0).scaled(3.0).shifted(x - 3.0)),
        ("x - exponential(x)", exponential(x).scaled(-1.0).shifted(x)),
        ("2*gamma(2, 1)/x", gamma(2.0, 1.0).scaled(S::from(2.0) / x)),
        ("-log_normal(0, x) + 9", log_normal(0.0, x).scaled(-1.0).shifted(9.0)),
        ("x - 3*beta(2, 0.5)", beta(2.0, 0.5).scaled(-3.0).shifted(x)),
        ("(uniform(0, 1) - 0.5)*4*x", uniform(0.0, 1.0).scaled(x * 4.0).shifted(x * -2.0)),
        ("-(x + normal(x, 2))", normal(x, 2.0).scaled(-1.0).shifted(-x)),
        ("x + 0.5*normal(0, 2)", normal(x, 1.0)),
        ("x*student_t(5, 1, 2) + 1", student_t(5.0, 1.0, 2.0).scaled(x).shifted(1.0)),
        ("(1 - laplace(x, 2))/-2", laplace(x, 2.0).scaled(0.5).shifted(-0.5)),
    ]
}

/// Catches parameters in another order, a distribution under another's name, and a shift or scale that is lost.
#[test]
fn densities_are_those_of_the_functions_in_rust() {
    for x in [0.3, 1.0, 2.7] {
        for (formula, expected) in pairs(x) {
            let found = measurement(&measuring(formula, ""), 0, &[x, 0.0])[0];
            for at in [-2.0, 0.0, 1.0, 1.5, 2.0, 3.0] {
                let [found, expected] = [found, expected].map(|distribution| distribution.log_density(at));
                let close = (found - expected).abs() <= 1e-12 * (1.0 + expected.abs());
                assert!(close || found == expected, "{formula} at {at}, x = {x}: {found} for {expected}");
            }
        }
    }
}

/// Without shift and scale it is the same distribution, to the last bit.
#[test]
fn parameters_have_the_same_bits() {
    for (formula, expected) in pairs(1.3).into_iter().take(12) {
        assert_eq!(measurement(&measuring(formula, ""), 0, &[1.3, 0.0])[0], expected, "{formula}");
    }
}

/// Catches derivatives that are lost where parameters become plain numbers.
#[test]
fn slopes_are_those_of_the_functions_in_rust() {
    type Number = Dual<f64, 2>;
    let x = Number::variable(1.3, 0);
    for (formula, expected) in pairs(x) {
        let found = measurement(&measuring(formula, ""), 0, &[x, Number::from(0.0)])[0];
        let [found, expected] = [found, expected]
            .map(|distribution| distribution.log_density(Number::from(2.0)).derivatives()[0]);
        let close = (found - expected).abs() <= 1e-12 * (1.0 + expected.abs());
        assert!(close || found.is_nan() && expected.is_nan(), "{formula}: {found} for {expected}");
    }
}

/// Side by side each lane is a number alone, for parameters that vary and such that do not.
#[test]
fn lanes_are_numbers_alone() {
    let point = |lane: usize| 0.2 + 0.1 * lane as f64;
    let lanes: Lanes = Lanes(std::array::from_fn(point));
    for (formula, _) in pairs(1.0) {
        let model = measuring(formula, "");
        let at = Lanes::from(2.0);
        let side = measurement(&model, 0, &[lanes, at])[0].log_density(at);
        for (lane, side) in side.0.iter().enumerate() {
            let alone = measurement(&model, 0, &[point(lane), 2.0])[0].log_density(2.0);
            assert_eq!(bits(&[*side]), bits(&[alone]), "{formula}, lane {lane}");
        }
    }
}

/// A definition means the states of where it is used, and the time of there.
#[test]
fn definitions_take_the_meaning_of_where_they_are_used() {
    let model = measuring("normal(twice + t, 1)", "[definitions]\ntwice = \"2*x + y\"\nfour = \"2*twice\"");
    assert_eq!(measurement(&model, 5, &[1.5, 0.25])[0], normal(8.25, 1.0));
    let text = "[initial]\nx = \"normal(c, 1)\"\n[definitions]\nd = \"x*c\"\nc = \"3\"\n[transition]\nx = \"normal(d + t, 1)\"\n\
                [measurement]\nz = \"normal(d, 2)\"\n";
    let model = super::helpers::model(text);
    assert_eq!(transition(&model, 2, &[10.0])[0], normal(32.0, 1.0));
    assert_eq!(measurement(&model, 2, &[20.0])[0], normal(60.0, 2.0));
}
