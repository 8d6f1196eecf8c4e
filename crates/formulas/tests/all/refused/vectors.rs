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
fn a_length_below_one() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("x[40]", "x[-1]")])), @"m.toml, line 5, column 1, [initial] x[-1]: `-1` is no length of a vector; it must be an integer from 1 to 10000, or a parameter that is one");
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

#[test]
fn a_part_that_is_empty() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("x[40]", "x[3..3]")])), @"m.toml, line 5, column 1, [initial] x[3..3]: the part from 3 to before 3 is empty; x[1..4] are x[1], x[2] and x[3]");
}

#[test]
fn a_part_that_leaves_coordinates_out() {
    insta::assert_snapshot!(refused("[initial]\nx[0] = 1\nx[2..4] = 2\n[transition]\nx[4] = 1\n[measurement]\ny = \"normal(x[0], 1)\"\n"), @"m.toml, line 3, column 1, [initial] x[2..4]: parts of a vector go on without gaps: this one of `x` must begin at 1, not at 2");
}

#[test]
fn a_part_that_begins_late() {
    insta::assert_snapshot!(refused("[initial]\nx[1..4] = 2\n[transition]\nx[4] = 1\n[measurement]\ny = \"normal(x[0], 1)\"\n"), @"m.toml, line 2, column 1, [initial] x[1..4]: parts of a vector go on without gaps: this one of `x` must begin at 0, not at 1");
}

#[test]
fn parts_that_are_too_few() {
    insta::assert_snapshot!(refused("[initial]\nx[4] = 2\n[transition]\nx[0] = 1\nx[1..3] = 2\n[measurement]\ny = \"normal(x[0], 1)\"\n"), @"m.toml, line 5, column 1, [transition] x[1..3]: it must be x[4] with all its parts, as in [initial]");
}

#[test]
fn a_definition_by_parts() {
    insta::assert_snapshot!(refused("[initial]\nx = 2\n[definitions]\nd[0] = 1\nd[1..3] = 2\n[transition]\nx = \"d[0]\"\n[measurement]\ny = \"normal(x, 1)\"\n"), @"m.toml, line 4, column 1, [definitions] d[0]: `d` is defined by parts; a definition has one formula for all coordinates, which may use if(i == 0, …)");
}

/// A model with lists of parameters, whose measurement is one of them.
fn listed(entry: &str) -> String {
    format!(
        "[parameters]\na = [1, 2, 3]\ng = [[1, 2], [3, 4]]\n[initial]\nx = 1\n[transition]\nx = 1\n[measurement]\ny = \"normal({entry}, 1)\"\n"
    )
}

#[test]
fn an_index_that_a_list_does_not_have() {
    insta::assert_snapshot!(refused(&listed("a[3]")), @"m.toml, line 9, column 13, [measurement] y: `a` has no entry 3; its indices are 0 to 2");
}

#[test]
fn a_list_without_an_index() {
    insta::assert_snapshot!(refused(&listed("a")), @"m.toml, line 9, column 13, [measurement] y: `a` is a list; an entry is written a[0]");
}

#[test]
fn a_list_of_lists_with_one_index() {
    insta::assert_snapshot!(refused(&listed("g[1]")), @"m.toml, line 9, column 13, [measurement] y: `g` is a list; an entry is written g[0, 0]");
}

#[test]
fn a_list_with_rows_of_different_lengths() {
    insta::assert_snapshot!(refused(&listed("a[0]").replace("[3, 4]", "[3]")), @"m.toml, line 3, column 14, [parameters] g: it is a list; it must be a list of 2, as the first one");
}

#[test]
fn a_list_with_a_text() {
    insta::assert_snapshot!(refused(&listed("a[0]").replace("[1, 2, 3]", "[1, 'x']")), @r#"m.toml, line 2, column 9, [parameters] a: it is the text "x"; it must be a number, or a prior as in "normal(0, 1)"; formulas stand in [definitions]"#);
}

#[test]
fn an_empty_list() {
    insta::assert_snapshot!(refused(&listed("a[0]").replace("[1, 2, 3]", "[]")), @"m.toml, line 2, column 5, [parameters] a: it is a list; it must be a list of one number or more");
}

#[test]
fn one_coordinate_that_does_not_come_next() {
    insta::assert_snapshot!(refused("[initial]\nx[0] = 1\nx[2] = 2\n[transition]\nx[2] = 1\n[measurement]\ny = \"normal(x[0], 1)\"\n"), @"m.toml, line 3, column 1, [initial] x[2]: parts of a vector go on without gaps: this one of `x` must begin at 1, not at 2");
}

#[test]
fn states_that_index_a_long_list() {
    let list = vec!["1"; 10_000].join(", ");
    insta::assert_snapshot!(refused(&format!("[parameters]\na = [{list}]\n[initial]\nx[10000] = 1\n[transition]\nx[10000] = \"normal(a[x[i]], 1)\"\n[measurement]\ny = \"normal(x[0], 1)\"\n")), @"m.toml, line 6, column 20, [transition] x[10000]: up to here the formulas come to more than 2000000 operations; shorter vectors would do");
}

#[test]
fn a_sum_along_nothing() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("normal(x[0], 1)", "normal(sum(j, 2*j), 1)")])), @"m.toml, line 9, column 17, [measurement] y: `j` is the index of a sum, and of no vector or list in it; as in sum(j, x[j]), one says how far it goes");
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("normal(x[0], 1)", "normal(sum(j, x[j+1]), 1)")])), @"m.toml, line 9, column 17, [measurement] y: `j` is the index of a sum, and of no vector or list in it; as in sum(j, x[j]), one says how far it goes");
}

#[test]
fn a_sum_without_an_index() {
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("normal(x[0], 1)", "normal(sum(x[0]), 1)")])), @"m.toml, line 9, column 13, [measurement] y: `sum` stands alone; it is written sum(j, x[j])");
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("normal(x[0], 1)", "normal(sum, 1)")])), @"m.toml, line 9, column 13, [measurement] y: `sum` stands alone; it is written sum(j, x[j])");
    insta::assert_snapshot!(refused(&changed(VECTOR, &[("normal(x[0], 1)", "normal(sum(3, x[0]), 1)")])), @"m.toml, line 9, column 13, [measurement] y: `sum` stands alone; it is written sum(j, x[j])");
}

#[test]
fn a_sum_whose_index_is_taken() {
    insta::assert_snapshot!(refused(&vector("normal(sum(i, x[i]), 1)")), @"m.toml, line 7, column 21, [transition] x[40]: `i` is the number of a vector's coordinate; another name is needed");
    insta::assert_snapshot!(refused(&vector("normal(sum(q, x[q]), 1)")), @"m.toml, line 7, column 21, [transition] x[40]: `q` is a name that is taken; another name is needed");
    insta::assert_snapshot!(refused(&vector("normal(sum(t, x[t]), 1)")), @"m.toml, line 7, column 21, [transition] x[40]: `t` is the time; another name is needed");
}

#[test]
fn a_sum_along_two_lengths() {
    let lists = changed(VECTOR, &[("q = 10.0", "q = 10.0\na = [1, 2]")]);
    insta::assert_snapshot!(refused(&changed(&lists, &[("normal(x[0], 1)", "normal(sum(j, a[j]*x[j]), 1)")])), @"m.toml, line 10, column 27, [measurement] y: `j` goes along vectors or lists of 2 and of 40; they must be of one length");
}

#[test]
fn a_distribution_in_a_sum() {
    insta::assert_snapshot!(refused(&vector("sum(j, normal(x[j], 1))")), @"m.toml, line 7, column 17, [transition] x[40]: `normal` stands inside of a sum; it can be shifted and scaled, as in x + 3*exponential(1); for more, make it a line of [draws] and use its value");
}

#[test]
fn an_index_beyond_a_vector_with_ends() {
    let text = "[initial]\nx[4] = \"normal(0, 1)\"\n[transition]\nx[0] = \"normal(x[0], 1)\"\nx[1..4] = \"x[i+1]\"\n[measurement]\ny = \"normal(x[0], 1)\"\n";
    insta::assert_snapshot!(refused(text), @"m.toml, line 5, column 12, [transition] x[1..4]: `x` has no entry 4; its indices are 0 to 3");
    let text = text.replace("x[i+1]", "x[i-1]").replace("y = \"normal(x[0], 1)\"", "y = \"normal(x[7], 1)\"");
    insta::assert_snapshot!(refused(&text), @"m.toml, line 7, column 13, [measurement] y: `x` has no entry 7; its indices are 0 to 3");
}
