//! Vectors: coordinates by index, modulo the length.

use motes_formulas::parse;
use motes_models::equations::normal;

use super::helpers::{measurement, model, transition};

const LORENZ: &str = r#"
[parameters]
h = 0.05
step = 2
[initial]
x[40] = "normal(i, 3)"
s = "normal(0, 1)"
[definitions]
d[40] = "x[i+1] - x[i-2]"
[transition]
s = "normal(s + x[-1], 1)"
x[40] = "normal(x[i] + h*(d[i]*x[i-1] - x[i] + 8) + s, 0.5)"
[measurement]
first = "normal(x[0], 1)"
y[20] = "normal(x[step*i + 1 - (3 - 2)], i + 1)"
last = "normal(d[39] + x[-1] + x[40], 1)"
"#;

/// Catches an index that ends at the end of the vector, or names that are not those of headers.
#[test]
fn indices_go_round() {
    let file = parse(LORENZ, "lorenz.toml", &[]).unwrap();
    assert_eq!((file.states.len(), file.measurements.len()), (41, 22));
    assert_eq!([&file.states[0], &file.states[39], &file.states[40]], ["x[0]", "x[39]", "s"]);
    assert_eq!(
        [&file.measurements[0], &file.measurements[1], &file.measurements[21]],
        ["first", "y[0]", "last"]
    );

    let model = model(LORENZ);
    let x: Vec<f64> = (0..41).map(|i| (1.7 * f64::from(i)).sin()).collect();
    let moved = transition(&model, 1, &x);
    for i in 0..40 {
        let [next, before, last] = [x[(i + 1) % 40], x[(i + 38) % 40], x[(i + 39) % 40]];
        let mean = x[i] + ((next - before) * last - x[i] + 8.0) * 0.05 + x[40];
        assert_eq!(moved[i], normal(mean, 0.5), "coordinate {i}");
    }
    assert_eq!(moved[40], normal(x[40] + x[39], 1.0));
    let measured = measurement(&model, 1, &x);
    assert_eq!(measured[0], normal(x[0], 1.0));
    for i in 0..20 {
        assert_eq!(measured[1 + i], normal(x[2 * i], 1.0 + i as f64), "entry {i}");
    }
    assert_eq!(measured[21], normal(x[0] - x[37] + x[39] + x[0], 1.0));
}

/// An index by a parameter follows it.
#[test]
fn parameters_in_indices_can_be_set() {
    let set = parse(LORENZ, "lorenz.toml", &[("step".to_string(), -1.0)]).unwrap();
    let motes_formulas::FileModel::Formulas(model) = set.model else { panic!("there are formulas") };
    let x: Vec<f64> = (0..41).map(f64::from).collect();
    assert_eq!(measurement(&model, 0, &x)[3], normal(38.0, 3.0));
}

/// Keys with their own quotes are the same keys.
#[test]
fn quotes_around_a_key_are_allowed() {
    let quoted = LORENZ.replace("\nx[40] =", "\n\"x[40]\" =").replace("y[20] =", "'y[20]' =");
    assert_eq!(parse(&quoted, "m.toml", &[]).unwrap().states, parse(LORENZ, "m.toml", &[]).unwrap().states);
}

/// Keys of vectors are no TOML until they are quoted: what an error says of a place is counted in the text as it was written.
#[test]
fn errors_behind_keys_of_vectors_are_where_they_stand() {
    let text = "[parameters]\nn = 2\n[definitions]\n\"f(x)\" = \"3*x\"\n[initial]\n  x[40] = \"normal(0, 1)\"\n[transition]\nx[40] = \"normal(x[i], 1)\"\n[measurement]\ny[n] = \"normal(x[i] + z, 1)\"\n";
    let error = motes_formulas::parse(text, "m.toml", &[]).unwrap_err().to_string();
    assert!(
        error.starts_with("m.toml, line 10, column 23, [measurement] y[n]: `z` is not known here"),
        "{error}"
    );
}

#[test]
fn a_name_that_is_near_is_suggested() {
    let advice = |name: &str| {
        let text = format!(
            "[definitions]\ndrift = \"1\"\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal({name}, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n"
        );
        motes_formulas::parse(&text, "m.toml", &[]).unwrap_err().to_string()
    };
    assert!(advice("drfit").ends_with("did you mean `drift`?"));
    assert!(advice("Drift").ends_with("did you mean `drift`?"));
    // A name of one letter is near to every other one.
    for far in ["q", "volatility"] {
        assert!(!advice(far).contains("did you mean"), "{far}");
    }
}

/// `x[1]` is one coordinate where the one before it has a line, and a vector of one coordinate elsewhere.
#[test]
fn coordinates_may_have_a_line_each() {
    let one_by_one = model(
        "[initial]\nx[4] = 1\n[transition]\nx[0] = \"x[3]\"\nx[1] = \"normal(x[0], 1)\"\nx[2..3] = \"x[i-1]\"\nx[3] = \"normal(2*x[i], 3)\"\n[measurement]\ny[0] = \"normal(x[1], 1)\"\ny[1] = \"normal(x[2], 2)\"\n",
    );
    let moved = transition(&one_by_one, 1, &[1.0, 2.0, 3.0, 4.0]);
    assert_eq!(moved, [normal(1.0, 1.0), normal(8.0, 3.0)]);
    assert_eq!(measurement(&one_by_one, 1, &[1.0, 2.0, 3.0, 4.0]), [normal(2.0, 1.0), normal(3.0, 2.0)]);
    let of_one = parse(
        "[initial]\nx[1] = 1\n[transition]\nx[1] = 1\n[measurement]\ny = \"normal(x[0], 1)\"\n",
        "m.toml",
        &[],
    );
    assert_eq!(of_one.unwrap().states, ["x[0]"]);
}
