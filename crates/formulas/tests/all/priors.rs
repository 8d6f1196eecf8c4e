//! Parameters with priors: starts against quantiles, densities against integrals, draws against densities.

use motes_formulas::{FileModel, FormulaModel, Origin, Prior, parse};
use motes_models::{Seed, StateSpaceModel, Step};

/// A model with parameters.
fn with(parameters: &str, set: &[(String, f64)]) -> FormulaModel {
    let text = format!(
        "[parameters]\n{parameters}\n[initial]\nx = \"normal(0, 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n"
    );
    match parse(&text, "m.toml", set).unwrap_or_else(|error| panic!("{error}\n{text}")).model {
        FileModel::Formulas(model) => model,
        FileModel::LinearGaussian(_) => panic!("the file has matrices"),
    }
}

fn prior(text: &str) -> Prior {
    with(&format!("a = 2\nq = \"{text}\""), &[]).frame().priors()[0].clone()
}

/// Priors with their medians.
const MEDIANS: [(&str, f64); 15] = [
    ("normal(a, 3)", 2.0),
    ("log_normal(log(30), 0.7)", 30.0),
    ("uniform(-1, a)", 0.5),
    ("1 + 3*exponential(1)", 1.0 + 3.0 * std::f64::consts::LN_2),
    ("5 - gamma(2, 1)", 5.0 - 1.678_346_990_016_661),
    ("inverse_gamma(2, 3)", 3.0 / 1.678_346_990_016_661),
    ("half_normal(a)", 2.0 * 0.674_489_750_196_081_7),
    ("half_cauchy(a)", 2.0),
    ("truncated(normal(0, 1), 0, inf)", 0.674_489_750_196_081_7),
    ("truncated(normal(0, 1), -inf, a - 2)", -0.674_489_750_196_081_7),
    ("truncated(exponential(1), 1, inf)", 1.0 + std::f64::consts::LN_2),
    ("truncated(inverse_gamma(2, 3), 0, 1e9)", 3.0 / 1.678_346_990_016_661),
    ("truncated(uniform(0, 10), 2, 3)", 2.5),
    ("truncated(truncated(uniform(0, 10), 2, 30), -1, 4)", 3.0),
    ("truncated(normal(0, 1), 6, inf)", 6.111_565_061_813_438),
];

/// Catches a median that is a mean, and a distribution that is scaled before it is shifted.
#[test]
fn a_start_is_the_median() {
    for (text, expected) in MEDIANS {
        let prior = prior(text);
        let [found] = prior.start() else { panic!("one number") };
        assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{text}: {found}, {expected}");
        assert_eq!(prior.origin(), Origin::Median);
    }
    assert_eq!(prior("poisson(2.7)").start(), [3.0]);
}

/// Of a density: half of it lies below the median, and all of it where the prior says.
#[test]
fn densities_integrate_to_one() {
    for (text, median) in MEDIANS {
        let prior = prior(text);
        // Simpson's rule for x = median + sinh z.
        let integral = |from: f64, to: f64| {
            const PIECES: usize = 40_000;
            let width = (to - from) / PIECES as f64;
            let value = |at: usize| {
                let z = from + width * at as f64;
                let density = prior.log_density(&[median + z.sinh()]).exp() * z.cosh();
                density * if at == 0 || at == PIECES { 1.0 } else { 2.0 + 2.0 * (at % 2) as f64 }
            };
            (0..=PIECES).map(value).sum::<f64>() * width / 3.0
        };
        for half in [integral(-18.0, 0.0), integral(0.0, 18.0)] {
            // Ends of the range lie between the points.
            assert!((half - 0.5).abs() < 1e-3, "{text}: {half}");
        }
    }
}

#[test]
fn draws_lie_below_the_median_half_of_the_time() {
    let mut stream = Seed::from_u64(1).stream();
    for (text, median) in MEDIANS {
        let prior = prior(text);
        let drawn: Vec<f64> = (0..4000).map(|_| prior.sample(&mut stream)[0]).collect();
        let below = drawn.iter().filter(|value| **value < median).count();
        assert!((below as f64 - 2000.0).abs() < 160.0, "{text}: {below} of 4000");
        assert!(drawn.iter().all(|value| prior.log_density(&[*value]) > f64::NEG_INFINITY), "{text}");
        let inside = |value: &f64| prior.support().is_none_or(|support| support.has(*value));
        assert!(drawn.iter().all(inside), "{text}: {:?}", prior.support());
    }
}

#[test]
fn supports_are_in_words() {
    let words = |text| prior(text).support().map_or("any".to_string(), |support| support.to_string());
    insta::assert_snapshot!(words("half_normal(1)"), @"it must be at least 0");
    insta::assert_snapshot!(words("5 - gamma(2, 1)"), @"it must be below 5");
    insta::assert_snapshot!(words("truncated(gamma(2, 1), -inf, 4)"), @"it must lie from 0 (not itself) to 4");
    insta::assert_snapshot!(words("binomial(7, 0.5)"), @"a count is a whole number from 0 to 7");
    insta::assert_snapshot!(words("inverse_gamma(2, 1)"), @"it must be above 0");
    insta::assert_snapshot!(words("student_t(4, 0, 1)"), @"any");
}

#[test]
fn shares_are_a_list() {
    let model = with("share = \"dirichlet(3, 0.1, 0.1, 96.8)\"\nb = \"uniform(0, 1)\"", &[]);
    let [share, b] = model.frame().priors() else { panic!("two priors") };
    assert_eq!(share.entries(), ["share[0]", "share[1]", "share[2]", "share[3]"]);
    assert_eq!((share.start(), share.origin()), (&[0.03, 0.001, 0.001, 0.968][..], Origin::Mean));
    assert_eq!((b.name(), b.text()), ("b", "uniform(0, 1)"));
    let mut stream = Seed::from_u64(2).stream();
    let mut mean = 0.0;
    for _ in 0..2000 {
        let drawn = share.sample(&mut stream);
        assert!((drawn.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        mean += drawn[0] / 2000.0;
    }
    assert!((mean - 0.03).abs() < 0.002, "{mean}");
    // B(2, 3) = 1/12.
    let two = with("p = \"dirichlet(2, 3)\"", &[]).frame().priors()[0].clone();
    assert!((two.log_density(&[0.3, 0.7]) - (12.0_f64 * 0.3 * 0.49).ln()).abs() < 1e-12);
    assert_eq!(two.log_density(&[0.3, 0.6]), f64::NEG_INFINITY);
}

/// Catches an entry that stays a number, or takes the place of another, and a prior above a list that sees one with priors as numbers.
#[test]
fn an_entry_of_a_list_has_a_prior_of_its_own() {
    let text = "a = [\"normal(1, 2)\", 0.3, { prior = \"uniform(0, 1)\", start = 0.25 }]\nb = \"half_normal(1)\"\ng = [[0.5, \"beta(2, 2)\"], [1, 2]]";
    let model = with(text, &[]);
    let names: Vec<&str> = model.frame().priors().iter().map(Prior::name).collect();
    assert_eq!(names, ["a[0]", "a[2]", "b", "g[0,1]"]);
    assert_eq!(model.frame().priors()[0].entries(), ["a[0]"]);
    let starts: Vec<f64> = model.frame().priors().iter().map(|prior| prior.start()[0]).collect();
    assert_eq!((starts[0], starts[1], starts[3]), (1.0, 0.25, 0.5));
    let set = [("a[2]".to_string(), 0.75)];
    let origins: Vec<Origin> = with(text, &set).frame().priors().iter().map(Prior::origin).collect();
    assert_eq!(origins, [Origin::Median, Origin::Set, Origin::Median, Origin::Median]);
    // What a formula makes of them.
    let file = format!(
        "[parameters]\n{text}\n[initial]\nx = \"normal(a[0] + a[2] + g[0, 1], 1)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n"
    );
    let read = |set: &[(String, f64)]| parse(&file, "m.toml", set).unwrap();
    let parameters = read(&set).parameters;
    let value = |name: &str| parameters.iter().find(|(known, _)| known == name).unwrap().1;
    assert_eq!([value("a[0]"), value("a[1]"), value("a[2]"), value("g[0,1]")], [1.0, 0.3, 0.75, 0.5]);
    let FileModel::Formulas(model) = read(&set).model else { panic!("it has formulas") };
    let [at_mean, beside] =
        [2.25, 3.25].map(|x| model.density().unwrap().log_density(&Step::of_index(0), None, &[x]));
    assert!((at_mean - beside - 0.5).abs() < 1e-12, "{at_mean} {beside}");
}

/// Catches a prior that does not see what a parameter is set to, and a start that hides such a value.
#[test]
fn values_from_outside_come_first() {
    let text = "a = 2\nr = \"normal(a, 1)\"\nrho = { prior = \"uniform(0, 1)\", start = 0.7 }\ns = { prior = \"dirichlet(1, 1)\", start = [0.25, 0.75] }";
    let values = |set: &[(&str, f64)]| {
        let set: Vec<(String, f64)> = set.iter().map(|(name, value)| (name.to_string(), *value)).collect();
        let model = with(text, &set);
        let of = |prior: &Prior| (prior.start().to_vec(), prior.origin());
        model.frame().priors().iter().map(of).collect::<Vec<_>>()
    };
    let given = [(vec![0.7], Origin::Given), (vec![0.25, 0.75], Origin::Given)];
    assert_eq!(values(&[]), [vec![(vec![2.0], Origin::Median)], given.to_vec()].concat());
    assert_eq!(values(&[("a", 5.0)])[0], (vec![5.0], Origin::Median));
    assert_eq!(values(&[("r", -1.0)])[0], (vec![-1.0], Origin::Set));
    assert_eq!(values(&[("s[1]", 0.5)])[2], (vec![0.25, 0.5], Origin::Set));
    let file = "[parameters]\nq = \"half_normal(1)\"\n[initial]\nx = \"normal(0, q)\"\n[transition]\nx = \"normal(x, 1)\"\n[measurement]\ny = \"normal(x, 1)\"\n";
    assert_eq!(parse(file, "m.toml", &[("q".into(), 3.0)]).unwrap().parameters, [("q".to_string(), 3.0)]);
}
