//! What formulas compute: the order of operations, and every function.

use super::helpers::value;

/// Catches an operator that binds otherwise than in mathematics.
#[test]
fn operators_bind_as_in_mathematics() {
    for (formula, expected) in [
        ("-x^2", -9.0),
        ("(-x)^2", 9.0),
        ("2^3^2", 512.0),
        ("2^-1", 0.5),
        ("x - 2 - 1", 0.0),
        ("x/2/2", 0.75),
        ("2 - -x", 5.0),
        ("-x*2", -6.0),
        ("+x", 3.0),
        ("2*x^2", 18.0),
        ("2^-x^2", 1.0 / 512.0),
        ("1 + 2*x - 4/2", 5.0),
        ("(1 + 2)*(x - 4)/2", -1.5),
        ("1_000 + 1e2 + 2.5E-1", 1100.25),
        ("--x", 3.0),
        ("x^0", 1.0),
        ("x^-2", 1.0 / 9.0),
        ("x^1", 3.0),
        ("t + x", 10.0),
        // A point needs digits on one side alone.
        (".5*x", 1.5),
        ("5. - x", 2.0),
        ("x*1.", 3.0),
        ("1.e1 + .2E1", 12.0),
        ("(x)-.5", 2.5),
    ] {
        assert_eq!(value(formula, 7, [3.0, 0.0]), expected, "{formula}");
    }
}

/// Catches a function under another's name, or with its arguments exchanged.
#[test]
fn functions_are_those_of_their_names() {
    let (x, y): (f64, f64) = (0.7, -1.9);
    for (formula, expected) in [
        ("sqrt(X)", x.sqrt()),
        ("exp(X)", x.exp()),
        ("log(X)", x.ln()),
        ("abs(Y)", 1.9),
        ("sin(X)", x.sin()),
        ("cos(X)", x.cos()),
        ("tan(X)", x.tan()),
        ("tanh(X)", x.tanh()),
        ("atan(X)", x.atan()),
        ("atan2(Y, X)", y.atan2(x)),
        ("min(X, Y)", y),
        ("max(X, Y)", x),
        ("floor(Y)", -2.0),
        ("pi*X", std::f64::consts::PI * x),
        ("X^Y", x.powf(y)),
        ("X^2.5", x.powf(2.5)),
        ("Y^3", y * y * y),
        ("Y^20", y.powi(20)),
        ("Y^-17", y.powi(-17)),
    ] {
        let found = value(&formula.replace('X', "x").replace('Y', "y"), 0, [x, y]);
        let allowed = 4.0 * f64::EPSILON * expected.abs();
        assert!((found - expected).abs() <= allowed, "{formula}: {found} for {expected}");
        // Of constants alone the parser knows the value, by the same arithmetic.
        let constant = formula.replace('X', "0.7").replace('Y', "(0 - 1.9)");
        let folded = value(&constant, 0, [f64::NAN, f64::NAN]);
        assert_eq!(folded.to_bits(), found.to_bits(), "{constant}");
    }
}

/// Division by zero and logarithms of 0 are those of floating-point numbers: nothing is repaired.
#[test]
fn nothing_is_repaired() {
    assert_eq!(value("1/x", 0, [0.0, 0.0]), f64::INFINITY);
    assert_eq!(value("log(x)", 0, [0.0, 0.0]), f64::NEG_INFINITY);
    assert!(value("x/y", 0, [0.0, 0.0]).is_nan());
    assert!(value("0*x", 0, [f64::INFINITY, 0.0]).is_nan());
    assert!(value("min(x, y)", 0, [f64::NAN, 0.0]).is_nan());
    assert!(value("x - x", 0, [f64::NAN, 0.0]).is_nan());
}
