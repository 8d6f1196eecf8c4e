//! Transitions as transports of normal noise, tile by tile, and measurements drawn for many states at once.

use motes_models::batch::LANES;
use motes_models::equations::Transport;
use motes_models::equations::{
    Coordinates, Draws, Equations, Lanes, Linearise, Scalar, beta, exponential, gamma, laplace, log_normal,
    normal, poisson, student_t, uniform,
};
use motes_models::{Seed, Simulator, StateSpaceModel, Step, Stream, fill_standard_normal};

const N: usize = 9;

/// A coordinate of every continuous family, whose parameters depend on the state before.
struct Every;

impl Equations for Every {
    fn dimensions(&self) -> [usize; 2] {
        [N, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..N).for_each(|i| state[i] = draws.draw(normal(0.1 * i as f64, 0.5)));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0].sin() + step.time, (x[1] * 0.3).exp()));
        state[1] = draws.draw(student_t(4.0, x[1], x[2].abs() + 0.2));
        state[2] = draws.draw(laplace(x[0] * x[1], 0.4));
        state[3] = draws.draw(log_normal(x[3] * 0.2, 0.4).scaled(-1.5));
        state[4] = draws.draw(exponential(x[4].abs() + 0.1).shifted(x[0]));
        state[5] = draws.draw(gamma(x[5].exp(), 0.5));
        state[6] = draws.draw(gamma(x[5].exp() + 2.0, 0.5).scaled(-1.0));
        state[7] = draws.draw(uniform(-(x[7].abs()) - 0.2, x[6].abs()));
        state[8] = draws.draw(beta(x[8].exp() + 0.3, x[0].abs() + 0.5).scaled(-2.0).shifted(x[8]));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.3));
        y.push(poisson((x[1] * 0.5).exp()));
    }
}

/// Likely states, and noise, in a tile.
fn tiles(seed: u64) -> [Vec<f64>; 2] {
    ["previous", "noise"].map(|label| {
        let mut tile = vec![0.0; N * LANES];
        fill_standard_normal(&mut Seed::from_u64(seed).child(label).stream(), &mut tile);
        tile
    })
}

/// The numbers of one particle.
fn lane(tile: &[f64], lane: usize) -> Vec<f64> {
    tile.iter().skip(lane).step_by(LANES).copied().collect()
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found - expected).abs() < tolerance * (1.0 + expected.abs()), "{what}: {found} for {expected}");
}

/// Catches a log slope that is not that of the transport, and one that does not make the density of `x`: both ways weights would be wrong.
#[test]
fn the_density_of_what_is_transported_is_the_models() {
    let [previous, noise] = tiles(70);
    let (mut states, mut log_slope) = (noise.clone(), [0.0; LANES]);
    Every.tile_from_normal(&Step::of_index(2), Some(&previous), &mut states, &mut log_slope);
    let (mut back, mut slope_back) = (states.clone(), [0.0; LANES]);
    Every.tile_to_normal(&Step::of_index(2), Some(&previous), &mut back, &mut slope_back);
    for (k, found) in log_slope.iter().enumerate() {
        let (before, now, v) = (lane(&previous, k), lane(&states, k), lane(&noise, k));
        let of_noise: f64 = v.iter().map(|v| -0.5 * v * v - 0.5 * std::f64::consts::TAU.ln()).sum();
        near(
            of_noise - found,
            Every.density().unwrap().log_density(&Step::of_index(2), Some(&before), &now),
            1e-9,
            "log density",
        );
        near(slope_back[k], *found, 1e-8, "log slope of the inverse");
        lane(&back, k).iter().zip(&v).for_each(|(back, v)| near(*back, *v, 1e-8, "back"));
    }
    // The slope is that of differences.
    const STEP: f64 = 1e-5;
    let moved = |by: f64| {
        let mut moved: Vec<f64> = noise.iter().map(|v| v + by).collect();
        Every.tile_from_normal(&Step::of_index(2), Some(&previous), &mut moved, &mut [0.0; LANES]);
        moved
    };
    let (up, down) = (moved(STEP), moved(-STEP));
    for (k, found) in log_slope.iter().enumerate() {
        let pairs = lane(&up, k).into_iter().zip(lane(&down, k));
        let sum: f64 = pairs.map(|(up, down)| ((up - down) / (2.0 * STEP)).ln()).sum();
        near(*found, sum, 1e-6, "differences");
    }
}

/// Catches a tile whose particles are not each their own, or whose normals are only nearly those asked for.
#[test]
fn centres_are_medians_and_their_slopes() {
    let [previous, _] = tiles(71);
    for before in [None, Some(&previous[..])] {
        let (mut centres, mut slopes) = (vec![0.0; N * LANES], vec![0.0; N * LANES]);
        Every.tile_centres(&Step::of_index(3), before, &mut centres, &mut slopes);
        let (mut medians, mut log_slope) = (vec![0.0; N * LANES], [0.0; LANES]);
        Every.tile_from_normal(&Step::of_index(3), before, &mut medians, &mut log_slope);
        assert_eq!(centres, medians);
        for (k, log_slope) in log_slope.iter().enumerate() {
            near(lane(&slopes, k).iter().map(|slope| slope.ln()).sum(), *log_slope, 1e-13, "slopes");
        }
        // Normals are asked for mean and deviation themselves.
        let (mut means, mut variances) = (vec![0.0; N * LANES], vec![0.0; N * LANES]);
        Every.tile_moments(&Step::of_index(3), before, &mut means, &mut variances);
        assert_eq!(centres[..LANES], means[..LANES]);
        let squares: Vec<f64> = slopes[..LANES].iter().map(|slope| slope * slope).collect();
        assert_eq!(squares, variances[..LANES]);
    }
}

/// A walk with normal noise, but for how it may start, and from when on it may be heavy-tailed; its measurements are counts.
struct Walk {
    starts_wide: bool,
    heavy_from: usize,
}

impl Equations for Walk {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
        state[1] = draws.draw(if self.starts_wide { uniform(-3.0, 3.0) } else { normal(0.0, 1.0) });
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * x[1], 0.3));
        state[1] = draws.draw(if step.index >= self.heavy_from {
            student_t(3.0, x[1], 0.3)
        } else {
            normal(x[1], 0.3)
        });
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson(x[0].exp()));
    }
}

/// Catches a look at one coordinate, at one time, or at measurements.
#[test]
fn affine_is_what_has_normal_coordinates_only() {
    let normal = Walk { starts_wide: false, heavy_from: usize::MAX };
    assert!(normal.is_affine());
    assert!(!Walk { starts_wide: true, ..normal }.is_affine());
    assert!(!Walk { starts_wide: false, heavy_from: 1 }.is_affine());
    assert!(!Walk { starts_wide: false, heavy_from: 4 }.is_affine());
    assert!(!Every.is_affine());
}

/// States fewer coordinates than it has, or more.
struct Ragged(usize);

impl Equations for Ragged {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        for i in 0..self.0 {
            let drawn = draws.draw(normal(0.0, 1.0));
            state.get_mut(i).into_iter().for_each(|coordinate| *coordinate = drawn);
        }
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, _: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        self.initial(step, draws, state);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, _: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, 1.0));
    }
}

/// Catches a wrong model whose noise would pass for states.
#[test]
fn another_number_of_coordinates_than_there_are_is_nan() {
    for stated in [0, 1, 3] {
        let (mut values, mut log_slope) = (vec![0.5; 2 * LANES], [0.0; LANES]);
        Ragged(stated).tile_from_normal(&Step::of_index(0), None, &mut values, &mut log_slope);
        assert!(log_slope.iter().all(|slope| slope.is_nan()));
        let (mut values, mut log_slope) = (vec![0.5; 2 * LANES], [0.0; LANES]);
        Ragged(stated).tile_to_normal(&Step::of_index(0), None, &mut values, &mut log_slope);
        assert!(log_slope.iter().all(|slope| slope.is_nan()));
    }
}

/// Catches measurements of other states, of another time's distribution, and of another stream.
#[test]
fn measurements_in_a_batch_have_the_distribution_of_those_one_by_one() {
    const EACH: usize = 20_000;
    // Three streams, each with states of its own.
    let places = [-1.0, 0.0, 1.5];
    let states: Vec<f64> = places.iter().flat_map(|x| std::iter::repeat_n(*x, N * EACH)).collect();
    let draw = |streams: &mut [Stream], states: &[f64]| {
        let mut out = vec![f64::NAN; 2 * states.len() / N];
        Every.sample_measurements(&Step::of_index(3), states, streams, &mut out);
        out
    };
    let all = draw(&mut Seed::from_u64(72).streams(3), &states);
    let last = draw(&mut Seed::from_u64(72).streams(3)[2..], &states[2 * N * EACH..]);
    assert_eq!(all[2 * 2 * EACH..], last, "a stream depends on the others");
    let mut stream = Seed::from_u64(73).stream();
    for (x, batch) in places.iter().zip(all.chunks_exact(2 * EACH)) {
        let mut alone = vec![0.0; 2 * EACH];
        alone.chunks_exact_mut(2).for_each(|y| {
            Every.sample_measurements(&Step::of_index(3), &[*x; N], std::slice::from_mut(&mut stream), y)
        });
        for entry in 0..2 {
            let column = |rows: &[f64]| rows.iter().skip(entry).step_by(2).copied().collect::<Vec<_>>();
            let [together, alone] = [column(batch), column(&alone)].map(|draws| moments(&draws));
            for (order, (one, other)) in together.iter().zip(&alone).enumerate() {
                let error = (one[1] + other[1]).sqrt();
                let z = (one[0] - other[0]) / error;
                assert!(z.abs() < 4.5, "at {x}, entry {entry}, moment {order}: {z} standard errors");
            }
        }
    }
    Every.sample_measurements(&Step::of_index(3), &[], &mut [], &mut []);
}

/// The mean, and the mean square, each with its squared standard error.
fn moments(draws: &[f64]) -> [[f64; 2]; 2] {
    let count = draws.len() as f64;
    [1, 2].map(|order| {
        let powers = || draws.iter().map(|x| x.powi(order));
        let mean = powers().sum::<f64>() / count;
        [mean, powers().map(|power| (power - mean).powi(2)).sum::<f64>() / count / count]
    })
}

/// Catches particles that all get the first one's measurement.
#[test]
fn particles_are_scored_by_their_own_measurements() {
    let [states, noise] = tiles(74);
    let own = Lanes(noise[..LANES].try_into().unwrap());
    let score = |measurement: &[Option<Lanes>]| {
        let (mut slopes, mut information) = ([0.0; 2 * LANES], [0.0; 2 * LANES]);
        let mut jacobian = [0.0; 2 * N * LANES];
        Every.tile_scores(
            &Step::of_index(1),
            &states,
            measurement,
            &mut slopes,
            &mut information,
            &mut jacobian,
        );
        slopes
    };
    let together = score(&[Some(own), None]);
    for (k, y) in own.0.into_iter().enumerate() {
        assert_eq!(together[k], score(&[Some(Lanes::from(y)), None])[k]);
    }
    assert_ne!(together[0], score(&[Some(Lanes::from(own.0[1])), None])[0]);
}
