//! Designed filters, and what needs a density of states.

use motes_models::batch::LANES;
use motes_models::equations::Lanes;
use motes_models::{ModelError, Seed, StateSpaceModel, Step, check_model};
use motes_smc::{
    Bootstrap, Context, FilterBank, FilterError, FilterHistory, FilterSettings, GaussianBatch, Linearised,
    ParticleFilter, Proposal, ProposalError, ResampleWhen, backward_simulation,
};

use super::models::{
    ConstantVelocity, Delays, Epidemic, Population, Series, Shocks, Untrue, WhiteAcceleration, cases, delays,
    moves, people, positions,
};
use super::score::score;

/// With enough particles for `ẑ` to have no long tail.
fn bootstrap<M: StateSpaceModel>(model: &M, series: &Series) -> f64 {
    score(model, &Bootstrap, FilterSettings::new(200), series)
}

#[test]
fn the_evidence_of_counts_with_sub_steps_is_unbiased() {
    let of = |resets, shares| bootstrap(&Epidemic { resets, shares }, &cases());
    let (right, kept, twice) = (of(true, true), of(false, true), of(true, false));
    println!("counts: z = {right:.1}, without reset {kept:.1}, infections drawn twice {twice:.1}");
    assert!(right.abs() < 4.0 && kept.abs() > 8.0 && twice.abs() > 8.0);
}

#[test]
fn the_evidence_of_a_shared_draw_is_unbiased() {
    let [right, apart] = [true, false].map(|shares| bootstrap(&WhiteAcceleration { shares }, &positions()));
    println!("shared draw: z = {right:.1}, drawn twice {apart:.1}");
    assert!(right.abs() < 4.0 && apart.abs() > 6.0);
}

#[test]
fn the_evidence_of_other_maps_is_unbiased() {
    let found = [
        bootstrap(&ConstantVelocity, &moves()),
        bootstrap(&Population, &people()),
        bootstrap(&Delays, &delays()),
    ];
    println!("without noise, sums of counts, gamma noise: z = {found:.1?}");
    assert!(found.iter().all(|z| z.abs() < 4.0));
}

/// By the linearised proposal, which draws the noise: with the share that it has of itself, with another, and with hardly any.
#[test]
fn linearised_noise_leaves_evidence_unbiased() {
    for defensive_weight in [None, Some(0.3), Some(0.01)] {
        let settings = FilterSettings { defensive_weight, ..FilterSettings::new(50) };
        let epidemic = Epidemic { resets: true, shares: true };
        let accelerated = WhiteAcceleration { shares: true };
        let found = [
            score(&epidemic, &Linearised::new(&epidemic).unwrap(), settings, &cases()),
            score(&accelerated, &Linearised::new(&accelerated).unwrap(), settings, &positions()),
            score(&ConstantVelocity, &Linearised::new(&ConstantVelocity).unwrap(), settings, &moves()),
            score(&Population, &Linearised::new(&Population).unwrap(), settings, &people()),
            score(&Delays, &Linearised::new(&Delays).unwrap(), settings, &delays()),
        ];
        println!("linearised, share {defensive_weight:?}: z = {found:.1?}");
        assert!(found.iter().all(|z| z.abs() < 4.0));
    }
}

/// Streams belong to blocks, whatever thread draws them.
#[test]
fn noise_is_the_same_on_any_number_of_threads() {
    let epidemic = Epidemic { resets: true, shares: true };
    let run = |threads: usize| {
        let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let proposal = Linearised::new(&epidemic).unwrap();
            let settings = FilterSettings::new(3000);
            let seed = Seed::from_u64(4);
            let mut bank = FilterBank::new(&epidemic, proposal, settings, 2, &seed).unwrap();
            for (index, row) in cases().measurements.rows().enumerate() {
                bank.step_at(&epidemic.step_of_index(index), row).unwrap();
            }
            [0, 1].map(|filter| bank.log_evidence(filter).to_bits())
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_ne!(one[0], one[1]);
}

/// Derivatives along six draws, in two passes, against differences; an entry that is missing says nothing.
#[test]
fn scores_of_noise_are_those_of_differences() {
    let (step, previous) =
        (Shocks.step_of_index(3), [0.3; LANES].iter().chain(&[0.1; LANES]).copied().collect::<Vec<_>>());
    let noise_space = Shocks.noise_space().unwrap();
    let locations = |at: usize, by: f64| {
        let (mut noise, mut states) = (vec![0.0; 6 * LANES], vec![0.0; 2 * LANES]);
        noise[at * LANES..][..LANES].fill(by);
        noise_space.tile_states(&step, Some(&previous), &noise, &mut states);
        let (x, before) = (states[5], states[LANES + 5]);
        [x * x, (x + before).exp()]
    };
    for is_missing in [false, true] {
        let measurement = [Some(Lanes::from(0.7)), (!is_missing).then(|| Lanes::from(2.0))];
        let (mut slopes, mut information) = (vec![9.0; 2 * LANES], vec![9.0; 2 * LANES]);
        let mut jacobian = vec![9.0; 12 * LANES];
        noise_space.tile_noise_scores(
            &step,
            Some(&previous),
            &measurement,
            &mut slopes,
            &mut information,
            &mut jacobian,
        );
        for at in 0..6 {
            let [up, down] = [1e-6, -1e-6].map(|by| locations(at, by));
            for entry in 0..2 {
                let expected = if entry == 1 && is_missing { 0.0 } else { (up[entry] - down[entry]) / 2e-6 };
                let found = jacobian[(entry * 6 + at) * LANES + 5];
                assert!((found - expected).abs() < 1e-6, "entry {entry}, draw {at}: {found}, {expected}");
            }
        }
    }
}

/// A draw that cannot vary, as nobody is there who could recover, leaves the derivatives along the others alone.
#[test]
fn a_draw_without_variance_leaves_the_others_alone() {
    let epidemic = Epidemic { resets: true, shares: true };
    let step = epidemic.step_of_index(1);
    // Nobody is ill at first; all that comes is none, and the position of the others is known.
    let previous: Vec<f64> = [13.0, 0.0, 0.0].iter().flat_map(|x| [*x; LANES]).collect();
    let mut found = vec![0.0; 11 * LANES];
    let (slopes, rest) = found.split_at_mut(LANES);
    let (information, jacobian) = rest.split_at_mut(LANES);
    let measurement = [Some(Lanes::from(1.0))];
    let noise_space = epidemic.noise_space().unwrap();
    noise_space.tile_noise_scores(&step, Some(&previous), &measurement, slopes, information, jacobian);
    assert!(found.iter().all(|value| value.is_finite()), "{found:?}");
}

/// Where position and speed share the noise and the position is measured, the proposal is the optimum: weights hardly vary, where those of the transition do.
#[test]
fn linearised_noise_is_the_optimum_of_a_linear_model() {
    let model = WhiteAcceleration { shares: true };
    let ess = |filter: &mut dyn FnMut(&[f64]) -> f64| {
        positions().measurements.rows().map(|row| filter(&[row[0].unwrap()])).fold(f64::INFINITY, f64::min)
    };
    let settings = FilterSettings { resample_when: ResampleWhen::Always, ..FilterSettings::new(2000) };
    let stream = || Seed::from_u64(5).stream();
    let mut guided =
        ParticleFilter::new(&model, Linearised::new(&model).unwrap(), settings, stream()).unwrap();
    let mut blind = ParticleFilter::new(&model, Bootstrap, settings, stream()).unwrap();
    let of_guided = ess(&mut |y| {
        guided.step(y).unwrap();
        guided.effective_sample_size()
    });
    let of_blind = ess(&mut |y| {
        blind.step(y).unwrap();
        blind.effective_sample_size()
    });
    println!("least effective sample sizes: linearised {of_guided:.0}, bootstrap {of_blind:.0}");
    assert!(of_guided > 1.1 * of_blind);
}

/// A proposal of states is weighed by a density that there is none of.
#[test]
fn proposals_of_states_are_refused_by_name() {
    let (settings, stream) = (FilterSettings::new(50), Seed::from_u64(1).stream());
    let settings = FilterSettings { defensive_weight: Some(0.5), ..settings };
    let mut filter = ParticleFilter::new(&ConstantVelocity, OfStates, settings, stream).unwrap();
    let said = filter.step(&[0.2]).unwrap_err();
    assert!(matches!(said, FilterError::Proposal { step: 0, source: ProposalError::NoDensity }), "{said}");
}

/// Standard normal states.
struct OfStates;

impl Proposal<ConstantVelocity> for OfStates {
    type Memory = ();
    type Scratch = GaussianBatch;
    type Conditional<'a> = &'a mut GaussianBatch;

    fn initial_memory(&self, _: usize) {}

    fn prepare(
        &mut self,
        _: &ConstantVelocity,
        _: &Step<'_>,
        measurement: &[Option<f64>],
    ) -> Result<bool, ProposalError> {
        Ok(measurement.iter().all(Option::is_some))
    }

    fn condition<'a>(
        &'a self,
        _: &'a ConstantVelocity,
        context: Context<'a>,
        (): (),
        scratch: &'a mut GaussianBatch,
    ) -> Result<&'a mut GaussianBatch, ProposalError> {
        let (means, lowers) = scratch.places(2, context.particles);
        means.fill(0.0);
        lowers.chunks_exact_mut(4).for_each(|lower| lower.copy_from_slice(&[1.0, 0.0, 0.0, 1.0]));
        Ok(scratch)
    }
}

/// Backward simulation has nothing to draw by: paths are those of the filter's ancestors, and their means the smoothed ones.
#[test]
fn smoothed_paths_follow_ancestors() {
    let settings = FilterSettings::new(20_000);
    let mut filter =
        ParticleFilter::new(&ConstantVelocity, Bootstrap, settings, Seed::from_u64(2).stream()).unwrap();
    let mut history = FilterHistory::default();
    for (index, row) in moves().measurements.rows().enumerate() {
        filter.step_at(&Step::of_index(index), row).unwrap();
        history.record(&filter).unwrap();
    }
    let paths = backward_simulation(&ConstantVelocity, &history, 20_000, &Seed::from_u64(3)).unwrap();
    assert!(paths.follow_ancestors());
    for path in (0..paths.len()).step_by(100) {
        let path = paths.path(path);
        let moves = path.windows(4).step_by(2);
        assert!(moves.clone().count() == 5 && moves.clone().all(|pair| pair[2] == pair[0] + pair[1]));
    }
    // The smoothed mean of the last time is the filtered one.
    let mean = (0..paths.len()).map(|path| paths.path(path)[10]).sum::<f64>() / paths.len() as f64;
    assert!((mean - 2.949163).abs() < 0.02, "{mean}");
}

#[test]
fn what_a_model_says_wrongly_of_itself_is_refused() {
    let said = |draws_by_state| match check_model(&Untrue { draws_by_state }) {
        Err(ModelError::Parameter { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(said(false), "the state");
    assert_eq!(said(true), "the number of draws of a step");
}
