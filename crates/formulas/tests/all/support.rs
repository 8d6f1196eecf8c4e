//! Measurements that no state can give.

use motes_models::{StateSpaceModel, Step};

use super::helpers::measuring;

/// What is said of a value at a time, if no state can give it.
fn refused(formula: &str, time: usize, value: f64) -> Option<String> {
    let model = measuring(formula, "[parameters]\nm = 10\n");
    let found =
        model.impossible(&Step::of_index(time), &[Some(value)]).map(|impossible| impossible.to_string());
    assert_eq!(model.impossible(&Step::of_index(time), &[None]), None, "{formula}");
    // Densities say the same at some states, whichever these are.
    let states = [[0.3, 0.2], [0.7, -0.4], [2.5, 3.0], [-1.5, 0.9]];
    let log_densities =
        states.map(|state| model.log_likelihood(&Step::of_index(time), &state, &[value]).unwrap());
    if found.is_some() {
        let is_zero = |density: &f64| *density == f64::NEG_INFINITY || density.is_nan();
        assert!(log_densities.iter().all(is_zero), "{formula} at {value}: {log_densities:?}");
    }
    found
}

#[test]
fn a_value_outside_of_the_support_is_named_with_what_it_could_be() {
    let said = |formula, value| refused(formula, 0, value).unwrap();
    insta::assert_snapshot!(said("binomial(m, 1/(1+exp(x)))", 4.5), @"4.5 is no value of binomial(m, 1/(1+exp(x))): a count is a whole number from 0 to 10");
    insta::assert_snapshot!(said("binomial(10, 0.3)", 11.0), @"11 is no value of binomial(10, 0.3): a count is a whole number from 0 to 10");
    insta::assert_snapshot!(said("binomial(10, 0.3)", -1.0), @"-1 is no value of binomial(10, 0.3): a count is a whole number from 0 to 10");
    insta::assert_snapshot!(said("poisson(exp(x))", -2.0), @"-2 is no value of poisson(exp(x)): a count is a whole number, 0 or more");
    insta::assert_snapshot!(said("poisson(exp(x))", 0.9999999999), @"0.9999999999 is no value of poisson(exp(x)): a count is a whole number, 0 or more");
    insta::assert_snapshot!(said("negative_binomial(exp(x), 2)", 0.5), @"0.5 is no value of negative_binomial(exp(x), 2): a count is a whole number, 0 or more");
    insta::assert_snapshot!(said("bernoulli(1/(1 + exp(x)))", 2.0), @"2 is no value of bernoulli(1/(1 + exp(x))): it can only be 0 or 1");
    insta::assert_snapshot!(said("exponential(exp(x))", -1.0), @"-1 is no value of exponential(exp(x)): it must be at least 0");
    insta::assert_snapshot!(said("gamma(2, exp(x))", 0.0), @"0 is no value of gamma(2, exp(x)): it must be above 0");
    insta::assert_snapshot!(said("5 - 2*exponential(exp(x))", 5.5), @"5.5 is no value of 5 - 2*exponential(exp(x)): it must be at most 5");
    insta::assert_snapshot!(said("-log_normal(x, 1)", 0.5), @"0.5 is no value of -log_normal(x, 1): it must be below 0");
    insta::assert_snapshot!(said("uniform(-1, 2)", 2.5), @"2.5 is no value of uniform(-1, 2): it must lie from -1 to 2");
    insta::assert_snapshot!(said("1 - uniform(-1, exp(x))", 2.5), @"2.5 is no value of 1 - uniform(-1, exp(x)): it must be at most 2");
}

/// Catches a measurement that is refused though there is a state for it.
#[test]
fn what_some_state_can_give_is_not_refused() {
    for (formula, value) in [
        ("normal(x, 1)", -1e300),
        ("student_t(3, x, 1)", 4.5),
        ("laplace(x, 1)", -2.0),
        ("poisson(exp(x))", 0.0),
        ("poisson(exp(x))", 1e15),
        ("binomial(10, 0.3)", 10.0),
        ("binomial(floor(exp(x)), 0.3)", 1e6),
        ("exponential(exp(x))", 0.0),
        ("x + exponential(1)", -7.0),
        ("x*exponential(1)", -7.0),
        ("gamma(2, exp(x))", 1e-300),
        ("log_normal(x, 1) + y", -3.0),
        ("uniform(x, x + 1)", 900.0),
        ("uniform(-1, exp(x))", 900.0),
        ("uniform(-1, 2)", 2.0),
        ("y + uniform(-1, 2)", 9.0),
    ] {
        assert_eq!(refused(formula, 0, value), None, "{formula}, {value}");
    }
    assert!(refused("binomial(floor(exp(x)), 0.3)", 0, 1.5).is_some(), "a count whatever n is");
    assert!(refused("uniform(-1, exp(x))", 0, -1.5).is_some(), "below the end that is known");
}

#[test]
fn what_is_known_of_the_time_is_used() {
    assert_eq!(refused("binomial(m + t, 0.3)", 2, 12.0), None);
    let said = refused("binomial(m + t, 0.3)", 1, 12.0).unwrap();
    assert_eq!(said, "12 is no value of binomial(m + t, 0.3): a count is a whole number from 0 to 11");
    assert!(refused("uniform(0, 1 + t)", 0, 1.5).is_some());
    assert_eq!(refused("uniform(0, 1 + t)", 1, 1.5), None);
}

#[test]
fn the_entry_of_a_vector_is_named() {
    let text = "[initial]\nx[3] = \"normal(0, 1)\"\n[transition]\nx[3] = \"normal(x[i], 1)\"\n[measurement]\nz = \"normal(x[0], 1)\"\ny[3] = \"poisson(exp(x[i]))\"\n";
    let model = super::helpers::model(text);
    let found = model.impossible(&Step::of_index(0), &[Some(-1.5), Some(0.0), None, Some(0.5)]).unwrap();
    assert_eq!((found.coordinate, found.value), (3, 0.5));
    assert_eq!(model.supports(&Step::of_index(0))[0], None);
}
