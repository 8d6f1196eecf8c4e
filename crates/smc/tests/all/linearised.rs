//! The linearised proposal: the optimum where there is one, and unbiased evidence everywhere.

use faer::mat;
use motes_models::equations::{
    Coordinates, Draws, Equations, Scalar, exponential, normal, poisson, student_t,
};
use motes_models::{Gaussian, LinearGaussian, Seed, StateSpaceModel, Step, kalman, simulate};
use motes_smc::{
    Bootstrap, Conditional, Context, FilterBank, FilterSettings, Linearised, LinearisedScratch,
    MinDegeneracy, ParticleFilter, Proposal, ResampleWhen,
};

/// `x_t = A x_{t−1} + v`, `y_t = C x_t + w`, with a state of three coordinates and two measurements.
struct Linear;

const VARIANCES: [f64; 3] = [0.5, 1.2, 0.8];
const NOISE: [f64; 2] = [0.3, 0.6];

impl Equations for Linear {
    fn dimensions(&self) -> [usize; 2] {
        [3, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..3).for_each(|i| state[i] = draws.draw(normal(0.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.9 + x[1] * 0.2, VARIANCES[0].sqrt()));
        state[1] = draws.draw(normal(x[1] * 0.7 - x[2] * 0.1, VARIANCES[1].sqrt()));
        state[2] = draws.draw(normal(x[2] * 0.5 + x[0] * 0.3, VARIANCES[2].sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] + x[1] * 0.5, NOISE[0].sqrt()));
        y.push(normal(x[2] - x[0] * 0.4, NOISE[1].sqrt()));
    }
}

/// The same by its matrices.
fn by_matrices() -> LinearGaussian {
    let diagonal = |v: &[f64]| faer::Mat::from_fn(v.len(), v.len(), |i, j| if i == j { v[i] } else { 0.0 });
    LinearGaussian::new(
        Gaussian::new("P_0", vec![0.0; 3], diagonal(&[1.0; 3])).unwrap(),
        mat![[0.9, 0.2, 0.0], [0.0, 0.7, -0.1], [0.3, 0.0, 0.5]],
        diagonal(&VARIANCES),
        mat![[1.0, 0.5, 0.0], [-0.4, 0.0, 1.0]],
        diagonal(&NOISE),
    )
    .unwrap()
}

#[test]
fn where_the_measurement_is_linear_it_is_the_optimum() {
    let matrices = by_matrices();
    let count = 70;
    let seed = Seed::from_u64(11);
    let draw = |label: &str| {
        let mut states = vec![0.0; 3 * count];
        Linear.sample_states(&Step::of_index(0), None, &mut [seed.child(label).stream()], &mut states);
        states
    };
    let (previous, at) = (draw("previous"), draw("at"));
    let mut linearised = Linearised::new(&Linear).unwrap();
    let mut optimal = MinDegeneracy::new(&matrices).unwrap();
    assert!(linearised.sees_measurements());
    for (measurement, time) in [([Some(0.4), Some(-1.1)], 1), ([None, Some(-1.1)], 1), ([Some(2.0), None], 0)]
    {
        let (mut found, mut expected) = (vec![0.0; count], vec![0.0; count]);
        let before = (time > 0).then_some(previous.as_slice());
        let context = Context::new(Step::of_index(time), before, count);
        assert!(linearised.prepare(&Linear, &Step::of_index(time), &measurement).unwrap());
        assert!(optimal.prepare(&matrices, &Step::of_index(time), &measurement).unwrap());
        let mut scratch = LinearisedScratch::default();
        linearised.condition(&Linear, context, (), &mut scratch).unwrap().log_density(&at, &mut found);
        optimal.condition(&matrices, context, (), &mut ()).unwrap().log_density(&at, &mut expected);
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-10, "time {time}: {found} for {expected}");
        }
        // And what it draws has the density that it states.
        let mut states = vec![0.0; 3 * count];
        let (mut along, mut after) = (vec![0.0; count], vec![0.0; count]);
        let mut conditional = linearised.condition(&Linear, context, (), &mut scratch).unwrap();
        conditional.sample(&mut seed.child("draws").streams(7), &mut states, &mut along);
        conditional.log_density(&states, &mut after);
        along.iter().zip(&after).for_each(|(a, b)| assert!((a - b).abs() < 1e-10, "{a} for {b}"));
    }
    assert!(!linearised.prepare(&Linear, &Step::of_index(1), &[None, None]).unwrap());
}

/// How far the mean of `Ẑ/Z` is from 1, in standard errors, for a whole sequence or one without some of its entries.
fn z<M: Equations, P: Proposal<M> + Clone>(
    model: &M,
    proposal: &P,
    when: ResampleWhen,
    rows: &[Vec<Option<f64>>],
    exact: f64,
) -> f64 {
    let runs = 20_000;
    let settings = FilterSettings { resample_when: when, ..FilterSettings::new(64) };
    let mut bank = FilterBank::new(model, proposal.clone(), settings, runs, &Seed::from_u64(12)).unwrap();
    rows.iter().enumerate().for_each(|(at, row)| bank.step_at(&Step::of_index(at), row).unwrap());
    let ratios: Vec<f64> = (0..runs).map(|run| (bank.log_evidence(run) - exact).exp()).collect();
    let n = runs as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

const RULES: [ResampleWhen; 3] = [ResampleWhen::Never, ResampleWhen::EssBelow(0.5), ResampleWhen::Always];

#[test]
fn evidence_of_a_linear_model_is_the_kalman_filters() {
    let data = simulate(&Linear, 5, &mut Seed::from_u64(13).stream()).unwrap().measurements;
    let whole: Vec<Vec<Option<f64>>> =
        data.rows().map(|row| row.iter().copied().map(Some).collect()).collect();
    let mut gaps = whole.clone();
    gaps[1][0] = None;
    gaps[3] = vec![None; 2];
    gaps[4][1] = None;
    for rows in [whole, gaps] {
        let partial = motes_models::PartialMeasurements::new(2, rows.concat()).unwrap();
        let exact = kalman::filter_partial(&by_matrices(), &partial).unwrap().log_evidence();
        for when in RULES {
            let of_linearised = z(&Linear, &Linearised::new(&Linear).unwrap(), when, &rows, exact);
            let of_bootstrap = z(&Linear, &Bootstrap, when, &rows, exact);
            assert!(
                of_linearised.abs() < 4.0 && of_bootstrap.abs() < 4.0,
                "{when:?}: {of_linearised}, {of_bootstrap}"
            );
        }
    }
}

/// One coordinate with heavy tails, or with a bound, and counts or a number with heavy tails of it.
struct Awkward {
    is_bounded: bool,
}

impl Awkward {
    const TIMES: usize = 5;

    fn measurements() -> Vec<Vec<Option<f64>>> {
        let rows = [
            [Some(3.0), None],
            [Some(0.0), Some(1.4)],
            [Some(7.0), Some(-2.0)],
            [None, Some(0.3)],
            [Some(2.0), Some(0.5)],
        ];
        rows.map(Vec::from).to_vec()
    }
}

impl Equations for Awkward {
    fn dimensions(&self) -> [usize; 2] {
        [1, 2]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.3, 0.8));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        let mean = x[0].sin() + x[0] * 0.5;
        state[0] = draws.draw(match self.is_bounded {
            true => exponential(0.6).shifted(mean - 0.5),
            false => student_t(4.0, mean, 0.5),
        });
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(poisson((x[0] * 0.8 + 0.5).exp()));
        y.push(student_t(3.0, x[0] * x[0] * 0.3, 0.7));
    }
}

/// The exact log-evidence by quadrature on a grid, that steps over the one edge of a bounded transition.
fn by_quadrature(model: &Awkward) -> f64 {
    const POINTS: usize = 6001;
    let (low, step) = (-9.0, 0.003);
    let grid: Vec<f64> = (0..POINTS).map(|i| low + step * i as f64).collect();
    let mut density: Vec<f64> = grid
        .iter()
        .map(|x| model.density().unwrap().log_density(&Step::of_index(0), None, &[*x]).exp())
        .collect();
    for (time, row) in Awkward::measurements().iter().enumerate() {
        if time > 0 {
            density = grid
                .iter()
                .map(|x| {
                    let into = |(from, before): (&f64, &f64)| {
                        if *before > 0.0 {
                            before
                                * model
                                    .density()
                                    .unwrap()
                                    .log_density(&Step::of_index(1), Some(&[*from]), &[*x])
                                    .exp()
                        } else {
                            0.0
                        }
                    };
                    grid.iter().zip(&density).map(into).sum::<f64>() * step
                })
                .collect();
        }
        for (density, x) in density.iter_mut().zip(&grid) {
            let mut out = [0.0];
            model.log_likelihoods(&Step::of_index(time), &[*x], row, &mut out).unwrap();
            *density *= out[0].exp();
        }
    }
    assert_eq!(Awkward::measurements().len(), Awkward::TIMES);
    (density.iter().sum::<f64>() * step).ln()
}

#[test]
fn evidence_of_counts_and_heavy_tails_is_that_of_quadrature() {
    for is_bounded in [false, true] {
        let model = Awkward { is_bounded };
        let exact = by_quadrature(&model);
        let rows = Awkward::measurements();
        let proposal = Linearised::new(&model).unwrap();
        for when in RULES {
            let of_bootstrap = z(&model, &Bootstrap, when, &rows, exact);
            assert!(of_bootstrap.abs() < 4.0, "bootstrap, bounded {is_bounded}, {when:?}: {of_bootstrap}");
            let defensive = z_defensive(&model, &proposal, when, &rows, exact);
            assert!(defensive.abs() < 4.0, "linearised, bounded {is_bounded}, {when:?}: {defensive}");
        }
    }
}

/// [`z`] with a share of the transition, without which a Gaussian proposal of a heavy tail has weights without bound.
fn z_defensive(
    model: &Awkward,
    proposal: &Linearised,
    when: ResampleWhen,
    rows: &[Vec<Option<f64>>],
    exact: f64,
) -> f64 {
    let runs = 20_000;
    let settings =
        FilterSettings { resample_when: when, defensive_weight: Some(0.1), ..FilterSettings::new(64) };
    let mut bank = FilterBank::new(model, proposal.clone(), settings, runs, &Seed::from_u64(14)).unwrap();
    rows.iter().enumerate().for_each(|(at, row)| bank.step_at(&Step::of_index(at), row).unwrap());
    let ratios: Vec<f64> = (0..runs).map(|run| (bank.log_evidence(run) - exact).exp()).collect();
    let n = runs as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|ratio| (ratio - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - 1.0) / (variance / n).sqrt()
}

/// Stochastic volatility: the mean of a return says nothing of the state.
struct Volatility;

impl Equations for Volatility {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.91, 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(0.0, (x[0] / 2.0).exp() * 0.5));
    }
}

#[test]
fn where_no_location_depends_on_the_state_it_is_the_transition() {
    let proposal = Linearised::new(&Volatility).unwrap();
    assert!(!proposal.sees_measurements());
    let data = simulate(&Volatility, 20, &mut Seed::from_u64(15).stream()).unwrap().measurements;
    let stream = || Seed::from_u64(16).stream();
    let mut linearised =
        ParticleFilter::new(&Volatility, proposal, FilterSettings::new(100), stream()).unwrap();
    let mut bootstrap =
        ParticleFilter::new(&Volatility, Bootstrap, FilterSettings::new(100), stream()).unwrap();
    for row in data.rows() {
        linearised.step(row).unwrap();
        bootstrap.step(row).unwrap();
    }
    assert_eq!(linearised.particles(), bootstrap.particles());
    assert_eq!(linearised.log_evidence(), bootstrap.log_evidence());
}
