//! A model stated once, against the same model written by hand, and against what its statement means.

use motes_models::batch::Rows;
use motes_models::equations::{
    Coordinates, Draws, Equations, Lanes, Linearise, Scalar, binomial, exponential, gamma, laplace,
    log_normal, negative_binomial, normal, poisson, student_t, uniform,
};
use motes_models::{
    LinearGaussian, Seed, Simulator, StateGradients, StateSpaceModel, Step, Stream, check_gradients,
    check_model, simulate,
};

/// Two coordinates that depend on each other, and a measurement of every kind.
struct ThreeDraws;

impl Equations for ThreeDraws {
    fn dimensions(&self) -> [usize; 2] {
        [2, 6]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.5, 0.8));
        state[1] = draws.draw(gamma(3.0, 0.5));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(student_t(5.0, x[0].sin() + x[1] * 0.3 + (step.time).cos(), 0.7));
        state[1] = draws.draw(log_normal(x[0].tanh() * 0.2 + x[1].ln() * 0.8, 0.4));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(laplace(x[0] * x[1], x[1].sqrt()));
        y.push(poisson(x[0].exp()));
        y.push(negative_binomial(x[1], 2.5));
        y.push(binomial(10.0, S::from(1.0) / ((-x[0]).exp() + 1.0)));
        y.push(exponential(1.0).scaled(x[1]).shifted(x[0]));
        y.push(normal(x[0].atan2(x[1]), 0.3));
    }
}

#[test]
fn gradients_are_those_of_differences() {
    let report = check_gradients(&ThreeDraws, 4, 1e-5, &mut Seed::from_u64(3).stream()).unwrap();
    assert!(report.compared > 10 * report.skipped, "{report:?}");
}

#[test]
fn a_batch_has_the_densities_and_gradients_of_its_rows() {
    let seed = Seed::from_u64(4);
    let data = simulate(&ThreeDraws, 3, &mut seed.child("data").stream()).unwrap();
    // More than a tile, and not whole ones.
    let count = 77;
    let (mut before, mut now) = (vec![0.0; 2 * count], vec![0.0; 2 * count]);
    ThreeDraws.sample_states(&Step::of_index(0), None, &mut [seed.child("before").stream()], &mut before);
    ThreeDraws.sample_states(
        &Step::of_index(1),
        Some(Rows::all(&before, 2)),
        &mut [seed.child("now").stream()],
        &mut now,
    );
    let y = data.measurements.row(1);
    let mut batch = vec![0.0; count];
    let row = |all: &[f64], k: usize| all[2 * k..2 * k + 2].to_vec();
    ThreeDraws.density().unwrap().log_densities(&Step::of_index(0), None, &before, &mut batch);
    (0..count).for_each(|k| {
        assert_eq!(
            batch[k],
            ThreeDraws.density().unwrap().log_density(&Step::of_index(0), None, &row(&before, k))
        )
    });
    ThreeDraws.density().unwrap().log_densities(
        &Step::of_index(1),
        Some(Rows::all(&before, 2)),
        &now,
        &mut batch,
    );
    (0..count).for_each(|k| {
        assert_eq!(
            batch[k],
            ThreeDraws.density().unwrap().log_density(
                &Step::of_index(1),
                Some(&row(&before, k)),
                &row(&now, k)
            )
        )
    });
    let entries: Vec<Option<f64>> = y.iter().copied().map(Some).collect();
    ThreeDraws.log_likelihoods(&Step::of_index(1), &now, &entries, &mut batch).unwrap();
    (0..count).for_each(|k| {
        assert_eq!(batch[k], ThreeDraws.log_likelihood(&Step::of_index(1), &row(&now, k), y).unwrap())
    });
    let (mut all, mut one) = (vec![0.0; 2 * count], vec![0.0; 2]);
    ThreeDraws.likelihood_gradients(&Step::of_index(1), &now, y, &mut all);
    for k in 0..count {
        ThreeDraws.likelihood_gradients(&Step::of_index(1), &row(&now, k), y, &mut one);
        assert_eq!(row(&all, k), one);
    }
}

#[test]
fn a_stream_draws_the_same_beside_others() {
    for each in [1, 10, 33, 300] {
        let previous = vec![0.7; 2 * 4 * each];
        let draw = |streams: &mut [Stream]| {
            let mut states = vec![0.0; 2 * streams.len() * each];
            let previous = Rows::all(&previous[..states.len()], 2);
            ThreeDraws.sample_states(&Step::of_index(2), Some(previous), streams, &mut states);
            states
        };
        let all = draw(&mut Seed::from_u64(5).streams(4));
        let last = draw(&mut Seed::from_u64(5).streams(4)[3..]);
        assert_eq!(all[2 * 3 * each..], last);
        assert!(all.iter().all(|x| x.is_finite()));
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "a number came twice");
    }
}

#[test]
fn missing_entries_integrate_to_one() {
    let state = [0.4, 1.3];
    let data = simulate(&ThreeDraws, 1, &mut Seed::from_u64(6).stream()).unwrap();
    let whole = data.measurements.row(0);
    let weigh = |measurement: &[Option<f64>]| {
        let mut out = [0.0];
        ThreeDraws.log_likelihoods(&Step::of_index(0), &state, measurement, &mut out).unwrap();
        out[0]
    };
    let all: Vec<Option<f64>> = whole.iter().copied().map(Some).collect();
    assert_eq!(weigh(&all), ThreeDraws.log_likelihood(&Step::of_index(0), &state, whole).unwrap());
    assert_eq!(weigh(&[None; 6]), 0.0);
    // The marginal is the integral, or the sum, over the entry that is missing.
    for (missing, points, step) in
        [(0, -400_000..400_000, 1e-4), (1, 0..200, 1.0), (5, -60_000..60_000, 1e-4)]
    {
        let mut partial = all.clone();
        partial[missing] = None;
        let mut filled = whole.to_vec();
        let sum: f64 = points
            .map(|i| {
                filled[missing] = f64::from(i) * step;
                ThreeDraws.log_likelihood(&Step::of_index(0), &state, &filled).unwrap().exp() * step
            })
            .sum();
        assert!(
            (weigh(&partial) - sum.ln()).abs() < 1e-6,
            "entry {missing}: {} for {}",
            weigh(&partial),
            sum.ln()
        );
    }
}

/// The growth model by hand, one row at a time.
struct ByHand;

/// And stated.
struct Stated;

impl Equations for Stated {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let x = x[0];
        let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
        state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] * x[0] / 20.0, 1.0));
    }
}

impl ByHand {
    fn log_normal(x: f64, mean: f64, variance: f64) -> f64 {
        -0.5 * ((x - mean).powi(2) / variance + (std::f64::consts::TAU * variance).ln())
    }

    fn log_transition(time: usize, x: f64, next: f64) -> f64 {
        let drift = x / 2.0 + 25.0 * x / (1.0 + x * x) + 8.0 * (1.2 * time as f64).cos();
        ByHand::log_normal(next, drift, 10.0)
    }
}

#[test]
fn what_is_stated_is_what_would_be_written_by_hand() {
    let data = simulate(&Stated, 50, &mut Seed::from_u64(7).stream()).unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a} for {b}");
    for time in 0..50 {
        let (x, y) = (data.states.row(time), data.measurements.row(time));
        near(
            Stated.density().unwrap().log_density(&Step::of_index(0), None, x),
            ByHand::log_normal(x[0], 0.0, 5.0),
        );
        near(
            Stated.log_likelihood(&Step::of_index(time), x, y).unwrap(),
            ByHand::log_normal(y[0], x[0] * x[0] / 20.0, 1.0),
        );
        if time > 0 {
            let before = data.states.row(time - 1);
            near(
                Stated.density().unwrap().log_density(&Step::of_index(time), Some(before), x),
                ByHand::log_transition(time, before[0], x[0]),
            );
        }
    }
}

/// A model that states another number of coordinates than it says.
struct Ragged(usize);

impl Equations for Ragged {
    fn dimensions(&self) -> [usize; 2] {
        [2, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        for i in 0..self.0 {
            let drawn = draws.draw(uniform(0.0, 1.0));
            state.get_mut(i).into_iter().for_each(|coordinate| *coordinate = drawn);
        }
    }

    fn transition<S: Scalar>(&self, step: &Step<'_, S>, _: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        self.initial(step, draws, state);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, _: &[S], y: &mut impl Coordinates<S>) {
        (0..self.0).for_each(|_| y.push(uniform(0.0, 1.0)));
    }
}

#[test]
fn another_number_of_coordinates_than_there_are_is_nan() {
    for stated in [0, 1, 3] {
        let (model, mut state) = (Ragged(stated), [0.5; 2]);
        assert!(model.density().unwrap().log_density(&Step::of_index(0), None, &state).is_nan());
        assert!(model.density().unwrap().log_density(&Step::of_index(1), Some(&[0.5; 2]), &state).is_nan());
        assert!(model.log_likelihood(&Step::of_index(1), &[0.5; 2], &state).unwrap().is_nan());
        let mut out = [0.0];
        model.log_likelihoods(&Step::of_index(0), &[0.5; 2], &[Some(0.5), None], &mut out).unwrap();
        assert!(out[0].is_nan());
        model.sample_measurements(
            &Step::of_index(0),
            &[0.5; 2],
            &mut [Seed::from_u64(1).stream()],
            &mut state,
        );
        assert!(state.iter().all(|x| x.is_nan()));
        let said = check_model(&model).unwrap_err().to_string();
        assert!(said.contains(&format!("{stated} draws for 2 coordinates at step 0")), "{said}");
    }
    assert!(check_model(&Ragged(2)).is_ok());
    assert_eq!(Ragged(2).density().unwrap().log_density(&Step::of_index(0), None, &[0.5; 2]), 0.0);
}

#[test]
fn a_linear_model_is_its_own_linearisation() {
    const LANES: usize = motes_models::batch::LANES;
    let states: Vec<f64> = (0..LANES).map(|lane| 0.2 * lane as f64 - 3.0).collect();
    let (mut slopes, mut information, mut jacobian) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    Stated.tile_scores(
        &Step::of_index(1),
        &states,
        &[Some(Lanes::from(2.0))],
        &mut slopes,
        &mut information,
        &mut jacobian,
    );
    for lane in 0..LANES {
        let x = states[lane];
        assert!((jacobian[lane] - x / 10.0).abs() < 1e-15 && information[lane] == 1.0);
        assert!((slopes[lane] - (2.0 - x * x / 20.0)).abs() < 1e-14);
    }
    let (mut means, mut variances) = ([0.0; LANES], [0.0; LANES]);
    Stated.tile_moments(&Step::of_index(3), Some(&states), &mut means, &mut variances);
    let x = states[5];
    let drift = x / 2.0 + 25.0 * x / (1.0 + x * x) + 8.0 * (1.2_f64 * 3.0).cos();
    assert!((means[5] - drift).abs() < 1e-14 && (variances[5] - 10.0).abs() < 1e-14);
    Stated.tile_scores(&Step::of_index(1), &states, &[None], &mut slopes, &mut information, &mut jacobian);
    assert_eq!([slopes[0], information[0], jacobian[0]], [0.0; 3]);
}

/// What is asked of a model can be asked of one that is stated.
#[test]
fn a_stated_model_is_a_model_like_others() {
    fn asked<M: StateSpaceModel + Simulator + StateGradients>(model: &M) -> usize {
        model.state_dim()
    }
    assert_eq!(asked(&ThreeDraws), 2);
    fn by_hand<M: StateSpaceModel>() {}
    by_hand::<LinearGaussian>();
}
