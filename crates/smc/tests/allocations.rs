//! A step of a designed filter allocates nothing after the first. It runs without the test harness, whose own thread allocates meanwhile.

use motes_models::batch::reserve_scratch;
use motes_models::{GraphDiffusion, GraphDiffusionConfig, Noise, Seed, simulate};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, MinDegeneracy, Proposal, ResampleWhen, Resampling};
use rayon_core::{ThreadPool, ThreadPoolBuilder};

#[global_allocator]
static COUNTING: dhat::Alloc = dhat::Alloc;

const STEPS: usize = 40;

/// Allocations, on any thread, in all steps but the first.
fn allocations<P: Proposal<GraphDiffusion> + Send>(
    proposal: fn(&GraphDiffusion) -> P,
    settings: FilterSettings,
    noise: Noise,
    filters: usize,
    pool: &ThreadPool,
) -> u64 {
    let seed = Seed::from_u64(60);
    let config = GraphDiffusionConfig { noise, ..GraphDiffusionConfig::new(4) };
    let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
    let data = simulate(&system, STEPS, &mut seed.child("data").stream()).unwrap();
    let mut bank = FilterBank::new(&system, proposal(&system), settings, filters, &seed).unwrap();
    pool.install(|| {
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
    })
}

fn min_degeneracy(system: &GraphDiffusion) -> MinDegeneracy {
    MinDegeneracy::new(system).unwrap()
}

fn settings(particles: usize, resampling: Resampling, defensive_weight: Option<f64>) -> FilterSettings {
    let resample_when = ResampleWhen::Always;
    FilterSettings { resampling, resample_when, defensive_weight, ..FilterSettings::new(particles) }
}

fn main() {
    // Pools that live to the end: one that ends allocates while it does.
    let [one, two] = [1, 2].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    // Their threads have started, and each has the scratch that it would allocate when it first helps.
    for pool in [&one, &two] {
        pool.broadcast(|_| reserve_scratch(5, 3 * 9000 + 1024 * 4));
    }
    let _counting = dhat::Profiler::builder().testing().build();
    let schemes =
        [Resampling::Multinomial, Resampling::Systematic, Resampling::Stratified, Resampling::Residual];
    for (filters, particles) in [(7, 10), (1, 9000)] {
        for scheme in schemes {
            let plain = settings(particles, scheme, None);
            let found = allocations(|_| Bootstrap, plain, Noise::Gaussian, filters, &one);
            assert_eq!(found, 0, "bootstrap, {scheme:?}, {filters} × {particles}");
            let found = allocations(min_degeneracy, plain, Noise::Gaussian, filters, &one);
            assert_eq!(found, 0, "minimum degeneracy, {scheme:?}, {filters} × {particles}");
        }
        let mixed = settings(particles, Resampling::Systematic, Some(0.1));
        let found = allocations(min_degeneracy, mixed, Noise::Gaussian, filters, &one);
        assert_eq!(found, 0, "defensive mixture, {filters} × {particles}");
    }
    // A noise for which the proposal is no more than a guess, and weights need every density.
    let large = settings(9000, Resampling::Multinomial, None);
    let found = allocations(min_degeneracy, large, Noise::Exponential, 1, &one);
    assert_eq!(found, 0, "minimum degeneracy, exponential noise");
    // Handing work to other threads goes through a queue that grows by a piece every few dozen times.
    let found = allocations(|_| Bootstrap, large, Noise::Gaussian, 1, &two);
    assert!(found <= 4, "{found} allocations in {STEPS} steps on two threads");
    println!("test steps_allocate_nothing ... ok");
}
