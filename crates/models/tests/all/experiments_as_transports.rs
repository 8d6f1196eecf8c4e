//! The paper's systems as what linearised and learned proposals ask of a model: transports, moments and scores.

use motes_models::batch::{LANES, Rows};
use motes_models::equations::{Lanes, Linearise, Transport};
use motes_models::{
    Drift, Epidemic, EpidemicConfig, GraphDiffusion, GraphDiffusionConfig, Noise, Seed, Simulator,
    StateSpaceModel, Step, fill_standard_normal,
};

const NOISES: [Noise; 3] = [Noise::Gaussian, Noise::Exponential, Noise::Uniform];

fn graph(noise: Noise, drift: Drift) -> GraphDiffusion {
    let config = GraphDiffusionConfig { noise, drift, ..GraphDiffusionConfig::new(6) };
    GraphDiffusion::random(&config, &mut Seed::from_u64(3).stream()).unwrap()
}

fn epidemic(noise: Noise) -> Epidemic {
    Epidemic::new(&EpidemicConfig::paper()).unwrap().with_noise(noise)
}

/// The numbers of one particle.
fn lane(tile: &[f64], lane: usize) -> Vec<f64> {
    tile.iter().skip(lane).step_by(LANES).copied().collect()
}

/// States that are likely at first, each in a lane.
fn likely(model: &impl StateSpaceModel) -> Vec<f64> {
    let n = model.state_dim();
    let (mut stream, mut state) = (Seed::from_u64(5).stream(), vec![0.0; n]);
    let mut tile = vec![0.0; n * LANES];
    for lane in 0..LANES {
        model.sample_states(&Step::of_index(0), None, std::slice::from_mut(&mut stream), &mut state);
        state.iter().enumerate().for_each(|(i, x)| tile[i * LANES + lane] = *x);
    }
    tile
}

/// A transport makes of normal noise what has the density of the transition, and its inverse gives the noise back.
fn transports_the_transition(model: &impl Transport) {
    let n = model.state_dim();
    let previous = likely(model);
    for previous in [None, Some(previous.as_slice())] {
        let mut noise = vec![0.0; n * LANES];
        fill_standard_normal(&mut Seed::from_u64(8).stream(), &mut noise);
        let (mut states, mut log_slopes) = (noise.clone(), [0.0; LANES]);
        model.tile_from_normal(&Step::of_index(1), previous, &mut states, &mut log_slopes);
        for (at, log_slope) in log_slopes.iter().enumerate() {
            let state = lane(&states, at);
            let expected = match previous {
                None => model.density().unwrap().log_density(&Step::of_index(0), None, &state),
                Some(previous) => model.density().unwrap().log_density(
                    &Step::of_index(1),
                    Some(&lane(previous, at)),
                    &state,
                ),
            };
            let normal: f64 =
                lane(&noise, at).iter().map(|v| -0.5 * v * v - 0.5 * motes_models::LN_2PI).sum();
            let found = normal - log_slope;
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found} for {expected}");
        }
        let mut back = states.clone();
        model.tile_to_normal(&Step::of_index(1), previous, &mut back, &mut log_slopes);
        for (found, expected) in back.iter().zip(&noise) {
            assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
        }
        let (mut centres, mut slopes) = (vec![0.0; n * LANES], vec![0.0; n * LANES]);
        model.tile_centres(&Step::of_index(1), previous, &mut centres, &mut slopes);
        let mut medians = vec![0.0; n * LANES];
        model.tile_from_normal(&Step::of_index(1), previous, &mut medians, &mut log_slopes);
        assert_eq!(centres, medians, "medians are what no noise leads to");
        let product: f64 = lane(&slopes, 2).iter().map(|slope| slope.ln()).sum();
        assert!((product - log_slopes[2]).abs() < 1e-9);
    }
}

/// Moments are those of many draws, and scores of Gaussian noise the derivatives of the density.
fn moments_and_scores(model: &(impl Linearise + Simulator), is_gaussian: bool) {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let previous = likely(model);
    let (mut means, mut variances) = (vec![0.0; n * LANES], vec![0.0; n * LANES]);
    model.tile_moments(&Step::of_index(1), Some(&previous), &mut means, &mut variances);
    let (mut stream, mut state) = (Seed::from_u64(6).stream(), vec![0.0; n]);
    let count = 20_000;
    let mut sums = vec![[0.0; 2]; n];
    let from = lane(&previous, 4);
    for _ in 0..count {
        model.sample_states(
            &Step::of_index(1),
            Some(Rows::all(&from, from.len())),
            std::slice::from_mut(&mut stream),
            &mut state,
        );
        for ((sum, x), mean) in sums.iter_mut().zip(&state).zip(lane(&means, 4)) {
            sum[0] += (x - mean) / f64::from(count);
            sum[1] += (x - mean).powi(2) / f64::from(count);
        }
    }
    for (sum, variance) in sums.iter().zip(lane(&variances, 4)) {
        let error = (variance / f64::from(count)).sqrt();
        assert!(sum[0].abs() < 5.0 * error, "{sum:?}");
        // The variance of the square of an exponential deviation is eight times the square of its variance.
        assert!((sum[1] - variance).abs() < 5.0 * variance * (8.0 / f64::from(count)).sqrt(), "{sum:?}");
    }

    let mut measurement = vec![0.0; m];
    model.sample_measurements(&Step::of_index(1), &from, std::slice::from_mut(&mut stream), &mut measurement);
    let mut entries: Vec<Option<Lanes>> = measurement.iter().map(|y| Some(Lanes::from(*y))).collect();
    let [mut slopes, mut information] = [0, 1].map(|_| vec![f64::NAN; m * LANES]);
    let mut jacobian = vec![f64::NAN; m * n * LANES];
    model.tile_scores(&Step::of_index(1), &previous, &entries, &mut slopes, &mut information, &mut jacobian);
    assert!(information.iter().all(|information| *information > 0.0));
    if is_gaussian {
        for i in 0..n {
            let along: f64 = (0..m).map(|j| slopes[j * LANES + 4] * jacobian[(j * n + i) * LANES + 4]).sum();
            let moved = |by: f64| {
                let mut state = from.clone();
                state[i] += by;
                model.log_likelihood(&Step::of_index(1), &state, &measurement).unwrap()
            };
            let difference = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!((along - difference).abs() < 1e-6 * (1.0 + difference.abs()), "{along} for {difference}");
        }
    }
    // What is missing says nothing.
    entries[0] = None;
    model.tile_scores(&Step::of_index(1), &previous, &entries, &mut slopes, &mut information, &mut jacobian);
    assert!(slopes[..LANES].iter().chain(&jacobian[..n * LANES]).all(|value| *value == 0.0));
}

#[test]
fn systems_on_graphs() {
    for noise in NOISES {
        for drift in [Drift::Identity, Drift::Abs] {
            let model = graph(noise, drift);
            assert_eq!(model.is_affine(), noise == Noise::Gaussian);
            transports_the_transition(&model);
            moments_and_scores(&model, noise == Noise::Gaussian);
        }
    }
}

#[test]
fn epidemics() {
    for noise in NOISES {
        let model = epidemic(noise);
        transports_the_transition(&model);
        moments_and_scores(&model, noise == Noise::Gaussian);
    }
}
