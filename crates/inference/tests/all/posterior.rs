//! Posteriors against sums over grids.

use std::convert::Infallible;
use std::sync::atomic::{AtomicU64, Ordering};

use motes_inference::{
    Estimator, EstimatorChoice, EstimatorCost, FitError, Likelihood, ParameterSummary, Posterior,
    PosteriorSettings, Stage,
};
use motes_models::Seed;

use crate::known::{EXACT, Half, Line, TwoModes, log_of_noise};

fn fitted<L: Likelihood<Error = Infallible>>(
    likelihood: &L,
    settings: PosteriorSettings,
    seed: u64,
) -> Posterior {
    let mut posterior = Posterior::new(likelihood, settings, seed).expect("it can be fitted");
    while posterior.stage() != Stage::Done {
        posterior.advance(likelihood).expect("nothing can fail");
    }
    posterior
}

/// Means and standard deviations within four Monte Carlo standard errors.
fn agrees(posterior: &Posterior, means: [f64; 2], sds: [f64; 2]) {
    for at in 0..2 {
        let summary = ParameterSummary::of(&posterior.coordinate(at)).expect("there are draws");
        assert!(summary.rhat < 1.01, "{summary:?}");
        assert!((summary.mean - means[at]).abs() < 4.0 * summary.mcse, "{summary:?} beside {means:?}");
        // That of the standard deviation is at most about as large where tails are normal.
        let error = summary.sd / (2.0 * summary.ess_bulk.min(summary.ess_tail)).sqrt();
        assert!((summary.sd - sds[at]).abs() < 4.0 * error, "{summary:?} beside {sds:?}");
    }
}

#[test]
fn an_exact_likelihood_gives_the_posterior_and_the_marginal_likelihood() {
    let line = Line::new(0.0);
    let (means, sds, log_marginal) = line.on_a_grid();
    let settings = PosteriorSettings { draws: Some(4000), ..PosteriorSettings::default() };
    let posterior = fitted(&line, settings, 1);
    agrees(&posterior, means, sds);
    let found = posterior.marginal_likelihood().expect("half of the moves are independent");
    assert!(found.standard_error < 0.02, "{found:?}");
    assert!((found.log - log_marginal).abs() < 4.0 * found.standard_error, "{found:?} beside {log_marginal}");
}

#[test]
fn noise_of_the_likelihood_changes_nothing_but_the_number_of_draws() {
    for particles in [None, Some(15)] {
        // Of 15 particles the variance of log ẑ is 4.
        let line = Line::new(60.0);
        let (means, sds, log_marginal) = line.on_a_grid();
        let estimator = particles.map(EstimatorChoice::Particles);
        let settings = PosteriorSettings { draws: Some(25_000), estimator, ..PosteriorSettings::default() };
        let posterior = fitted(&line, settings, 2);
        agrees(&posterior, means, sds);
        let found = posterior.marginal_likelihood().expect("half of the moves are independent");
        assert!((found.log - log_marginal).abs() < 4.0 * found.standard_error, "{found:?} {log_marginal}");
        let variance = posterior.variance();
        match particles {
            None => assert!((0.5..4.0).contains(&variance), "{variance}"),
            Some(_) => assert!((2.0..8.0).contains(&variance), "{variance}"),
        }
    }
}

#[test]
fn both_modes_have_their_share() {
    let two = TwoModes { costs: vec![EXACT] };
    let posterior = fitted(&two, PosteriorSettings { draws: Some(5000), ..PosteriorSettings::default() }, 3);
    let draws = posterior.coordinate(0);
    let above = draws.iter().flatten().filter(|value| **value > 0.0).count() as f64;
    let share = above / draws.iter().flatten().count() as f64;
    let signs: Vec<Vec<f64>> =
        draws.iter().map(|chain| chain.iter().map(|value| f64::from(*value > 0.0)).collect()).collect();
    let summary = ParameterSummary::of(&signs).expect("there are draws");
    assert!((share - 0.7).abs() < 4.0 * summary.mcse, "{share} ± {}", summary.mcse);
    assert!(summary.mcse < 0.03, "{summary:?}");
}

#[test]
fn it_ends_where_the_gates_hold() {
    let line = Line::new(60.0);
    let posterior = fitted(&line, PosteriorSettings::default(), 4);
    assert!(posterior.gates_hold(&line));
    assert!(posterior.kept() < 20_000);
    for at in 0..2 {
        let summary = ParameterSummary::of(&posterior.coordinate(at)).expect("there are draws");
        assert!(summary.rhat < 1.01 && summary.ess_bulk >= 400.0 && summary.ess_tail >= 400.0, "{summary:?}");
    }
}

#[test]
fn a_fit_that_is_written_down_goes_on_to_the_same_draws() {
    let line = Line::new(60.0);
    let settings = PosteriorSettings { draws: Some(300), ..PosteriorSettings::default() };
    let whole = fitted(&line, settings, 5);
    let mut posterior = Posterior::new(&line, settings, 5).expect("it can be fitted");
    while posterior.stage() != Stage::Done {
        posterior.advance(&line).expect("nothing can fail");
        let mut written = Vec::new();
        ciborium::into_writer(&posterior, &mut written).expect("it can be written");
        posterior = ciborium::from_reader(written.as_slice()).expect("it can be read");
    }
    assert_eq!(posterior.coordinate(0), whole.coordinate(0));
    assert_eq!(posterior.marginal_likelihood(), whole.marginal_likelihood());
}

#[test]
fn threads_change_nothing() {
    let line = Line::new(60.0);
    let settings = PosteriorSettings { draws: Some(200), ..PosteriorSettings::default() };
    let [one, four] = [1, 4].map(|threads| {
        let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| fitted(&line, settings, 6)).coordinate(1)
    });
    assert_eq!(one, four);
}

#[test]
fn what_the_prior_makes_impossible_is_said() {
    let half = |above| Half { above, costs: vec![EXACT] };
    let refused = Posterior::new(&half(9.0), PosteriorSettings::default(), 1);
    assert!(matches!(&refused, Err(FitError::Impossible(draw)) if draw.v[0] < 9.0), "{refused:?}");
    let some = Posterior::new(&half(0.0), PosteriorSettings::default(), 1).expect("half of it is possible");
    assert!((some.possible() - 0.5).abs() < 0.3, "{}", some.possible());
    let impossible = some.impossible().expect("half of it is impossible");
    assert!(impossible.v[0] <= 0.0, "{impossible:?}");
    // The posterior is a normal distribution above 0, with mean √(2/π).
    let posterior =
        fitted(&half(0.0), PosteriorSettings { draws: Some(4000), ..PosteriorSettings::default() }, 7);
    let summary = ParameterSummary::of(&posterior.coordinate(0)).expect("there are draws");
    assert!((summary.mean - (2.0 / std::f64::consts::PI).sqrt()).abs() < 4.0 * summary.mcse, "{summary:?}");
}

/// A line by an estimator that needs a million particles, and by one that needs ten, each of which costs as much as two of the others, and a thousand besides.
struct Choice {
    line: Line,
    costs: [EstimatorCost; 2],
    work: AtomicU64,
}

impl Likelihood for Choice {
    type Error = Infallible;

    fn dimension(&self) -> usize {
        2
    }

    fn estimators(&self) -> &[EstimatorCost] {
        &self.costs
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, Infallible> {
        let work = self.costs[estimator.index].of(estimator.particles);
        self.work.fetch_add(work as u64, Ordering::Relaxed);
        let noise = [1e6, 10.0][estimator.index] / estimator.particles as f64;
        Ok(self.line.exact(v) + log_of_noise(noise, seed))
    }
}

/// Catches starts that take ever more particles of an estimator that is hopeless, and a tuning that asks it first for as many as it would need.
#[test]
fn starts_take_the_estimator_that_is_best_as_soon_as_it_can_be_paid() {
    let cost = |per_particle, fixed| EstimatorCost { per_particle, fixed, is_exact: false };
    let choice = Choice { line: Line::new(1.0), costs: [cost(1.0, 0.0), cost(2.0, 1000.0)], work: 0.into() };
    let mut posterior = Posterior::new(&choice, PosteriorSettings::default(), 3).expect("it can be fitted");
    while posterior.stage() == Stage::Starting {
        posterior.advance(&choice).expect("nothing can fail");
    }
    assert_eq!(posterior.estimator().index, 1);
    // Some 4000 estimates of 2048 at most; by the other alone, of 8192 and then of 10⁶.
    let work = choice.work.load(Ordering::Relaxed);
    assert!(work < 10_000_000, "{work}");
}
