//! Distributions of measurements that are made of others: catches one that would be another, or none.

use super::{FILE, MEASURE, MOVE, changed, measurement, refused, transition};

#[test]
fn one_of_a_state() {
    insta::assert_snapshot!(refused(&transition("rounded(normal(x, 1))")), @"m.toml, line 7, column 6, [transition] x: `rounded` is for measurements; a state or a draw cannot have it");
}

#[test]
fn an_angle_that_is_drawn() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("[transition]", "[draws]\ne = \"von_mises(0, 1)\"\n[transition]")])), @"m.toml, line 7, column 6, [draws] e: `von_mises` is for measurements; a state or a draw cannot have it");
}

#[test]
fn a_number_that_is_rounded() {
    insta::assert_snapshot!(refused(&measurement("rounded(x)")), @"m.toml, line 9, column 14, [measurement] y: `x` is no distribution; d of rounded(d) is one, as in normal(x, 1)");
}

#[test]
fn too_few_arguments() {
    insta::assert_snapshot!(refused(&measurement("censored(normal(x, 1), 0)")), @"m.toml, line 9, column 6, [measurement] y: `censored(d, low, high)` takes 3 arguments, not 2");
}

#[test]
fn a_distribution_as_an_end() {
    insta::assert_snapshot!(refused(&measurement("censored(normal(x, 1), 0, normal(x, 1))")), @"m.toml, line 9, column 32, [measurement] y: `normal` stands inside of censored(d, low, high); it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn one_that_is_shifted() {
    insta::assert_snapshot!(refused(&measurement("1 + rounded(normal(x, 1))")), @"m.toml, line 9, column 10, [measurement] y: `rounded` cannot be shifted or scaled; what stands inside of it can");
}

#[test]
fn one_with_a_sign_inside_of_another() {
    insta::assert_snapshot!(refused(&measurement("floored(-rounded(normal(x, 1)), 0.1)")), @"m.toml, line 9, column 15, [measurement] y: `rounded` cannot be shifted or scaled; what stands inside of it can");
}

#[test]
fn one_without_masses() {
    insta::assert_snapshot!(refused(&measurement("rounded(von_mises(x, 1))")), @"m.toml, line 9, column 14, [measurement] y: `von_mises` has no masses for rounded(d); those of the table of distributions have, and all but von_mises, floored and log_density made of these");
}

#[test]
fn ends_on_a_number_with_a_mass() {
    insta::assert_snapshot!(refused(&measurement("truncated(mixture(0.1, censored(normal(x, 1), 0, inf), normal(x, 1)), 0, 9)")), @"m.toml, line 9, column 29, [measurement] y: `censored` has no masses for truncated(d, low, high); those of the table of distributions have, and rounded, truncated and mixture made of these");
}

#[test]
fn ends_the_wrong_way_round() {
    insta::assert_snapshot!(refused(&measurement("truncated(normal(x, 1), 2, -inf)")), @"m.toml, line 9, column 6, [measurement] y: the high of truncated(d, low, high) is -inf; it must be above low, which is 2");
}

#[test]
fn a_probability_above_one() {
    insta::assert_snapshot!(refused(&measurement("zero_inflated(2, poisson(3))")), @"m.toml, line 9, column 6, [measurement] y: the p of zero_inflated(p, d) is 2; it must be between 0 and 1");
}

#[test]
fn a_floor_of_zero() {
    insta::assert_snapshot!(refused(&measurement("floored(normal(x, 1), 0)")), @"m.toml, line 9, column 6, [measurement] y: the eps of floored(d, eps) is 0; it must be above 0");
}

#[test]
fn a_parameter_of_what_is_inside() {
    insta::assert_snapshot!(refused(&measurement("rounded(normal(x, -1))")), @"m.toml, line 9, column 14, [measurement] y: the sd of normal(mean, sd) is -1; it must be above 0");
}

#[test]
fn an_infinite_number_elsewhere() {
    insta::assert_snapshot!(refused(&measurement("normal(x, inf)")), @"m.toml, line 9, column 16, [measurement] y: `inf` is not known here; it is an end of censored(d, low, high) and of truncated(d, low, high)");
}

#[test]
fn a_measurement_outside_of_its_log_density() {
    insta::assert_snapshot!(refused(&measurement("normal(y, 1)")), @"m.toml, line 9, column 13, [measurement] y: `y` is a measurement; formulas are made of states, draws, inputs, parameters, definitions and t");
}

#[test]
fn another_measurement_in_a_log_density() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MEASURE, "y = \"normal(x, 1)\"\nz = \"log_density(-y^2)\"")])), @"m.toml, line 10, column 19, [measurement] z: `y` is a measurement; formulas are made of states, draws, inputs, parameters, definitions and t");
}

#[test]
fn another_index_of_itself() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MEASURE, "y[2] = \"log_density(-y[0]^2)\"")])), @"m.toml, line 9, column 22, [measurement] y[2]: in its own log density `y` is the coordinate itself; it is written y, or y[i]");
}

#[test]
fn one_that_stands_alone() {
    insta::assert_snapshot!(refused(&measurement("rounded")), @"m.toml, line 9, column 6, [measurement] y: `rounded` stands alone; it is written rounded(d)");
}

#[test]
fn one_in_a_definition() {
    let text = changed(FILE, &[(MOVE, "x = \"normal(x, q)\"\n[definitions]\nd = \"rounded(normal(x, 1))\"")]);
    insta::assert_snapshot!(refused(&text), @"m.toml, line 9, column 6, [definitions] d: `rounded` is a distribution; it belongs where the definition is used");
}
