//! Files that are refused, each by one line that says where and what would be right.

mod files;
mod formulas;
mod functions;
mod matrices;
mod names;
mod noise;
mod overrides;
mod paths;
mod priors;
mod times;
mod vectors;
mod wrapped;

use motes_formulas::parse;

/// A file that is fine.
const FILE: &str = r#"name = "m"
[parameters]
q = 10.0
[initial]
x = "normal(0, 1)"
[transition]
x = "normal(x, q)"
[measurement]
y = "normal(x, 1)"
"#;

/// Lines of [`FILE`].
const START: &str = r#"x = "normal(0, 1)""#;
const MOVE: &str = r#"x = "normal(x, q)""#;
const MEASURE: &str = r#"y = "normal(x, 1)""#;

/// A file of vectors that is fine.
const VECTOR: &str = r#"name = "m"
[parameters]
q = 10.0
[initial]
x[40] = "normal(0, 1)"
[transition]
x[40] = "normal(x[i], 1)"
[measurement]
y = "normal(x[0], 1)"
"#;

/// A file of matrices that is fine.
const MATRICES: &str = r#"kind = "linear-gaussian"
states = ["p", "v"]
measurements = ["y"]
m0 = [0, 0]
P0 = [[1, 0], [0, 1]]
A = [[1, 0.1], [0, 1]]
Q = [[0.1, 0], [0, 0.1]]
C = [[1, 0]]
R = [[0.5]]
"#;

/// The error of a text.
fn refused(text: &str) -> String {
    match parse(text, "m.toml", &[]) {
        Ok(_) => panic!("it was accepted:\n{text}"),
        Err(error) => {
            assert!(!error.is_io(), "{error}");
            error.to_string()
        }
    }
}

/// A text with parts replaced, each of which must be there.
fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_string(), |text, (from, to)| {
        assert!(text.contains(from), "{from} is not in\n{text}");
        text.replace(from, to)
    })
}

/// [`FILE`] with another formula of the state.
fn transition(formula: &str) -> String {
    changed(FILE, &[(MOVE, &format!("x = \"{formula}\""))])
}

/// [`FILE`] with another formula of the state at the start.
fn initial(formula: &str) -> String {
    changed(FILE, &[(START, &format!("x = \"{formula}\""))])
}

/// [`FILE`] with another formula of the measurement.
fn measurement(formula: &str) -> String {
    changed(FILE, &[(MEASURE, &format!("y = \"{formula}\""))])
}

/// [`FILE`] with definitions.
fn definitions(lines: &str) -> String {
    changed(FILE, &[("[transition]", &format!("[definitions]\n{lines}\n[transition]"))])
}

/// [`VECTOR`] with another formula of the state.
fn vector(formula: &str) -> String {
    changed(VECTOR, &[("\"normal(x[i], 1)\"", &format!("\"{formula}\""))])
}

/// The files above are models: what is refused is refused for what was changed.
#[test]
fn nothing_is_wrong_before_the_change() {
    for text in [FILE, VECTOR, MATRICES] {
        parse(text, "m.toml", &[]).unwrap();
    }
}
