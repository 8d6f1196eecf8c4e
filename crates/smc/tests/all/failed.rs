//! What a bank that failed still shows: the particles that the failed step started from.

use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal, uniform};
use motes_models::{Seed, StateSpaceModel, Step, simulate};
use motes_smc::{
    Bootstrap, Context, FilterBank, FilterError, FilterSettings, Proposal, ProposalError, ResampleWhen,
    Transition,
};

/// A state that falls until the square root of it is no number.
struct Root;

impl Equations for Root {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(1.0, 0.1));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0].sqrt() - 0.4, 0.1));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

/// Steps until a step fails: the particles that every filter had before it, and the error.
fn fail<P: Proposal<Root>>(bank: &mut FilterBank<&Root, P>) -> (Vec<Vec<f64>>, FilterError) {
    for _ in 0..100 {
        let before = (0..bank.filters()).map(|filter| bank.particles(filter).to_vec()).collect();
        if let Err(error) = bank.step(&[0.3]) {
            return (before, error);
        }
    }
    panic!("it stays in its domain");
}

#[test]
fn the_states_that_a_failed_step_started_from_are_there() {
    // Small filters that share a block, and one of several blocks.
    for (filters, particles) in [(7, 30), (1, 5000)] {
        for resample_when in [ResampleWhen::Never, ResampleWhen::Always] {
            let settings = FilterSettings { resample_when, ..FilterSettings::new(particles) };
            let mut bank = FilterBank::new(&Root, Bootstrap, settings, filters, &Seed::from_u64(4)).unwrap();
            assert!(bank.previous_particles(0).is_none() && bank.failure().is_none());
            bank.step(&[0.3]).unwrap();
            assert!(bank.previous_particles(0).is_none());
            let (before, error) = fail(&mut bank);
            assert_eq!(bank.failure().map(ToString::to_string), Some(error.to_string()));
            for (filter, before) in before.iter().enumerate() {
                assert_eq!(bank.previous_particles(filter), Some(before.as_slice()));
            }
            let FilterError::NotANumber { filter, particle, .. } = error else { panic!("{error}") };
            let row = bank.ancestors()[filter * particles + particle] - filter * particles;
            // There the root is of a negative number. The ancestor of another particle would have one that is not: most have.
            assert!(before[filter][row] < 0.0, "{}", before[filter][row]);
            assert!(before[filter].iter().filter(|x| **x >= 0.0).count() > particles / 2);
        }
    }
}

/// The transition, until the proposal can no longer be prepared.
struct ForTwoSteps;

impl<M: StateSpaceModel> Proposal<M> for ForTwoSteps {
    type Memory = ();
    type Scratch = ();
    type Conditional<'a>
        = Transition<'a, M>
    where
        M: 'a;

    fn initial_memory(&self, _particles: usize) {}

    fn prepare(&mut self, _: &M, step: &Step<'_>, _: &[Option<f64>]) -> Result<bool, ProposalError> {
        if step.index < 2 {
            Ok(true)
        } else {
            Err(ProposalError::PastHorizon { horizon: 2, time: step.index })
        }
    }

    fn condition<'a>(
        &'a self,
        model: &'a M,
        context: Context<'a>,
        (): (),
        (): &'a mut (),
    ) -> Result<Transition<'a, M>, ProposalError> {
        Ok(Transition::new(model, context))
    }
}

#[test]
fn a_proposal_that_cannot_be_prepared_leaves_them_where_they_were() {
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(20) };
    let mut bank = FilterBank::new(&Root, ForTwoSteps, settings, 2, &Seed::from_u64(5)).unwrap();
    let (before, error) = fail(&mut bank);
    assert!(matches!(error, FilterError::Proposal { step: 2, .. }), "{error}");
    // The states of the step before that would be found if a failed preparation left them where they are.
    (0..2).for_each(|filter| assert_eq!(bank.previous_particles(filter), Some(before[filter].as_slice())));
    assert!(bank.ancestors().iter().copied().eq(0..40), "nothing was resampled");
}

/// A state in an interval that moves, seen with noise of which no more than a bound is possible: with few particles often none explains what is measured.
struct Bounded;

impl Equations for Bounded {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(uniform(-2.0, 2.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(uniform(x[0] * 0.9 - 1.0, x[0] * 0.9 + 1.0));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(uniform(x[0] - 0.3, x[0] + 0.3));
    }
}

#[test]
fn filters_that_collapse_have_no_evidence_and_leave_the_others_what_they_would_be_alone() {
    let data = simulate(&Bounded, 6, &mut Seed::from_u64(2).stream()).unwrap().measurements;
    let (seed, filters) = (Seed::from_u64(9), 60);
    for particles in [8, 3000] {
        let settings = FilterSettings::new(particles);
        let filters = if particles > 1024 { 3 } else { filters };
        let mut bank =
            FilterBank::new(&Bounded, Bootstrap, settings, filters, &seed).unwrap().keeping_collapsed();
        bank.run(&data, |_| ()).unwrap();
        let mut collapsed = 0;
        for filter in 0..filters {
            let stream = seed.nth(filter as u64).stream();
            let mut alone = FilterBank::with_streams(&Bounded, Bootstrap, settings, vec![stream]).unwrap();
            match alone.run(&data, |_| ()) {
                Ok(()) => {
                    assert_eq!(alone.log_evidence(0).to_bits(), bank.log_evidence(filter).to_bits());
                    assert_eq!(alone.particles(0), bank.particles(filter));
                }
                Err(FilterError::Collapse { .. }) => {
                    collapsed += 1;
                    assert_eq!(bank.log_evidence(filter), f64::NEG_INFINITY);
                }
                Err(error) => panic!("{error}"),
            }
        }
        assert_eq!((5..55).contains(&collapsed), particles == 8, "{collapsed}");
        assert!(bank.diagnosis().effective_sample_size > 0.0);
    }
}

/// A walk with a coordinate that no measurement sees: a function of the walk, or its square without end.
struct Unseen {
    function: fn(f64) -> f64,
}

impl Equations for Unseen {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(0.0, 1.0));
        state[1] = S::from(0.0);
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0], 1.0));
        state[1] = state[0] * (self.function)(1.0);
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

/// The measurement weighs each particle well; the coordinate would be an estimate that is no number.
#[test]
fn a_state_that_no_measurement_sees_is_looked_at() {
    for (function, is_right) in
        [(f64::ln_1p as fn(f64) -> f64, true), (|_| f64::NAN, false), (|_| f64::INFINITY, false)]
    {
        for (filters, particles) in [(7, 30), (1, 5000)] {
            let (model, settings) = (Unseen { function }, FilterSettings::new(particles));
            let mut bank = FilterBank::new(&model, Bootstrap, settings, filters, &Seed::from_u64(4)).unwrap();
            bank.step(&[0.3]).unwrap();
            match bank.step(&[0.1]) {
                Ok(()) => assert!(is_right),
                Err(FilterError::State { step, filter, particle, coordinate, value }) => {
                    assert!(!is_right && !value.is_finite());
                    assert_eq!((step, filter, particle, coordinate), (1, 0, 0, 1));
                }
                Err(error) => panic!("{error}"),
            }
        }
    }
}

/// A state that is 1 or infinite, measured between 1 and 3 or between 0 and 2.
struct Beyond;

impl Equations for Beyond {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = (-draws.draw(normal(0.0, 1.0))).where_positive(S::from(f64::INFINITY), S::from(1.0));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], _: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = x[0];
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        let low = S::from(1.0) / x[0];
        y.push(uniform(low, low + 2.0));
    }
}

#[test]
fn an_infinite_state_that_weighs_nothing_is_no_error() {
    let mut bank =
        FilterBank::new(&Beyond, Bootstrap, FilterSettings::new(1000), 1, &Seed::from_u64(4)).unwrap();
    bank.step(&[2.5]).unwrap();
    let half = (0.5_f64 * 0.5).ln();
    assert!((bank.log_evidence(0) - half).abs() < 0.15, "{}", bank.log_evidence(0));
}
