//! Why a formula gives no number.

use motes_formulas::FileModel;
use motes_models::Step;

use super::helpers::model;

const FILE: &str = r#"
[parameters]
c = 2.0
[initial]
x = "normal(0, 1)"
v[3] = "normal(0, exp(1))"
[definitions]
root = "1 + sqrt(x - c)"
[transition]
x = "normal(max(x, 0)/t, 1 + root)"
v[3] = "normal(v[i], v[i+1])"
[measurement]
y = "(x - 1)*exponential(x) + log(v[0])"
k = "binomial(10, x/4)"
u = "uniform(x, 3)"
"#;

fn explained(previous: Option<&[f64]>, state: Option<&[f64]>) -> Option<String> {
    model(FILE).explain(&Step::of_index(2), previous, state).map(|error| error.to_string())
}

/// Catches an error where all is fine, as at a measurement that was not asked for.
#[test]
fn what_is_fine_has_no_error() {
    assert_eq!(explained(None, None), None);
    assert_eq!(explained(Some(&[3.0, 1.0, 1.0, 1.0]), Some(&[2.0, 1.0, 1.0, 1.0])), None);
    assert_eq!(explained(Some(&[3.0, 1.0, 1.0, 1.0]), None), None);
}

/// Catches a place that is only on the way, and values of another particle.
#[test]
fn the_operation_is_named_with_its_values() {
    let fine = [3.0, 1.0, 1.0, 1.0];
    insta::assert_snapshot!(explained(Some(&[1.5, 1.0, 1.0, 1.0]), None).unwrap(), @"m.toml, line 8, [definitions] root: `sqrt(x - c)` is NaN where x = 1.5, c = 2");
    insta::assert_snapshot!(explained(Some(&[3.0, 1.0, 1.0, -0.5]), None).unwrap(), @"m.toml, line 11, [transition] v[1]: sd, `v[i+1]`, is -0.5 where v[2] = -0.5, i = 1; it must be above 0");
    insta::assert_snapshot!(explained(Some(&fine), Some(&[2.0, -1.0, 1.0, 1.0])).unwrap(), @"m.toml, line 13, [measurement] y: `log(v[0])` is NaN where v[0] = -1");
    insta::assert_snapshot!(explained(Some(&fine), Some(&[1.0, 1.0, 1.0, 1.0])).unwrap(), @"m.toml, line 13, [measurement] y: the factor, `(x - 1)`, is 0 where x = 1; it must be another number than 0");
    insta::assert_snapshot!(explained(Some(&fine), Some(&[3.5, 1.0, 1.0, 1.0])).unwrap(), @"m.toml, line 15, [measurement] u: high, `3`, is 3; it must be above low, which is 3.5");
    insta::assert_snapshot!(explained(Some(&fine), Some(&[6.0, 1.0, 1.0, 1.0])).unwrap(), @"m.toml, line 14, [measurement] k: p, `x/4`, is 1.5 where x = 6; it must be between 0 and 1");
    insta::assert_snapshot!(explained(Some(&fine), Some(&[f64::NAN, 1.0, 1.0, 1.0])).unwrap(), @"m.toml, line 13, [measurement] y: `x` is NaN");
}

/// What is NaN is why a weight is none; what is infinite is named only where nothing is NaN.
#[test]
fn the_infinite_comes_last() {
    let fine = [3.0, 1.0, 1.0, 1.0];
    insta::assert_snapshot!(explained(Some(&fine), Some(&[2.0, 0.0, 1.0, 1.0])).unwrap(), @"m.toml, line 13, [measurement] y: `log(v[0])` is -inf where v[0] = 0");
    insta::assert_snapshot!(explained(Some(&fine), Some(&[6.0, 0.0, 1.0, 1.0])).unwrap(), @"m.toml, line 14, [measurement] k: p, `x/4`, is 1.5 where x = 6; it must be between 0 and 1");
}

/// States of another model give an error, not a panic.
#[test]
fn states_that_are_too_few_are_no_panic() {
    assert!(explained(Some(&[]), Some(&[])).is_some());
}

/// Lines of a text that a program wrote are nobody's: neither a text that is none, nor a formula at run time, nor the closed form speaks of them.
#[test]
fn a_text_of_a_program_has_no_lines() {
    let parse = |text: &str| motes_formulas::parse_generated(text, "model", &[]);
    let FileModel::Formulas(model) = parse(FILE).unwrap().model else { panic!("there are no matrices") };
    let error = model.explain(&Step::of_index(2), Some(&[3.0, 1.0, 1.0, -0.5]), None).unwrap();
    insta::assert_snapshot!(error.to_string(), @"model, [transition] v[1]: sd, `v[i+1]`, is -0.5 where v[2] = -0.5, i = 1; it must be above 0");
    let error = model.closed_form().unwrap_err();
    insta::assert_snapshot!(error.to_string(), @"model, [measurement] y: `exponential` is not normal; the closed form is for normal distributions");
    let error = parse(&FILE.replace("max(x, 0)", "z")).unwrap_err();
    assert!(error.to_string().starts_with("model, [transition] x: `z` is not known here"), "{error}");
}

/// Catches a distribution of another state or another entry, and numbers in place of the random part.
#[test]
fn a_distribution_is_written_with_its_numbers() {
    let model = model(FILE);
    let at = |entry| model.distribution_at(&Step::of_index(2), &[2.0, 1.0, 1.0, 1.0], entry);
    insta::assert_snapshot!(at(0).unwrap(), @"1 * exponential(2) + 0");
    insta::assert_snapshot!(at(1).unwrap(), @"binomial(10, 0.5)");
    assert_eq!(at(3), None);
    let text = "[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny[2] = \"rounded(mixture(0.1*i, normal(1e6*x, 2/3), normal(x, 1)))\"\nz = \"log_density(-(z - x)^2)\"\n";
    let model = super::helpers::model(text);
    let at = |entry| model.distribution_at(&Step::of_index(2), &[2e6], entry);
    insta::assert_snapshot!(at(1).unwrap(), @"rounded(mixture(0.1, normal(2e12, 0.666667), normal(2000000, 1)))");
    insta::assert_snapshot!(at(2).unwrap(), @"log_density(-(z - x)^2)");
}

/// Catches what follows from a draw that is NaN in place of the draw.
#[test]
fn a_count_that_floating_point_does_not_have_is_named_by_its_draw() {
    let text = "[initial]\nx = \"normal(0, 1)\"\nn = 0\n[draws]\nk = \"poisson(exp(x + 45))\"\n[transition]\nx = \"normal(x, 1)\"\nn = \"k\"\n[measurement]\ny = \"normal(n, 1)\"\n";
    let model = super::helpers::model(text);
    let explained = |x: f64| {
        let error = model.explain(&Step::of_index(1), Some(&[x, 0.0]), Some(&[x, f64::NAN]));
        error.unwrap().to_string()
    };
    insta::assert_snapshot!(explained(0.0), @"m.toml, line 5, [draws] k: mean, `exp(x + 45)`, is 3.4934271057485095e19 where x = 0; it must be at most 9.2e18, beyond which counts are not drawn");
    // A mean that can be drawn from is not to blame.
    insta::assert_snapshot!(explained(-10.0), @"m.toml, line 10, [measurement] y: `n` is NaN");
}
