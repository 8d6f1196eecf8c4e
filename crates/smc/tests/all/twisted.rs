//! Twisted filters: exact where quadratics are, unbiased everywhere, and far ahead where a state is felt late.

use faer::mat;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal, student_t};
use motes_models::{Gaussian, LinearGaussian, PartialMeasurements, Seed, Simulator, Step, kalman, simulate};
use motes_smc::{
    FilterBank, FilterError, FilterSettings, Linearised, ResampleWhen, Resampling, Twisting, TwistingError,
};

/// Two coordinates, of which the first is measured.
struct Linear;

impl Equations for Linear {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(100.0, 2.0));
        x[1] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, now: &mut [S]) {
        now[0] = draws.draw(normal(x[0] + x[1], 0.1));
        now[1] = draws.draw(normal(x[1] * 0.95, 0.2));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.5));
    }
}

fn by_matrices() -> LinearGaussian {
    LinearGaussian::new(
        Gaussian::new("P_0", vec![100.0, 0.0], mat![[4.0, 0.0], [0.0, 1.0]]).unwrap(),
        mat![[1.0, 1.0], [0.0, 0.95]],
        mat![[0.01, 0.0], [0.0, 0.04]],
        mat![[1.0, 0.0]],
        mat![[0.25]],
    )
    .unwrap()
}

/// A chaotic system on a ring of six, of which each second one is measured; noise may be heavy.
struct Ring {
    is_heavy: bool,
}

fn slopes<S: Scalar>(x: &[S; 6]) -> [S; 6] {
    std::array::from_fn(|i| (x[(i + 1) % 6] - x[(i + 4) % 6]) * x[(i + 5) % 6] - x[i] + 8.0)
}

/// A step of 0.05 by the Runge–Kutta method of fourth order.
fn advanced<S: Scalar>(x: &[S]) -> [S; 6] {
    let x: [S; 6] = std::array::from_fn(|i| x[i]);
    let moved = |by: &[S; 6], step: f64| -> [S; 6] { std::array::from_fn(|i| x[i] + by[i] * step) };
    let first = slopes(&x);
    let second = slopes(&moved(&first, 0.025));
    let third = slopes(&moved(&second, 0.025));
    let fourth = slopes(&moved(&third, 0.05));
    std::array::from_fn(|i| x[i] + (first[i] + (second[i] + third[i]) * 2.0 + fourth[i]) * (0.05 / 6.0))
}

impl Equations for Ring {
    fn dimensions(&self) -> [usize; 2] {
        [6, 3]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        (0..6).for_each(|i| x[i] = draws.draw(normal(8.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, now: &mut [S]) {
        for (now, mean) in now.iter_mut().zip(advanced(x)) {
            let noise = if self.is_heavy { student_t(6.0, mean, 0.4) } else { normal(mean, 0.5) };
            *now = draws.draw(noise);
        }
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        (0..3).for_each(|i| y.push(normal(x[2 * i], 1.0)));
    }
}

/// One coordinate, which is measured.
struct Walk;

impl Equations for Walk {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, now: &mut [S]) {
        now[0] = draws.draw(normal(x[0], 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

fn measured(model: &impl Simulator, times: usize, seed: u64) -> PartialMeasurements {
    let data = simulate(model, times, &mut Seed::from_u64(seed).stream()).unwrap();
    PartialMeasurements::from(&data.measurements)
}

/// The mean and the standard deviation of the log-evidence, and the standard error of the logarithm of the average evidence.
fn summed_up(found: &[f64]) -> (f64, f64, f64) {
    let count = found.len() as f64;
    let mean = found.iter().sum::<f64>() / count;
    let sd = (found.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0)).sqrt();
    let largest = found.iter().copied().fold(f64::MIN, f64::max);
    let shares: Vec<f64> = found.iter().map(|x| (x - largest).exp()).collect();
    let average = shares.iter().sum::<f64>() / count;
    let spread: f64 = shares.iter().map(|x| (x / average - 1.0).powi(2)).sum();
    (largest + average.ln(), sd, (spread / (count * (count - 1.0))).sqrt())
}

fn by_twisted(model: &Ring, measurements: &PartialMeasurements, particles: usize) -> Vec<f64> {
    let seed = Seed::from_u64(5);
    let twisting = Twisting::learn(model, measurements, 2000, particles, &seed.child("learn")).unwrap();
    let run = |filter| twisting.log_evidence(model, particles, seed.nth(filter).stream()).unwrap();
    (0..12).map(run).collect()
}

fn by_linearised(
    model: &Ring,
    measurements: &PartialMeasurements,
    particles: usize,
    count: usize,
) -> Vec<f64> {
    let settings = FilterSettings {
        resampling: Resampling::Systematic,
        resample_when: ResampleWhen::EssBelow(0.5),
        ..FilterSettings::new(particles)
    };
    let seed = Seed::from_u64(6);
    let proposal = Linearised::new(model).unwrap();
    let mut bank = FilterBank::new(model, proposal, settings, count, &seed).unwrap();
    bank.run_partial(measurements, |_| ()).unwrap();
    (0..count).map(|filter| bank.log_evidence(filter)).collect()
}

#[test]
fn it_is_exact_for_a_linear_gaussian_model_with_gaps() {
    let whole = measured(&Linear, 60, 1);
    let mut values: Vec<Option<f64>> = whole.rows().flatten().copied().collect();
    for gap in [0, 7, 8, 9, 59] {
        values[gap] = None;
    }
    let measurements = PartialMeasurements::new(1, values).unwrap();
    let exact: f64 = kalman::filter_partial(&by_matrices(), &measurements)
        .unwrap()
        .steps
        .iter()
        .map(|step| step.log_evidence_increment)
        .sum();
    let seed = Seed::from_u64(2);
    let twisting = Twisting::learn(&Linear, &measurements, 200, 200, &seed.child("learn")).unwrap();
    let found = twisting.log_evidence(&Linear, 50, seed.stream()).unwrap();
    println!("exact {exact}, by 50 particles {found}");
    // A least-squares quadratic differs by its ridge.
    assert!((found - exact).abs() < 1e-3, "{found}, not {exact}");
}

#[test]
fn a_chaotic_system_needs_a_hundredth_of_the_particles() {
    let model = Ring { is_heavy: false };
    let measurements = measured(&model, 150, 3);
    let (plain, plain_sd, plain_error) = summed_up(&by_linearised(&model, &measurements, 20_000, 8));
    let (twisted, twisted_sd, twisted_error) = summed_up(&by_twisted(&model, &measurements, 200));
    println!("20000 linearised {plain} (sd {plain_sd}), 200 twisted {twisted} (sd {twisted_sd})");
    assert!(twisted_sd < plain_sd);
    assert!((twisted - plain).abs() < 4.0 * plain_error.hypot(twisted_error));
}

#[test]
fn it_is_unbiased_where_a_transition_is_not_gaussian() {
    let model = Ring { is_heavy: true };
    let measurements = measured(&model, 60, 4);
    let (plain, _, plain_error) = summed_up(&by_linearised(&model, &measurements, 20_000, 8));
    let (twisted, sd, twisted_error) = summed_up(&by_twisted(&model, &measurements, 1000));
    println!("linearised {plain} ± {plain_error}, twisted {twisted} ± {twisted_error} (sd {sd})");
    let error = plain_error.hypot(twisted_error);
    assert!((twisted - plain).abs() < 4.0 * error && error < 0.3);
}

#[test]
fn what_cannot_be_is_refused() {
    let measurements = measured(&Linear, 10, 1);
    let seed = Seed::from_u64(1);
    let said = Twisting::learn(&Linear, &measurements, 100, 23, &seed).unwrap_err();
    assert!(matches!(said, TwistingError::Setting { .. }), "{said}");
    assert!(said.to_string().contains("is 23 for 2 coordinates"), "{said}");
    let said = Twisting::learn(&Linear, &measurements, 23, 100, &seed).unwrap_err();
    assert!(said.to_string().contains("is 23 for 2 coordinates"), "{said}");
    let other = PartialMeasurements::new(2, vec![Some(1.0); 20]).unwrap();
    let said = Twisting::learn(&Linear, &other, 100, 100, &seed).unwrap_err();
    assert!(matches!(said, TwistingError::Filter(_)), "{said}");
    // No particle explains it.
    let far = PartialMeasurements::new(1, vec![Some(1e200)]).unwrap();
    let said = Twisting::learn(&Linear, &far, 100, 100, &seed).unwrap_err();
    println!("{said}");
    assert!(matches!(said, TwistingError::Filter(_) | TwistingError::Fit { .. }), "{said}");
    // One of another model.
    let twisting = Twisting::learn(&Linear, &measurements, 100, 100, &seed).unwrap();
    let said = twisting.log_evidence(&Ring { is_heavy: false }, 100, seed.stream()).unwrap_err();
    assert!(matches!(said, FilterError::Model(_)), "{said}");
    let said = twisting.log_evidence(&Walk, 100, seed.stream()).unwrap_err();
    assert!(
        said.to_string().contains("the state dimension N is 2 in the proposal and 1 in the model"),
        "{said}"
    );
}
