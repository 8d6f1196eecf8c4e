//! Files of matrices: catches a shape, an entry or a covariance that no model has.

use super::{MATRICES, changed, refused};

#[test]
fn a_matrix_that_is_missing() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[(r#"R = [[0.5]]
"#, "")])), @"m.toml: there is no R; it is needed: the covariance of the measurement's noise, as in R = [[1.0]]");
}

#[test]
fn a_matrix_that_is_a_number() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("R = [[0.5]]", "R = 0.5")])), @"m.toml, line 9, column 5, R: it is the number 0.5; it must be a list of 1 row of 1 number, as there are 2 states and 1 measurement; rows are lists");
}

#[test]
fn a_matrix_with_a_row_too_few() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("A = [[1, 0.1], [0, 1]]", "A = [[1, 0.1]]")])), @"m.toml, line 6, column 5, A: it has 1 row; it must have 2 rows of 2 numbers, as there are 2 states and 1 measurement");
}

#[test]
fn a_row_that_is_too_short() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("A = [[1, 0.1], [0, 1]]", "A = [[1, 0.1], [0]]")])), @"m.toml, line 6, column 16, A: it has 1 number; it must have 2, as there are 2 states and 1 measurement");
}

#[test]
fn an_entry_that_is_text() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("A = [[1, 0.1], [0, 1]]", r#"A = [[1, "a"], [0, 1]]"#)])), @r#"m.toml, line 6, column 10, A: `a` is not known here; an entry is a number, or a formula of numbers and of [parameters]"#);
}

#[test]
fn an_entry_that_is_infinite() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("C = [[1, 0]]", "C = [[1, inf]]")])), @"m.toml, line 8, column 10, C: it is the number inf; it must be a finite number, or a formula of parameters in quotes");
}

#[test]
fn a_covariance_that_is_not_symmetric() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("Q = [[0.1, 0], [0, 0.1]]", "Q = [[0.1, 0.05], [0, 0.1]]")])), @"m.toml, line 7, column 5, Q: it differs from its transpose by 5.00e-2 at row 1, column 0; it must be symmetric");
}

#[test]
fn a_covariance_that_is_not_positive() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("R = [[0.5]]", "R = [[-0.5]]")])), @"m.toml, line 9, column 5, R: it has the smallest eigenvalue -5.00e-1; it must be positive semi-definite");
}

#[test]
fn a_mean_that_is_too_long() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("m0 = [0, 0]", "m0 = [0, 0, 0]")])), @"m.toml, line 4, column 6, m0: it has 3 numbers; it must have 2, as there are 2 states and 1 measurement");
}

#[test]
fn a_name_that_is_there_twice() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[(r#"["p", "v"]"#, r#"["p", "p"]"#)])), @r#"m.toml, line 2, column 16, states: the name "p" is there twice; each must differ"#);
}

#[test]
fn a_name_of_a_state_and_a_measurement() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[(r#"["y"]"#, r#"["p"]"#)])), @"m.toml, line 3, column 16, measurements: `p` stands in states, too; a name can mean one thing only");
}

#[test]
fn no_names() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[(r#"["p", "v"]"#, "[]")])), @"m.toml, line 2, column 10, states: the list is empty; there must be at least one name");
}

#[test]
fn names_that_are_no_list() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[(r#"["y"]"#, r#""y""#)])), @r#"m.toml, line 3, column 16, measurements: it is the text "y"; it must be a list of names, as in ["position", "speed"]"#);
}

#[test]
fn a_section_of_formulas() {
    insta::assert_snapshot!(refused(&(MATRICES.to_string() + r#"[transition]
x = "normal(x, 1)"
"#)), @r#"m.toml, line 10, column 2: a model file has no `transition` here; of kind "linear-gaussian" it has name, states, measurements, m0, P0, A, Q, C, R, b, B, d, D, S, [parameters], [inputs], [series]"#);
}

#[test]
fn inputs_that_are_not_declared() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("C = ", "D = [[1]]\nC = ")])), @r#"m.toml, line 8, column 5, D: there is no [inputs]; it is needed: it names what B and D multiply, column by column, as in u = "hold""#);
}

#[test]
fn inputs_that_nothing_multiplies() {
    insta::assert_snapshot!(refused(&format!("{MATRICES}[inputs]\nu = \"hold\"\n")), @"m.toml: there is no B or D; it is needed: what an input adds to states or measurements, as in D = [[1.0]]");
}

#[test]
fn inputs_with_another_number_of_columns() {
    insta::assert_snapshot!(refused(&format!("{}[inputs]\nu = \"hold\"\n", changed(MATRICES, &[("C = ", "D = [[1, 2]]\nC = ")]))), @"m.toml, line 8, column 6, D: it has 2 numbers; it must have 1, as there are 2 states and 1 measurement, and 1 input");
}

#[test]
fn noise_that_is_shared_too_much() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("C = ", "S = [[0.3], [0]]\nC = ")])), @"m.toml, line 8, column 5, S: with Q and R it makes the covariance [[Q, S], [Sᵀ, R]], which has the smallest eigenvalue -6.06e-2; it must be positive semi-definite");
}

#[test]
fn an_entry_that_is_a_distribution() {
    insta::assert_snapshot!(refused(&changed(MATRICES, &[("A = [[1, 0.1], [0, 1]]", r#"A = [[1, "normal(0, 1)"], [0, 1]]"#)])), @r#"m.toml, line 6, column 10, A: it is the text "normal(0, 1)"; it must be a number, or a formula of numbers and parameters"#);
}
