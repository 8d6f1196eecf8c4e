//! Distributions as transports of normal noise: exact in both tails, with the slope of their density.

use motes_models::batch::LANES;
use motes_models::equations::{
    Coordinates, Distribution, Equations, Scalar, Transport, exponential, gamma, laplace, log_normal, normal,
    poisson, student_t, uniform,
};
use motes_models::{Seed, Simulator, StateSpaceModel, simulate};

/// Each family, whole, and turned around where it has an end.
fn families() -> Vec<Distribution<f64>> {
    vec![
        normal(1.0, 2.0),
        student_t(1.0, 0.5, 2.0),
        student_t(4.0, -3.0, 0.5),
        student_t(30.0, 0.0, 1.0),
        laplace(1.0, 0.3),
        log_normal(0.2, 0.7),
        log_normal(0.2, 0.7).scaled(-2.0).shifted(1.0),
        exponential(3.0),
        exponential(3.0).scaled(-1.0).shifted(2.0),
        gamma(0.4, 2.0),
        gamma(3.5, 0.2),
        gamma(3.5, 0.2).scaled(-1.0),
        uniform(-1.0, 4.0),
    ]
}

#[test]
fn a_number_that_went_there_comes_back() {
    for family in families() {
        for step in -24..=24 {
            let v = 0.25 * f64::from(step);
            let x = family.from_normal(v);
            // What one step of the floating-point numbers of x moves v by.
            let slope = (-0.5 * v * v - 0.5 * std::f64::consts::TAU.ln() - family.log_density(x)).exp();
            let mut grain = 1e-10 + 16.0 * f64::EPSILON * (x.abs() + 5.0) / slope;
            // One tail of a gamma distribution is only known as what the other leaves of 1.
            if matches!(family, Distribution::Gamma { .. }) {
                grain += 1e-15 * (0.5 * v * v).exp();
            }
            let back = family.to_normal(x);
            assert!((back - v).abs() < grain, "{family:?} at {v}: {back} through {x}, allowed {grain}");
        }
    }
}

#[test]
fn it_increases_with_the_slope_of_its_density() {
    for family in families() {
        for v in [-4.0, -1.3, -0.1, 0.6, 2.0, 4.0] {
            let h = 1e-4;
            let (down, x, up) = (family.from_normal(v - h), family.from_normal(v), family.from_normal(v + h));
            assert!(down < x && x < up, "{family:?} at {v}");
            let expected = (-0.5 * v * v - 0.5 * std::f64::consts::TAU.ln() - family.log_density(x)).exp();
            let found = (up - down) / (2.0 * h);
            assert!((found / expected - 1.0).abs() < 1e-5, "{family:?} at {v}: {found} for {expected}");
        }
    }
}

#[test]
fn draws_become_normal() {
    // By the theorem of Kolmogorov, the largest distance times √n is above 2.2 once in 8000 times.
    for (number, family) in families().into_iter().enumerate() {
        let mut stream = Seed::from_u64(7).nth(number as u64).stream();
        let n = 20_000;
        let mut draws: Vec<f64> = (0..n).map(|_| family.to_normal(family.sample(&mut stream))).collect();
        draws.sort_by(f64::total_cmp);
        let standard: Distribution<f64> = uniform(0.0, 1.0);
        let distance = draws
            .iter()
            .enumerate()
            .map(|(at, v)| (standard.from_normal(*v) - (at as f64 + 0.5) / f64::from(n)).abs())
            .fold(0.0, f64::max);
        assert!(distance * f64::from(n).sqrt() < 2.2, "{family:?}: {distance}");
    }
}

#[test]
fn beyond_the_range_it_is_infinite() {
    let found: Distribution<f64> = uniform(0.0, 1.0);
    assert_eq!((found.to_normal(-0.1), found.to_normal(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
    let found: Distribution<f64> = exponential(1.0).scaled(-1.0);
    assert_eq!((found.to_normal(0.1), found.to_normal(0.0)), (f64::INFINITY, f64::INFINITY));
    let count: Distribution<f64> = poisson(2.0);
    assert!(count.from_normal(0.3).is_nan() && count.to_normal(2.0).is_nan());
    let wrong: Distribution<f64> = gamma(-1.0, 2.0);
    assert!(wrong.from_normal(0.3).is_nan() && wrong.to_normal(2.0).is_nan());
}

/// One coordinate of each kind.
struct Mixed;

impl Equations for Mixed {
    fn dimensions(&self) -> [usize; 2] {
        [2, 2]
    }

    fn initial<S: Scalar>(&self, state: &mut impl Coordinates<S>) {
        (0..2).for_each(|_| state.push(normal(1.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: usize, x: &[S], state: &mut impl Coordinates<S>) {
        state.push(normal(x[1], x[0] * x[0] + 0.5));
        state.push(exponential(x[0].abs() + 0.1).shifted(x[1]));
    }

    fn measurement<S: Scalar>(&self, _: usize, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.5));
        y.push(poisson(x[1].exp()));
    }
}

#[test]
fn tiles_are_particle_by_particle() {
    let streams = &mut [Seed::from_u64(3).stream()];
    let mut previous = vec![0.0; 2 * LANES];
    Mixed.sample_initials(streams, &mut previous);
    // Coordinates in rows: any numbers will do for either.
    let mut values: Vec<f64> = (0..2 * LANES).map(|at| 0.05 * at as f64 - 1.5).collect();
    let noise = values.clone();
    let (mut there, mut back) = ([0.0; LANES], [0.0; LANES]);
    Mixed.tile_from_normal(1, Some(&previous), &mut values, &mut there);
    let (mut centres, mut slopes) = (vec![0.0; 2 * LANES], vec![0.0; 2 * LANES]);
    Mixed.tile_centres(1, Some(&previous), &mut centres, &mut slopes);
    for lane in 0..LANES {
        let (a, b) = (previous[lane], previous[LANES + lane]);
        let first: Distribution<f64> = normal(b, a * a + 0.5);
        let second: Distribution<f64> = exponential(a.abs() + 0.1).shifted(b);
        assert!((values[lane] - first.from_normal(noise[lane])).abs() < 1e-12);
        assert_eq!(values[LANES + lane], second.from_normal(noise[LANES + lane]));
        assert_eq!(centres[LANES + lane], second.from_normal(0.0));
        let log_normal = |v: f64| -0.5 * v * v - 0.5 * std::f64::consts::TAU.ln();
        let of_second = log_normal(noise[LANES + lane]) - second.log_density(values[LANES + lane]);
        assert!((there[lane] - (a * a + 0.5).ln() - of_second).abs() < 1e-9);
    }
    Mixed.tile_to_normal(1, Some(&previous), &mut values, &mut back);
    for (lane, (back, there)) in back.iter().zip(&there).enumerate() {
        assert!((back - there).abs() < 1e-6 && (values[lane] - noise[lane]).abs() < 1e-9);
    }
    assert!(!Mixed.is_affine());
}

#[test]
fn measurements_of_a_batch_are_distributed_as_those_of_one() {
    let states = [0.3, 0.7].repeat(4000);
    let mut batch = vec![0.0; states.len()];
    Mixed.sample_measurements(3, &states, &mut Seed::from_u64(4).streams(4), &mut batch);
    let mean = |at: usize| batch.iter().skip(at).step_by(2).sum::<f64>() / 4000.0;
    // Means 0.3 with deviation 0.5, and e^0.7 = 2.014 with deviation 1.419.
    assert!((mean(0) - 0.3).abs() < 4.0 * 0.5 / 4000_f64.sqrt(), "{}", mean(0));
    assert!((mean(1) - 0.7_f64.exp()).abs() < 4.0 * 1.42 / 4000_f64.sqrt(), "{}", mean(1));
    assert!(simulate(&Mixed, 3, &mut Seed::from_u64(5).stream()).is_ok());
}
