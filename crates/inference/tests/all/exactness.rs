//! What makes chains exact, by every question that they ask of a likelihood: bugs whose draws look right are caught here whatever luck they have.

use std::collections::HashSet;
use std::convert::Infallible;
use std::sync::Mutex;

use ciborium::Value;
use motes_inference::{Estimator, EstimatorCost, Likelihood, Posterior, PosteriorSettings, Stage};
use motes_models::Seed;

use crate::known::Line;

/// A question: the position, the random numbers, and the answer.
struct Question {
    v: Vec<f64>,
    seed: Seed,
    found: f64,
}

/// A likelihood that keeps all questions.
struct Questions {
    line: Line,
    questions: Mutex<Vec<Question>>,
}

impl Questions {
    fn new() -> Self {
        Questions { line: Line::new(60.0), questions: Mutex::new(Vec::new()) }
    }

    fn take(&self) -> Vec<Question> {
        std::mem::take(&mut *self.questions.lock().expect("no thread has panicked"))
    }
}

impl Likelihood for Questions {
    type Error = Infallible;

    fn dimension(&self) -> usize {
        self.line.dimension()
    }

    fn estimators(&self) -> &[EstimatorCost] {
        self.line.estimators()
    }

    fn log_likelihood(&self, v: &[f64], estimator: Estimator, seed: &Seed) -> Result<f64, Infallible> {
        let found = self.line.log_likelihood(v, estimator, seed)?;
        let question = Question { v: v.to_vec(), seed: seed.clone(), found };
        self.questions.lock().expect("no thread has panicked").push(question);
        Ok(found)
    }
}

/// A fit with noise, at the first of its kept draws.
fn warmed_up(likelihood: &Questions) -> Posterior {
    let settings = PosteriorSettings { draws: Some(500), ..PosteriorSettings::default() };
    let mut posterior = Posterior::new(likelihood, settings, 1).expect("it can be fitted");
    while posterior.stage() != Stage::Sampling {
        posterior.advance(likelihood).expect("nothing can fail");
    }
    posterior
}

fn finish(posterior: &mut Posterior, likelihood: &Questions) {
    while posterior.stage() != Stage::Done {
        posterior.advance(likelihood).expect("nothing can fail");
    }
}

/// Catches an estimate that is drawn anew for where a chain is: such a chain has another distribution than the posterior.
#[test]
fn an_estimate_belongs_to_a_position_until_it_is_left() {
    let likelihood = Questions::new();
    let mut posterior = warmed_up(&likelihood);
    let before = likelihood.take();
    finish(&mut posterior, &likelihood);
    let all: Vec<Question> = before.into_iter().chain(likelihood.take()).collect();
    for chain in 0..posterior.chains() {
        let draws: Vec<(&[f64], f64)> = posterior.draws(chain).collect();
        for pair in draws.windows(2) {
            if pair[0].0 == pair[1].0 {
                assert_eq!(pair[0].1, pair[1].1, "two estimates of {:?}", pair[0].0);
            }
        }
        for (v, kept) in draws {
            assert!(all.iter().any(|asked| asked.v == v && asked.found == kept), "{v:?}: {kept}");
        }
    }
}

/// Catches chains that share a stream, and estimates that share their random numbers.
#[test]
fn no_two_moves_and_no_two_estimates_share_random_numbers() {
    let likelihood = Questions::new();
    let mut posterior = warmed_up(&likelihood);
    let before = likelihood.take();
    finish(&mut posterior, &likelihood);
    let sampling = likelihood.take();
    let positions: HashSet<Vec<u64>> =
        sampling.iter().map(|asked| asked.v.iter().map(|value| value.to_bits()).collect()).collect();
    assert_eq!(positions.len(), sampling.len(), "two moves led to the same place");
    assert_eq!(sampling.len(), 4 * 500);
    let count = before.len() + sampling.len();
    let seeds: HashSet<String> =
        before.iter().chain(&sampling).map(|asked| format!("{:?}", asked.seed)).collect();
    assert_eq!(seeds.len(), count, "two estimates have the same random numbers");
}

/// Catches an adaptation that does not stop: moves that depend on all draws before them leave nothing as it is.
#[test]
fn moves_and_particles_are_frozen_after_the_warm_up() {
    let likelihood = Questions::new();
    let mut posterior = warmed_up(&likelihood);
    let frozen = |posterior: &Posterior| {
        let written = Value::serialized(posterior).expect("it can be written down");
        let entries = written.into_map().expect("it has names");
        let of = |name: &str| {
            entries.iter().find(|(key, _)| key.as_text() == Some(name)).map(|(_, value)| value.clone())
        };
        ["kernel", "estimator"].map(|name| of(name).expect("it is part of a fit"))
    };
    let first = frozen(&posterior);
    while posterior.stage() != Stage::Done {
        posterior.advance(&likelihood).expect("nothing can fail");
        assert_eq!(frozen(&posterior), first);
    }
}
