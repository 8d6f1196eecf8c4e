//! What models do for many particles at once against what they do for one.

use faer::{Mat, mat};
use motes_models::batch::Rows;
use motes_models::{
    AdditiveGaussian, Drift, Epidemic, EpidemicConfig, Gaussian, GraphDiffusion, GraphDiffusionConfig,
    LinearGaussian, Noise, Seed, StateSpaceModel, Step,
};

fn dense() -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.5, -1.0], mat![[1.0, 0.3], [0.3, 2.0]]).unwrap();
    LinearGaussian::new(
        initial,
        mat![[0.9, 0.2], [-0.1, 0.8]],
        mat![[0.5, 0.1], [0.1, 0.4]],
        mat![[1.0, 0.5], [0.0, -0.3], [0.2, 0.2]],
        mat![[0.6, 0.1, 0.0], [0.1, 0.9, 0.2], [0.0, 0.2, 0.7]],
    )
    .unwrap()
}

fn diffusion(drift: Drift, noise: Noise) -> GraphDiffusion {
    let config = GraphDiffusionConfig { drift, noise, ..GraphDiffusionConfig::new(7) };
    GraphDiffusion::random(&config, &mut Seed::from_u64(20).stream()).unwrap()
}

fn epidemic(noise: Noise) -> Epidemic {
    Epidemic::new(&EpidemicConfig { noise, ..EpidemicConfig::paper() }).unwrap()
}

fn diffusions() -> impl Iterator<Item = GraphDiffusion> {
    let noises = [Noise::Gaussian, Noise::Exponential, Noise::Uniform];
    [Drift::Identity, Drift::Abs]
        .into_iter()
        .flat_map(move |drift| noises.map(|noise| diffusion(drift, noise)))
}

fn assert_same(many: &[f64], one: impl Fn(usize) -> f64) {
    for (row, &many) in many.iter().enumerate() {
        let one = one(row);
        assert!(many == one || (many - one).abs() < 1e-12 * (1.0 + one.abs()), "row {row}: {many} for {one}");
    }
}

/// Draws and densities of a model, for batches that do and do not fill their tiles.
fn check(model: &impl StateSpaceModel) {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let measurement: Vec<f64> = (0..m).map(|i| 0.3 * i as f64).collect();
    for particles in [1, 8, 31, 32, 33, 100] {
        let mut streams = Seed::from_u64(21).streams(2);
        let (mut previous, mut states) =
            (vec![f64::NAN; 2 * particles * n], vec![f64::NAN; 2 * particles * n]);
        model.sample_states(&Step::of_index(0), None, &mut streams, &mut previous);
        model.sample_states(&Step::of_index(1), Some(Rows::all(&previous, n)), &mut streams, &mut states);

        let mut out = vec![f64::NAN; 2 * particles];
        model.density().unwrap().log_densities(&Step::of_index(0), None, &previous, &mut out);
        assert_same(&out, |row| {
            model.density().unwrap().log_density(&Step::of_index(0), None, &previous[row * n..][..n])
        });
        model.density().unwrap().log_densities(
            &Step::of_index(1),
            Some(Rows::all(&previous, n)),
            &states,
            &mut out,
        );
        // What was drawn lies in the support.
        assert!(out.iter().all(|density| density.is_finite()));
        assert_same(&out, |row| {
            model.density().unwrap().log_density(
                &Step::of_index(1),
                Some(&previous[row * n..][..n]),
                &states[row * n..][..n],
            )
        });
        // Elsewhere, too.
        model.density().unwrap().log_densities(
            &Step::of_index(1),
            Some(Rows::all(&states, n)),
            &previous,
            &mut out,
        );
        assert_same(&out, |row| {
            model.density().unwrap().log_density(
                &Step::of_index(1),
                Some(&states[row * n..][..n]),
                &previous[row * n..][..n],
            )
        });
        let entries: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
        model.log_likelihoods(&Step::of_index(1), &states, &entries, &mut out).unwrap();
        assert_same(&out, |row| {
            model.log_likelihood(&Step::of_index(1), &states[row * n..][..n], &measurement).unwrap()
        });

        // Each stream gives what it gives alone, and rows that were picked what they give where they lie.
        let mut alone = Seed::from_u64(21).streams(2).split_off(1);
        let (mut first, mut second) = (vec![f64::NAN; particles * n], vec![f64::NAN; particles * n]);
        model.sample_states(&Step::of_index(0), None, &mut alone, &mut first);
        assert!(first == previous[particles * n..]);
        let picked: Vec<usize> = (particles..2 * particles).collect();
        let rows = Rows::picked(&previous, n, &picked);
        model.sample_states(&Step::of_index(1), Some(rows), &mut alone, &mut second);
        assert!(second == states[particles * n..]);
        // Drawing and weighing in one pass are the same two things.
        if let Some(propagator) = model.propagator() {
            let (mut third, mut likelihoods) = (vec![f64::NAN; particles * n], vec![f64::NAN; particles]);
            let mut again = Seed::from_u64(21).streams(2).split_off(1);
            model.sample_states(&Step::of_index(0), None, &mut again, &mut first);
            propagator.propagate(
                &Step::of_index(1),
                rows,
                &measurement,
                &mut again,
                &mut third,
                &mut likelihoods,
            );
            assert!(third == second);
            assert_same(&likelihoods, |row| out[particles + row]);
        }
        let mut densities = vec![f64::NAN; particles];
        model.density().unwrap().log_densities(&Step::of_index(1), Some(rows), &second, &mut densities);
        assert_same(&densities, |row| {
            model.density().unwrap().log_density(
                &Step::of_index(1),
                Some(&first[row * n..][..n]),
                &second[row * n..][..n],
            )
        });
    }
}

#[test]
fn batches_are_their_rows() {
    check(&dense());
    for noise in [Noise::Gaussian, Noise::Exponential, Noise::Uniform] {
        check(&epidemic(noise));
    }
    diffusions().for_each(|system| check(&system));
}

#[test]
fn means_of_tiles_are_means_of_rows() {
    for system in diffusions() {
        let n = system.state_dim();
        let previous: Vec<f64> = (0..50 * n).map(|i| (i as f64).sin()).collect();
        let mut means = vec![f64::NAN; 50 * n];
        system.transition_means(&Step::of_index(1), &previous, &mut means);
        for (previous, means) in previous.chunks(n).zip(means.chunks(n)) {
            for (i, mean) in means.iter().enumerate() {
                let flow: f64 = (0..n).map(|j| system.adjacency()[(i, j)] * previous[j]).sum();
                assert!((mean - flow).abs() < 1e-13 || (mean + flow).abs() < 1e-13);
            }
        }
    }
}

/// Mean and covariance of rows minus their expectations, in standard errors of samples that are no worse than Gaussian in their
/// fourth moments by much.
fn check_moments(deviations: &[f64], covariance: impl Fn(usize, usize) -> f64, n: usize) {
    let rows = (deviations.len() / n) as f64;
    for i in 0..n {
        let mean = deviations.chunks(n).map(|row| row[i]).sum::<f64>() / rows;
        assert!(mean.abs() < 4.5 * (covariance(i, i) / rows).sqrt(), "mean {i}: {mean}");
        for j in 0..=i {
            let found = deviations.chunks(n).map(|row| row[i] * row[j]).sum::<f64>() / rows;
            let error = 3.0 * (covariance(i, i) * covariance(j, j) / rows).sqrt();
            assert!((found - covariance(i, j)).abs() < 4.5 * error, "({i}, {j}): {found}");
        }
    }
}

#[test]
fn draws_in_batches_have_the_moments_of_the_model() {
    const ROWS: usize = 100_000;
    fn draw(model: &impl AdditiveGaussian) {
        let n = model.state_dim();
        let mut streams = [Seed::from_u64(22).stream()];
        let (mut initial, mut states) = (vec![0.0; ROWS * n], vec![0.0; ROWS * n]);
        model.sample_states(&Step::of_index(0), None, &mut streams, &mut initial);
        model.sample_states(&Step::of_index(1), Some(Rows::all(&initial, n)), &mut streams, &mut states);
        let mut means = vec![0.0; ROWS * n];
        model.transition_means(&Step::of_index(1), &initial, &mut means);
        states.iter_mut().zip(&means).for_each(|(state, mean)| *state -= mean);
        let q: Mat<f64> = model.transition_covariance().to_owned();
        check_moments(&states, |i, j| q[(i, j)], n);
        initial.chunks_mut(n).for_each(|row| {
            row.iter_mut().zip(model.initial().mean()).for_each(|(value, mean)| *value -= mean);
        });
        let p: Mat<f64> = model.initial().covariance().to_owned();
        check_moments(&initial, |i, j| p[(i, j)], n);
    }
    draw(&dense());
    draw(&epidemic(Noise::Exponential));
    diffusions().for_each(|system| draw(&system));
}

/// The measurements' entries that are there: all, none, and each one missing. What is left is the full density integrated over the rest.
fn assert_marginal(model: &impl StateSpaceModel, state: &[f64], measurement: &[f64], spread: f64) {
    let of = |entries: &[Option<f64>]| {
        let mut out = [f64::NAN];
        model.log_likelihoods(&Step::of_index(3), state, entries, &mut out).unwrap();
        out[0]
    };
    let all: Vec<Option<f64>> = measurement.iter().copied().map(Some).collect();
    let whole = model.log_likelihood(&Step::of_index(3), state, measurement).unwrap();
    assert!((of(&all) - whole).abs() < 1e-12 * whole.abs(), "{} for {whole}", of(&all));
    assert_eq!(of(&vec![None; measurement.len()]), 0.0);
    for missing in 0..measurement.len() {
        let mut entries = all.clone();
        entries[missing] = None;
        let (mut values, points) = (measurement.to_vec(), 40_000);
        let step = 2.0 * spread / points as f64;
        let mut integral = 0.0;
        for at in 0..points {
            values[missing] = measurement[missing] - spread + (at as f64 + 0.5) * step;
            integral += model.log_likelihood(&Step::of_index(3), state, &values).unwrap().exp() * step;
        }
        let found = of(&entries);
        assert!((found - integral.ln()).abs() < 2e-3, "without {missing}: {found} for {}", integral.ln());
    }
}

#[test]
fn what_is_there_of_a_measurement_has_the_marginal_density() {
    assert_marginal(&dense(), &[0.3, -0.8], &[0.1, 0.9, -0.4], 12.0);
    // Rounding beside a large entry would be an asymmetry beside the small ones alone.
    let r = mat![[1e6, 0.0, 0.0], [0.0, 1e-3, 1e-8], [0.0, 0.0, 1e-3]];
    let initial = Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap();
    let model = LinearGaussian::new(initial, mat![[1.0]], mat![[1.0]], mat![[1.0], [1.0], [1.0]], r).unwrap();
    let mut out = [0.0];
    model.log_likelihoods(&Step::of_index(0), &[0.1], &[None, Some(0.1), Some(0.12)], &mut out).unwrap();
    assert!(out[0].is_finite());
    for noise in [Noise::Gaussian, Noise::Exponential, Noise::Uniform] {
        // σ is about 1.5.
        let state = [1.0, 0.5, 0.2, 0.8, 1.3, 0.9, 1.1];
        assert_marginal(&diffusion(Drift::Abs, noise), &state, &[1.0, 0.7, 0.3, 0.8, 1.2], 25.0);
        assert_marginal(&epidemic(noise), &[700.0, 200.0, 100.0], &[720.0, 130.0], 800.0);
    }
}
