//! Every distribution: draws against its density, derivatives against differences, moments against draws.

use motes_models::equations::{
    Coordinates, Distribution, Draws, Dual, Equations, Scalar, bernoulli, beta, binomial, exponential, gamma,
    laplace, log_normal, negative_binomial, normal, poisson, student_t, uniform,
};
use motes_models::{Seed, StateSpaceModel, Step};

/// A distribution by two parameters, with parameters to try and numbers that hold almost all of its probability.
struct Case {
    name: &'static str,
    of: fn([Dual<f64, 4>; 2]) -> Distribution<Dual<f64, 4>>,
    plain: fn([f64; 2]) -> Distribution<f64>,
    parameters: [f64; 2],
    range: [f64; 2],
}

macro_rules! case {
    ($name:literal, |$p:ident| $distribution:expr, $parameters:expr, $range:expr) => {{
        fn of<S: Scalar>($p: [S; 2]) -> Distribution<S> {
            $distribution
        }
        Case { name: $name, of: of::<Dual<f64, 4>>, plain: of::<f64>, parameters: $parameters, range: $range }
    }};
}

fn continuous() -> Vec<Case> {
    vec![
        case!("normal", |p| normal(p[0], p[1]), [0.7, 1.4], [-8.0, 10.0]),
        case!("student_t", |p| student_t(4.5, p[0], p[1]), [0.7, 1.4], [-200.0, 200.0]),
        case!("student_t by df", |p| student_t(p[0], 0.3, p[1]), [6.0, 0.5], [-60.0, 60.0]),
        case!("laplace", |p| laplace(p[0], p[1]), [0.7, 0.4], [-15.0, 16.0]),
        case!("log_normal", |p| log_normal(p[0], p[1]), [0.3, 0.5], [0.0, 40.0]),
        case!("exponential", |p| exponential(p[0]).shifted(p[1]), [1.7, -0.2], [-0.2, 70.0]),
        case!("gamma", |p| gamma(p[0], p[1]), [2.6, 0.8], [0.0, 40.0]),
        case!("beta", |p| beta(p[0], p[1]), [2.6, 1.8], [0.0, 1.0]),
        case!("uniform", |p| uniform(p[0], p[1]), [-0.4, 1.9], [-0.4, 1.9]),
        case!("scaled normal", |p| normal(0.2, 1.1).scaled(p[0]).shifted(p[1]), [-1.5, 0.4], [-12.0, 12.0]),
        case!(
            "scaled student_t",
            |p| student_t(5.0, 0.2, 1.1).scaled(p[0]).shifted(p[1]),
            [-1.5, 0.4],
            [-200.0, 200.0]
        ),
        case!("scaled laplace", |p| laplace(0.2, 0.5).scaled(p[0]).shifted(p[1]), [-1.5, 0.4], [-30.0, 30.0]),
        case!(
            "scaled log_normal",
            |p| log_normal(0.2, 0.4).scaled(p[0]).shifted(p[1]),
            [-1.5, 0.4],
            [-40.0, 0.4]
        ),
        case!(
            "scaled exponential",
            |p| exponential(1.0).scaled(p[0]).shifted(p[1]),
            [-3.0, 1.0],
            [-120.0, 1.0]
        ),
        case!("scaled gamma", |p| gamma(3.0, 0.5).scaled(p[0]).shifted(p[1]), [-1.5, 0.4], [-40.0, 0.4]),
        case!("scaled beta", |p| beta(3.0, 1.4).scaled(p[0]).shifted(p[1]), [-1.5, 0.4], [-1.1, 0.4]),
        case!("scaled uniform", |p| uniform(-1.0, 2.0).scaled(p[0]).shifted(p[1]), [-1.5, 0.4], [-2.6, 1.9]),
    ]
}

fn counts() -> Vec<Case> {
    vec![
        case!("poisson", |p| poisson(p[0] * p[1]), [1.5, 2.0], [0.0, 40.0]),
        case!("negative_binomial", |p| negative_binomial(p[0], p[1]), [3.5, 2.2], [0.0, 150.0]),
        case!("binomial", |p| binomial(12.0, p[0] + p[1]), [0.2, 0.15], [0.0, 12.0]),
        // Of many the draws are made in other ways.
        case!("poisson of many", |p| poisson(p[0] * p[1]), [16.0, 5.0], [0.0, 200.0]),
        case!("binomial of many", |p| binomial(300.0, p[0] + p[1]), [0.2, 0.15], [0.0, 300.0]),
        case!("binomial of many successes", |p| binomial(300.0, p[0] + p[1]), [0.5, 0.25], [0.0, 300.0]),
        case!("bernoulli", |p| bernoulli(p[0] * p[1]), [0.6, 0.5], [0.0, 1.0]),
    ]
}

/// A model of one coordinate that has the distribution; filters draw from it in bulk.
struct Only(fn([f64; 2]) -> Distribution<f64>, [f64; 2]);

impl Equations for Only {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw((self.0)(self.1).map(|p| S::from(*p)));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, _: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        self.initial(step, draws, state);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, _: &[S], measurement: &mut impl Coordinates<S>) {
        measurement.push((self.0)(self.1).map(|p| S::from(*p)));
    }
}

const DRAWS: usize = 200_000;

/// Draws one by one, and in bulk as a filter does, from streams of their own.
fn draws(case: &Case) -> [Vec<f64>; 2] {
    let seed = Seed::from_u64(50).child(case.name);
    let distribution = (case.plain)(case.parameters);
    let mut stream = seed.nth(0).stream();
    let alone = (0..DRAWS).map(|_| distribution.sample(&mut stream)).collect();
    let mut bulk = vec![0.0; DRAWS];
    Only(case.plain, case.parameters).sample_states(
        &Step::of_index(0),
        None,
        &mut [seed.nth(1).stream()],
        &mut bulk,
    );
    [alone, bulk]
}

/// By how many standard errors the share of draws in a bin differs from its probability.
fn check_shares(name: &str, draws: &[f64], bin_of: impl Fn(f64) -> Option<usize>, probabilities: &[f64]) {
    let mut found = vec![0.0; probabilities.len()];
    draws.iter().filter_map(|x| bin_of(*x)).for_each(|bin| found[bin] += 1.0);
    let count = draws.len() as f64;
    for (bin, (found, probability)) in found.iter().zip(probabilities).enumerate() {
        let error = (probability * (1.0 - probability) * count).sqrt().max(1.0);
        let z = (found - probability * count) / error;
        assert!(z.abs() < 4.5, "{name}, bin {bin}: {found} draws for {:.1}, z = {z}", probability * count);
    }
}

#[test]
fn continuous_draws_are_distributed_as_the_density_says() {
    // Bins of equal numbers of draws: where there are few, none is wide.
    const BINS: usize = 40;
    for case in continuous() {
        let distribution = (case.plain)(case.parameters);
        let [alone, bulk] = draws(&case);
        let mut sorted = alone.clone();
        sorted.sort_by(f64::total_cmp);
        let mut edges: Vec<f64> = (1..BINS).map(|bin| sorted[bin * DRAWS / BINS]).collect();
        edges.insert(0, case.range[0]);
        edges.push(case.range[1]);
        let probabilities: Vec<f64> = edges
            .windows(2)
            .map(|edge| integral(edge[0], edge[1], |x| distribution.log_density(x).exp()))
            .collect();
        let total: f64 = probabilities.iter().sum();
        assert!((total - 1.0).abs() < 2e-6, "the density of {} integrates to {total}", case.name);
        let bin_of = |x: f64| {
            assert!(x.is_finite(), "{}: {x}", case.name);
            Some(edges.partition_point(|edge| *edge <= x).clamp(1, BINS) - 1)
        };
        check_shares(case.name, &bulk, bin_of, &probabilities);
        // Half of the draws alone have no say in the edges' places within a standard error of them.
        let equal: Vec<f64> = probabilities.iter().map(|p| (p - 1.0 / BINS as f64).abs()).collect();
        let error = (1.0 / BINS as f64 / DRAWS as f64).sqrt() * 2.0_f64.sqrt();
        assert!(equal.iter().all(|off| *off < 4.5 * error), "{}, one by one: {equal:?}", case.name);
    }
}

/// Simpson's rule on a grid that is finer towards the lower end, where a density may have an edge.
fn integral(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    const PARTS: usize = 4000;
    let x = |u: f64| low + (high - low) * u * u * (3.0 - 2.0 * u);
    let weight = |u: f64| 6.0 * u * (1.0 - u) * (high - low);
    let at = |i: usize| {
        let u = i as f64 / PARTS as f64;
        // The ends themselves have no weight.
        if i == 0 || i == PARTS { 0.0 } else { f(x(u)) * weight(u) }
    };
    let inner = |i: usize| if i.is_multiple_of(2) { 2.0 * at(i) } else { 4.0 * at(i) };
    (1..PARTS).map(inner).sum::<f64>() / (3.0 * PARTS as f64)
}

#[test]
fn counts_are_distributed_as_the_density_says() {
    for case in counts() {
        let distribution = (case.plain)(case.parameters);
        let most = case.range[1] as usize;
        let probabilities: Vec<f64> = (0..=most).map(|k| distribution.log_density(k as f64).exp()).collect();
        let total: f64 = probabilities.iter().sum();
        assert!((total - 1.0).abs() < 1e-9, "the probabilities of {} sum to {total}", case.name);
        for draws in draws(&case) {
            let bin_of = |x: f64| {
                assert!(x >= 0.0 && x.fract() == 0.0, "{}: {x}", case.name);
                Some(x as usize).filter(|bin| *bin <= most)
            };
            check_shares(case.name, &draws, bin_of, &probabilities);
        }
        assert_eq!(distribution.log_density(1.5), f64::NEG_INFINITY, "{}", case.name);
        assert_eq!(distribution.log_density(-1.0), f64::NEG_INFINITY, "{}", case.name);
    }
}

#[test]
fn derivatives_in_argument_and_parameters_are_those_of_differences() {
    const STEP: f64 = 1e-6;
    for case in continuous().into_iter().chain(counts()) {
        let is_count = (case.plain)(case.parameters).is_discrete();
        let [low, high] = case.range;
        for part in 1..8 {
            // Near the low end, where most of the probability is for those with an edge.
            let x = low + (high - low) * (0.03 + 0.9 * (part as f64 / 8.0).powi(3));
            let x = if is_count { x.round() } else { x };
            let number = |value: f64, direction: usize| Dual::<f64, 4>::variable(value, direction);
            let parameters = [number(case.parameters[0], 0), number(case.parameters[1], 1)];
            let argument = if is_count { Dual::constant(x) } else { number(x, 2) };
            let found = (case.of)(parameters).log_density(argument);
            let value = |[a, b, x]: [f64; 3]| (case.plain)([a, b]).log_density(x);
            let point = [case.parameters[0], case.parameters[1], x];
            if value(point) == f64::NEG_INFINITY {
                continue;
            }
            assert_eq!(found.value(), value(point), "{} at {x}", case.name);
            for direction in 0..if is_count { 2 } else { 3 } {
                let moved = |by: f64| {
                    let mut moved = point;
                    moved[direction] += by;
                    value(moved)
                };
                let difference = (moved(STEP) - moved(-STEP)) / (2.0 * STEP);
                let error = (found.derivatives()[direction] - difference).abs();
                assert!(
                    error < 1e-6 * (1.0 + difference.abs()),
                    "{} at {x}, direction {direction}: {error}",
                    case.name
                );
            }
        }
    }
}

#[test]
fn moments_are_those_of_draws() {
    for case in continuous().into_iter().chain(counts()) {
        let [mean, variance] = (case.plain)(case.parameters).moments();
        let [_, bulk] = draws(&case);
        let n = bulk.len() as f64;
        let z = (bulk.iter().sum::<f64>() / n - mean) / (variance / n).sqrt();
        assert!(z.abs() < 4.0, "{}: the mean is off by {z} standard errors", case.name);
        let squares: Vec<f64> = bulk.iter().map(|x| (x - mean).powi(2)).collect();
        let found = squares.iter().sum::<f64>() / n;
        let error = (squares.iter().map(|s| (s - found).powi(2)).sum::<f64>() / n / n).sqrt();
        assert!(((found - variance) / error).abs() < 4.5, "{}: variance {found} for {variance}", case.name);
    }
}

/// Catches outliers that are given the information of a number near by: the state is then held where it is.
#[test]
fn an_outlier_of_heavy_tails_says_next_to_nothing() {
    for distribution in [student_t(3.0, 1.0, 0.5), laplace(1.0, 0.5)] {
        let [near, far] = [1.05, 101.0].map(|y| distribution.score(y));
        assert!((far.information - far.slope / 100.0).abs() < 1e-15, "{far:?}");
        assert!(far.information < 0.02 * near.information && near.information < near.slope / 0.05);
    }
}

#[test]
fn the_information_is_the_variance_of_the_score() {
    // Of those whose support does not move with the location.
    for case in continuous().into_iter().chain(counts()) {
        let distribution = (case.plain)(case.parameters);
        if matches!(
            distribution,
            Distribution::Exponential(_) | Distribution::Gamma(_) | Distribution::Uniform(_)
        ) {
            continue;
        }
        let [_, bulk] = draws(&case);
        let n = bulk.len() as f64;
        let scores: Vec<_> = bulk.iter().map(|y| distribution.score(*y)).collect();
        // That of heavy tails is smaller far out.
        let information = scores.iter().map(|score| score.information).fold(0.0, f64::max);
        let mean = scores.iter().map(|score| score.slope).sum::<f64>() / n;
        assert!(
            (mean / (information / n).sqrt()).abs() < 4.0,
            "{}: the score has the mean {mean}",
            case.name
        );
        let squares: Vec<f64> = scores.iter().map(|score| score.slope * score.slope).collect();
        let found = squares.iter().sum::<f64>() / n;
        let error = (squares.iter().map(|s| (s - found).powi(2)).sum::<f64>() / n / n).sqrt();
        // Laplace's has one size only, and so no error.
        let off = (found - information).abs();
        assert!(off <= 4.5 * error + 1e-9 * information, "{}: {found} for {information}", case.name);
    }
}

#[test]
fn parameters_out_of_range_give_nan() {
    let wrong: [Distribution<f64>; 16] = [
        beta(0.0, 1.0),
        beta(1.0, -1.0),
        normal(0.0, 0.0),
        normal(0.0, -1.0),
        student_t(0.0, 0.0, 1.0),
        laplace(0.0, -1.0),
        log_normal(0.0, 0.0),
        exponential(-1.0),
        gamma(-1.0, 1.0),
        uniform(1.0, 1.0),
        poisson(-1.0),
        poisson(f64::NAN),
        negative_binomial(2.0, 0.0),
        binomial(2.5, 0.5),
        binomial(3.0, 1.5),
        poisson(2.0).scaled(2.0),
    ];
    for distribution in wrong {
        for x in [0.0, 1.0] {
            assert!(distribution.log_density(x).is_nan(), "{distribution:?} at {x}");
        }
        assert!(distribution.sample(&mut Seed::from_u64(1).stream()).is_nan(), "{distribution:?}");
    }
    // A mean of 0 is one of counts, all of which are 0.
    let none = poisson::<f64>(0.0);
    assert_eq!([none.log_density(0.0), none.log_density(1.0)], [0.0, f64::NEG_INFINITY]);
}

#[test]
fn a_mean_beyond_numbers_makes_counts_unlikely_and_not_wrong() {
    let poisson: Distribution<f64> = poisson(f64::INFINITY);
    let overdispersed: Distribution<f64> = negative_binomial(f64::INFINITY, 2.0);
    for count in [0.0, 3.0] {
        assert!(poisson.log_density(count) < -1e100, "{}", poisson.log_density(count));
        assert!(overdispersed.log_density(count) < -1e3, "{}", overdispersed.log_density(count));
    }
}

/// Catches logarithms of large numbers that cancel each other: right values are those of the limits, with the next term of the expansion.
#[test]
fn large_sizes_keep_their_digits() {
    let density = |distribution: Distribution<f64>, x: f64| distribution.log_density(x);
    for size in [1e7, 1e8, 1e9, 3e9, 1e12, 1e14, 1e16] {
        let next = (10.0 * 10.0 - 310.0) / (2.0 * size);
        let found = density(negative_binomial(300.0, size), 310.0);
        assert!((found + 3.952_338_574_182_477 - next).abs() < 2e-6, "size {size}: {found}");
        let found = density(student_t(size, 0.0, 1.0), 1.0);
        assert!((found + 1.418_938_533_204_672_7 + 0.5 / size).abs() < 1e-6, "df {size}: {found}");
        let found = density(binomial(size.min(9e15), 3.0 / size.min(9e15)), 2.0);
        let poisson = 2.0 * 3.0_f64.ln() - 3.0 - 2.0_f64.ln();
        assert!((found - poisson).abs() < 2e-6, "n {size}: {found}");
    }
    // Derivatives do, too: of the size it is next to nothing, of the mean x/mean − 1.
    let mean = Dual::<f64, 4>::variable(300.0, 0);
    let found = negative_binomial(mean, Dual::constant(1e12)).log_density(Dual::constant(310.0));
    assert!((found.derivatives()[0] - 10.0 / 300.0).abs() < 1e-9);
}
