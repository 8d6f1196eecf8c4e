//! The recurrent proposal: memory that belongs to its particle, and sequences of any length.

use motes_models::{GraphDiffusion, GraphDiffusionConfig, Seed, StateSpaceModel, simulate};
use motes_proposals::{Backend, Cell, Compute, Family, Fcnn, Hidden, Learnable, Precision, Rnn, RnnConfig};
use motes_smc::{
    Conditional, FilterBank, FilterError, FilterSettings, Past, Proposal, ProposalError, ResampleWhen,
};
use motes_tests::{relative_distance, small_fcnn, small_rnn, trained_family};

const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };
const N: usize = 5;

fn system() -> GraphDiffusion {
    GraphDiffusion::random(&GraphDiffusionConfig::new(N), &mut Seed::from_u64(110).stream()).unwrap()
}

fn untrained(cell: Cell) -> Rnn {
    Rnn::new(&small_rnn(cell), &system(), F64, &Seed::from_u64(111)).unwrap()
}

/// Runs a bank that resamples at every step, and replays the ancestral path of each of its particles from scratch, alone.
fn replay(mut rnn: Rnn) {
    let (system, seed) = (system(), Seed::from_u64(112));
    let measurements = simulate(&system, 6, &mut seed.child("data").stream()).unwrap().measurements;
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(8) };
    let mut bank = FilterBank::new(&system, rnn.clone(), settings, 2, &seed.child("filter")).unwrap();
    let (mut states, mut ancestors) = (vec![], vec![]);
    for measurement in measurements.rows() {
        bank.step(measurement).unwrap();
        states.push((0..2).flat_map(|filter| bank.particles(filter).to_vec()).collect::<Vec<f64>>());
        ancestors.push(bank.ancestors().to_vec());
    }
    let (stored, last) = (bank.memory().host(), states.len() - 1);
    let (mut moved, mut increments) = (0, vec![]);
    for row in 0..16 {
        let mut path = vec![row];
        for time in (1..=last).rev() {
            path.push(ancestors[time][path[path.len() - 1]]);
        }
        path.reverse();
        moved += path.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let mut memory: Hidden = Proposal::<GraphDiffusion>::initial_memory(&rnn, 1);
        let mut log_density = [0.0];
        for time in 0..=last {
            let state = |time: usize| &states[time][path[time] * N..(path[time] + 1) * N];
            let previous = (time > 0).then(|| state(time - 1));
            let past = Past { time, previous, measurement: measurements.row(time), particles: 1 };
            let conditional = rnn.condition(&system, past, &mut memory).unwrap();
            conditional.log_density(state(time), &mut log_density);
        }
        for (replayed, stored) in memory.host().iter().zip(&stored) {
            let width = replayed.len();
            let distance = relative_distance(replayed, &stored[row * width..(row + 1) * width]);
            assert!(distance < 1e-12, "row {row}: memory is {distance:e} off");
        }
        let state = &states[last][row * N..(row + 1) * N];
        let parent = &states[last - 1][path[last - 1] * N..(path[last - 1] + 1) * N];
        increments.push(
            system.log_likelihood(last, state, measurements.row(last))
                + system.log_transition(last, parent, state)
                - log_density[0],
        );
    }
    assert!(moved > 16, "resampling moved only {moved} particles");
    // After resampling a weight is its last increment, normalised: so log q was the replayed one.
    for (filter, increments) in increments.chunks_exact(8).enumerate() {
        let largest = increments.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = increments.iter().map(|log| (log - largest).exp()).sum();
        let expected: Vec<f64> = increments.iter().map(|log| (log - largest).exp() / sum).collect();
        let found = bank.weights(filter).normalised();
        assert!(relative_distance(found, &expected) < 1e-9, "{found:?} for {expected:?}");
    }
}

#[test]
fn memory_and_log_q_are_those_of_the_ancestral_path() {
    for cell in [Cell::Lstm, Cell::Gru, Cell::Elman] {
        replay(untrained(cell));
        replay(trained_family(&small_rnn(cell), &system(), 4, F64));
    }
}

/// Filters twelve measurements.
fn run(proposal: impl Proposal<GraphDiffusion>) -> Result<(), FilterError> {
    let (system, seed) = (system(), Seed::from_u64(113));
    let measurements = simulate(&system, 12, &mut seed.child("data").stream()).unwrap().measurements;
    let mut bank = FilterBank::new(&system, proposal, FilterSettings::new(20), 1, &seed.child("filter"))?;
    measurements.rows().try_for_each(|measurement| bank.step(measurement))
}

#[test]
fn trained_on_one_length_it_runs_on_any_other() {
    let rnn: Rnn = trained_family(&small_rnn(Cell::Lstm), &system(), 4, F64);
    assert_eq!(rnn.horizon(), None);
    run(rnn).unwrap();
    let fcnn: Fcnn = trained_family(&small_fcnn(), &system(), 4, F64);
    let error = run(fcnn).unwrap_err();
    let source = ProposalError::PastHorizon { horizon: 4, time: 4 };
    assert_eq!(error, FilterError::Proposal { step: 4, source });
    assert_eq!(
        error.to_string(),
        "at step 4: this proposal is unrolled over 4 times and was asked for time 4"
    );
}

#[test]
fn the_number_of_weights_is_what_the_family_says_before_it_allocates_them() {
    let system = system();
    for cell in [Cell::Lstm, Cell::Gru, Cell::Elman] {
        let rnn = untrained(cell);
        let found: usize = (0..rnn.parameters().len()).map(|at| rnn.parameters().host(at).len()).sum();
        let sizes = (system.state_dim(), system.measurement_dim());
        assert_eq!(Rnn::count(&small_rnn(cell), sizes, 7), Some(found), "{cell:?}");
    }
    let huge = RnnConfig { hidden: usize::MAX, ..small_rnn(Cell::Lstm) };
    assert_eq!(Rnn::count(&huge, (5, 3), 1), None);
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let new = |change: fn(&mut RnnConfig)| {
        let mut config = small_rnn(Cell::Lstm);
        change(&mut config);
        Rnn::new(&config, &system(), F64, &Seed::from_u64(1)).err().unwrap().to_string()
    };
    assert_eq!(new(|config| config.hidden = 0), "the hidden size H is 0; it must be at least 1");
    assert_eq!(
        new(|config| config.depth = 0),
        "the depth of the recurrent network is 0; it must be at least 1"
    );
    let ridge = new(|config| config.ridge = f64::NAN);
    assert_eq!(ridge, "the ridge of the covariance is NaN; it must be at least 0 and finite");
}
