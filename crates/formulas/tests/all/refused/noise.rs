//! Distributions: catches a coordinate whose density would be another one, or none.

use super::{FILE, MOVE, START, changed, initial, measurement, refused, transition};

#[test]
fn a_coordinate_that_is_no_number() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(START, r#"x = "normal(0, 1)"
v = 0"#), (MOVE, r#"x = "normal(x, q)"
v = "1/0""#)])), @"m.toml, line 9, column 6, [transition] v: the value is inf; it must be a finite number");
}

#[test]
fn a_measurement_without_noise() {
    insta::assert_snapshot!(refused(&measurement("x")), @r#"m.toml, line 9, column 6, [measurement] y: a measurement has a distribution, as in "normal(x, 0.01)"; a formula without noise can be a state"#);
}

#[test]
fn two_distributions() {
    insta::assert_snapshot!(refused(&transition("x + normal(0, 1) + laplace(0, 1)")), @"m.toml, line 7, column 25, [transition] x: `laplace` is a second distribution; a coordinate has one, and others stand in [draws]");
}

#[test]
fn a_product_of_two_distributions() {
    insta::assert_snapshot!(refused(&transition("normal(0, 1)*normal(0, 1)")), @"m.toml, line 7, column 19, [transition] x: `normal` is a second distribution; a coordinate has one, and others stand in [draws]");
}

#[test]
fn a_distribution_inside_of_a_function() {
    insta::assert_snapshot!(refused(&transition("exp(normal(x, 1))")), @"m.toml, line 7, column 10, [transition] x: `normal` stands inside of exp(x); it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn a_distribution_as_an_argument() {
    insta::assert_snapshot!(refused(&transition("normal(normal(x, 1), 1)")), @"m.toml, line 7, column 13, [transition] x: `normal` stands inside of normal(mean, sd); it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn a_distribution_as_a_divisor() {
    insta::assert_snapshot!(refused(&transition("x/gamma(2, 1)")), @"m.toml, line 7, column 8, [transition] x: `gamma` stands inside of a divisor; it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn a_distribution_in_a_power() {
    insta::assert_snapshot!(refused(&transition("normal(x, 1)^2")), @"m.toml, line 7, column 6, [transition] x: `normal` stands inside of a power; it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn counts_that_are_shifted() {
    insta::assert_snapshot!(refused(&measurement("poisson(3) + 1")), @"m.toml, line 9, column 6, [measurement] y: `poisson` gives counts, which cannot be shifted or scaled; as a line of [draws] it can be part of any formula of [transition]");
}

#[test]
fn counts_that_are_scaled() {
    insta::assert_snapshot!(refused(&measurement("2*poisson(3)")), @"m.toml, line 9, column 8, [measurement] y: `poisson` gives counts, which cannot be shifted or scaled; as a line of [draws] it can be part of any formula of [transition]");
}

#[test]
fn counts_with_a_sign() {
    insta::assert_snapshot!(refused(&measurement("-binomial(3, 0.5)")), @"m.toml, line 9, column 7, [measurement] y: `binomial` gives counts, which cannot be shifted or scaled; as a line of [draws] it can be part of any formula of [transition]");
}

#[test]
fn a_draw_in_a_definition() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("[transition]", "[draws]\ne = \"normal(0, 1)\"\n[definitions]\nd = \"2*e\"\n[transition]")])), @"m.toml, line 9, column 8, [definitions] d: `e` is a draw of a step; [draws] and [transition] can use it, and a state can keep it");
}

#[test]
fn a_draw_of_a_draw_below() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("[transition]", "[draws]\na = \"normal(b, 1)\"\nb = \"normal(0, 1)\"\n[transition]")])), @"m.toml, line 7, column 13, [draws] a: `b` has no value here yet; [draws] goes in order, and a line can use those above it");
}

#[test]
fn a_deviation_below_zero() {
    insta::assert_snapshot!(refused(&transition("normal(x, -1)")), @"m.toml, line 7, column 6, [transition] x: the sd of normal(mean, sd) is -1; it must be above 0");
}

#[test]
fn a_deviation_that_is_no_number() {
    insta::assert_snapshot!(refused(&transition("normal(x, sqrt(-q))")), @"m.toml, line 7, column 6, [transition] x: the sd of normal(mean, sd) is NaN; it must be above 0");
}

#[test]
fn a_mean_that_is_infinite() {
    insta::assert_snapshot!(refused(&transition("normal(1/0, 1)")), @"m.toml, line 7, column 6, [transition] x: the mean of normal(mean, sd) is inf; it must be a finite number");
}

#[test]
fn a_probability_above_one() {
    insta::assert_snapshot!(refused(&measurement("bernoulli(1.5)")), @"m.toml, line 9, column 6, [measurement] y: the p of bernoulli(p) is 1.5; it must be between 0 and 1");
}

#[test]
fn trials_that_are_no_count() {
    insta::assert_snapshot!(refused(&measurement("binomial(2.5, 0.5)")), @"m.toml, line 9, column 6, [measurement] y: the n of binomial(n, p) is 2.5; it must be an integer of at least 0");
}

#[test]
fn ends_the_wrong_way_round() {
    insta::assert_snapshot!(refused(&transition("uniform(1, 0)")), @"m.toml, line 7, column 6, [transition] x: the high of uniform(low, high) is 0; it must be above low, which is 1");
}

#[test]
fn noise_that_is_multiplied_by_zero() {
    insta::assert_snapshot!(refused(&transition("x + 0*normal(0, 1)")), @"m.toml, line 7, column 12, [transition] x: `normal(mean, sd)` is multiplied by 0, so that the coordinate has no noise; the factor must be another number");
}

#[test]
fn noise_that_is_divided_by_zero() {
    insta::assert_snapshot!(refused(&transition("x + exponential(1)/0")), @"m.toml, line 7, column 10, [transition] x: the factor of exponential(mean) is inf; it must be a finite number");
}

/// [`FILE`] with a draw.
fn draw(line: &str) -> String {
    changed(FILE, &[("[transition]", &format!("[draws]\n{line}\n[transition]"))])
}

#[test]
fn draws_of_several_parts_as_a_state() {
    insta::assert_snapshot!(refused(&transition("euler_multinomial(5, 0.1, 0.2)")), @r#"m.toml, line 7, column 6, [transition] x: `euler_multinomial` draws several numbers at once; as a line of [draws], n = "euler_multinomial(…)", they are n[0], n[1], …, which any line of [transition] may use, as in x[2] = "n[i]""#);
    insta::assert_snapshot!(refused(&initial("euler_multinomial(5, 0.1, 0.2)")), @r#"m.toml, line 5, column 6, [initial] x: `euler_multinomial` draws several numbers at once; a start that does is an mvnormal or a dirichlet"#);
}

#[test]
fn draws_of_several_parts_with_a_length() {
    insta::assert_snapshot!(refused(&draw("out[2] = \"euler_multinomial(5, 0.1, 0.2)\"")), @"m.toml, line 7, column 1, [draws] out[2]: `out` has as many coordinates as its distribution has parts; it is written without a length");
}

#[test]
fn draws_of_several_parts_in_a_sum() {
    insta::assert_snapshot!(refused(&draw("out = \"5 - euler_multinomial(5, 0.1, 0.2)\"")), @"m.toml, line 7, column 12, [draws] out: `euler_multinomial` stands alone; as a line of [draws] its values can be part of any formula of [transition]");
    insta::assert_snapshot!(refused(&draw("out = \"euler_multinomial(5, 0.1, 0.2)/5\"")), @"m.toml, line 7, column 8, [draws] out: `euler_multinomial` stands alone; as a line of [draws] its values can be part of any formula of [transition]");
}

#[test]
fn a_categorical_that_does_not_stand_alone() {
    insta::assert_snapshot!(refused(&initial("1 + categorical(0.5, 0.5)")), @"m.toml, line 5, column 10, [initial] x: `categorical` stands alone; formulas of the lines below it may use what it draws");
    insta::assert_snapshot!(refused(&measurement("rounded(categorical(0.5, 0.5))")), @"m.toml, line 9, column 14, [measurement] y: `categorical` stands alone; it is measured as it is, not shifted, scaled or inside of another distribution");
    insta::assert_snapshot!(refused(&measurement("2*categorical(0.5, 0.5)")), @"m.toml, line 9, column 8, [measurement] y: `categorical` stands alone; it is measured as it is, not shifted, scaled or inside of another distribution");
}

#[test]
fn a_part_that_there_is_not() {
    insta::assert_snapshot!(refused(&changed(&draw("out = \"euler_multinomial(5, 0.1, 0.2)\""), &[(MOVE, "x = \"out[2]\"")])), @"m.toml, line 9, column 6, [transition] x: `out` has no entry 2; its indices are 0 to 1");
}

#[test]
fn a_draw_of_several_parts_without_an_index() {
    insta::assert_snapshot!(refused(&changed(&draw("out = \"euler_multinomial(5, 0.1, 0.2)\""), &[(MOVE, "x = \"x + out\"")])), @"m.toml, line 9, column 10, [transition] x: `out` is a vector of 2; one of its coordinates is written out[0], or out[i] in the formula of a vector");
}

#[test]
fn a_rate_below_zero() {
    insta::assert_snapshot!(refused(&draw("out = \"euler_multinomial(5, 0.1, -0.2)\"")), @"m.toml, line 7, column 8, [draws] out: the rate of euler_multinomial(n, rate, …) is -0.2; it must be at least 0");
}

#[test]
fn a_rate_that_is_missing() {
    insta::assert_snapshot!(refused(&draw("out = \"euler_multinomial(5)\"")), @"m.toml, line 7, column 8, [draws] out: `euler_multinomial(n, rate, …)` takes 2 arguments or more, not 1");
}

#[test]
fn probabilities_that_do_not_add_up() {
    insta::assert_snapshot!(refused(&transition("categorical(0.5, 0.3, 0.1)")), @"m.toml, line 7, column 6, [transition] x: the sum of the probabilities of categorical(p0, p1, …) is 0.9; it must be 1");
}

#[test]
fn a_category_with_a_negative_probability() {
    insta::assert_snapshot!(refused(&transition("categorical(0.5, -0.5, 1)")), @"m.toml, line 7, column 6, [transition] x: the p1 of categorical(p0, p1, …) is -0.5; it must be between 0 and 1");
}

#[test]
fn a_covariance_that_is_none() {
    for covariance in ["[[1, 2], [2, 1]]", "[[1, 0.5], [0.4, 1]]", "[[0, 0], [0, 1]]"] {
        let line = format!("v = \"mvnormal([0, 0], {covariance})\"");
        assert!(refused(&draw(&line)).ends_with("positive definite; it must be"), "{covariance}");
    }
    insta::assert_snapshot!(refused(&draw("v = \"mvnormal([0, 0], [[1, 2], [2, 1]])\"")), @"m.toml, line 7, column 6, [draws] v: the covariance is not symmetric and positive definite; it must be");
}

#[test]
fn a_covariance_of_another_size() {
    insta::assert_snapshot!(refused(&draw("v = \"mvnormal([0, 0], [[1, 2]])\"")), @"m.toml, line 7, column 30, [draws] v: there is `]` where a comma and the next row of the covariance should be");
    insta::assert_snapshot!(refused(&draw("v = \"mvnormal([0, 0], [[1], [2]])\"")), @"m.toml, line 7, column 25, [draws] v: the row has 1 of 2 numbers; the covariance has as many rows and columns as there are means");
    insta::assert_snapshot!(refused(&draw("v = \"mvnormal(0, 1)\"")), @"m.toml, line 7, column 15, [draws] v: there is `0` where a list, as in [0, 1], should be");
}
