//! Steps of their own times, inputs and parameters: evidence and smoothed means against exact ones.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Seed, Step};
use motes_smc::{
    Bootstrap, FilterBank, FilterHistory, FilterSettings, Linearised, ParticleFilter, Proposal,
    backward_simulation,
};

/// A velocity with friction that is pushed, seen at irregular times:
/// `x(t + Δ) ~ N(x e^{−θΔ} + uΔ, (1 − e^{−2θΔ}) / 2θ)`, `y ~ N(x, ½²)`.
struct Velocity;

impl Equations for Velocity {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn inputs(&self) -> &[f64] {
        &[0.0]
    }

    fn parameters(&self) -> &[f64] {
        &FRICTION
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        let (friction, push) = (step.parameters[0], step.inputs[0]);
        let kept = (friction * -step.length).exp();
        let variance = (-(kept * kept) + 1.0) / (friction * 2.0);
        x[0] = draws.draw(normal(previous[0] * kept + push * step.length, variance.sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 0.5));
    }
}

const FRICTION: [f64; 1] = [0.7];
const TIMES: [f64; 6] = [0.0, 0.3, 0.4, 2.0, 2.5, 5.0];
const PUSHES: [[f64; 1]; 6] = [[0.0], [1.0], [-2.0], [0.5], [0.0], [0.3]];
const MEASURED: [Option<f64>; 6] = [Some(0.4), Some(0.9), None, Some(1.6), Some(0.7), Some(1.1)];

fn steps() -> impl Iterator<Item = (Step<'static>, [Option<f64>; 1])> {
    (0..TIMES.len()).map(|index| {
        let length = if index == 0 { 0.0 } else { TIMES[index] - TIMES[index - 1] };
        let (time, inputs) = (TIMES[index], &PUSHES[index][..]);
        let step = Step { time, length, inputs, parameters: &FRICTION, ..Step::of_index(index) };
        (step, [MEASURED[index]])
    })
}

/// The log-evidence, and the smoothed means, by the scalar Kalman filter and smoother.
fn exact<'a>(steps: impl Iterator<Item = (Step<'a>, [Option<f64>; 1])>) -> (f64, Vec<f64>) {
    let (mut log_evidence, mut filtered, mut predicted) = (0.0, vec![], vec![]);
    let (mut mean, mut variance) = (0.0, 1.0);
    for (step, [measured]) in steps {
        let kept = (-FRICTION[0] * step.length).exp();
        if step.index > 0 {
            mean = mean * kept + step.inputs[0] * step.length;
            variance = variance * kept * kept + (1.0 - kept * kept) / (2.0 * FRICTION[0]);
        }
        predicted.push((mean, variance, kept));
        if let Some(y) = measured {
            let spread: f64 = variance + 0.25;
            log_evidence -= 0.5 * ((std::f64::consts::TAU * spread).ln() + (y - mean).powi(2) / spread);
            mean += variance / spread * (y - mean);
            variance -= variance * variance / spread;
        }
        filtered.push((mean, variance));
    }
    let mut means = vec![mean];
    for index in (1..filtered.len()).rev() {
        let ((mean, variance), (ahead, spread, kept)) = (filtered[index - 1], predicted[index]);
        means.push(mean + variance * kept / spread * (means[means.len() - 1] - ahead));
    }
    means.reverse();
    (log_evidence, means)
}

fn score(values: &[f64], expected: f64) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean - expected) / (variance / n).sqrt()
}

fn evidence_score(proposal: impl Proposal<Velocity>, expected: f64) -> f64 {
    let seed = Seed::from_u64(90);
    let mut bank = FilterBank::new(&Velocity, proposal, FilterSettings::new(20), 5000, &seed).unwrap();
    steps().for_each(|(step, measured)| bank.step_at(&step, &measured).unwrap());
    let ratios: Vec<f64> = (0..bank.filters()).map(|filter| bank.log_evidence(filter).exp()).collect();
    score(&ratios, expected.exp())
}

#[test]
fn evidence_is_unbiased_with_irregular_times_inputs_and_parameters() {
    let (expected, _) = exact(steps());
    assert!(evidence_score(Bootstrap, expected).abs() < 4.0);
    assert!(evidence_score(Linearised::new(&Velocity).unwrap(), expected).abs() < 4.0);
    // Off by what a single push adds, the test would fail.
    assert!(evidence_score(Bootstrap, expected + 0.1).abs() > 4.0);
}

#[test]
fn smoothing_goes_back_by_the_steps_that_were_taken() {
    let (_, means) = exact(steps());
    let seed = Seed::from_u64(91);
    let settings = FilterSettings::new(2000);
    let mut filter =
        ParticleFilter::new(&Velocity, Bootstrap, settings, seed.child("filter").stream()).unwrap();
    let mut history = FilterHistory::new();
    for (step, measured) in steps() {
        filter.step_at(&step, &measured).unwrap();
        assert_eq!(filter.bank().last_step(), step);
        history.record(&filter).unwrap();
    }
    let paths = backward_simulation(&Velocity, &history, 4000, &seed.child("paths")).unwrap();
    for (time, expected) in means.iter().enumerate() {
        assert!((paths.mean(time, 0) - expected).abs() < 0.05, "{time}: {} {expected}", paths.mean(time, 0));
    }
}

#[test]
fn a_step_that_is_not_the_next_is_refused_and_changes_nothing() {
    let stream = Seed::from_u64(92).stream();
    let mut filter = ParticleFilter::new(&Velocity, Bootstrap, FilterSettings::new(50), stream).unwrap();
    let (first, measured) = steps().next().unwrap();
    let bad = [
        (Step { index: 1, ..first }, "the index of a step is 1; it must be the number of steps before it"),
        (
            Step { time: f64::NAN, ..first },
            "a time, input or parameter of a step is NaN; it must be a finite number",
        ),
        (Step { length: -0.5, ..first }, "the length of a step is -0.5; it must be at least 0"),
        (
            Step { inputs: &[], ..first },
            "the number of inputs of a step is 0; it must be as many as the model takes, or so many for each sub-step and for the measurement",
        ),
        (Step { sub_steps: 2, ..first }, "the number of sub-steps of a step is 2; it must be 1 at the start"),
        (
            Step { inputs: &[f64::INFINITY], ..first },
            "a time, input or parameter of a step is inf; it must be a finite number",
        ),
    ];
    for (step, line) in bad {
        assert_eq!(filter.step_at(&step, &measured).unwrap_err().to_string(), line);
    }
    assert_eq!((filter.time(), filter.failure()), (0, None));
    filter.step_at(&first, &measured).unwrap();
    let (second, measured) = steps().nth(1).unwrap();
    let refused = filter.step_at(&Step { sub_steps: 3, ..second }, &measured).unwrap_err();
    let line = "the number of sub-steps of a step is 3; it must be 1 for a model with a density of states, which says of a whole step what it is";
    assert_eq!(refused.to_string(), line);
}

/// [`Velocity`], whose state is made of parts of a step.
struct InParts;

impl Equations for InParts {
    fn dimensions(&self) -> [usize; 2] {
        Velocity.dimensions()
    }

    fn inputs(&self) -> &[f64] {
        Equations::inputs(&Velocity)
    }

    fn parameters(&self) -> &[f64] {
        &FRICTION
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, step: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        Velocity.initial(step, draws, x);
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        Velocity.transition(step, previous, draws, x);
    }

    fn measurement<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] + step.inputs[0], 0.5));
    }
}

/// Steps of 1, 3 and 2 sub-steps: the pushes of each, and what is added to the measurement.
const IN_PARTS: [(usize, f64, &[f64], Option<f64>); 4] = [
    (1, 0.0, &[0.0, 0.1], Some(0.4)),
    (3, 0.9, &[1.0, -0.5, 2.0, -0.2], Some(1.3)),
    (1, 0.5, &[0.0, 0.0], None),
    (2, 1.5, &[-1.0, 0.7, 0.3], Some(0.2)),
];

fn steps_in_parts() -> impl Iterator<Item = (Step<'static>, [Option<f64>; 1])> {
    let mut time = 0.0;
    IN_PARTS.iter().enumerate().map(move |(index, (sub_steps, length, inputs, measured))| {
        time += length;
        let (sub_steps, length) = (*sub_steps, *length);
        let step = Step { time, length, sub_steps, inputs, parameters: &FRICTION, ..Step::of_index(index) };
        (step, [*measured])
    })
}

/// The log-evidence of [`InParts`], each sub-step a step at which nothing is measured but the last.
fn exact_in_parts() -> f64 {
    let mut all = vec![];
    for (step, [measured]) in steps_in_parts() {
        for part in 0..step.sub_steps {
            let is_last = part + 1 == step.sub_steps;
            // What is added to the measurement is taken from it.
            let measured = measured.filter(|_| is_last).map(|y| y - step.inputs[step.sub_steps]);
            let inputs = &step.inputs[part..=part];
            let length = step.length / step.sub_steps as f64;
            all.push((Step { length, inputs, sub_steps: 1, ..step }, [measured]));
        }
    }
    exact(all.into_iter()).0
}

fn evidence_score_in_parts(proposal: impl Proposal<InParts>, expected: f64) -> f64 {
    let seed = Seed::from_u64(94);
    let mut bank = FilterBank::new(&InParts, proposal, FilterSettings::new(20), 5000, &seed).unwrap();
    steps_in_parts().for_each(|(step, measured)| bank.step_at(&step, &measured).unwrap());
    let ratios: Vec<f64> = (0..bank.filters()).map(|filter| bank.log_evidence(filter).exp()).collect();
    score(&ratios, expected.exp())
}

#[test]
fn evidence_is_unbiased_over_sub_steps_with_an_input_each() {
    let expected = exact_in_parts();
    assert!(evidence_score_in_parts(Bootstrap, expected).abs() < 4.0);
    assert!(evidence_score_in_parts(Linearised::new(&InParts).unwrap(), expected).abs() < 4.0);
    // Off by what a single push adds, the test would fail.
    assert!(evidence_score_in_parts(Bootstrap, expected + 0.1).abs() > 4.0);
}

#[test]
fn linearising_looks_through_all_sub_steps_to_the_next_measurement() {
    let ess = |filter: &mut dyn FnMut(&Step<'static>, &[Option<f64>]) -> f64| {
        let found = steps_in_parts().map(|(step, measured)| filter(&step, &measured));
        found.fold(f64::INFINITY, f64::min)
    };
    let stream = || Seed::from_u64(95).stream();
    let linearised = Linearised::new(&InParts).unwrap();
    let mut guided = ParticleFilter::new(&InParts, linearised, FilterSettings::new(500), stream()).unwrap();
    let guided = ess(&mut |step, measured| {
        guided.step_at(step, measured).unwrap();
        guided.effective_sample_size()
    });
    let mut blind = ParticleFilter::new(&InParts, Bootstrap, FilterSettings::new(500), stream()).unwrap();
    let blind = ess(&mut |step, measured| {
        blind.step_at(step, measured).unwrap();
        blind.effective_sample_size()
    });
    assert!(guided > 1.2 * blind && guided > 300.0, "{guided} {blind}");
}
