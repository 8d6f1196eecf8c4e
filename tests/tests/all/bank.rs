//! What a bank of filters promises: independence, shift invariance, memory, and errors that say what happened.

use std::sync::Arc;

use faer::Mat;
use motes_models::batch::Rows;
use motes_models::{
    GraphDiffusion, GraphDiffusionConfig, GraphModel, LinearGaussian, Measurements, ModelError, ModelShape,
    Seed, StateSpaceModel, Step, Stream, kalman, simulate,
};
use motes_proposals::{
    Adapter, Backend, Cell, Family, Fcnn, FcnnConfig, Gnn, Learnable, Psi, Rnn, RnnConfig,
};
use motes_smc::{
    Bootstrap, Context, ErrorKind, FilterBank, FilterError, FilterSettings, MinDegeneracy, ParticleFilter,
    Proposal, ProposalError, ResampleWhen, Resampling, Transition,
};
use motes_tests::{Shifted, reference, relative_distance, small_fcnn, small_gnn, small_psi, small_rnn};

/// Filters the reference measurements with this constant in every log-likelihood: an evidence, all particles, all ancestors.
fn shifted<M: StateSpaceModel + Clone, P: Proposal<Shifted<M>> + Clone>(
    model: &M,
    proposal: &P,
    settings: FilterSettings,
    shift: f64,
) -> (f64, Vec<f64>, Vec<usize>) {
    let model = Shifted { model: model.clone(), shift, from: 0 };
    let mut bank = FilterBank::new(&model, proposal.clone(), settings, 3, &Seed::from_u64(50)).unwrap();
    let (mut particles, mut ancestors) = (vec![], vec![]);
    for measurement in reference().measurements.rows() {
        bank.step(measurement).unwrap();
        particles.extend((0..3).flat_map(|filter| bank.particles(filter).to_vec()));
        ancestors.extend(bank.ancestors().to_vec());
    }
    (bank.log_evidence(1), particles, ancestors)
}

fn assert_shifts<M: StateSpaceModel + Clone, P: Proposal<Shifted<M>> + Clone>(
    name: &str,
    model: &M,
    proposal: &P,
    settings: FilterSettings,
) {
    let settings = FilterSettings { resample_when: ResampleWhen::EssBelow(0.5), ..settings };
    let (plain, particles, ancestors) = shifted(model, proposal, settings, 0.0);
    assert!(ancestors.iter().enumerate().any(|(k, &a)| k % 192 != a), "{name}: nothing was resampled");
    for shift in [-1e5, 1e5] {
        let (found, same_particles, same_ancestors) = shifted(model, proposal, settings, shift);
        assert!(((found - plain) / (5.0 * shift) - 1.0).abs() < 1e-9, "{name}: {found} for {plain}");
        assert!(same_particles == particles && same_ancestors == ancestors, "{name}");
    }
}

#[test]
fn a_constant_in_every_log_likelihood_shifts_the_evidence_and_nothing_else() {
    let model = reference().model;
    for resampling in
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual]
    {
        let settings = FilterSettings { resampling, ..FilterSettings::new(64) };
        assert_shifts(&format!("{resampling:?}"), &model, &Bootstrap, settings);
    }
    // One node, so that a graph network has a graph.
    let config = GraphDiffusionConfig { measurement_dim: 1, ..GraphDiffusionConfig::new(1) };
    let node = GraphDiffusion::on_graph(&config, Mat::from_fn(1, 1, |_, _| 0.9).as_ref()).unwrap();
    let safe = FilterSettings { defensive_weight: Some(0.2), ..FilterSettings::new(64) };
    assert_shifts("fcnn", &node, &made::<Fcnn>(&small_fcnn(), &node), safe);
    assert_shifts("rnn", &node, &made::<Rnn>(&small_rnn(Cell::Lstm), &node), safe);
    assert_shifts("gnn", &node, &made::<Gnn>(&small_gnn(Adapter::Fixed), &node), safe);
    assert_shifts("psi", &node, &made::<Psi>(&small_psi(), &node), safe);
}

fn made<F: Family + Learnable>(config: &F::Config, model: &impl GraphModel) -> F {
    F::create(config, &ModelShape::on_graph(model), 5, Backend::Native.into(), &Seed::from_u64(53)).unwrap()
}

#[test]
fn a_filter_in_a_bank_does_what_it_would_do_alone() {
    let reference = reference();
    let proposal = MinDegeneracy::new(&reference.model).unwrap();
    let settings = FilterSettings { defensive_weight: Some(0.3), ..FilterSettings::new(32) };
    let seed = Seed::from_u64(51);
    let mut bank = FilterBank::new(&reference.model, proposal.clone(), settings, 5, &seed).unwrap();
    let mut alone = ParticleFilter::new(&reference.model, proposal, settings, seed.nth(3).stream()).unwrap();
    for measurement in reference.measurements.rows() {
        bank.step(measurement).unwrap();
        alone.step(measurement).unwrap();
        assert_eq!(bank.particles(3), alone.particles());
        assert_eq!(bank.weights(3), alone.weights());
    }
    assert_eq!(bank.log_evidence(3), alone.log_evidence());
}

#[test]
fn a_filter_in_a_bank_of_larger_states_does_what_it_would_do_alone() {
    let seed = Seed::from_u64(54);
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(10), &mut seed.child("graph").stream()).unwrap();
    let measurements = simulate(&system, 6, &mut seed.child("data").stream()).unwrap().measurements;
    let config = FcnnConfig { widths: vec![32, 16], ..FcnnConfig::paper() };
    let fcnn =
        Fcnn::create(&config, &ModelShape::of(&system), 6, Backend::Native.into(), &seed.child("weights"))
            .unwrap();
    // Products of matrices may round differently in a batch of another size: then by some 1e-15, f32 networks by 1e-7.
    same_alone(&system, MinDegeneracy::new(&system).unwrap(), &measurements, 1e-12);
    same_alone(&system, fcnn, &measurements, 1e-4);
}

fn same_alone<P: Proposal<GraphDiffusion> + Clone>(
    system: &GraphDiffusion,
    proposal: P,
    measurements: &Measurements,
    tolerance: f64,
) {
    let (settings, seed) = (FilterSettings::new(24), Seed::from_u64(55));
    let mut bank = FilterBank::new(system, proposal.clone(), settings, 7, &seed).unwrap();
    // A filter that shares ownership of its model, as a service would hold it.
    let mut alone =
        ParticleFilter::new(Arc::new(system.clone()), proposal, settings, seed.nth(3).stream()).unwrap();
    for measurement in measurements.rows() {
        bank.step(measurement).unwrap();
        alone.step(measurement).unwrap();
        let distance = relative_distance(alone.particles(), bank.particles(3));
        assert!(distance <= tolerance, "particles differ by {distance:e}");
    }
    assert!((bank.log_evidence(3) / alone.log_evidence() - 1.0).abs() <= tolerance);
}

/// The transition, remembering every state that a particle descends from.
#[derive(Clone)]
struct Remembering;

impl Proposal<LinearGaussian> for Remembering {
    type Memory = Vec<Vec<f64>>;
    type Scratch = ();
    type Conditional<'a> = <Bootstrap as Proposal<LinearGaussian>>::Conditional<'a>;

    fn initial_memory(&self, particles: usize) -> Self::Memory {
        vec![vec![]; particles]
    }

    fn prepare(
        &mut self,
        _model: &LinearGaussian,
        _step: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        Ok(measurement.iter().all(Option::is_some))
    }

    fn condition<'a>(
        &'a self,
        model: &'a LinearGaussian,
        context: Context<'a>,
        memory: &mut [Vec<f64>],
        (): &'a mut (),
    ) -> Result<Self::Conditional<'a>, ProposalError> {
        if let Some(previous) = context.previous {
            memory.iter_mut().enumerate().for_each(|(row, path)| path.push(previous.row(row)[0]));
        }
        Ok(Transition::new(model, context))
    }
}

#[test]
fn memory_follows_the_particle_that_owns_it() {
    let reference = reference();
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(16) };
    let mut bank = FilterBank::new(&reference.model, Remembering, settings, 2, &Seed::from_u64(52)).unwrap();
    let (mut history, mut ancestry): (Vec<Vec<f64>>, Vec<Vec<usize>>) = (vec![], vec![]);
    for measurement in reference.measurements.rows() {
        bank.step(measurement).unwrap();
        history.push((0..2).flat_map(|filter| bank.particles(filter).to_vec()).collect());
        ancestry.push(bank.ancestors().to_vec());
    }
    let (last, mut moved) = (history.len() - 1, 0);
    for row in 0..32 {
        let (mut path, mut at) = (vec![], row);
        for time in (0..last).rev() {
            moved += usize::from(ancestry[time + 1][at] != at);
            at = ancestry[time + 1][at];
            path.push(history[time][at]);
        }
        path.reverse();
        assert_eq!(bank.memory()[row], path, "row {row}");
    }
    assert!(moved > 32, "resampling moved only {moved} particles");
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let reference = reference();
    let model = &reference.model;
    let new = |settings| FilterBank::new(model, Bootstrap, settings, 1, &Seed::from_u64(1)).map(|_| ());
    let none = new(FilterSettings::new(0)).unwrap_err();
    assert_eq!(none.to_string(), "the number of particles K is 0; it must be at least 1");
    let rule = FilterSettings { resample_when: ResampleWhen::EssBelow(f64::NAN), ..FilterSettings::new(4) };
    assert!(new(rule).unwrap_err().to_string().contains("NaN"));
    for weight in [-0.1, 1.0, f64::NAN] {
        let settings = FilterSettings { defensive_weight: Some(weight), ..FilterSettings::new(4) };
        let error = new(settings).unwrap_err().to_string();
        assert!(error.starts_with("the transition's weight in a defensive mixture is"), "{error}");
    }

    let stream = Seed::from_u64(1).stream();
    let mut filter = ParticleFilter::new(model, Bootstrap, FilterSettings::new(4), stream).unwrap();
    assert!(filter.step(&[1.0, 2.0]).unwrap_err().to_string().contains("width 2"));
    assert!(filter.step(&[f64::INFINITY]).unwrap_err().to_string().contains("row 0, column 0 is inf"));
    assert_eq!(filter.time(), 0);
    filter.step(&[0.5]).unwrap();
}

#[test]
fn the_collapse_of_all_weights_is_reported_with_its_circumstances() {
    let model = Shifted { model: reference().model, shift: f64::NEG_INFINITY, from: 0 };
    let stream = Seed::from_u64(1).stream();
    let mut filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(4), stream).unwrap();
    let error = filter.step(&[0.0]).unwrap_err();
    assert!(matches!(error, FilterError::Collapse { step: 0, filter: 0, .. }));
    assert_eq!(
        error.to_string(),
        "at step 0, all weights of filter 0 are zero (ESS before it 4.0, largest log-likelihood -inf)"
    );
    assert_eq!(error.kind(), ErrorKind::Collapse);
    assert_eq!(filter.step(&[0.0]).unwrap_err(), error, "a filter that failed stays failed");
}

/// A model whose second state is NaN from the first transition on.
struct RunsAway(LinearGaussian);

impl StateSpaceModel for RunsAway {
    fn state_dim(&self) -> usize {
        1
    }

    fn measurement_dim(&self) -> usize {
        1
    }

    fn sample_states(
        &self,
        step: &Step<'_>,
        previous: Option<Rows<'_>>,
        streams: &mut [Stream],
        states: &mut [f64],
    ) {
        match previous {
            None => self.0.sample_states(step, None, streams, states),
            Some(_) => states.fill(f64::NAN),
        }
    }

    fn log_likelihoods(
        &self,
        step: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        self.0.log_likelihoods(step, states, measurement, out)
    }
}

#[test]
fn a_state_that_is_no_number_is_an_error_where_nothing_is_measured() {
    let model = RunsAway(reference().model);
    let mut filter =
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(5000), Seed::from_u64(57).stream())
            .unwrap();
    filter.step(&[0.3]).unwrap();
    let said = filter.step_at(&Step::of_index(1), &[None]).unwrap_err();
    assert_eq!(said.kind(), ErrorKind::Numerical);
    assert!(
        matches!(said, FilterError::State { step: 1, filter: 0, particle: 0, coordinate: 0, .. }),
        "{said}"
    );
    assert_eq!(filter.step(&[0.3]).unwrap_err().to_string(), said.to_string(), "it stays failed");
}

#[test]
fn quantiles_are_those_of_the_weighted_particles() {
    let reference = reference();
    let stream = Seed::from_u64(58).stream();
    let mut filter =
        ParticleFilter::new(&reference.model, Bootstrap, FilterSettings::new(40_000), stream).unwrap();
    reference.measurements.rows().for_each(|measurement| filter.step(measurement).unwrap());
    let exact = kalman::filter(&reference.model, &reference.measurements).unwrap();
    let belief = &exact.steps[reference.measurements.len() - 1].filtered;
    let (mean, deviation) = (belief.mean[0], belief.covariance[(0, 0)].sqrt());
    // Normal quantiles; a standard error of the outer ones is some 0.02 deviations with 10,000 effective particles.
    let expected = [-1.644_853_6, -0.674_489_8, 0.0, 0.674_489_8, 1.644_853_6].map(|z| mean + deviation * z);
    let found = filter.quantiles(0, &[0.05, 0.25, 0.5, 0.75, 0.95]);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 0.08 * deviation, "{found} for {expected}");
    }
    // The ends are the outermost particles that have weight.
    let ends = filter.quantiles(0, &[0.0, 1.0]);
    let least = filter.particles().iter().copied().fold(f64::INFINITY, f64::min);
    let most = filter.particles().iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(ends, [least, most]);
}

/// Particles and evidence of learned filters on so many threads: a large one, and one of a bank.
fn on_threads<F: Family + Learnable + Proposal<GraphDiffusion> + Clone + Send>(
    config: &F::Config,
    threads: usize,
) -> Vec<(Vec<f64>, f64)> {
    let system =
        GraphDiffusion::random(&GraphDiffusionConfig::new(5), &mut Seed::from_u64(59).stream()).unwrap();
    let measurements = simulate(&system, 3, &mut Seed::from_u64(60).stream()).unwrap().measurements;
    let proposal: F = made(config, &system);
    let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    // 76 filters of ten: halves would not be whole groups.
    let seen = [(1, 5000), (120, 40), (76, 10)].map(|(filters, particles)| {
        let settings = FilterSettings { defensive_weight: Some(0.1), ..FilterSettings::new(particles) };
        let seed = Seed::from_u64(61);
        let mut bank = FilterBank::new(&system, proposal.clone(), settings, filters, &seed).unwrap();
        pool.install(|| bank.run(&measurements, |_| ())).unwrap();
        let last = filters - 1;
        (bank.particles(last).to_vec(), bank.log_evidence(last))
    });
    seen.into()
}

#[test]
fn learned_filters_give_the_same_bytes_on_any_number_of_threads() {
    fn check<F: Family + Learnable + Proposal<GraphDiffusion> + Clone + Send>(config: &F::Config) {
        let one = on_threads::<F>(config, 1);
        assert!(one == on_threads::<F>(config, 2) && one == on_threads::<F>(config, 3), "{}", F::NAME);
    }
    check::<Fcnn>(&small_fcnn());
    check::<Rnn>(&RnnConfig { hidden: 32, depth: 1, ..small_rnn(Cell::Lstm) });
    check::<Gnn>(&small_gnn(Adapter::Fixed));
    check::<Psi>(&small_psi());
}
