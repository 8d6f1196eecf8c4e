//! The same bytes on any number of threads, and for a filter in a bank and alone.

use motes_models::{Drift, GraphDiffusion, GraphDiffusionConfig, Measurements, Noise, Seed, simulate};
use motes_smc::{
    Bootstrap, FilterBank, FilterError, FilterSettings, MinDegeneracy, ParticleFilter, Proposal, ResampleWhen,
};

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

/// Everything that a bank shows after each step, stepped one by one or run.
fn run<P: Proposal<GraphDiffusion, Memory: Send> + Send>(
    proposal: P,
    noise: Noise,
    particles: usize,
    filters: usize,
    threads: usize,
    stepped: bool,
) -> Vec<(Vec<f64>, Vec<f64>, Vec<usize>)> {
    let (system, measurements) = problem(noise);
    let bank = FilterBank::new(&system, proposal, settings(particles), filters, &Seed::from_u64(81)).unwrap();
    let mut bank = bank.with_threads(threads).unwrap();
    let mut seen = vec![];
    let mut see = |bank: &FilterBank<&GraphDiffusion, P>| {
        let states = (0..filters).flat_map(|filter| bank.particles(filter).to_vec()).collect();
        let weights = (0..filters).flat_map(|filter| bank.weights(filter).log().to_vec()).collect();
        seen.push((states, weights, bank.ancestors().to_vec()));
    };
    if stepped {
        for measurement in measurements.rows() {
            bank.step(measurement).unwrap();
            see(&bank);
        }
    } else {
        bank.run(&measurements, see).unwrap();
    }
    assert_eq!(bank.time(), measurements.len());
    seen
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let (system, _) = problem(Noise::Gaussian);
    let proposal = MinDegeneracy::new(&system).unwrap();
    for (particles, filters) in [(20_000, 1), (9000, 3), (50, 300), (10, 100), (1, 5000), (300, 40)] {
        let one = run(Bootstrap, Noise::Gaussian, particles, filters, 1, true);
        for (threads, stepped) in [(2, true), (3, true), (1, false), (2, false), (3, false)] {
            let other = run(Bootstrap, Noise::Gaussian, particles, filters, threads, stepped);
            assert!(one == other, "bootstrap, {filters} × {particles}, {threads} threads");
        }
        let one = run(proposal.clone(), Noise::Gaussian, particles, filters, 1, true);
        let other = run(proposal.clone(), Noise::Gaussian, particles, filters, 2, false);
        assert!(one == other, "minimum degeneracy, {filters} × {particles}");
    }
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
    let bank = FilterBank::new(&system, Bootstrap, settings(500), 1, &Seed::from_u64(83)).unwrap();
    let mut bank = bank.with_threads(2).unwrap();
    let mut seen = vec![];
    let error = bank.run(&jumping, |bank| seen.push(bank.time())).unwrap_err();
    assert!(matches!(error, FilterError::Collapse { .. }), "{error}");
    assert_eq!(bank.run(&jumping, |_| panic!("it has failed")).unwrap_err(), error);
    assert!(seen.len() <= 2 && seen.iter().enumerate().all(|(step, time)| step + 1 == *time));
}

#[test]
fn banks_at_the_same_time_have_threads_of_their_own() {
    let (system, measurements) = problem(Noise::Gaussian);
    // Each waits in every step for the other, which would never come if one had to wait for the other's threads.
    let barrier = std::sync::Barrier::new(2);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                let seed = Seed::from_u64(84);
                let bank = FilterBank::new(&system, Bootstrap, settings(3000), 1, &seed).unwrap();
                bank.with_threads(2)
                    .unwrap()
                    .run(&measurements, |_| {
                        barrier.wait();
                    })
                    .unwrap();
            });
        }
    });
}

#[test]
fn no_threads_are_refused() {
    let (system, _) = problem(Noise::Gaussian);
    let bank = FilterBank::new(&system, Bootstrap, settings(10), 1, &Seed::from_u64(1)).unwrap();
    assert!(matches!(bank.with_threads(0), Err(FilterError::Setting { .. })));
}
