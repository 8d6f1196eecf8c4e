//! A filter with an amortised proposal allocates nothing once its buffers have their sizes. It runs without the test harness, whose own thread allocates meanwhile.

use motes_models::batch::reserve_scratch;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{ModelShape, Seed, Step, simulate};
use motes_proposals::{Amortised, AmortisedConfig, Backend, Base, Covariance, Family, HeadConfig, Sees};
use motes_smc::{FilterBank, FilterSettings, ResampleWhen, Resampling};
use rayon_core::{ThreadPool, ThreadPoolBuilder};

#[global_allocator]
static COUNTING: dhat::Alloc = dhat::Alloc;

const STEPS: usize = 30;
const FIRST: usize = 10;

/// Two coordinates, of which a bent sum is measured.
struct Bent;

impl Equations for Bent {
    fn dimensions(&self) -> [usize; 2] {
        [2, 1]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        (0..2).for_each(|i| state[i] = draws.draw(normal(0.0, 1.0)));
    }

    fn transition<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
        state[0] = draws.draw(normal(x[0] * 0.9 + x[1].sin(), 0.7));
        state[1] = draws.draw(normal(x[1] * 0.7, 1.1));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0] + x[1] * x[1] / 5.0, 0.5));
    }
}

/// Allocations, on any thread, in the last steps. Networks keep a buffer for each number of distinct particles; a few steps have seen them all.
fn allocations(head: HeadConfig, filters: usize, particles: usize, pool: &ThreadPool) -> u64 {
    let seed = Seed::from_u64(60);
    let data = simulate(&Bent, STEPS, &mut seed.child("data").stream()).unwrap();
    let config = AmortisedConfig {
        widths: vec![64, 64],
        sees: Sees::All,
        base: Base::Linearised,
        head,
        ..AmortisedConfig::gaussian()
    };
    let shape = ModelShape::of(&Bent);
    let proposal = Amortised::create(&config, &shape, 0, Backend::Native.into(), &seed).unwrap();
    let settings = FilterSettings {
        resampling: Resampling::Systematic,
        resample_when: ResampleWhen::Always,
        defensive_weight: Some(0.1),
        ..FilterSettings::new(particles)
    };
    let mut bank = FilterBank::new(&Bent, proposal, settings, filters, &seed).unwrap();
    pool.install(|| {
        let mut before = 0;
        for (time, measurement) in data.measurements.rows().enumerate() {
            if time == FIRST {
                before = dhat::HeapStats::get().total_blocks;
            }
            bank.step(measurement).unwrap();
        }
        dhat::HeapStats::get().total_blocks - before
    })
}

fn main() {
    // A pool that lives to the end, whose thread has the scratch that it would allocate when it first helps.
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.broadcast(|_| reserve_scratch(8, 3 * 9000 + 1024 * 4));
    let _counting = dhat::Profiler::builder().testing().build();
    let covariance = Covariance::Full;
    for head in [
        HeadConfig::Gaussian { covariance },
        HeadConfig::Kernel,
        HeadConfig::Mixture { components: 3, covariance },
        HeadConfig::Flow { pieces: 8, covariance },
    ] {
        for (filters, particles) in [(7, 10), (1, 9000)] {
            assert_eq!(allocations(head, filters, particles, &pool), 0, "{head:?}, {filters} × {particles}");
        }
    }
    println!("test steps_with_an_amortised_proposal_allocate_nothing ... ok");
}
