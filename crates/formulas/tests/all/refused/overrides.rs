//! Parameters set from outside: catches one that is set to nothing, or a name that is silently ignored.

use motes_formulas::parse;

use super::{FILE, MATRICES, START, changed};

fn refused(text: &str, name: &str, value: f64) -> String {
    parse(text, "m.toml", &[(name.to_string(), value)]).unwrap_err().to_string()
}

#[test]
fn a_parameter_that_there_is_not() {
    insta::assert_snapshot!(refused(FILE, "sigma", 1.0), @"m.toml: there is no parameter `sigma` to set; there are q");
    insta::assert_snapshot!(refused(FILE, "Q", 1.0), @"m.toml: there is no parameter `Q` to set; did you mean `q`?");
    let none = changed(FILE, &[("[parameters]\nq = 10.0\n", ""), ("q)", "1)")]);
    insta::assert_snapshot!(refused(&none, "q", 1.0), @"m.toml: there is no parameter `q` to set; the file has no [parameters]");
    insta::assert_snapshot!(refused(MATRICES, "q", 1.0), @r#"m.toml: there is no parameter `q` to set; a file of kind "linear-gaussian" has none"#);
}

#[test]
fn a_value_that_is_no_number() {
    insta::assert_snapshot!(refused(FILE, "q", f64::NAN), @"m.toml: the parameter `q` is set to NaN; it must be a finite number");
    insta::assert_snapshot!(refused(FILE, "q", f64::INFINITY), @"m.toml: the parameter `q` is set to inf; it must be a finite number");
}

#[test]
fn a_value_out_of_range_where_it_is_used() {
    insta::assert_snapshot!(refused(FILE, "q", -1.0), @"m.toml, line 7, column 6, [transition] x: the sd of normal(mean, sd) is -1; it must be above 0");
    let vector = changed(
        FILE,
        &[(START, r#"x[q] = "normal(0, 1)""#), ("x = \"normal(x", "x[q] = \"normal(x[i]"), ("(x,", "(x[0],")],
    );
    assert_eq!(parse(&vector, "m.toml", &[("q".to_string(), 3.0)]).unwrap().states, ["x[0]", "x[1]", "x[2]"]);
    insta::assert_snapshot!(refused(&vector, "q", 0.5), @"m.toml, line 5, column 1, [initial] x[q]: `q` is no length of a vector; it must be an integer from 1 to 10000, or a parameter that is one");
}
