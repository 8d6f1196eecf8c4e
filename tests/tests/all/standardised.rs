//! Families in units that suit networks: derivatives, densities, and frames that do what they say.

use motes_models::{
    Epidemic, EpidemicConfig, Measurements, ModelShape, Noise, Seed, Simulations, Spread, StateSpaceModel,
    Step, simulate_within,
};
use motes_proposals::{
    Backend, Cell, Compute, Family, Fcnn, Frame, Frames, Learnable, Origin, Parametric, Precision, Psi, Rnn,
    SavedError, Standardised, StandardisedConfig, load, save,
};
use motes_smc::{Conditional, Context, Proposal};
use motes_tests::{central_differences, distance, norm, small_fcnn, small_psi, small_rnn};
use motes_train::{GradientFlow, Objective, TrainConfig, rollout};

const HORIZON: usize = 4;
const ORIGINS: [Origin; 3] = [Origin::Mean, Origin::MeanAtEachTime, Origin::Prediction];
const F64: Compute = Compute { backend: Backend::Native, precision: Precision::F64 };

fn system() -> Epidemic {
    Epidemic::new(&EpidemicConfig::paper()).unwrap()
}

fn simulations(trajectories: usize) -> Simulations {
    Simulations::draw(&system(), HORIZON, trajectories, 2000.0, &Seed::from_u64(140)).unwrap()
}

fn frames(origin: Origin) -> Frames {
    Frames::of(&simulations(300), origin).unwrap()
}

fn measurements() -> Measurements {
    simulate_within(&system(), HORIZON, 2000.0, &Seed::from_u64(141)).unwrap().0.measurements
}

fn make<F: Family + Learnable>(family: F::Config, origin: Origin, compute: Compute) -> Standardised<F> {
    let config = StandardisedConfig { family, frames: frames(origin) };
    Standardised::create(&config, &ModelShape::of(&system()), HORIZON, compute, &Seed::from_u64(142)).unwrap()
}

/// Holds the gradient of the objective with respect to each matrix against central differences.
fn check_gradients(label: &str, proposal: &mut dyn Learnable) {
    let (model, measurements) = (system().with_noise(Noise::Gaussian), measurements());
    let found = |proposal: &dyn Learnable| {
        let mut stream = Seed::from_u64(143).stream();
        let (objective, flow) = (Objective::Elbo, GradientFlow::Full);
        rollout(proposal, &model, &measurements, objective, flow, 4, &mut stream).unwrap()
    };
    let gradients = found(proposal).workspace.into_gradients();
    let count = proposal.parameters().len();
    let host = |at: usize, size: usize| gradients.host(at).unwrap_or_else(|| vec![0.0; size]);
    let sizes: Vec<usize> = (0..count).map(|at| proposal.parameters().host(at).len()).collect();
    let whole = norm(&(0..count).flat_map(|at| host(at, sizes[at])).collect::<Vec<f64>>());
    for (index, size) in sizes.iter().enumerate() {
        let values = proposal.parameters().host(index);
        let numeric = central_differences(&values, 1e-5, |values| {
            proposal.parameters_mut().set_host(index, values).unwrap();
            -found(proposal).objective
        });
        proposal.parameters_mut().set_host(index, &values).unwrap();
        let error = distance(&host(index, *size), &numeric) / (norm(&numeric) + 1e-5 * whole);
        assert!(error < 1e-5, "{label}, {}: relative error {error:e}", proposal.parameters().names()[index]);
    }
}

#[test]
fn the_whole_objective_with_respect_to_every_weight() {
    for origin in ORIGINS {
        check_gradients(&format!("fcnn {origin:?}"), &mut make::<Fcnn>(small_fcnn(), origin, F64));
        check_gradients(&format!("rnn {origin:?}"), &mut make::<Rnn>(small_rnn(Cell::Lstm), origin, F64));
        check_gradients(&format!("psi {origin:?}"), &mut make::<Psi>(small_psi(), origin, F64));
    }
}

/// The density along a sample is that at its point, and a filter draws what training draws.
fn check_densities<F>(label: &str, mut proposal: Standardised<F>)
where
    F: Family + Learnable + for<'a> Proposal<Epidemic, Memory: 'a>,
{
    let (model, particles) = (system(), 5);
    let measurement = measurements().row(1).to_vec();
    let previous: Vec<f64> = [900.0, 60.0, 10.0, 980.0, 20.0, -5.0].into_iter().cycle().take(15).collect();
    let mut memory = proposal.initial_memory(particles);
    for context in [
        Context::new(Step::of_index(0), None, particles),
        Context::new(Step::of_index(1), Some(&previous), particles),
    ] {
        let mut scratch = Default::default();
        let mut conditional =
            proposal.condition_batch(&model, context, &measurement, &mut memory, &mut scratch).unwrap();
        let (mut states, mut along, mut at) =
            (vec![0.0; 3 * particles], vec![0.0; particles], vec![0.0; particles]);
        conditional.sample(&mut Seed::from_u64(144).streams(1), &mut states, &mut along);
        conditional.log_density(&states, &mut at);
        for (along, at) in along.iter().zip(&at) {
            assert!((along - at).abs() < 1e-6, "{label}: {along} {at}");
        }
    }
}

#[test]
fn densities_are_those_of_the_states() {
    for origin in ORIGINS {
        check_densities("fcnn", make::<Fcnn>(small_fcnn(), origin, F64));
        check_densities("rnn", make::<Rnn>(small_rnn(Cell::Gru), origin, F64));
        check_densities("psi", make::<Psi>(small_psi(), origin, F64));
    }
}

#[test]
fn a_density_integrates_to_one_in_the_units_of_the_state() {
    // One coordinate, in a frame by hand: 2 + 3 ξ' + 0.5 υ + 7 ξ.
    let scale = |mean: f64, deviation: f64| Spread { means: vec![mean], deviations: vec![deviation] };
    let frame = Frame {
        previous: scale(1.0, 2.0),
        measurement: scale(-1.0, 4.0),
        output: scale(2.0, 7.0),
        by_previous: vec![3.0],
        by_measurement: vec![0.5],
    };
    let model = motes_tests::reference().model;
    assert_eq!((model.state_dim(), model.measurement_dim()), (1, 1));
    let config = StandardisedConfig { family: small_fcnn(), frames: Frames::Constant(frame) };
    let mut proposal: Standardised<Fcnn> =
        Standardised::create(&config, &ModelShape::of(&model), 2, F64, &Seed::from_u64(145)).unwrap();
    let (count, step) = (4001, 0.05);
    let states: Vec<f64> = (0..count).map(|at| (f64::from(at) - 2000.0) * step).collect();
    let previous = vec![0.7; count as usize];
    let context = Context::new(Step::of_index(1), Some(&previous), count as usize);
    let mut memory = Proposal::<motes_models::LinearGaussian>::initial_memory(&proposal, count as usize);
    let mut log_density = vec![0.0; count as usize];
    let mut scratch = Default::default();
    let mut conditional =
        proposal.condition_batch(&model, context, &[1.5], &mut memory, &mut scratch).unwrap();
    conditional.log_density(&states, &mut log_density);
    let mass: f64 = log_density.iter().map(|log| step * log.exp()).sum();
    assert!((mass - 1.0).abs() < 1e-9, "{mass}");
}

#[test]
fn a_standardised_proposal_comes_back_as_it_was_saved() {
    let folder = tempfile::tempdir().unwrap();
    let (path, model) = (folder.path().join("fcnn"), system());
    let proposal = make::<Fcnn>(small_fcnn(), Origin::Prediction, Backend::Native.into());
    let shape = ModelShape::of(&model);
    save(&path, &proposal, &model, &shape, &TrainConfig::paper(10)).unwrap();
    let loaded: Standardised<Fcnn> = load(&path, &model, &shape, Backend::Native.into()).unwrap();
    assert_eq!(loaded.config(), proposal.config());
    let weights = |proposal: &dyn Learnable| -> Vec<Vec<f64>> {
        (0..proposal.parameters().len()).map(|at| proposal.parameters().host(at)).collect()
    };
    assert_eq!(weights(&loaded), weights(&proposal));
    // The plain family does not take it for its own.
    let error = load::<Fcnn>(&path, &model, &shape, Backend::Native.into()).err().unwrap();
    assert!(matches!(error, SavedError::Unfit { .. }), "{error}");
}

fn too_long_of(frames: usize) -> String {
    format!("the number of frames is {frames}; it must be one for each time")
}

#[test]
fn frames_that_do_not_fit_are_refused() {
    let create = |frames: Frames, horizon: usize| {
        let config = StandardisedConfig { family: small_fcnn(), frames };
        let compute = Backend::Native.into();
        Standardised::<Fcnn>::create(
            &config,
            &ModelShape::of(&system()),
            horizon,
            compute,
            &Seed::from_u64(1),
        )
        .err()
        .unwrap()
    };
    let too_long = create(frames(Origin::MeanAtEachTime), HORIZON + 1);
    assert_eq!(too_long.to_string(), too_long_of(HORIZON));
    let good = || frames(Origin::Prediction).at(1).unwrap().clone();
    let refused = |change: fn(&mut Frame)| {
        let mut frame = good();
        change(&mut frame);
        create(Frames::Constant(frame), HORIZON).to_string()
    };
    assert!(refused(|frame| frame.output.deviations[1] = 0.0).contains("standard deviation"));
    assert!(refused(|frame| frame.previous.means[1] = f64::NAN).contains("NaN"));
    assert!(refused(|frame| frame.measurement.means.push(0.0)).contains("3 in the proposal and 2"));
    assert!(refused(|frame| frame.by_previous.truncate(8)).contains("8 in the proposal and 9"));
    let error = Frames::of(&simulations(3), Origin::Prediction).unwrap_err();
    assert!(error.to_string().contains("ten or more"), "{error}");
    // No frame at all is not one for all times.
    assert_eq!(create(Frames::AtEachTime(Vec::new()), 1).to_string(), too_long_of(0));
    // The horizon is that of the frames where the family has none.
    let rnn = make::<Rnn>(small_rnn(Cell::Lstm), Origin::Prediction, Backend::Native.into());
    assert_eq!(rnn.horizon(), Some(HORIZON));
}
