//! Measurements whose distributions are made of others: each is the one of the same name in Rust, and what no state can give is said.

use motes_formulas::FormulaModel;
use motes_models::batch::LANES;
use motes_models::equations::{Dual, Lanes, Linearise, Scalar, Wrapped, gamma, normal, poisson, student_t};
use motes_models::{Seed, Simulator, StateGradients, StateSpaceModel, Step};

use super::helpers::{bits, measuring};

/// The same in Rust, where the states are `x`, which is positive, and 0.
fn density<S: Scalar>(formula: &str, x: S, at: f64) -> S {
    let (s, at) = (S::from, S::from(at));
    let plain = Wrapped::Plain;
    let (zero, infinite) = (s(0.0), s(f64::INFINITY));
    match formula {
        "von_mises(x, 2)" => Wrapped::VonMises { mu: x, kappa: s(2.0) }.log_density(at),
        "rounded(normal(x, 2))" => Wrapped::Rounded(&plain(normal(x, 2.0))).log_density(at),
        "rounded(2*gamma(2, x) + x)" => {
            Wrapped::Rounded(&plain(gamma(2.0, x).scaled(2.0).shifted(x))).log_density(at)
        }
        "rounded(censored(normal(x, x), 0, inf))" => {
            let of = plain(normal(x, x));
            Wrapped::Rounded(&Wrapped::Censored { low: zero, high: infinite, of: &of }).log_density(at)
        }
        "censored(x + normal(0, 1), -inf, 2*x)" => {
            let of = plain(normal(x, 1.0));
            Wrapped::Censored { low: -infinite, high: x * 2.0, of: &of }.log_density(at)
        }
        "truncated(student_t(4, x, 1), -1, 3)" => {
            let of = plain(student_t(4.0, x, 1.0));
            Wrapped::Truncated { low: s(-1.0), high: s(3.0), of: &of }.log_density(at)
        }
        "zero_inflated(0.1*x, poisson(x))" => {
            Wrapped::ZeroInflated { p: x * 0.1, of: &plain(poisson(x)) }.log_density(at)
        }
        "mixture(0.9, normal(x, 1), student_t(3, x, 2))" => {
            let [first, second] = [plain(normal(x, 1.0)), plain(student_t(3.0, x, 2.0))];
            Wrapped::Mixture { weight: s(0.9), first: &first, second: &second }.log_density(at)
        }
        "floored(rounded(normal(x, sqrt(y))), 1e-18)" => {
            Wrapped::Floored { floor: s(1e-18), of: &Wrapped::Rounded(&plain(normal(x, 0.0))) }
                .log_density(at)
        }
        _ => plain(normal(x, 2.0)).log_density(at),
    }
}

const FORMULAS: [&str; 10] = [
    "von_mises(x, 2)",
    "rounded(normal(x, 2))",
    "rounded(2*gamma(2, x) + x)",
    "rounded(censored(normal(x, x), 0, inf))",
    "censored(x + normal(0, 1), -inf, 2*x)",
    "truncated(student_t(4, x, 1), -1, 3)",
    "zero_inflated(0.1*x, poisson(x))",
    "mixture(0.9, normal(x, 1), student_t(3, x, 2))",
    "floored(rounded(normal(x, sqrt(y))), 1e-18)",
    "log_density(-(z - x)^2/(2*spread) - 0.5*log(2*pi*spread))",
];

const MORE: &str = "[definitions]\nspread = \"4 + 0*x\"\n";

/// Catches arguments in another order, one distribution under another's name, and a part that is lost.
#[test]
fn densities_are_those_of_rust() {
    for formula in FORMULAS {
        let model = measuring(formula, MORE);
        for x in [0.6, 1.5] {
            for at in [-1.0, 0.0, 1.0, 2.5, 3.0] {
                let found = model.log_likelihood(&Step::of_index(0), &[x, 0.0], &[at]).unwrap();
                let expected = density(formula, x, at);
                let close = (found - expected).abs() <= 1e-12 * (1.0 + expected.abs());
                assert!(close || found == expected, "{formula} at {at}, x = {x}: {found} for {expected}");
            }
        }
    }
}

/// Catches derivatives that are lost, and lanes that are not numbers alone.
#[test]
fn derivatives_and_lanes_are_those_of_rust() {
    type Number = Dual<f64, 3>;
    for formula in FORMULAS {
        let model = measuring(formula, MORE);
        for at in [0.0, 1.0, 2.0] {
            let mut found = [0.0; 2];
            let x = Number::variable(1.3, 0);
            model.likelihood_gradients(&Step::of_index(0), &[1.3, 0.0], &[at], &mut found);
            let expected = density(formula, x, at).derivatives()[0];
            assert!(
                (found[0] - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                "{formula}: {found:?} {expected}"
            );
            let states: Vec<f64> = (0..40).flat_map(|k| [0.4 + 0.05 * f64::from(k), 0.0]).collect();
            let mut together = [0.0; 40];
            model.log_likelihoods(&Step::of_index(0), &states, &[Some(at)], &mut together).unwrap();
            for (state, together) in states.chunks(2).zip(together) {
                let alone = model.log_likelihood(&Step::of_index(0), state, &[at]).unwrap();
                assert_eq!(bits(&[alone]), bits(&[together]), "{formula} at {at}");
            }
        }
    }
}

/// Catches draws of another distribution, and a log density that passes for one that can be drawn.
#[test]
fn measurements_are_drawn() {
    const DRAWS: usize = 20_000;
    let draw = |model: &FormulaModel| {
        let mut drawn = vec![0.0; DRAWS];
        let streams = &mut [Seed::from_u64(5).stream()];
        model.sample_measurements(&Step::of_index(0), &[1.5, 0.25].repeat(DRAWS), streams, &mut drawn);
        drawn
    };
    for (formula, expected) in [
        ("rounded(censored(normal(x, x), 0, inf))", 1.62),
        ("mixture(0.25, normal(x, 1), normal(x + 4, 1))", 4.5),
        ("zero_inflated(0.4, exponential(x))", 0.9),
        ("truncated(exponential(1), 2, inf)", 3.0),
        ("floored(rounded(normal(x, sqrt(y))), 1e-18)", 1.5),
    ] {
        let model = measuring(formula, "");
        assert_eq!(model.can_be_simulated(), Ok(()));
        let mean = draw(&model).iter().sum::<f64>() / DRAWS as f64;
        assert!((mean - expected).abs() < 0.06, "{formula}: {mean} for {expected}");
    }
    let model = measuring("floored(log_density(-abs(z - x)), 1e-9)", "");
    assert!(draw(&model).iter().all(|drawn| drawn.is_nan()));
    let error = model.can_be_simulated().unwrap_err().to_string();
    assert_eq!(
        error,
        "m.toml, line 8, [measurement] z: log_density(f) says how likely a measurement is, not how it is drawn; the model filters data and cannot be simulated"
    );
}

/// What a proposal is told is finite, and 0 where a floor is all that there is.
#[test]
fn proposals_are_told_of_all() {
    for formula in FORMULAS {
        let model = measuring(formula, MORE);
        let mut states = [1.3; 2 * LANES];
        states[LANES..].fill(0.0);
        let (mut slopes, mut information) = ([0.0; LANES], [0.0; LANES]);
        let mut jacobian = [0.0; 2 * LANES];
        let y = [Some(Lanes::from(2.0))];
        model.tile_scores(&Step::of_index(0), &states, &y, &mut slopes, &mut information, &mut jacobian);
        assert!(slopes[0].is_finite() && information[0] >= 0.0 && jacobian[0].is_finite(), "{formula}");
        assert_eq!(information[0] == 0.0, formula.starts_with("floored"), "{formula}: {}", information[0]);
    }
}

/// What some state can give is not refused, and what none can is.
#[test]
fn supports_are_those_of_what_is_inside() {
    let words = |formula: &str, value: f64| {
        let model = measuring(formula, "");
        model.impossible(&Step::of_index(0), &[Some(value)]).map(|impossible| impossible.to_string())
    };
    for (formula, value) in [
        ("rounded(normal(x, 1))", -3.0),
        ("rounded(exponential(1))", 0.0),
        ("rounded(uniform(0.5, 2))", 1.0),
        ("censored(normal(x, 1), 0, x)", 0.0),
        ("censored(poisson(3), -inf, 5)", 5.0),
        ("truncated(poisson(3), 1, inf)", 1.0),
        ("zero_inflated(0.5, truncated(poisson(3), 1, inf))", 0.0),
        ("zero_inflated(0.5, gamma(2, 1))", 0.0),
        ("mixture(0.5, poisson(3), normal(x, 1))", 0.5),
        ("floored(poisson(3), 1e-9)", 4.5),
        ("floored(rounded(normal(x, 1)), 1e-9)", 4.5),
        ("von_mises(x, 1)", 400.0),
        ("log_density(-z)", -4.5),
    ] {
        assert_eq!(words(formula, value), None, "{formula}");
    }
    let refused = |formula, value| words(formula, value).unwrap();
    assert_eq!(
        refused("rounded(normal(x, 1))", 4.5),
        "4.5 is no value of rounded(normal(x, 1)): it is a whole number"
    );
    assert_eq!(
        refused("rounded(censored(normal(x, 1), 0, inf))", -1.0),
        "-1 is no value of rounded(censored(normal(x, 1), 0, inf)): a count is a whole number, 0 or more"
    );
    assert_eq!(
        refused("censored(normal(x, 1), 0, 5)", 5.5),
        "5.5 is no value of censored(normal(x, 1), 0, 5): it must lie from 0 to 5"
    );
    assert_eq!(
        refused("truncated(poisson(x), 1, inf)", 0.0),
        "0 is no value of truncated(poisson(x), 1, inf): it is a whole number, 1 or more"
    );
    assert_eq!(
        refused("zero_inflated(0.2, binomial(10, 0.5))", 11.0),
        "11 is no value of zero_inflated(0.2, binomial(10, 0.5)): a count is a whole number from 0 to 10"
    );
    assert_eq!(
        refused("zero_inflated(0.2, gamma(2, 1))", -0.5).split(": ").nth(1),
        Some("it must be at least 0")
    );
}

/// A vector's coordinates are their own measurements, and time is known in a log density.
#[test]
fn log_densities_of_vectors_are_of_each_coordinate() {
    let text = "[initial]\nx[3] = \"normal(0, 1)\"\n[transition]\nx[3] = \"normal(x[i], 1)\"\n\
                [measurement]\ny[3] = \"log_density(-(y[i] - x[i])^2 - t)\"\nw = \"rounded(normal(x[0], 1))\"\n";
    let model = super::helpers::model(text);
    let (x, y) = ([0.1, 0.7, -0.4], [0.3, 1.1, 2.0, 0.0]);
    let found = model.log_likelihood(&Step::of_index(2), &x, &y).unwrap();
    let of = x.iter().zip(y).map(|(x, y): (&f64, f64)| -(y - x).powi(2) - 2.0).sum::<f64>();
    let rounded = Wrapped::Rounded(&Wrapped::Plain(normal(0.1, 1.0))).log_density(0.0);
    assert!((found - of - rounded).abs() < 1e-12);
}

/// Catches a scale of 0 that is an error where a floor takes it, and one that is none elsewhere.
#[test]
fn what_is_out_of_range_is_explained_but_under_a_floor() {
    let explained = |formula: &str| {
        let model = measuring(formula, "");
        model.explain(&Step::of_index(1), Some(&[0.0; 2]), Some(&[0.5, 0.0])).map(|error| error.to_string())
    };
    assert_eq!(explained("floored(rounded(normal(x, y)), 1e-9)"), None);
    assert_eq!(
        explained("rounded(normal(x, y))").unwrap(),
        "m.toml, line 8, [measurement] z: sd, `y`, is 0; it must be above 0"
    );
    assert_eq!(
        explained("zero_inflated(x + 2, poisson(3))").unwrap(),
        "m.toml, line 8, [measurement] z: p, `x + 2`, is 2.5 where x = 0.5; it must be between 0 and 1"
    );
    assert_eq!(
        explained("censored(normal(0, 1), x, y)").unwrap(),
        "m.toml, line 8, [measurement] z: high, `y`, is 0; it must be above low, which is 0.5"
    );
}

/// As pomp's measles, whose spread vanishes where there are no cases.
#[test]
fn under_a_floor_what_has_no_spread_is_drawn_as_its_mean() {
    for (formula, drawn) in [
        ("floored(normal(x, y), 1e-18)", 2.3),
        ("floored(rounded(normal(x, y)), 1e-18)", 2.0),
        ("floored(rounded(censored(normal(-x, y), 0, inf)), 1e-18)", 0.0),
    ] {
        let mut found = [f64::NAN];
        let mut stream = Seed::from_u64(1).stream();
        let model = measuring(formula, "");
        model.sample_measurements(
            &Step::of_index(1),
            &[2.3, 0.0],
            std::slice::from_mut(&mut stream),
            &mut found,
        );
        assert_eq!(found, [drawn], "{formula}");
    }
}
