//! When there is no second opinion: a bootstrap that collapses or is too poor, and calls that make no sense.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal, uniform};
use motes_models::{Seed, StateSpaceModel, Step, Stream, fill_uniform};
use motes_smc::{
    Bootstrap, Conditional, Context, ErrorKind, FilterError, FilterSettings, Linearised, ParticleFilter,
    Proposal, ProposalError, SecondOpinion, Verdict, particles_by_stream,
};

use super::models::{Linear, judge, judge_all};

/// A walk that is measured within narrow bounds.
struct Narrow;

const BOUND: f64 = 0.05;

impl Equations for Narrow {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0], 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(uniform(x[0] - BOUND, x[0] + BOUND));
    }
}

/// Draws where the measurement can have come from.
struct WithinBounds {
    at: f64,
}

struct WithinBoundsBlock {
    at: f64,
}

impl Proposal<Narrow> for WithinBounds {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a> = WithinBoundsBlock;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(
        &mut self,
        _model: &Narrow,
        _step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        self.at = measurement[0].unwrap_or_default();
        Ok(measurement[0].is_some())
    }

    fn condition<'a>(
        &'a self,
        _model: &'a Narrow,
        _context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<WithinBoundsBlock, ProposalError> {
        Ok(WithinBoundsBlock { at: self.at })
    }
}

impl Conditional for WithinBoundsBlock {
    fn sample(&mut self, streams: &mut [Stream], states: &mut [f64], log_density: &mut [f64]) {
        let particles = states.len();
        for (stream, states) in particles_by_stream(streams, states, 1, particles) {
            fill_uniform(stream, states);
            states.iter_mut().for_each(|x| *x = self.at + 0.999 * BOUND * (2.0 * *x - 1.0));
        }
        self.log_density(states, log_density);
    }

    fn log_density(&mut self, _states: &[f64], log_density: &mut [f64]) {
        log_density.fill(-(2.0 * 0.999 * BOUND).ln());
    }
}

#[test]
fn a_bootstrap_that_collapses_has_no_opinion_from_there_on() {
    let (seed, settings) = (Seed::from_u64(930), FilterSettings::new(1000));
    let jump = 6;
    // Eight standard deviations away at the jump: no particle of the bootstrap is there.
    let values = (0..20).map(|time| if time < jump { 0.1 * time as f64 } else { 8.5 }).collect();
    let measurements = motes_models::Measurements::new(1, values).unwrap();
    let mut bootstrap =
        ParticleFilter::new(&Narrow, Bootstrap, settings, seed.child("bootstrap").stream()).unwrap();
    let failure = measurements.rows().find_map(|row| bootstrap.step(row).err()).unwrap();
    assert!(matches!(failure, FilterError::Collapse { step, .. } if step == jump), "{failure}");
    let judged = judge(&Narrow, WithinBounds { at: 0.0 }, settings, &measurements, &seed);
    let Verdict::NoOpinion { first_step, unjudged, steps } = judged.verdict else {
        panic!("{}", judged.verdict)
    };
    assert!(first_step <= jump && unjudged >= 20 - jump && steps == 20, "{}", judged.verdict);
}

#[test]
fn a_bootstrap_that_is_too_poor_has_no_opinion() {
    // Six dimensions measured to a tenth of the noise of the transition: the bootstrap's evidence is off by dozens of nats either way.
    let model = Linear { coordinates: 6, a: 0.9, q: 1.0, r: 0.1 };
    let proposal = Linearised::new(&model).unwrap();
    for judged in judge_all(&model, || proposal.clone(), FilterSettings::new(1000), 60, 0..20) {
        assert!(matches!(judged.verdict, Verdict::NoOpinion { first_step: 0, .. }), "{}", judged.verdict);
    }
}

#[test]
fn steps_are_shown_one_by_one_and_from_the_first_on() {
    let model = Linear { coordinates: 1, a: 0.9, q: 1.0, r: 1.0 };
    let new = |particles| {
        let stream = Seed::from_u64(931).stream();
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(particles), stream).unwrap()
    };
    let (mut filter, mut bootstrap, mut opinion) = (new(50), new(80), SecondOpinion::new());
    assert_eq!(opinion.verdict(), Verdict::NoOpinion { first_step: 0, unjudged: 0, steps: 0 });
    let refused =
        |opinion: &mut SecondOpinion, filter: &ParticleFilter<_, _>, bootstrap: &ParticleFilter<_, _>| {
            let error = opinion.step(filter, bootstrap).unwrap_err();
            assert_eq!(error.kind(), ErrorKind::BadInput, "{error}");
            error.to_string()
        };
    assert!(refused(&mut opinion, &filter, &bootstrap).contains("is 0; it must be one more"));
    filter.step(&[0.1]).unwrap();
    assert!(refused(&mut opinion, &filter, &bootstrap).contains("is 0; it must be one more"));
    bootstrap.step(&[0.1]).unwrap();
    opinion.step(&filter, &bootstrap).unwrap();
    assert!(refused(&mut opinion, &filter, &bootstrap).contains("is 1; it must be one more"));
    let error = opinion.step_of_banks((filter.bank(), 1), (bootstrap.bank(), 0)).unwrap_err();
    assert!(error.to_string().contains("one of its bank"), "{error}");
    assert_eq!(opinion.steps(), 1);
    assert_eq!(opinion.difference(), bootstrap.log_evidence() - filter.log_evidence());
    assert!(opinion.standard_error() > 0.0);

    // Gaps are steps like others: no evidence, no error.
    let before = (opinion.difference(), opinion.standard_error());
    filter.step_at(&Step::of_index(filter.time()), &[None]).unwrap();
    bootstrap.step_at(&Step::of_index(bootstrap.time()), &[None]).unwrap();
    opinion.step(&filter, &bootstrap).unwrap();
    assert!((opinion.difference() - before.0).abs() < 1e-12);
    assert!((opinion.standard_error() - before.1).abs() < 1e-12);
}

/// A proposal that fails at the second step.
struct Once;

impl<M: StateSpaceModel> Proposal<M> for Once {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a>
        = motes_smc::Transition<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(&mut self, _: &M, step: &Step<'_>, _: &[Option<f64>]) -> Result<bool, ProposalError> {
        if step.index < 1 {
            Ok(true)
        } else {
            Err(ProposalError::PastHorizon { horizon: 1, time: step.index })
        }
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        Ok(motes_smc::Transition::new(model, context))
    }
}

#[test]
fn a_filter_that_fails_has_its_own_error() {
    let model = Linear { coordinates: 1, a: 0.9, q: 1.0, r: 1.0 };
    let stream = || Seed::from_u64(932).stream();
    let settings = FilterSettings::new(50);
    let mut filter = ParticleFilter::new(&model, Once, settings, stream()).unwrap();
    let mut bootstrap = ParticleFilter::new(&model, Bootstrap, settings, stream()).unwrap();
    let mut opinion = SecondOpinion::new();
    filter.step(&[0.1]).unwrap();
    bootstrap.step(&[0.1]).unwrap();
    opinion.step(&filter, &bootstrap).unwrap();
    let failure = filter.step(&[0.1]).unwrap_err();
    bootstrap.step(&[0.1]).unwrap();
    assert_eq!(opinion.step(&filter, &bootstrap), Err(failure));
    assert_eq!(opinion.steps(), 1);
}
