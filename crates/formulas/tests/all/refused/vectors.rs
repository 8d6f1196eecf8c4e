//! Vectors and indices: catches an index that is rounded, or a length that cannot be had.

use super::{VECTOR, changed, refused, vector};

#[test]
fn a_vector_without_an_index() {
    insta::assert_snapshot!(refused(&vector("normal(x, 1)")), @"m.toml, line 7, column 17, [transition] x[40]: `x` is a vector of 40; one of its coordinates is written x[0], or x[i] in the formula of a vector");
}

#[test]
fn an_index_that_is_a_fraction() {
    insta::assert_snapshot!(refused(&vector("normal(x[i+0.5], 1)")), @"m.toml, line 7, column 21, [transition] x[40]: `0.5` is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn an_index_that_is_divided() {
    insta::assert_snapshot!(refused(&vector("normal(x[i/2], 1)")), @"m.toml, line 7, column 20, [transition] x[40]: `/` is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn an_index_that_is_a_state() {
    insta::assert_snapshot!(refused(&vector("normal(x[x[0]], 1)")), @"m.toml, line 7, column 19, [transition] x[40]: `x` is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn an_index_that_is_the_time() {
    insta::assert_snapshot!(refused(&vector("normal(x[t], 1)")), @"m.toml, line 7, column 19, [transition] x[40]: `t` is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn an_index_that_is_a_function() {
    insta::assert_snapshot!(refused(&vector("normal(x[floor(i)], 1)")), @"m.toml, line 7, column 19, [transition] x[40]: `floor(…)` is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn an_index_by_a_parameter_that_is_a_fraction() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[(r#""normal(x[i], 1)""#, r#""normal(x[i+q], 1)""#), ("q = 10.0", "q = 0.5")])), @"m.toml, line 7, column 21, [transition] x[40]: `q`, which is 0.5, is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn an_index_that_is_not_closed() {
    insta::assert_snapshot!(refused(&vector("normal(x[i, 1)")), @"m.toml, line 7, column 20, [transition] x[40]: there is `,` where a closing bracket ] should be");
}

#[test]
fn an_index_beyond_all_integers() {
    insta::assert_snapshot!(refused(&vector("normal(x[9999999999*9999999999], 1)")), @"m.toml, line 7, column 17, [transition] x[40]: 99999999980000000000 is no part of an index; an index is made of integers, i, and parameters that are integers, by + - *");
}

#[test]
fn a_length_of_zero() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("x[40]", "x[0]")])), @"m.toml, line 5, column 1, [initial] x[0]: `0` is no length of a vector; it must be an integer from 1 to 10000, or a parameter that is one");
}

#[test]
fn a_length_that_is_a_fraction() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("x[40]", "x[q]"), ("10.0", "2.5")])), @"m.toml, line 5, column 1, [initial] x[q]: `q` is no length of a vector; it must be an integer from 1 to 10000, or a parameter that is one");
}

#[test]
fn a_length_beyond_measure() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("x[40]", "x[20000]")])), @"m.toml, line 5, column 1, [initial] x[20000]: `20000` is no length of a vector; it must be an integer from 1 to 10000, or a parameter that is one");
}

#[test]
fn too_many_coordinates() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[(r#"x[40] = "normal(0, 1)""#, r#"x[6000] = "normal(0, 1)"
z[6000] = "normal(0, 1)""#)])), @"m.toml, line 6, column 1, [initial] z[6000]: with it there are more than 10000 coordinates; there can be at most so many");
}
