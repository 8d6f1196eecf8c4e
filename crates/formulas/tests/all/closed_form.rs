//! Where the best proposal has a closed form.

use super::helpers::model;

/// A model of two states with these formulas.
fn why_not(transition: &str, measurement: &str) -> Option<String> {
    let text = format!(
        "[parameters]\na = 0.5\n[initial]\nx = \"normal(0, 1)\"\ny = \"normal(0, 1)\"\n[definitions]\nd = \"3*x - y/a + t\"\n\
         [transition]\nx = \"{transition}\"\ny = \"normal(y, 1)\"\n[measurement]\nz = \"{measurement}\"\n"
    );
    model(&text).closed_form().err().map(|error| error.to_string())
}

/// Catches one that is refused though it is linear.
#[test]
fn what_is_linear_has_one() {
    let moves = "normal(sin(x)*y, 1 + x^2)";
    for measurement in [
        "normal(x, 1)",
        "normal(2*x - (y + 3)/4, a)",
        "-d + 2*normal(d*cos(t), exp(a*t))",
        "normal(3, 1)",
        "normal(x*a^2 - -y, 1)",
    ] {
        assert_eq!(why_not(moves, measurement), None, "{measurement}");
    }
}

/// Catches one that is granted though it is not, and the wrong line.
#[test]
fn the_line_that_is_not_is_named() {
    let linear = "normal(x, 1)";
    insta::assert_snapshot!(why_not("laplace(x, 1)", linear).unwrap(), @"m.toml, line 9, [transition] x: `laplace` is not normal; the closed form is for normal distributions");
    insta::assert_snapshot!(why_not(linear, "poisson(exp(x))").unwrap(), @"m.toml, line 12, [measurement] z: `poisson` is not normal; the closed form is for normal distributions");
    insta::assert_snapshot!(why_not(linear, "normal(x*y, 1)").unwrap(), @"m.toml, line 12, [measurement] z: the mean of `normal(x*y, 1)` is not linear in the states; the closed form needs it to be");
    insta::assert_snapshot!(why_not(linear, "normal(x, abs(y))").unwrap(), @"m.toml, line 12, [measurement] z: the standard deviation of `normal(x, abs(y))` depends on states; in the closed form it does not");
    insta::assert_snapshot!(why_not(linear, "y*normal(x, 1)").unwrap(), @"m.toml, line 12, [measurement] z: the mean of `y*normal(x, 1)` is not linear in the states; the closed form needs it to be");
    for other in ["1/d", "d^2", "abs(x)", "max(x, y)", "x + 2^y", "a/x"] {
        assert!(why_not(linear, &format!("normal({other}, 1)")).is_some(), "{other}");
    }
}

/// Catches one that is granted though draws stand before the state.
#[test]
fn draws_stand_in_the_way() {
    let drawn = model(
        "[initial]\nx = \"normal(0, 1)\"\n[draws]\ns = \"gamma(2, 1)\"\n[transition]\nx = \"normal(x, s)\"\n[measurement]\ny = \"normal(x, 1)\"\n",
    );
    insta::assert_snapshot!(drawn.closed_form().unwrap_err().to_string(), @"m.toml, line 4, [draws] s: `gamma(2, 1)` is drawn apart from the coordinates; in the closed form each coordinate has its own distribution");
}
