//! Measurements whose distributions are made of others: densities that integrate to 1, draws, derivatives, and what they say to a proposal.

use std::f64::consts::PI;

use motes_models::batch::LANES;
use motes_models::equations::{
    Coordinates, Distribution, Draws, Equations, Lanes, Linearise, Scalar, Wrapped, beta, binomial,
    exponential, gamma, laplace, log_normal, negative_binomial, normal, poisson, student_t, uniform,
};
use motes_models::{Marginal, Seed, Simulator, StateGradients, StateSpaceModel, Step};

/// What a case is called, its atoms, and the intervals in which it has a density, of which all but the first atom may be few.
type Case = (&'static str, &'static [f64], &'static [[f64; 2]]);

const CASES: [Case; 19] = [
    ("von mises", &[], &[[-PI, PI]]),
    ("concentrated von mises", &[], &[[-2.0, 4.0]]),
    ("rounded normal", INTEGERS, &[]),
    ("rounded and censored", COUNTS, &[]),
    ("rounded gamma", COUNTS, &[]),
    ("censored normal", &[0.0, 2.0], &[[0.0, 2.0]]),
    ("censored below", &[0.5], &[[0.5, 60.0]]),
    ("truncated normal", &[], &[[0.0, 12.0]]),
    ("truncated far out", &[], &[[9.0, 14.0]]),
    ("truncated counts", COUNTS, &[]),
    ("censored counts", COUNTS, &[]),
    ("zero-inflated counts", COUNTS, &[]),
    ("zero-inflated gamma", &[0.0], &[[0.0, 60.0]]),
    ("mixture", &[], &[[-400.0, 400.0]]),
    ("mixture with an atom", &[0.0], &[[-14.0, 0.0], [0.0, 14.0]]),
    ("rounded mixture", INTEGERS, &[]),
    ("truncated binomial", COUNTS, &[]),
    ("truncated beta", &[], &[[0.2, 0.7]]),
    ("truncated and rounded", COUNTS, &[]),
];

const INTEGERS: &[f64] = &{
    let mut integers = [0.0; 161];
    let mut at = 0;
    while at < 161 {
        integers[at] = at as f64 - 80.0;
        at += 1;
    }
    integers
};

const COUNTS: &[f64] = INTEGERS.split_at(80).1;

/// The distribution of a case, given a state near 1.
fn with<S: Scalar>(case: usize, x: S, push: &mut dyn FnMut(&Wrapped<'_, S>)) {
    let s = S::from;
    let plain = |distribution: Distribution<S>| Wrapped::Plain(distribution);
    let normal = |mean: S, sd: f64| plain(normal(mean, sd));
    let (zero, infinite) = (s(0.0), s(f64::INFINITY));
    match CASES[case].0 {
        "von mises" => push(&Wrapped::VonMises { mu: x, kappa: x * 1.5 }),
        "concentrated von mises" => push(&Wrapped::VonMises { mu: x, kappa: x * 80.0 }),
        "rounded normal" => push(&Wrapped::Rounded(&normal(x, 1.7))),
        "rounded and censored" => {
            let inner = normal(x * 1.5, 2.5);
            push(&Wrapped::Rounded(&Wrapped::Censored { low: zero, high: infinite, of: &inner }))
        }
        "rounded gamma" => push(&Wrapped::Rounded(&plain(gamma(x * 2.0, x * 1.5)))),
        "censored normal" => {
            push(&Wrapped::Censored { low: zero, high: s(2.0), of: &normal(x, 1.3) });
        }
        "censored below" => {
            let of = &plain(log_normal(x * 0.3, 0.6));
            push(&Wrapped::Censored { low: s(0.5), high: infinite, of });
        }
        "truncated normal" => {
            push(&Wrapped::Truncated { low: zero, high: infinite, of: &normal(x, 1.3) });
        }
        "truncated far out" => {
            push(&Wrapped::Truncated { low: s(9.0), high: infinite, of: &normal(x, 1.0) });
        }
        "truncated counts" => {
            let of = &plain(negative_binomial(x * 3.0, x * 2.0));
            push(&Wrapped::Truncated { low: s(1.0), high: s(80.0), of });
        }
        "censored counts" => {
            push(&Wrapped::Censored { low: s(1.0), high: s(4.0), of: &plain(poisson(x * 3.0)) });
        }
        "zero-inflated counts" => {
            push(&Wrapped::ZeroInflated { p: x * 0.2, of: &plain(poisson(x * 3.0)) });
        }
        "zero-inflated gamma" => {
            push(&Wrapped::ZeroInflated { p: x * 0.2, of: &plain(gamma(2.0, x)) });
        }
        "mixture" => {
            // Of fewer degrees of freedom than 5 the variance of draws has no standard error to hold it against.
            let [first, second] = [normal(x, 1.0), plain(student_t(6.0, x, 2.0))];
            push(&Wrapped::Mixture { weight: s(0.8), first: &first, second: &second });
        }
        "mixture with an atom" => {
            let [inner, second] = [normal(x * 0.5, 1.0), normal(x, 1.5)];
            let first = Wrapped::Censored { low: zero, high: infinite, of: &inner };
            push(&Wrapped::Mixture { weight: x * 0.4, first: &first, second: &second });
        }
        "rounded mixture" => {
            let [first, second] = [plain(laplace(x, 1.0)), plain(uniform(x - 9.0, x + 9.0))];
            push(&Wrapped::Rounded(&Wrapped::Mixture { weight: s(0.8), first: &first, second: &second }));
        }
        "truncated binomial" => {
            push(&Wrapped::Truncated { low: s(2.0), high: s(9.0), of: &plain(binomial(12.0, x * 0.4)) });
        }
        "truncated beta" => {
            push(&Wrapped::Truncated { low: s(0.2), high: s(0.7), of: &plain(beta(x * 1.5, x + 1.0)) });
        }
        _ => {
            let inner = plain(exponential(x * 6.0));
            push(&Wrapped::Truncated { low: s(2.0), high: s(60.0), of: &Wrapped::Rounded(&inner) });
        }
    }
}

/// A model whose measurement is so distributed.
struct Measured(usize);

impl Equations for Measured {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(1.0, 0.1));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, _: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        self.initial(step, draws, state);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
        with(self.0, x[0], &mut |wrapped| measurement.push_wrapped(wrapped));
    }
}

fn log_density(case: usize, x: f64, y: f64) -> f64 {
    Measured(case).log_likelihood(&Step::of_index(0), &[x], &[y]).unwrap()
}

/// Simpson's rule on a grid that is finer towards both ends.
fn integral([low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    const PARTS: usize = 4000;
    let at = |i: usize| {
        let u = i as f64 / PARTS as f64;
        f(low + (high - low) * u * u * (3.0 - 2.0 * u)) * 6.0 * u * (1.0 - u) * (high - low)
    };
    let inner = |i: usize| if i.is_multiple_of(2) { 2.0 * at(i) } else { 4.0 * at(i) };
    (1..PARTS).map(inner).sum::<f64>() / (3.0 * PARTS as f64)
}

/// The probability of an interval without its ends.
fn probability(case: usize, x: f64, ends: [f64; 2]) -> f64 {
    integral(ends, |y| log_density(case, x, y).exp())
}

#[test]
fn all_have_the_mass_one() {
    for (case, (name, atoms, ranges)) in CASES.iter().enumerate() {
        for x in [0.8, 1.0, 1.3] {
            let of_atoms: f64 = atoms.iter().map(|y| log_density(case, x, *y).exp()).sum();
            let between: f64 = ranges.iter().map(|ends| probability(case, x, *ends)).sum();
            let sum = of_atoms + between;
            let tolerance = if *name == "mixture" { 1e-6 } else { 1e-7 };
            assert!((sum - 1.0).abs() < tolerance, "{name} at {x}: {sum}");
        }
    }
}

/// Catches a draw of another distribution: bins of draws hold as many as their probabilities say.
#[test]
fn draws_are_distributed_as_densities_say() {
    const DRAWS: usize = 40_000;
    for (case, (name, atoms, ranges)) in CASES.iter().enumerate() {
        let mut drawn = vec![f64::NAN; DRAWS];
        let streams = &mut [Seed::from_u64(80).child(name).stream()];
        Measured(case).sample_measurements(&Step::of_index(0), &vec![1.1; DRAWS], streams, &mut drawn);
        let check = |what: &str, found: usize, probability: f64| {
            let error = (probability * (1.0 - probability) * DRAWS as f64).sqrt().max(1.0);
            let z = (found as f64 - probability * DRAWS as f64) / error;
            assert!(z.abs() < 4.5, "{name}, {what}: {found} draws, {z} standard errors");
        };
        let is_atom = |y: &f64| atoms.contains(y);
        for atom in *atoms {
            let found = drawn.iter().filter(|y| *y == atom).count();
            check(&format!("{atom}"), found, log_density(case, 1.1, *atom).exp());
        }
        // One turn of angles, wherever they are.
        let shift = if *name == "von mises" { 1.1 } else { 0.0 };
        let mut others: Vec<f64> = drawn.iter().copied().filter(|y| !is_atom(y)).collect();
        others.sort_by(f64::total_cmp);
        for ends in *ranges {
            let [low, high] = ends.map(|end| end + shift);
            let inside =
                &others[others.partition_point(|y| *y <= low)..others.partition_point(|y| *y < high)];
            // Kolmogorov and Smirnov: the largest distance of both distribution functions, at some places.
            let mut sum = 0.0;
            for part in 0..50 {
                let place = |at: usize| {
                    if at == 0 {
                        low
                    } else if at == 50 {
                        high
                    } else {
                        inside[at * inside.len() / 50]
                    }
                };
                let edges = [place(part), place(part + 1)];
                sum += probability(case, 1.1, edges);
                let below = inside.partition_point(|y| *y < edges[1]);
                check(&format!("below {}", edges[1]), below, sum.min(1.0));
            }
        }
        assert!(drawn.iter().all(|y| y.is_finite()), "{name}");
    }
}

/// Catches a distribution function, or moments, of another distribution than the one that is drawn.
#[test]
fn marginals_are_those_of_draws() {
    const DRAWS: usize = 40_000;
    for (case, (name, atoms, ranges)) in CASES.iter().enumerate() {
        let (step, measured) = (Step::of_index(0), Measured(case));
        let mut drawn = vec![f64::NAN; DRAWS];
        let streams = &mut [Seed::from_u64(81).child(name).stream()];
        measured.sample_measurements(&step, &vec![1.1; DRAWS], streams, &mut drawn);
        let share = |of: &dyn Fn(f64) -> bool| drawn.iter().filter(|y| of(**y)).count() as f64 / DRAWS as f64;
        let mut out = [Marginal::of_draw(f64::NAN, None)];
        for y in values(atoms, ranges) {
            measured.marginals(&step, &[1.1], &[Some(y)], &mut streams[0], &mut out);
            let [Marginal { mean, variance, below, at, is_angle, .. }] = out;
            if is_angle {
                assert!(name.ends_with("mises"), "{name}");
                continue;
            }
            for (what, found, probability) in
                [("below", below, share(&|drawn| drawn < y)), ("at", at, share(&|drawn| drawn == y))]
            {
                let error = (found * (1.0 - found) / DRAWS as f64).sqrt() + 1e-5;
                let z = (probability - found) / error;
                assert!(z.abs() < 4.5, "{name}, {what} {y}: {found}, of draws {probability}");
            }
            // A draw stands for the others.
            if variance > 0.0 {
                let error = (variance / DRAWS as f64).sqrt();
                let of_draws = drawn.iter().sum::<f64>() / DRAWS as f64;
                assert!((of_draws - mean).abs() < 4.5 * error, "{name}: {mean}, of draws {of_draws}");
                let squares = drawn.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / DRAWS as f64;
                assert!((squares / variance).ln().abs() < 0.1, "{name}: {variance}, of draws {squares}");
            }
        }
    }
}

/// Numbers that a case can give.
fn values(atoms: &[f64], ranges: &[[f64; 2]]) -> Vec<f64> {
    let of_range = |[low, high]: &[f64; 2]| [0.1, 0.3, 0.45, 0.53, 0.8].map(|u| low + u * (high - low));
    let inner = ranges.iter().flat_map(of_range);
    atoms.iter().copied().filter(|y| y.abs() < 12.0).chain(inner).collect()
}

#[test]
fn derivatives_are_those_of_differences() {
    const STEP: f64 = 1e-5;
    for (case, (name, atoms, ranges)) in CASES.iter().enumerate() {
        for y in values(atoms, ranges) {
            for x in [0.9, 1.2] {
                let mut found = [0.0];
                Measured(case).likelihood_gradients(&Step::of_index(0), &[x], &[y], &mut found);
                let value = log_density(case, x, y);
                if value == f64::NEG_INFINITY {
                    continue;
                }
                let difference =
                    (log_density(case, x + STEP, y) - log_density(case, x - STEP, y)) / (2.0 * STEP);
                let error = (found[0] - difference).abs();
                assert!(
                    error < 1e-6 * (1.0 + difference.abs()),
                    "{name}, y = {y}, x = {x}: {found:?} for {difference}"
                );
            }
        }
    }
}

/// What is said of the location is the derivative itself, where all parts have the same location.
#[test]
fn scores_are_derivatives_of_what_is_normal_inside() {
    for (case, (name, atoms, ranges)) in CASES.iter().enumerate() {
        let is_exact = matches!(*name, "von mises" | "censored normal" | "mixture");
        for y in values(atoms, ranges) {
            let (mut slopes, mut information) = ([0.0; LANES], [0.0; LANES]);
            let mut jacobian = [0.0; LANES];
            Measured(case).tile_scores(
                &Step::of_index(0),
                &[1.2; LANES],
                &[Some(Lanes::from(y))],
                &mut slopes,
                &mut information,
                &mut jacobian,
            );
            if log_density(case, 1.2, y) == f64::NEG_INFINITY {
                continue;
            }
            let mut gradient = [0.0];
            Measured(case).likelihood_gradients(&Step::of_index(0), &[1.2], &[y], &mut gradient);
            let found = slopes[0] * jacobian[0];
            assert!(found.is_finite() && information[0] >= 0.0, "{name}: {found} {}", information[0]);
            if is_exact && *name != "von mises" {
                let error = (found - gradient[0]).abs();
                assert!(error < 1e-9 * (1.0 + found.abs()), "{name}, y = {y}: {found} for {}", gradient[0]);
            }
        }
    }
}

/// A plain number's log density.
fn at(wrapped: &Wrapped<'_, f64>, y: f64) -> f64 {
    wrapped.log_density(y)
}

/// Catches a difference of two distribution functions that are both 1, or both 0. The numbers are mpmath's.
#[test]
fn tails_keep_their_digits() {
    let standard = Wrapped::Plain(normal(0.0, 1.0));
    let rounded = Wrapped::Rounded(&standard);
    for (y, expected) in [(8.0, -30.3), (-30.0, -439.4), (60.0, -1775.0)] {
        let found = at(&rounded, y);
        let rough = -0.5 * (y.abs() - 0.5) * (y.abs() - 0.5) - (y.abs() - 0.5).ln() - 0.918938533;
        assert!((found - rough).abs() < 0.05 && (found - expected).abs() < 10.0, "{y}: {found} {rough}");
    }
    // Wide ones are their densities.
    for sd in [1e4, 1e5, 1e9, 1e13] {
        let wide = Wrapped::Plain(normal(0.0, sd));
        let (found, density) = (at(&Wrapped::Rounded(&wide), 3.0), at(&wide, 3.0));
        assert!((found - density).abs() < 1e-8, "{sd}: {found} for {density}");
    }
    let certain = Wrapped::Plain(normal(3.1, 1e-9));
    assert_eq!(at(&Wrapped::Rounded(&certain), 3.0), 0.0);
}

#[test]
fn what_cannot_be_is_minus_infinity_and_what_is_wrong_is_nan() {
    let standard = Wrapped::Plain(normal(0.0, 1.0));
    let rounded = Wrapped::Rounded(&standard);
    assert_eq!(at(&rounded, 4.5), f64::NEG_INFINITY);
    let censored = Wrapped::Censored { low: 0.0, high: f64::INFINITY, of: &standard };
    assert_eq!(at(&censored, -0.5), f64::NEG_INFINITY);
    assert!((at(&censored, 0.0) - 0.5_f64.ln()).abs() < 1e-15);
    assert_eq!(at(&Wrapped::Truncated { low: 0.0, high: 1.0, of: &standard }, 1.5), f64::NEG_INFINITY);
    let wrong = Wrapped::Plain(normal(0.0, -1.0));
    for wrapped in [
        Wrapped::Rounded(&wrong),
        Wrapped::Censored { low: 0.0, high: 1.0, of: &wrong },
        Wrapped::Censored { low: 1.0, high: 0.0, of: &standard },
        Wrapped::Truncated { low: 1.0, high: 1.0, of: &standard },
        Wrapped::ZeroInflated { p: 1.5, of: &standard },
        Wrapped::Mixture { weight: -0.5, first: &standard, second: &standard },
        Wrapped::VonMises { mu: 0.0, kappa: -1.0 },
    ] {
        assert!(at(&wrapped, 1.0).is_nan());
    }
}

/// A scale of 0 at some particles is what the floor is for.
#[test]
fn a_floor_takes_what_is_no_number() {
    let floor = 1e-18;
    for inner in [normal(0.0, 0.0), normal(f64::NAN, 1.0), uniform(3.0, 4.0), normal(1e9, 1e-3)] {
        let inner = Wrapped::Plain(inner);
        let rounded = Wrapped::Rounded(&inner);
        for of in [&inner, &rounded] {
            assert_eq!(at(&Wrapped::Floored { floor, of }, 2.0), floor.ln());
        }
    }
    let standard = Wrapped::Plain(normal(0.0, 1.0));
    let found = at(&Wrapped::Floored { floor: 0.5, of: &standard }, 0.3);
    assert!((found - (0.5 + at(&standard, 0.3).exp()).ln()).abs() < 1e-15);
}
