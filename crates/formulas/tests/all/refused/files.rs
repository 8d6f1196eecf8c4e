//! The file as TOML: catches a section, key or value that would be ignored or misread.

use super::{FILE, MEASURE, MOVE, changed, refused};

#[test]
fn what_is_not_toml() {
    insta::assert_snapshot!(refused(r#"[initial
x = 1"#), @"m.toml, line 1, column 9: this is not TOML: unclosed table, expected `]`");
}

#[test]
fn a_formula_without_quotes() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, "x = normal(x, q)")])), @r#"m.toml, line 7, column 13, [transition] x: a formula stands in quotes: x = "normal(x, q)""#);
}

#[test]
fn a_key_that_is_there_twice() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, r#"x = "normal(x, q)"
x = "normal(x, q)""#)])), @"m.toml, line 8, column 1, [transition] x: `x` is there twice; it can be there only once");
}

#[test]
fn nothing() {
    insta::assert_snapshot!(refused(""), @r#"m.toml: there is no [initial]; it is needed: a line for each coordinate of the state, as x = "normal(0, 1)""#);
}

#[test]
fn a_section_that_is_missing() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(r#"[measurement]
y = "normal(x, 1)""#, "")])), @r#"m.toml: there is no [measurement]; it is needed: a line for each measurement, as y = "normal(x, 1)""#);
}

#[test]
fn a_section_that_is_empty() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, "")])), @r#"m.toml: there is no [transition]; it is needed: a line for each coordinate of the state, as x = "normal(0.9*x, 1)""#);
}

#[test]
fn a_section_with_another_name() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("[measurement]", "[measurements]")])), @"m.toml, line 8, column 2: a model file has no `measurements` here; did you mean `measurement`?");
}

#[test]
fn a_key_that_there_is_not() {
    insta::assert_snapshot!(refused(&(r#"author = "me"
"#.to_string() + FILE)), @"m.toml, line 1, column 1: a model file has no `author` here; it has name, kind, [series], [time], [inputs], [parameters], [initial], [definitions], [draws], [transition], [measurement]");
}

#[test]
fn a_section_that_is_none() {
    insta::assert_snapshot!(refused(r#"initial = "normal(0, 1)"
"#), @r#"m.toml, line 1, column 11, initial: it is the text "normal(0, 1)"; it must be a section: a line [initial], and lines below it"#);
}

#[test]
fn a_name_that_is_no_text() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(r#"name = "m""#, "name = 3")])), @"m.toml, line 1, column 8, name: it is the number 3; it must be text in quotes");
}

#[test]
fn a_kind_that_there_is_not() {
    insta::assert_snapshot!(refused(&(r#"kind = "linear"
"#.to_string() + FILE)), @r#"m.toml, line 1, column 8, kind: there is no kind `linear`; it must be "linear-gaussian", and is left out where there are formulas"#);
}

#[test]
fn a_measurement_that_is_a_number() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MEASURE, "y = 3")])), @r#"m.toml, line 9, column 5, [measurement] y: it is the number 3; it must be a distribution in quotes, as in "normal(3, 1)""#);
}

#[test]
fn a_formula_that_is_a_list() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, r#"x = ["normal(x, 1)"]"#)])), @"m.toml, line 7, column 5, [transition] x: it is a list; it must be a formula in quotes");
}

#[test]
fn a_key_with_a_point() {
    insta::assert_snapshot!(refused(&changed(FILE, &[(MOVE, r#"x.a = "normal(x, 1)""#)])), @"m.toml, line 7, column 1, [transition] x: it is a section; it must be a formula in quotes");
}

#[test]
fn a_parameter_that_is_a_formula() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", r#"q = "sqrt(2)""#)])), @r#"m.toml, line 3, column 5, [parameters] q: it is the text "sqrt(2)"; it must be a number, or a prior as in "normal(0, 1)"; formulas stand in [definitions]"#);
}

#[test]
fn a_parameter_that_is_no_number() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", "q = nan")])), @"m.toml, line 3, column 5, [parameters] q: it is the number nan; it must be a finite number");
}

#[test]
fn a_parameter_that_is_a_date() {
    insta::assert_snapshot!(refused(&changed(FILE, &[("q = 10.0", "q = 2020-01-01")])), @"m.toml, line 3, column 5, [parameters] q: it is a date or time; it must be a finite number");
}
