//! Filters that are written down and restored: to the last bit they go on as the originals do, and what is no snapshot is refused.

use ciborium::Value;
use faer::mat;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{Gaussian, LinearGaussian, Measurements, Seed, StateSpaceModel, Step, simulate};
use motes_smc::{
    BankSnapshot, Bootstrap, FilterBank, FilterError, FilterSettings, FilterSnapshot, MinDegeneracy,
    ParticleFilter, Proposal, ResampleWhen, Resampling, SecondOpinion,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn model() -> LinearGaussian {
    let initial = Gaussian::new("P_0", vec![0.0, 1.0], mat![[1.0, 0.0], [0.0, 0.5]]).unwrap();
    let (moves, noise) = (mat![[1.0, 1.0], [0.0, 0.9]], mat![[0.1, 0.0], [0.0, 0.2]]);
    LinearGaussian::new(initial, moves, noise, mat![[1.0, 0.0]], mat![[0.5]]).unwrap()
}

fn data(model: &LinearGaussian) -> Measurements {
    simulate(model, 30, &mut Seed::from_u64(40).stream()).unwrap().measurements
}

/// What is read of a value that was written.
fn written<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).unwrap();
    ciborium::from_reader(&bytes[..]).unwrap()
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

fn assert_same<M: StateSpaceModel, P: Proposal<M>>(a: &FilterBank<&M, P>, b: &FilterBank<&M, P>) {
    assert_eq!((a.time(), a.ancestors(), a.failure()), (b.time(), b.ancestors(), b.failure()));
    for filter in 0..a.filters() {
        assert_eq!(bits(a.particles(filter)), bits(b.particles(filter)));
        assert_eq!(a.previous_particles(filter).map(bits), b.previous_particles(filter).map(bits));
        assert_eq!(bits(a.weights(filter).log()), bits(b.weights(filter).log()));
        assert_eq!(a.log_evidence(filter).to_bits(), b.log_evidence(filter).to_bits());
        assert_eq!(a.resampled(filter), b.resampled(filter));
    }
    assert_eq!(a.diagnosis(), b.diagnosis());
}

fn goes_on<P: Proposal<LinearGaussian, Memory = ()> + Clone>(
    proposal: &P,
    settings: FilterSettings,
    filters: usize,
) {
    let model = model();
    let data = data(&model);
    let mut bank = FilterBank::new(&model, proposal.clone(), settings, filters, &Seed::from_u64(1)).unwrap();
    for (time, row) in data.rows().enumerate() {
        // Before the first step, too, and after gaps.
        if [0, 1, 7, 20].contains(&time) {
            let mut again = FilterBank::restore(&model, proposal.clone(), written(&bank.snapshot())).unwrap();
            assert_same(&bank, &again);
            let mut original = bank.clone();
            for later in time..time + 8 {
                let step = |bank: &mut FilterBank<&LinearGaussian, P>| match later % 4 {
                    3 => bank.step_at(&Step::of_index(later), &vec![None; data.width()]),
                    _ => bank.step(data.row(later)),
                };
                step(&mut original).unwrap();
                step(&mut again).unwrap();
                assert_same(&original, &again);
            }
        }
        bank.step(row).unwrap();
    }
}

#[test]
fn a_bank_goes_on_from_a_snapshot_to_the_last_bit() {
    let designed = MinDegeneracy::new(&model()).unwrap();
    for resampling in
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual]
    {
        let settings = FilterSettings { resampling, ..FilterSettings::new(60) };
        goes_on(&Bootstrap, settings, 3);
        goes_on(&designed, FilterSettings { defensive_weight: Some(0.1), ..settings }, 2);
    }
    for resample_when in [ResampleWhen::Always, ResampleWhen::Never] {
        // Cut into blocks, which have streams of their own.
        goes_on(&Bootstrap, FilterSettings { resample_when, ..FilterSettings::new(2500) }, 1);
    }
}

#[test]
fn a_filter_and_a_second_opinion_go_on() {
    let model = model();
    let data = data(&model);
    let filter = |label: &str, count: usize| {
        let stream = Seed::from_u64(3).child(label).stream();
        ParticleFilter::new(&model, Bootstrap, FilterSettings::new(count), stream).unwrap()
    };
    let (mut a, mut b, mut opinion) = (filter("a", 30), filter("b", 300), SecondOpinion::new());
    for row in data.rows().take(10) {
        a.step(row).unwrap();
        b.step(row).unwrap();
        opinion.step(&a, &b).unwrap();
    }
    let snapshot: FilterSnapshot<()> = written(&a.snapshot());
    assert_eq!((snapshot.time(), snapshot.settings().particles), (10, 30));
    let mut again = ParticleFilter::restore(&model, Bootstrap, snapshot).unwrap();
    assert_eq!(bits(again.mean()), bits(a.mean()));
    let mut same = written(&opinion);
    for row in data.rows().skip(10) {
        a.step(row).unwrap();
        again.step(row).unwrap();
        b.step(row).unwrap();
        opinion.step(&a, &b).unwrap();
        same.step(&again, &b).unwrap();
        assert_eq!(bits(a.particles()), bits(again.particles()));
        assert_eq!(bits(a.mean()), bits(again.mean()));
        assert_eq!(opinion.verdict(), same.verdict());
        assert_eq!(opinion.difference().to_bits(), same.difference().to_bits());
        assert_eq!(opinion.standard_error().to_bits(), same.standard_error().to_bits());
    }
}

/// A root whose argument can become negative, measured with bounded noise of no use.
struct Root;

impl Equations for Root {
    fn dimensions(&self) -> [usize; 2] {
        [1, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(1.0, 0.1));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0].sqrt() - 0.5, 0.1));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

#[test]
fn a_filter_that_failed_has_failed() {
    let stream = Seed::from_u64(1).stream();
    let mut filter = ParticleFilter::new(&Root, Bootstrap, FilterSettings::new(100), stream).unwrap();
    let failure = (0..20).find_map(|_| filter.step(&[0.2]).err()).unwrap();
    let FilterError::NotANumber { particle, .. } = failure else { panic!("{failure}") };
    let mut again = ParticleFilter::restore(&Root, Bootstrap, written(&filter.snapshot())).unwrap();
    assert_eq!(again.step(&[0.2]).unwrap_err().to_string(), failure.to_string());
    // Still there, to say where the formula left its domain.
    assert!(again.previous_particles().unwrap()[again.ancestors()[particle]] < 0.0);
    assert_eq!(again.previous_particles().map(bits), filter.previous_particles().map(bits));
}

#[test]
fn the_words_of_other_failures_are_kept() {
    let model = model();
    let wide = LinearGaussian::new(
        Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap(),
        mat![[0.9]],
        mat![[1.0]],
        mat![[1.0]],
        mat![[1.0]],
    )
    .unwrap();
    // A proposal of another model cannot be prepared.
    let foreign = MinDegeneracy::new(&wide).unwrap();
    let stream = Seed::from_u64(1).stream();
    let mut filter = ParticleFilter::new(&model, foreign.clone(), FilterSettings::new(10), stream).unwrap();
    let failure = filter.step(&[0.2]).unwrap_err();
    let mut again = ParticleFilter::restore(&model, foreign, written(&filter.snapshot())).unwrap();
    let restored = again.step(&[0.2]).unwrap_err();
    assert_eq!((restored.to_string(), restored.kind()), (failure.to_string(), failure.kind()));
}

/// A snapshot of three filters with one of its entries replaced.
fn edited(entry: &str, value: Value) -> Result<(), String> {
    let model = model();
    let mut bank = FilterBank::new(&model, Bootstrap, FilterSettings::new(4), 3, &Seed::from_u64(1)).unwrap();
    bank.step(data(&model).row(0)).unwrap();
    let mut map = Value::serialized(&bank.snapshot()).unwrap();
    let entries = map.as_map_mut().unwrap();
    let found = entries.iter_mut().find(|(key, _)| key.as_text() == Some(entry)).unwrap();
    found.1 = value;
    let snapshot: BankSnapshot<()> = map.deserialized().map_err(|error| error.to_string())?;
    FilterBank::restore(&model, Bootstrap, snapshot).map(drop).map_err(|error| error.to_string())
}

#[test]
fn what_fits_no_filter_is_refused() {
    let numbers = |count: usize, value: f64| Value::Array(vec![Value::Float(value); count]);
    let integers = |count: usize, value: u64| Value::Array(vec![Value::Integer(value.into()); count]);
    assert_eq!(edited("log_evidence", numbers(3, -1.0)), Ok(()));
    for (entry, value) in [
        ("states", numbers(23, 0.0)),
        ("previous", numbers(0, 0.0)),
        ("streams", Value::Array(vec![])),
        ("log_evidence", numbers(2, 0.0)),
        ("increments", numbers(4, 0.0)),
        ("resampled", Value::Array(vec![Value::Bool(false); 2])),
        ("weights", Value::Array(vec![])),
        ("ancestors", integers(12, 0)),
        ("ancestors", integers(12, u64::MAX)),
        ("time", Value::Integer(u64::MAX.into())),
    ] {
        let said = edited(entry, value).unwrap_err();
        assert!(!said.contains('\n'), "{entry}: {said}");
    }
    let model = model();
    let other = LinearGaussian::new(
        Gaussian::new("P_0", vec![0.0], mat![[1.0]]).unwrap(),
        mat![[0.9]],
        mat![[1.0]],
        mat![[1.0]],
        mat![[1.0]],
    )
    .unwrap();
    let stream = Seed::from_u64(1).stream();
    let filter = ParticleFilter::new(&model, Bootstrap, FilterSettings::new(10), stream).unwrap();
    assert!(ParticleFilter::restore(&other, Bootstrap, filter.snapshot()).is_err());
}
