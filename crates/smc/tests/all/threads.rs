//! The same bytes on any number of threads, and for a filter in a bank and alone.

use motes_models::{Drift, GraphDiffusion, GraphDiffusionConfig, Measurements, Noise, Seed, Step, simulate};
use motes_smc::{
    Bootstrap, FilterBank, FilterError, FilterSettings, MinDegeneracy, ParticleFilter, Proposal, ResampleWhen,
};
use rayon_core::{ThreadPool, ThreadPoolBuilder};

fn problem(noise: Noise) -> (GraphDiffusion, Measurements) {
    let seed = Seed::from_u64(80);
    let config = GraphDiffusionConfig { noise, drift: Drift::Abs, ..GraphDiffusionConfig::new(10) };
    let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
    let measurements = simulate(&system, 4, &mut seed.child("data").stream()).unwrap().measurements;
    (system, measurements)
}

fn settings(particles: usize) -> FilterSettings {
    FilterSettings { resample_when: ResampleWhen::EssBelow(0.9), ..FilterSettings::new(particles) }
}

/// A pool of so many threads.
fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// What a bank shows after each step: particles, log-weights, ancestors.
type Seen = Vec<(Vec<f64>, Vec<f64>, Vec<usize>)>;

/// Everything that a bank shows after each step on so many threads, stepped one by one or run.
fn run<P: Proposal<GraphDiffusion> + Send>(
    proposal: P,
    settings: FilterSettings,
    filters: usize,
    threads: usize,
    stepped: bool,
) -> Seen {
    let (system, measurements) = problem(Noise::Gaussian);
    let mut bank = FilterBank::new(&system, proposal, settings, filters, &Seed::from_u64(81)).unwrap();
    let mut seen = vec![];
    let mut see = |bank: &FilterBank<&GraphDiffusion, P>| {
        let states = (0..filters).flat_map(|filter| bank.particles(filter).to_vec()).collect();
        let weights = (0..filters).flat_map(|filter| bank.weights(filter).log().to_vec()).collect();
        seen.push((states, weights, bank.ancestors().to_vec()));
    };
    pool(threads).install(|| {
        if stepped {
            for measurement in measurements.rows() {
                bank.step(measurement).unwrap();
                see(&bank);
            }
        } else {
            bank.run(&measurements, see).unwrap();
        }
    });
    assert_eq!(bank.time(), measurements.len());
    seen
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let (system, _) = problem(Noise::Gaussian);
    let proposal = MinDegeneracy::new(&system).unwrap();
    for (particles, filters) in [(20_000, 1), (9000, 3), (50, 300), (10, 100), (1, 5000), (300, 40)] {
        let plain = settings(particles);
        let one = run(Bootstrap, plain, filters, 1, true);
        for (threads, stepped) in [(2, true), (3, true), (1, false), (2, false), (3, false)] {
            let other = run(Bootstrap, plain, filters, threads, stepped);
            assert!(one == other, "bootstrap, {filters} × {particles}, {threads} threads");
        }
        for settings in [plain, FilterSettings { defensive_weight: Some(0.2), ..plain }] {
            let one = run(proposal.clone(), settings, filters, 1, true);
            let other = run(proposal.clone(), settings, filters, 2, false);
            assert!(one == other, "minimum degeneracy, {filters} × {particles}, {settings:?}");
        }
    }
}

#[test]
fn gaps_give_the_same_bytes_on_any_number_of_threads() {
    let (system, measurements) = problem(Noise::Gaussian);
    let with_gaps = measurements.rows().enumerate().map(|(time, row)| {
        let there = |at: usize| time == 0 || (time != 2 && at % 3 != time % 3);
        row.iter().enumerate().map(move |(at, value)| there(at).then_some(*value)).collect::<Vec<_>>()
    });
    let with_gaps: Vec<Vec<Option<f64>>> = with_gaps.collect();
    let seen = |threads: usize| {
        let proposal = MinDegeneracy::new(&system).unwrap();
        let stream = Seed::from_u64(85).stream();
        let mut filter = ParticleFilter::new(&system, proposal, settings(20_000), stream).unwrap();
        let rows = with_gaps.iter().enumerate();
        pool(threads)
            .install(|| rows.for_each(|(at, row)| filter.step_at(&Step::of_index(at), row).unwrap()));
        (filter.particles().to_vec(), filter.log_evidence())
    };
    let one = seen(1);
    assert!(one == seen(2) && one == seen(3));
}

#[test]
fn a_filter_in_a_bank_gets_the_bytes_that_it_gets_alone() {
    for noise in [Noise::Gaussian, Noise::Exponential, Noise::Uniform] {
        let (system, measurements) = problem(noise);
        for particles in [1, 3, 10, 50, 127, 300, 5000] {
            let seed = Seed::from_u64(82);
            let proposal = Bootstrap;
            let mut bank = FilterBank::new(&system, proposal, settings(particles), 11, &seed).unwrap();
            let stream = seed.nth(7).stream();
            let mut alone = ParticleFilter::new(&system, proposal, settings(particles), stream).unwrap();
            for measurement in measurements.rows() {
                let (both, one) = (bank.step(measurement), alone.step(measurement));
                // Bounded noise may leave no particle: then all filters stop.
                if both.is_err() || one.is_err() {
                    break;
                }
                assert_eq!(bank.particles(7), alone.particles(), "{noise:?}, {particles}");
                assert_eq!(bank.weights(7), alone.weights(), "{noise:?}, {particles}");
            }
        }
    }
}

#[test]
fn a_run_ends_at_the_first_error() {
    // Noise so narrow that a jump of the measurements leaves no particle.
    let (system, measurements) = problem(Noise::Uniform);
    let mut values = measurements.values().to_vec();
    values[2 * 8..].fill(1e3);
    let jumping = Measurements::new(8, values).unwrap();
    let mut bank = FilterBank::new(&system, Bootstrap, settings(500), 1, &Seed::from_u64(83)).unwrap();
    let mut seen = vec![];
    let error = bank.run(&jumping, |bank| seen.push(bank.time())).unwrap_err();
    assert!(matches!(error, FilterError::Collapse { .. }), "{error}");
    assert_eq!(bank.run(&jumping, |_| panic!("it has failed")).unwrap_err(), error);
    assert!(seen.len() <= 2 && seen.iter().enumerate().all(|(step, time)| step + 1 == *time));
}

#[test]
fn a_clone_goes_its_own_way() {
    let (system, measurements) = problem(Noise::Gaussian);
    let stream = Seed::from_u64(84).stream();
    let mut filter = ParticleFilter::new(&system, Bootstrap, settings(3000), stream).unwrap();
    filter.step(measurements.row(0)).unwrap();
    let before = (filter.mean().to_vec(), filter.log_evidence());
    let mut forecast = filter.clone();
    let nothing = vec![None; measurements.row(0).len()];
    (1..4).for_each(|at| forecast.step_at(&Step::of_index(at), &nothing).unwrap());
    assert_eq!((filter.mean().to_vec(), filter.log_evidence(), filter.time()), (before.0, before.1, 1));
    // From where it was cloned, it draws what the original draws.
    let mut same = filter.clone();
    filter.step(measurements.row(1)).unwrap();
    same.step(measurements.row(1)).unwrap();
    assert_eq!(filter.particles(), same.particles());
    assert_eq!((forecast.time(), filter.time()), (4, 2));
}
