//! What names may be: catches a name with two meanings, one without any, and advice that leads nowhere.

use super::{FILE, MEASURE, MOVE, START, changed, definitions, initial, refused, transition};

#[test]
fn a_name_that_is_not_known() {
    insta::assert_snapshot!(refused(&transition("normal(drfit, 1)")), @"m.toml, line 7, column 13, [transition] x: `drfit` is not known here; known are q, x, t, pi");
}

#[test]
fn a_name_with_a_near_one() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("[transition]", r#"[definitions]
drift = "x/2"
[transition]"#), (MOVE, r#"x = "normal(drfit, 1)""#)])), @"m.toml, line 9, column 13, [transition] x: `drfit` is not known here; did you mean `drift`?");
}

#[test]
fn a_name_of_elsewhere() {
    insta::assert_snapshot!(refused(&transition("normal(ln(x), 1)")), @"m.toml, line 7, column 13, [transition] x: `ln` is not known here; did you mean `log`?");
}

#[test]
fn a_function_that_there_is_not() {
    insta::assert_snapshot!(refused(&transition("normal(softplus(x), 1)")), @"m.toml, line 7, column 13, [transition] x: `softplus` is not known here; functions are sqrt, exp, log, abs, sin, cos, tan, tanh, atan, atan2, min, max, floor, ceil, round, mod, sign, log1p, expm1, logit, logistic, lgamma, erf, normal_cdf, if, sum; distributions are normal, student_t, laplace, log_normal, exponential, gamma, beta, uniform, poisson, negative_binomial, binomial, bernoulli, categorical");
}

#[test]
fn a_power_as_a_function() {
    insta::assert_snapshot!(refused(&transition("normal(pow(x, 2), 1)")), @"m.toml, line 7, column 13, [transition] x: `pow` is not known here; a power is written x^2");
}

#[test]
fn a_logarithm_of_another_base() {
    insta::assert_snapshot!(refused(&transition("normal(log10(x), 1)")), @"m.toml, line 7, column 13, [transition] x: `log10` is not known here; it is log(x)/log(10)");
}

#[test]
fn a_function_that_is_not_called() {
    insta::assert_snapshot!(refused(&transition("normal(sqrt, 1)")), @"m.toml, line 7, column 13, [transition] x: `sqrt` stands alone; it is written sqrt(x)");
}

#[test]
fn a_name_that_is_called() {
    insta::assert_snapshot!(refused(&transition("normal(x(1 + x), 1)")), @"m.toml, line 7, column 13, [transition] x: `x` is no function; a product is written x*(…)");
}

#[test]
fn a_measurement_in_a_formula() {
    insta::assert_snapshot!(refused(&transition("normal(y, 1)")), @"m.toml, line 7, column 13, [transition] x: `y` is a measurement; formulas are made of states, draws, inputs, parameters, definitions and t");
}

#[test]
fn a_state_before_there_is_one() {
    insta::assert_snapshot!(refused(&initial("normal(x, 1)")), @"m.toml, line 5, column 13, [initial] x: `x` has no value here yet; [initial] goes in order, and a line can use those above it");
}

#[test]
fn a_definition_of_states_before_there_are_any() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("[transition]", r#"[definitions]
d = "x/2"
[transition]"#), (START, r#"x = "normal(d, 1)""#)])), @"m.toml, line 5, column 13, [initial] x: `x` has no value here yet; [initial] goes in order, and a line can use those above it");
}

#[test]
fn a_name_with_a_hyphen() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", "q-r = 1")])), @"m.toml, line 3, column 1, [parameters] q-r: `q-r` is no name; a name has letters, digits and _, and begins with a letter");
}

#[test]
fn a_name_of_a_function() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", r#"q = 10.0
exp = 1"#)])), @"m.toml, line 4, column 1, [parameters] exp: `exp` is a function; another name is needed");
}

#[test]
fn a_name_that_is_the_time() {
    insta::assert_snapshot!(refused(&definitions(r#"t = "x""#)), @"m.toml, line 7, column 1, [definitions] t: `t` is the time; another name is needed");
}

#[test]
fn a_name_that_is_the_length_of_a_step() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", "q = 10.0\ndt = 1")])), @"m.toml, line 4, column 1, [parameters] dt: `dt` is the length of a sub-step; another name is needed");
}

#[test]
fn a_name_that_is_i() {
    insta::assert_snapshot!(refused(&definitions(r#"i = "1""#)), @"m.toml, line 7, column 1, [definitions] i: `i` is the number of a vector's coordinate; another name is needed");
}

#[test]
fn a_name_that_is_pi() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", r#"q = 10.0
pi = 3"#)])), @"m.toml, line 4, column 1, [parameters] pi: `pi` is the circle constant; another name is needed");
}

#[test]
fn a_name_with_two_meanings() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", r#"q = 10.0
x = 1"#)])), @"m.toml, line 6, column 1, [initial] x: `x` stands in [parameters], too; a name can mean one thing only");
}

#[test]
fn a_state_that_is_a_measurement() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MEASURE, r#"x = "normal(x, 1)""#)])), @"m.toml, line 9, column 1, [measurement] x: `x` stands in [initial], too; a name can mean one thing only");
}

#[test]
fn a_vector_that_is_a_number_too() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(START, r#"x = "normal(0, 1)"
x[3] = "normal(0, 1)""#)])), @"m.toml, line 6, column 1, [initial] x[3]: `x` stands in [initial], too; a name can mean one thing only");
}

#[test]
fn a_name_of_a_column() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MEASURE, r#"series = "normal(x, 1)""#)])), @"m.toml, line 9, column 1, [measurement] series: `series` is the column that tells sequences apart; another name is needed");
}

#[test]
fn definitions_in_a_circle() {
    insta::assert_snapshot!(refused(&definitions(r#"a = "b + 1"
b = "2*c"
c = "a""#)), @"m.toml, line 7, column 1, [definitions] a: definitions go in a circle: a → b → c → a; one of them must do without the others");
}

#[test]
fn a_definition_of_itself() {
    insta::assert_snapshot!(refused(&definitions(r#"d[3] = "d[i-1] + 1""#)), @"m.toml, line 7, column 1, [definitions] d[3]: definitions go in a circle: d → d; one of them must do without the others");
}

#[test]
fn a_distribution_in_a_definition() {
    insta::assert_snapshot!(refused(&definitions(r#"d = "normal(0, 1)""#)), @"m.toml, line 7, column 6, [definitions] d: `normal` is a distribution; it belongs where the definition is used");
}

#[test]
fn a_coordinate_that_does_not_move() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(START, r#"x = "normal(0, 1)"
v = "normal(0, 1)""#)])), @"m.toml, line 6, column 1, [initial] v: `v` is in [initial], but not in [transition]; each coordinate of the state needs a line in both");
}

#[test]
fn a_coordinate_that_does_not_begin() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, r#"x = "normal(x, q)"
v = "normal(0, 1)""#)])), @"m.toml, line 8, column 1, [transition] v: `v` is in [transition], but not in [initial]; each coordinate of the state needs a line in both");
}

#[test]
fn a_vector_of_two_lengths() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(START, r#"x[3] = "normal(0, 1)""#), (MOVE, r#"x[4] = "normal(x[i], 1)""#)])), @"m.toml, line 7, column 1, [transition] x[4]: it must be x[3], as in [initial]");
}
