//! Functions of one's own, against their formulas written out.

use motes_models::Step;

use super::helpers::{measurement, measuring, model, transition};

/// The mean of `z` at `x = 1.7`, `y = −0.4`, `t = 5`.
fn mean(formula: &str, more: &str) -> f64 {
    measurement(&measuring(&format!("normal({formula}, 1)"), more), 5, &[1.7, -0.4])[0].moments()[0]
}

#[test]
fn a_function_is_its_formula() {
    let functions = r#"
"logistic(x)" = "1/(1 + exp(-x))"
season(from, a) = "1 + a*cos(2*pi*(t - from)/12) + r*y"
"twice(u)" = "2*logistic(u) + half"
half = "square(x)/2"
"square(u)" = "u^2"
"mod(a, b)" = "a - b*floor(a/b) + 100"
[parameters]
r = 0.5
"#;
    let functions = format!("[definitions]{functions}");
    let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
    for (formula, expected) in [
        // Its argument, not the state of that name.
        ("logistic(y)", logistic(-0.4)),
        ("logistic(2*y - 1)", logistic(-1.8)),
        ("season(2, 0.3)", 1.0 + 0.3 * (std::f64::consts::PI / 2.0).cos() - 0.2),
        ("twice(logistic(x))", 2.0 * logistic(logistic(1.7)) + 1.7 * 1.7 / 2.0),
        // The file's own stands before the one that there is.
        ("mod(7, 3)", 101.0),
        ("if(x > 0, square(y), 0)*square(square(2))", 0.16 * 16.0),
    ] {
        let found = mean(formula, &functions);
        assert!((found - expected).abs() < 1e-15, "{formula}: {found}, {expected}");
    }
}

/// Catches an argument that is rounded where it is an index, and states that are not those of the section.
#[test]
fn arguments_can_be_indices_and_draws() {
    let neighbours = model(
        r#"
[parameters]
a = [1, 10, 100]
[initial]
x[3] = "normal(0, 1)"
[definitions]
"slope(k)" = "a[k]*(x[k+1] - x[k-1])"
"shrunk(u)" = "u/2"
[draws]
e = "normal(0, 1)"
[transition]
x[3] = "slope(i) + shrunk(e)"
[measurement]
y[3] = "normal(slope(i), 1)"
"#,
    );
    let x = [1.0, 2.0, 4.0];
    let slopes = [1.0 * (2.0 - 4.0), 10.0 * (4.0 - 1.0), 100.0 * (1.0 - 2.0)];
    let means: Vec<f64> = measurement(&neighbours, 0, &x).iter().map(|y| y.moments()[0]).collect();
    assert_eq!(means, slopes);
    // Its draw only.
    assert_eq!(transition(&neighbours, 1, &x).len(), 1);
}

#[test]
fn an_error_says_where_in_the_function() {
    let functions = "[definitions]\n\"root(u)\" = \"sqrt(u - 1)\"\nb = \"root(x) + 1\"";
    let text = |formula: &str, state: [f64; 2]| {
        measuring(formula, functions)
            .explain(&Step::of_index(3), None, Some(&state))
            .map(|error| error.to_string())
    };
    insta::assert_snapshot!(text("normal(root(x), 1)", [0.5, 0.0]).unwrap(), @"m.toml, line 10, [definitions] root(u): `sqrt(u - 1)` is NaN where u = 0.5");
    insta::assert_snapshot!(text("normal(b, 1)", [0.5, 0.0]).unwrap(), @"m.toml, line 10, [definitions] root(u): `sqrt(u - 1)` is NaN where u = 0.5");
    // What went wrong was its argument.
    insta::assert_snapshot!(text("normal(root(log(y)), 1)", [0.5, -2.0]).unwrap(), @"m.toml, line 8, [measurement] z: `log(y)` is NaN where y = -2");
    assert_eq!(text("normal(root(x), 1)", [1.5, 0.0]), None);
}

/// Catches recursion that nothing bounds, and work without end.
#[test]
fn calls_have_an_end() {
    let chain = |length: usize, body: fn(String) -> String| {
        let mut lines = String::from("[definitions]\n\"f0(u)\" = \"sin(u)\"\n");
        for level in 1..length {
            lines += &format!("\"f{level}(u)\" = \"{}\"\n", body(format!("f{}(u)", level - 1)));
        }
        format!(
            "[initial]\nx = \"normal(0, 1)\"\n{lines}[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(f{}(x), 1)\"\n",
            length - 1
        )
    };
    model(&chain(100, |call| call));
    let refused = |text: String| motes_formulas::parse(&text, "m.toml", &[]).unwrap_err().to_string();
    insta::assert_snapshot!(refused(chain(101, |call| call)), @"m.toml, line 104, column 1, [definitions] f100(u): functions call each other more than 100 deep; fewer would do");
    insta::assert_snapshot!(refused(chain(60, |call| format!("{call}*{call} + 1"))), @"m.toml, line 5, column 12, [definitions] f1(u): up to here the formulas come to more than 2000000 operations; shorter vectors would do");
}
