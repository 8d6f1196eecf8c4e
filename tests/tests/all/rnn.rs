//! The recurrent proposal: memory that belongs to its particle, and sequences of any length.

use motes_models::{GraphDiffusion, ModelShape, Seed, StateSpaceModel, Step, simulate};
use motes_proposals::{Backend, Cell, Compute, Family, Fcnn, Parametric, Precision, Rnn, RnnConfig};
use motes_smc::{Context, FilterBank, FilterError, FilterSettings, ParticleMemory, Proposal, ProposalError};
use motes_tests::{replay, replayed_system, small_fcnn, small_rnn, trained_family};

const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };
fn untrained(cell: Cell) -> Rnn {
    Rnn::create(&small_rnn(cell), &ModelShape::of(&replayed_system()), 0, F64, &Seed::from_u64(111)).unwrap()
}

fn assert_replayed(rnn: &Rnn) {
    // Over gaps, too: memory stays as it is there, and moves with its particle.
    for missing in [&[][..], &[0, 3]] {
        let found = replay(rnn, |memory| memory, missing);
        assert!(found.holds(), "without measurements at {missing:?}: {found:?}");
    }
}

#[test]
fn memory_and_log_q_are_those_of_the_ancestral_path() {
    for cell in [Cell::Lstm, Cell::Gru, Cell::Elman] {
        assert_replayed(&untrained(cell));
        assert_replayed(&trained_family(&small_rnn(cell), &replayed_system(), 4, F64));
    }
}

/// Filters twelve measurements.
fn run(proposal: impl Proposal<GraphDiffusion>) -> Result<(), FilterError> {
    let (system, seed) = (replayed_system(), Seed::from_u64(113));
    let measurements = simulate(&system, 12, &mut seed.child("data").stream()).unwrap().measurements;
    let mut bank = FilterBank::new(&system, proposal, FilterSettings::new(20), 1, &seed.child("filter"))?;
    measurements.rows().try_for_each(|measurement| bank.step(measurement))
}

#[test]
fn trained_on_one_length_it_runs_on_any_other() {
    let rnn: Rnn = trained_family(&small_rnn(Cell::Lstm), &replayed_system(), 4, F64);
    assert_eq!(rnn.horizon(), None);
    run(rnn).unwrap();
    let fcnn: Fcnn = trained_family(&small_fcnn(), &replayed_system(), 4, F64);
    let error = run(fcnn).unwrap_err();
    let source = ProposalError::PastHorizon { horizon: 4, time: 4 };
    assert_eq!(error, FilterError::Proposal { step: 4, source });
    assert_eq!(
        error.to_string(),
        "at step 4: this proposal is unrolled over 4 times and was asked for time 4"
    );
}

/// Means and memory after three steps of 300 particles with fifty ancestors at the last two, `ancestor` telling which each has.
fn after_three_steps(precision: Precision, ancestor: impl Fn(usize) -> usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    const PARTICLES: usize = 300;
    let system = replayed_system();
    // So wide that gates are computed in panels.
    let config = RnnConfig { hidden: 24, ..small_rnn(Cell::Lstm) };
    let compute = Compute { backend: Backend::Native, precision };
    let mut rnn = Rnn::create(&config, &ModelShape::of(&system), 0, compute, &Seed::from_u64(114)).unwrap();
    let ancestors: Vec<usize> = (0..PARTICLES).map(ancestor).collect();
    let n = system.state_dim();
    let previous: Vec<f64> =
        ancestors.iter().flat_map(|a| (0..n).map(move |i| (0.7 * (a * n + i) as f64).sin())).collect();
    let measurement = vec![0.3; system.measurement_dim()];
    let mut memory = Proposal::<GraphDiffusion>::initial_memory(&rnn, PARTICLES);
    let mut means = Vec::new();
    for time in 0..3 {
        let previous = (time > 0).then_some(previous.as_slice());
        let context = Context::new(Step::of_index(time), previous, PARTICLES);
        means = rnn
            .condition_batch(&system, context, &measurement, &mut memory, &mut Default::default())
            .unwrap()
            .means()
            .to_vec();
        if time == 1 {
            // Each becomes the first child of its ancestor, and with it carries what that one does.
            let first_of = |a: &usize| ancestors.iter().position(|other| other == a).unwrap();
            memory.resample(&ancestors.iter().map(first_of).collect::<Vec<_>>());
        }
    }
    (means, memory.host())
}

#[test]
fn particles_of_one_ancestor_are_what_they_are_apart() {
    // Side by side they are computed once, in turns each by itself.
    let (side_by_side, in_turns) = (|particle| particle / 6, |particle| particle % 50);
    let same = |together: &[f64], apart: &[f64]| {
        let width = together.len() / 300;
        let row = |rows: &[f64], at: usize| rows[at * width..(at + 1) * width].to_vec();
        for particle in 0..300 {
            let other = (0..300).filter(|&other| in_turns(other) == side_by_side(particle));
            other.for_each(|other| assert_eq!(row(together, particle), row(apart, other)));
        }
    };
    for precision in [Precision::F32, Precision::F64] {
        let (means, memory) = after_three_steps(precision, side_by_side);
        let (means_apart, memory_apart) = after_three_steps(precision, in_turns);
        same(&means, &means_apart);
        memory.iter().zip(&memory_apart).for_each(|(together, apart)| same(together, apart));
    }
}

#[test]
fn no_particles_are_no_work() {
    let (system, mut rnn) = (replayed_system(), untrained(Cell::Lstm));
    let mut memory = Proposal::<GraphDiffusion>::initial_memory(&rnn, 0);
    for previous in [None, Some(&[][..])] {
        let context = Context::new(Step::of_index(0), previous, 0);
        assert!(
            rnn.condition_batch(&system, context, &[0.3; 3], &mut memory, &mut Default::default())
                .unwrap()
                .means()
                .is_empty()
        );
    }
}

#[test]
fn the_number_of_weights_is_what_the_family_says_before_it_allocates_them() {
    let shape = ModelShape::of(&replayed_system());
    for cell in [Cell::Lstm, Cell::Gru, Cell::Elman] {
        let rnn = untrained(cell);
        let found: usize = (0..rnn.parameters().len()).map(|at| rnn.parameters().host(at).len()).sum();
        assert_eq!(Rnn::count(&small_rnn(cell), &shape, 7), Some(found), "{cell:?}");
    }
    let huge = RnnConfig { hidden: usize::MAX, ..small_rnn(Cell::Lstm) };
    assert_eq!(Rnn::count(&huge, &shape, 1), None);
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let new = |change: fn(&mut RnnConfig)| {
        let mut config = small_rnn(Cell::Lstm);
        change(&mut config);
        Rnn::create(&config, &ModelShape::of(&replayed_system()), 0, F64, &Seed::from_u64(1))
            .err()
            .unwrap()
            .to_string()
    };
    assert_eq!(new(|config| config.hidden = 0), "the hidden size H is 0; it must be at least 1");
    assert_eq!(
        new(|config| config.depth = 0),
        "the depth of the recurrent network is 0; it must be at least 1"
    );
    let ridge = new(|config| config.ridge = f64::NAN);
    assert_eq!(ridge, "the ridge of the covariance is NaN; it must be at least 0 and finite");
}
