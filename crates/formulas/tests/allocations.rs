//! A model of formulas allocates nothing after its first call. It runs without the test harness, whose own thread allocates meanwhile.

use motes_formulas::{FileModel, parse};
use motes_models::batch::Rows;
use motes_models::{Seed, StateGradients, StateSpaceModel, Step};

#[global_allocator]
static COUNTING: dhat::Alloc = dhat::Alloc;

const FILE: &str = r#"
[parameters]
c = 0.3
[initial]
x[6] = "normal(0, 1)"
[definitions]
d[6] = "sin(x[i+1] - c*t) + exp(-x[i]^2)*x[i+2]/(1 + x[i-1]^2)"
[transition]
x[6] = "d[i] + d[i+1] + 0.5*student_t(5, 0, 1)"
[measurement]
y[6] = "poisson(exp(d[i]))"
"#;

const MEASUREMENT: [f64; 6] = [1.0, 0.0, 2.0, 1.0, 3.0, 0.0];

/// Catches registers that are made anew for each call, tile or particle.
fn main() {
    let FileModel::Formulas(model) = parse(FILE, "m.toml", &[]).unwrap().model else {
        panic!("it has formulas")
    };
    let mut streams = [Seed::from_u64(1).stream()];
    let particles = 300;
    let (mut before, mut states) = (vec![0.0; 6 * particles], vec![0.0; 6 * particles]);
    let (mut slopes, mut weights) = (vec![0.0; 6 * particles], vec![0.0; particles]);
    let mut step = |time| {
        model.sample_states(&Step::of_index(0), None, &mut streams, &mut before);
        model.sample_states(&Step::of_index(time), Some(Rows::all(&before, 6)), &mut streams, &mut states);
        model.density().unwrap().log_densities(
            &Step::of_index(time),
            Some(Rows::all(&before, 6)),
            &states,
            &mut weights,
        );
        model.log_likelihoods(&Step::of_index(time), &states, &MEASUREMENT.map(Some), &mut weights).unwrap();
        model.likelihood_gradients(&Step::of_index(time), &states, &MEASUREMENT, &mut slopes);
    };
    step(1);
    let _counting = dhat::Profiler::builder().testing().build();
    let start = dhat::HeapStats::get().total_blocks;
    (2..20).for_each(&mut step);
    assert_eq!(dhat::HeapStats::get().total_blocks - start, 0);
    println!("test calls_allocate_nothing ... ok");
}
