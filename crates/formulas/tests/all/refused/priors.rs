//! Priors: catches a parameter that begins at a number nobody meant.

use super::{FILE, changed, refused};

/// [`FILE`] with another parameter.
fn parameter(line: &str) -> String {
    changed(FILE, &[("q = 10.0", line)])
}

#[test]
fn a_prior_of_a_parameter_with_a_prior() {
    insta::assert_snapshot!(refused(&parameter("s = \"half_normal(1)\"\nq = \"normal(0, s)\"")), @"m.toml, line 4, column 16, [parameters] q: `s` has a prior itself; a prior is made of numbers, and of parameters above it that are numbers");
    insta::assert_snapshot!(refused(&parameter("q = \"normal(q, 1)\"")), @"m.toml, line 3, column 13, [parameters] q: `q` has a prior itself; a prior is made of numbers, and of parameters above it that are numbers");
}

#[test]
fn a_prior_of_a_parameter_below_it() {
    insta::assert_snapshot!(refused(&parameter("q = \"normal(0, s)\"\ns = 1")), @"m.toml, line 3, column 16, [parameters] q: `s` is not known here; a prior is made of numbers and of parameters above it");
}

#[test]
fn a_prior_of_a_state() {
    insta::assert_snapshot!(refused(&parameter("q = \"normal(x, 1)\"")), @"m.toml, line 3, column 13, [parameters] q: `x` is not known here; a prior is made of numbers and of parameters above it");
}

#[test]
fn a_prior_that_changes_with_time() {
    insta::assert_snapshot!(refused(&parameter("q = \"normal(t, 1)\"")), @"m.toml, line 3, column 13, [parameters] q: `t` is not known here; a prior is made of numbers and of parameters above it");
}

#[test]
fn a_prior_that_is_misspelt() {
    insta::assert_snapshot!(refused(&parameter("q = \"lognormal(0, 1)\"")), @"m.toml, line 3, column 6, [parameters] q: `lognormal` is not known here; did you mean `log_normal`?");
}

#[test]
fn a_prior_without_a_density() {
    insta::assert_snapshot!(refused(&parameter("q = \"flat()\"")), @"m.toml, line 3, column 6, [parameters] q: `flat` is not known here; a prior integrates to 1: where next to nothing is known take a wide one, as in normal(0, 100) or log_normal(0, 5)");
    insta::assert_snapshot!(refused(&parameter("q = \"uniform(0, inf)\"")), @"m.toml, line 3, column 17, [parameters] q: `inf` is not known here; only truncated(prior, low, high) has such an end; a prior integrates to 1: where next to nothing is known take a wide one, as in normal(0, 100) or log_normal(0, 5)");
}

#[test]
fn a_prior_that_is_not_known() {
    insta::assert_snapshot!(refused(&parameter("q = \"cauchy(0, 1)\"")), @"m.toml, line 3, column 6, [parameters] q: `cauchy` is not known here; it is student_t(1, location, scale)");
    insta::assert_snapshot!(refused(&parameter("q = \"weibull(1, 1)\"")), @"m.toml, line 3, column 6, [parameters] q: `weibull` is not known here; priors are normal, student_t, laplace, log_normal, exponential, gamma, beta, uniform, poisson, negative_binomial, binomial, bernoulli, dirichlet, inverse_gamma, half_normal, half_cauchy, truncated");
}

#[test]
fn a_prior_out_of_range() {
    insta::assert_snapshot!(refused(&parameter("q = \"normal(0, -1)\"")), @"m.toml, line 3, column 16, [parameters] q: the sd of normal(mean, sd) is -1; it must be above 0");
    insta::assert_snapshot!(refused(&parameter("q = \"uniform(2, 1)\"")), @"m.toml, line 3, column 6, [parameters] q: the high of uniform(low, high) is 1; it must be above low, which is 2");
    insta::assert_snapshot!(refused(&parameter("q = \"dirichlet(1, 0)\"")), @"m.toml, line 3, column 19, [parameters] q: the a1 of dirichlet(a0, a1, …) is 0; it must be above 0");
}

#[test]
fn a_prior_that_is_none() {
    insta::assert_snapshot!(refused(&parameter("q = \"categorical(0.5, 0.5)\"")), @"m.toml, line 3, column 6, [parameters] q: `categorical` is for states and draws; a prior is a distribution of one number, or a dirichlet");
}

#[test]
fn a_prior_of_a_prior_only_that_is_moved() {
    insta::assert_snapshot!(refused(&parameter("q = \"1 + half_normal(1)\"")), @"m.toml, line 3, column 10, [parameters] q: `half_normal` stands alone in a prior; it is not shifted or scaled");
}

#[test]
fn a_distribution_for_priors_elsewhere() {
    insta::assert_snapshot!(refused(&super::transition("half_normal(1)")), @"m.toml, line 7, column 6, [transition] x: `half_normal` is for priors, in [parameters]");
}

#[test]
fn a_truncation_with_nothing_in_it() {
    insta::assert_snapshot!(refused(&parameter("q = \"truncated(normal(0, 1), 3, 2)\"")), @"m.toml, line 3, column 6, [parameters] q: between 3 and 2 the distribution has no probability");
    insta::assert_snapshot!(refused(&parameter("q = \"truncated(uniform(0, 1), 2, inf)\"")), @"m.toml, line 3, column 6, [parameters] q: between 2 and inf the distribution has no probability");
}

#[test]
fn a_truncation_of_what_has_no_density() {
    insta::assert_snapshot!(refused(&parameter("q = \"truncated(poisson(3), 1, inf)\"")), @"m.toml, line 3, column 16, [parameters] q: there is `poisson(3)` where the distribution of one number that is no count should be");
    insta::assert_snapshot!(refused(&parameter("q = \"truncated(3, 1, inf)\"")), @"m.toml, line 3, column 16, [parameters] q: there is `3` where the distribution of one number that is no count should be");
}

#[test]
fn a_truncation_without_its_ends() {
    insta::assert_snapshot!(refused(&parameter("q = \"truncated(normal(0, 1))\"")), @"m.toml, line 3, column 6, [parameters] q: `truncated(d, low, high)` takes 3 arguments, not 1");
    insta::assert_snapshot!(refused(&parameter("q = \"truncated(normal(0, 1), 0, infinity)\"")), @"m.toml, line 3, column 33, [parameters] q: `infinity` is not known here; a prior is made of numbers and of parameters above it");
}

#[test]
fn a_start_that_the_prior_does_not_have() {
    insta::assert_snapshot!(refused(&parameter("q = { prior = \"uniform(0, 1)\", start = 2 }")), @"m.toml, line 3, column 40, [parameters] q: the start 2 is no value that the prior can give");
}

#[test]
fn a_start_of_another_length() {
    insta::assert_snapshot!(refused(&parameter("q = { prior = \"dirichlet(1, 1)\", start = [1] }")), @"m.toml, line 3, column 42, [parameters] q: it is a list; it must be a list of 2 numbers");
    insta::assert_snapshot!(refused(&parameter("q = { prior = \"normal(0, 1)\", start = [1] }")), @"m.toml, line 3, column 39, [parameters] q: it is a list; it must be a finite number");
}

#[test]
fn a_parameter_with_more_than_prior_and_start() {
    insta::assert_snapshot!(refused(&parameter("q = { prior = \"normal(0, 1)\", value = 2 }")), @"m.toml, line 3, column 31, [parameters] q: a model file has no `value` here; a parameter has prior and start");
    insta::assert_snapshot!(refused(&parameter("q = { start = 2 }")), @r#"m.toml, line 3, column 5, [parameters] q: there is no prior; it is needed: { prior = "uniform(0, 1)", start = 0.5 }"#);
}

#[test]
fn priors_of_entries_that_are_none() {
    insta::assert_snapshot!(refused(&parameter("q = [1, \"dirichlet(1, 1)\"]")), @r#"m.toml, line 3, column 9, [parameters] q: it is the text "dirichlet(1, 1)"; it must be a prior of one number; a dirichlet is the prior of a whole list"#);
    insta::assert_snapshot!(refused(&parameter("q = [1, { start = 2 }]")), @r#"m.toml, line 3, column 9, [parameters] q: there is no prior; it is needed: { prior = "uniform(0, 1)", start = 0.5 }"#);
    insta::assert_snapshot!(refused(&parameter("q = [1, \"normal(0, q[0])\"]")), @"m.toml, line 3, column 20, [parameters] q: `q` has a prior itself; a prior is made of numbers, and of parameters above it that are numbers");
    insta::assert_snapshot!(refused(&parameter("a = [1, \"half_normal(1)\"]\nq = \"normal(0, a[0])\"")), @"m.toml, line 4, column 16, [parameters] q: `a` has a prior itself; a prior is made of numbers, and of parameters above it that are numbers");
}
