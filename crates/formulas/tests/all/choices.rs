//! Functions, comparisons and choices against the standard library, draws and lists against what they mean.

use motes_models::batch::LANES;
use motes_models::equations::{Dual, Lanes};
use motes_models::{StateGradients, Step};

use super::helpers::{measurement, measuring, model, transition, value};

/// At `x = 1.7`, `y = −0.4`, `t = 5`.
fn at(formula: &str) -> f64 {
    value(formula, 5, [1.7, -0.4])
}

#[test]
fn functions_are_those_of_the_standard_library() {
    for (formula, expected) in [
        ("ceil(x)", 2.0),
        ("ceil(y)", -0.0),
        ("round(x)", 2.0),
        ("round(2.5)", 3.0),
        ("round(-2.5)", -2.0),
        ("round(0.49999999999999994)", 0.0),
        ("round(4503599627370496)", 4_503_599_627_370_496.0),
        ("1/log1p(-1)", -0.0),
        ("1/log1p(1e300*1e300)", 0.0),
        ("mod(t, 3)", 2.0),
        ("mod(y, 1)", 0.6),
        ("sign(y) + 2*sign(x) + 4*sign(0)", 1.0),
        ("log1p(1e-10)", 1e-10_f64.ln_1p()),
        ("log1p(x)", 1.7_f64.ln_1p()),
        ("expm1(1e-10)", 1e-10_f64.exp_m1()),
        ("expm1(x)", 1.7_f64.exp_m1()),
        ("logit(0.3)", (0.3_f64 / 0.7).ln()),
        ("logistic(x)", 1.0 / (1.0 + (-1.7_f64).exp())),
        ("logistic(-1000)", 0.0),
        ("lgamma(5)", 24.0_f64.ln()),
        ("erf(0.5)", 0.520_499_877_813_046_5),
        ("normal_cdf(-2)", 0.022_750_131_948_179_2),
        ("log(normal_cdf(-30))", -454.321_243_956_343_2),
        ("min(x, y, t, -2)", -2.0),
        ("max(x, y, t, -2)", 5.0),
    ] {
        let found = at(formula);
        assert!((found - expected).abs() <= 4e-16 * (1.0 + expected.abs()), "{formula}: {found}, {expected}");
    }
    for formula in ["log1p(1e-10)", "expm1(1e-10)"] {
        assert!((at(formula) / 1e-10 - 1.0).abs() < 1e-9);
        assert!(at(formula) != 1e-10, "the second term is there: {formula}");
    }
}

#[test]
fn conditions_choose() {
    for (formula, expected) in [
        ("if(x > 0, 1, 2)", 1.0),
        ("if(y > 0, 1, 2)", 2.0),
        ("if(x >= 1.7 and x <= 1.7, 1, 2)", 1.0),
        ("if(x == 1.7, 1, 2) + if(x != 1.7, 10, 20)", 21.0),
        ("if(not x < 0, 1, 2)", 1.0),
        ("if(y > 0 or t > 4 and x > 1, 1, 2)", 1.0),
        ("(y > 0 or t > 4) and x > 3", 0.0),
        ("x + y > 1 and x - y > 2", 1.0),
        ("if(t - 5, 1, 2)", 2.0),
        ("if(-3, 1, 2)", 1.0),
        // What is not chosen may be no number.
        ("if(y > 0, log(y), 7)", 7.0),
        ("if(x > 0, x^2, sqrt(y))", 1.7 * 1.7),
    ] {
        assert_eq!(at(formula), expected, "{formula}");
    }
    assert!(at("if(log(y) > 0, 1, 2)").is_nan(), "a condition that is no number chooses nothing");
}

/// Each particle by its own condition, and derivatives of what is chosen.
#[test]
fn particles_choose_for_themselves() {
    let choosing = measuring("normal(if(x > y, x^2, 3*y), 1)", "");
    let x: Lanes<LANES> = Lanes(std::array::from_fn(|lane| lane as f64 - 16.0));
    let found = measurement(&choosing, 0, &[x, Lanes::from(2.0)])[0].moments()[0];
    for (lane, found) in found.0.iter().enumerate() {
        let x = lane as f64 - 16.0;
        assert_eq!(*found, if x > 2.0 { x * x } else { 6.0 });
    }
    for (x, slopes) in [(4.0, [8.0, 0.0]), (1.0, [0.0, 3.0])] {
        let point = [Dual::<f64, 3>::variable(x, 0), Dual::variable(2.0, 1)];
        let found = measurement(&choosing, 0, &point)[0].moments()[0];
        assert_eq!(found.derivatives(), &slopes);
    }
}

const LISTS: &str = r#"
[parameters]
a = [1.5, 2.5, 3.5]
g = [[1, 2, 3], [4, 5, 6]]
[initial]
x = 1
k = 2
[transition]
x = "normal(a[mod(t, 3)] + g[1, k]*g[0, 0], a[k])"
k = "k"
[measurement]
y[3] = "normal(a[i]*x, 1)"
"#;

#[test]
fn lists_have_entries_by_numbers_times_and_states() {
    let lists = model(LISTS);
    for (t, k) in [(4, 0), (5, 2), (3, 1)] {
        let [mean, variance] = transition(&lists, t, &[1.0, k as f64])[0].moments();
        assert_eq!(mean, [1.5, 2.5, 3.5][t % 3] + [4.0, 5.0, 6.0][k]);
        assert_eq!(variance, [1.5_f64, 2.5, 3.5][k].powi(2));
    }
    assert!(transition(&lists, 1, &[1.0, 0.5])[0].moments()[0].is_nan(), "there is no entry 0.5");
    let text = lists.explain(&Step::of_index(1), Some(&[1.0, 0.5]), None).unwrap().to_string();
    assert!(text.ends_with("an index of g[1, k], `k`, is 0.5; it must be an integer from 0 to 2"), "{text}");
    let means: Vec<f64> = measurement(&lists, 0, &[2.0, 0.0]).iter().map(|y| y.moments()[0]).collect();
    assert_eq!(means, [3.0, 5.0, 7.0]);
}

#[test]
fn an_entry_can_be_set_from_outside() {
    let set = [("a[1]".to_string(), 7.0), ("g[1, 2]".to_string(), 9.0)];
    let file = motes_formulas::parse(LISTS, "m.toml", &set).unwrap();
    assert!(
        file.parameters.contains(&("a[1]".into(), 7.0)) && file.parameters.contains(&("g[1,2]".into(), 9.0))
    );
    let motes_formulas::FileModel::Formulas(lists) = file.model else { panic!("formulas") };
    assert_eq!(transition(&lists, 4, &[1.0, 2.0])[0].moments()[0], 7.0 + 9.0);
}

/// At 0 the logistic function is steepest; an absolute value in it would have no derivative there.
#[test]
fn the_logistic_function_has_its_derivative_at_zero() {
    let model = measuring("normal(logistic(x), 1)", "");
    let mut gradient = [0.0; 2];
    model.likelihood_gradients(&Step::of_index(1), &[0.0, 0.3], &[2.5], &mut gradient);
    assert_eq!(gradient, [(2.5 - 0.5) * 0.25, 0.0]);
}
