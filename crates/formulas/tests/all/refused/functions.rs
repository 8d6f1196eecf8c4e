//! Functions of one's own: catches one that means something else to the file than to its author.

use super::{FILE, MEASURE, START, changed, definitions, refused};

/// [`FILE`] with a function and a measurement.
fn calling(function: &str, measurement: &str) -> String {
    changed(&definitions(function), &[(MEASURE, &format!("y = \"{measurement}\""))])
}

#[test]
fn a_function_of_too_few_arguments() {
    insta::assert_snapshot!(refused(&calling("f(u, v) = \"u*v\"", "normal(f(x), 1)")), @"m.toml, line 11, column 13, [measurement] y: `f(u, v)` takes 2 arguments, not 1");
}

#[test]
fn a_function_without_its_arguments() {
    insta::assert_snapshot!(refused(&calling("f(u, v) = \"u*v\"", "normal(f, 1)")), @"m.toml, line 11, column 13, [measurement] y: `f` stands alone; it is written f(u, v)");
}

#[test]
fn a_function_that_is_misspelt() {
    insta::assert_snapshot!(refused(&calling("saturated(u) = \"u\"", "normal(saturate(x), 1)")), @"m.toml, line 11, column 13, [measurement] y: `saturate` is not known here; did you mean `saturated`?");
}

#[test]
fn a_function_with_the_name_of_a_construct() {
    insta::assert_snapshot!(refused(&definitions("sum(u) = \"u + 1\"")), @"m.toml, line 7, column 1, [definitions] sum(u): `sum` is a function; another name is needed");
}

#[test]
fn a_function_that_calls_itself_in_place_of_the_one_that_there_is() {
    insta::assert_snapshot!(refused(&definitions("exp(u) = \"exp(u) + 1\"")), @"m.toml, line 7, column 1, [definitions] exp(u): definitions go in a circle: exp → exp; one of them must do without the others");
}

#[test]
fn a_function_with_the_name_of_a_distribution() {
    insta::assert_snapshot!(refused(&definitions("gamma(u) = \"u\"")), @"m.toml, line 7, column 1, [definitions] gamma(u): `gamma` is a distribution; another name is needed");
}

#[test]
fn a_function_with_the_name_of_a_parameter() {
    insta::assert_snapshot!(refused(&definitions("q(u) = \"u\"")), @"m.toml, line 7, column 1, [definitions] q(u): `q` stands in [parameters], too; a name can mean one thing only");
}

#[test]
fn a_function_without_arguments() {
    insta::assert_snapshot!(refused(&definitions("f() = \"x\"")), @"m.toml, line 7, column 1, [definitions] f(): `f()` is no function; it is written f(x) or f(x, y), with the names of its arguments, each once");
}

#[test]
fn an_argument_that_is_there_twice() {
    insta::assert_snapshot!(refused(&definitions("f(u, u) = \"u\"")), @"m.toml, line 7, column 1, [definitions] f(u, u): `f(u, u)` is no function; it is written f(x) or f(x, y), with the names of its arguments, each once");
}

#[test]
fn an_argument_that_is_the_time() {
    insta::assert_snapshot!(refused(&definitions("season(t) = \"cos(t)\"")), @"m.toml, line 7, column 1, [definitions] season(t): `t` is the time; another name is needed");
}

#[test]
fn a_function_in_another_section() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(START, "x(u) = \"normal(0, 1)\"")])), @"m.toml, line 5, column 1, [initial] x(u): `x(u)` is written like a function; functions stand in [definitions]");
}

#[test]
fn a_function_of_itself() {
    insta::assert_snapshot!(refused(&definitions("f(n) = \"if(n < 1, 1, n*g(n - 1))\"\ng(n) = \"f(n)\"")), @"m.toml, line 7, column 1, [definitions] f(n): definitions go in a circle: f → g → f; one of them must do without the others");
}

#[test]
fn an_argument_that_is_called() {
    insta::assert_snapshot!(refused(&definitions("f(u) = \"u(1 + u)\"")), @"m.toml, line 7, column 9, [definitions] f(u): `u` is no function; a product is written u*(…)");
}

#[test]
fn an_argument_that_is_not_known_elsewhere() {
    insta::assert_snapshot!(refused(&calling("f(speed) = \"speed\"", "normal(speed, 1)")), @"m.toml, line 11, column 13, [measurement] y: `speed` is not known here; known are q, x, t, pi");
}

#[test]
fn a_distribution_as_what_a_function_takes() {
    insta::assert_snapshot!(refused(&calling("f(u) = \"u^2\"", "f(normal(x, 1))")), @"m.toml, line 11, column 8, [measurement] y: `normal` stands inside of f(u); it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn a_function_whose_index_is_no_number() {
    insta::assert_snapshot!(refused("[initial]\nx[3] = 1\n[definitions]\nf(k) = \"x[k]\"\n[transition]\nx[3] = \"x[i]\"\n[measurement]\ny = \"normal(f(x[0]), 1)\"\n"), @"m.toml, line 4, column 9, [definitions] f(k): what the function is given is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}
