//! A step of a designed filter allocates nothing after the first.

use motes_models::{GraphDiffusion, GraphDiffusionConfig, Noise, Seed, simulate};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, MinDegeneracy, Proposal, ResampleWhen, Resampling};

#[global_allocator]
static COUNTING: dhat::Alloc = dhat::Alloc;

const STEPS: usize = 40;

/// Allocations, on any thread, in all steps but the first.
fn allocations<P: Proposal<GraphDiffusion>>(
    proposal: fn(&GraphDiffusion) -> P,
    noise: Noise,
    resampling: Resampling,
    (filters, particles): (usize, usize),
    threads: usize,
) -> u64 {
    let seed = Seed::from_u64(60);
    let config = GraphDiffusionConfig { noise, ..GraphDiffusionConfig::new(4) };
    let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
    let data = simulate(&system, STEPS, &mut seed.child("data").stream()).unwrap();
    let settings =
        FilterSettings { resampling, resample_when: ResampleWhen::Always, ..FilterSettings::new(particles) };
    let bank = FilterBank::new(&system, proposal(&system), settings, filters, &seed).unwrap();
    let mut bank = bank.with_threads(threads).unwrap();
    let mut mean = [0.0; 4];
    let mut before = 0;
    for (time, measurement) in data.measurements.rows().enumerate() {
        if time == 1 {
            before = dhat::HeapStats::get().total_blocks;
        }
        bank.step(measurement).unwrap();
        bank.mean(0, &mut mean);
    }
    dhat::HeapStats::get().total_blocks - before
}

fn min_degeneracy(system: &GraphDiffusion) -> MinDegeneracy {
    MinDegeneracy::new(system).unwrap()
}

#[test]
fn steps_allocate_nothing() {
    let _counting = dhat::Profiler::builder().testing().build();
    let schemes =
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual];
    for size in [(7, 10), (1, 9000)] {
        for scheme in schemes {
            let found = allocations(|_| Bootstrap, Noise::Gaussian, scheme, size, 1);
            assert_eq!(found, 0, "bootstrap, {scheme:?}, {size:?}");
            let found = allocations(min_degeneracy, Noise::Gaussian, scheme, size, 1);
            assert_eq!(found, 0, "minimum degeneracy, {scheme:?}, {size:?}");
        }
    }
    // A noise for which the proposal is no more than a guess, and weights need every density.
    let found = allocations(min_degeneracy, Noise::Exponential, Resampling::Multinomial, (1, 9000), 1);
    assert_eq!(found, 0, "minimum degeneracy, exponential noise");
    // Handing work to other threads goes through a queue that grows by a piece every few dozen times.
    let found = allocations(|_| Bootstrap, Noise::Gaussian, Resampling::Multinomial, (1, 9000), 2);
    assert!(found <= 4, "{found} allocations in {STEPS} steps on two threads");
}
