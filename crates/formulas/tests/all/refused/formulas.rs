//! The grammar: catches what is read otherwise than written, and columns that point elsewhere.

use super::{FILE, MOVE, changed, refused, transition};

#[test]
fn an_empty_formula() {
    insta::assert_snapshot!(refused(&transition("")), @r#"m.toml, line 7, column 6, [transition] x: the formula is empty; it may look like "normal(0, 1)""#);
}

#[test]
fn a_parenthesis_that_is_not_closed() {
    insta::assert_snapshot!(refused(&transition("normal(x, (1 + q)")), @"m.toml, line 7, column 23, [transition] x: there is the end where a comma or a closing parenthesis should be");
}

#[test]
fn a_parenthesis_that_is_not_opened() {
    insta::assert_snapshot!(refused(&transition("normal(x, 1))")), @"m.toml, line 7, column 18, [transition] x: there is `)` where an operator or the end should be");
}

#[test]
fn an_operand_that_is_missing() {
    insta::assert_snapshot!(refused(&transition("normal(x * , 1)")), @"m.toml, line 7, column 17, [transition] x: there is `,` where a number, a name or an opening parenthesis should be");
}

#[test]
fn an_operator_that_is_missing() {
    insta::assert_snapshot!(refused(&transition("normal(2x, 1)")), @"m.toml, line 7, column 14, [transition] x: an operator is missing before `x`; a product is written with *, as in 2*x");
}

#[test]
fn a_power_of_two_stars() {
    insta::assert_snapshot!(refused(&transition("normal(x**2, 1)")), @"m.toml, line 7, column 14, [transition] x: there is `**` where the power ^ should be");
}

#[test]
fn a_comparison_of_a_comparison() {
    insta::assert_snapshot!(refused(&transition("normal(0 < x < 1, 1)")), @"m.toml, line 7, column 19, [transition] x: `<` compares a comparison; write both with and, as in 0 < x and x < 1");
}

#[test]
fn a_distribution_that_is_compared() {
    insta::assert_snapshot!(refused(&transition("normal(x, 1) > 0")), @"m.toml, line 7, column 6, [transition] x: `normal` stands inside of a comparison; it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn a_remainder_as_in_other_languages() {
    insta::assert_snapshot!(refused(&transition("normal(x % 2, 1)")), @"m.toml, line 7, column 15, [transition] x: `%` has no meaning in a formula; a remainder is written mod(x, n)");
}

#[test]
fn a_conjunction_as_in_other_languages() {
    insta::assert_snapshot!(refused(&transition("normal(if(x > 0 && x < 1, 1, 2), 1)")), @"m.toml, line 7, column 22, [transition] x: `&` has no meaning in a formula; write and, as in x > 0 and x < 1");
}

#[test]
fn a_choice_without_its_other_side() {
    insta::assert_snapshot!(refused(&transition("normal(if(x > 0, 1), 1)")), @"m.toml, line 7, column 13, [transition] x: `if(c, a, b)` takes 3 arguments, not 2");
}

#[test]
fn an_argument_with_a_name() {
    insta::assert_snapshot!(refused(&transition("normal(mean=x, sd=1)")), @"m.toml, line 7, column 17, [transition] x: `=` has no meaning in a formula; arguments have no names, and equality is written ==");
}

#[test]
fn a_raised_two() {
    insta::assert_snapshot!(refused(&transition("normal(x², 1)")), @"m.toml, line 7, column 14, [transition] x: `²` has no meaning in a formula; a power is written x^2");
}

#[test]
fn a_point_without_digits() {
    insta::assert_snapshot!(refused(&transition("normal(.*x, 1)")), @"m.toml, line 7, column 13, [transition] x: `.` has no meaning in a formula; numbers are written 0.5, 10, 1e-3");
}

#[test]
fn a_number_with_two_points() {
    insta::assert_snapshot!(refused(&transition("normal(1.2.3*x, 1)")), @"m.toml, line 7, column 13, [transition] x: `1.2.3` is no number; numbers are written 0.5, 10, 1e-3");
}

#[test]
fn a_number_that_is_too_large() {
    insta::assert_snapshot!(refused(&transition("normal(1e999, 1)")), @"m.toml, line 7, column 13, [transition] x: `1e999` is too large; numbers are below 1.8e308");
}

#[test]
fn too_many_arguments() {
    insta::assert_snapshot!(refused(&transition("normal(0,5*x, 1)")), @"m.toml, line 7, column 6, [transition] x: `normal(mean, sd)` takes 2 arguments, not 3");
}

#[test]
fn too_few_arguments() {
    insta::assert_snapshot!(refused(&transition("normal(x)")), @"m.toml, line 7, column 6, [transition] x: `normal(mean, sd)` takes 2 arguments, not 1");
}

#[test]
fn a_function_of_two() {
    insta::assert_snapshot!(refused(&transition("normal(sin(x, q), 1)")), @"m.toml, line 7, column 13, [transition] x: `sin(x)` takes one argument, not 2");
}

#[test]
fn an_index_of_a_number() {
    insta::assert_snapshot!(refused(&transition("normal(x[0], 1)")), @"m.toml, line 7, column 13, [transition] x: `x` is no vector; it is written without an index");
}

#[test]
fn an_index_of_a_parameter() {
    insta::assert_snapshot!(refused(&transition("normal(q[0], 1)")), @"m.toml, line 7, column 13, [transition] x: `q` is no vector; it is written without an index");
}

#[test]
fn i_without_a_vector() {
    insta::assert_snapshot!(refused(&transition("normal(i*x, 1)")), @r#"m.toml, line 7, column 13, [transition] x: `i` counts the coordinates of a vector; it has a meaning only in a formula like x[40] = "…x[i-1]…""#);
}

#[test]
fn a_column_after_letters_of_several_bytes() {
    insta::assert_snapshot!(refused(&transition("normal(x + é, 1)")), @"m.toml, line 7, column 17, [transition] x: `é` is not known here; known are q, x, t, pi");
}

#[test]
fn a_column_in_a_text_of_several_lines() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, r#"x = """
normal(
  x + z,
  1)
""""#)])), @"m.toml, line 9, column 7, [transition] x: `z` is not known here; known are q, x, t, pi");
}

#[test]
fn a_column_that_is_not_known() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, r#"x = "\u006eormal(z, 1)""#)])), @"m.toml, line 7, column 5, [transition] x: `z` is not known here; known are q, x, t, pi");
}
