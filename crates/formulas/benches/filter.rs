//! Whole bootstrap filters of the growth model: from a file, stated in Rust, and by hand.
//!
//! `cargo bench -p motes-formulas --bench filter` prints millions of particles a second, on one thread, in turns. With `-- PYTHON`, an interpreter that has
//! `particles` 0.4, that library takes its turn, too, on the same measurements; log-evidences are printed beside, since equal work has to agree.

use std::process::Command;
use std::time::Instant;

use motes_formulas::{FileModel, parse};
use motes_models::batch::{Rows, draw_rows};
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{
    Measurements, ModelError, Seed, StateSpaceModel, Step, Stream, fill_standard_normal, simulate,
};
use motes_smc::{Bootstrap, FilterSettings, ParticleFilter, ResampleWhen, Resampling};
use rand::RngExt;
use rand_distr::StandardNormal;

const GROWTH: &str = include_str!("../../../examples/growth.toml");

/// A model stated once; `$inline` before each of its formulas.
macro_rules! stated {
    ($(#[$doc:meta])* $name:ident $(, #[$inline:meta])?) => {
        $(#[$doc])*
        struct $name;

        impl Equations for $name {
            fn dimensions(&self) -> [usize; 2] {
                [1, 1]
            }

            $(#[$inline])?
            fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
                state[0] = draws.draw(normal(0.0, 5.0_f64.sqrt()));
            }

            $(#[$inline])?
            fn transition<S: Scalar>(&self, step: &Step<'_, S>, x: &[S], draws: &mut impl Draws<S>, state: &mut [S]) {
                let x = x[0];
                let drift = x / 2.0 + x * 25.0 / (x * x + 1.0) + 8.0 * (1.2 * step.time).cos();
                state[0] = draws.draw(normal(drift, 10.0_f64.sqrt()));
            }

            $(#[$inline])?
            fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], measurement: &mut impl Coordinates<S>) {
                measurement.push(normal(x[0] * x[0] / 20.0, 1.0));
            }
        }
    };
}

stated!(
    /// Stated once.
    Stated
);
stated!(
    /// The same, put in line: compiled for the widest vectors.
    InLine,
    #[inline(always)]
);

/// The same by hand, in batches: loops over all states, noise in bulk.
struct ByHand;

fn drift(time: f64, x: f64) -> f64 {
    x / 2.0 + 25.0 * x / (1.0 + x * x) + 8.0 * (1.2 * time).cos()
}

impl StateSpaceModel for ByHand {
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
        let each = states.len() / streams.len();
        // The same for all particles.
        let (wave, sd) = (8.0 * (1.2 * step.time).cos(), 10.0_f64.sqrt());
        let mut row = 0;
        for (stream, states) in streams.iter_mut().zip(states.chunks_exact_mut(each)) {
            fill_standard_normal(stream, states);
            let Some(previous) = previous else {
                states.iter_mut().for_each(|x| *x *= 5.0_f64.sqrt());
                continue;
            };
            for state in states {
                let x = previous.row(row)[0];
                *state = x / 2.0 + 25.0 * x / (1.0 + x * x) + wave + sd * *state;
                row += 1;
            }
        }
    }

    fn log_likelihoods(
        &self,
        _: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        let (constant, y) = (0.5 * std::f64::consts::TAU.ln(), measurement[0].expect("no gaps"));
        for (x, out) in states.iter().zip(out) {
            let z = y - x * x / 20.0;
            *out = -0.5 * z * z - constant;
        }
        Ok(())
    }
}

/// The same by hand, state by state.
struct ByRows;

impl StateSpaceModel for ByRows {
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
        draw_rows(streams, 1, states, |row, stream, state| {
            let noise: f64 = stream.sample(StandardNormal);
            state[0] = match previous {
                None => 5.0_f64.sqrt() * noise,
                Some(previous) => drift(step.time, previous.row(row)[0]) + 10.0_f64.sqrt() * noise,
            };
        });
    }

    fn log_likelihoods(
        &self,
        _: &Step<'_>,
        states: &[f64],
        measurement: &[Option<f64>],
        out: &mut [f64],
    ) -> Result<(), ModelError> {
        let y = measurement[0].expect("no gaps");
        for (x, out) in states.iter().zip(out) {
            let z = y - x * x / 20.0;
            *out = -0.5 * (z * z + std::f64::consts::TAU.ln());
        }
        Ok(())
    }
}

/// Millions of particles a second, and the log-evidence.
fn run(model: &impl StateSpaceModel, data: &Measurements, particles: usize) -> [f64; 2] {
    let settings = FilterSettings {
        resampling: Resampling::Systematic,
        resample_when: ResampleWhen::EssBelow(0.5),
        ..FilterSettings::new(particles)
    };
    let mut filter =
        ParticleFilter::new(model, Bootstrap, settings, Seed::from_u64(3).stream()).expect("settings");
    let start = Instant::now();
    for row in data.rows() {
        filter.step(row).expect("a step");
    }
    let seconds = start.elapsed().as_secs_f64();
    [(particles * data.len()) as f64 / seconds / 1e6, filter.log_evidence()]
}

/// The same by `particles`: its script prints the two numbers.
fn by_peer(python: &str, data: &Measurements, particles: usize) -> Option<[f64; 2]> {
    const SCRIPT: &str = include_str!("growth_particles.py");
    let values: Vec<String> = data.values().iter().map(ToString::to_string).collect();
    let output = Command::new(python)
        .env("OMP_NUM_THREADS", "1")
        .args(["-c", SCRIPT, &particles.to_string(), &values.join(",")])
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let mut numbers = text.split_whitespace().map(str::parse);
    Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
}

fn main() {
    let python = std::env::args().skip(1).find(|argument| !argument.starts_with("--"));
    let FileModel::Formulas(formulas) = parse(GROWTH, "growth.toml", &[]).expect("a model").model else {
        unreachable!("the file has formulas")
    };
    let data = simulate(&Stated, 200, &mut Seed::from_u64(2).stream()).expect("data").measurements;
    let pool = rayon_core::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for particles in [1000, 100_000] {
        let mut speeds: [Vec<f64>; 6] = Default::default();
        let mut evidence = [f64::NAN; 6];
        for _ in 0..7 {
            let found = pool.install(|| {
                [
                    run(&formulas, &data, particles),
                    run(&Stated, &data, particles),
                    run(&InLine, &data, particles),
                    run(&ByRows, &data, particles),
                    run(&ByHand, &data, particles),
                ]
            });
            let peer = python.as_deref().and_then(|python| by_peer(python, &data, particles));
            for (way, [speed, log_evidence]) in found.into_iter().chain(peer).enumerate() {
                speeds[way].push(speed);
                evidence[way] = log_evidence;
            }
        }
        let ways = [
            "from a file",
            "stated in Rust",
            "stated in line",
            "by hand, rows",
            "by hand, batches",
            "particles",
        ];
        for (way, name) in ways.into_iter().enumerate() {
            let speeds = &mut speeds[way];
            speeds.sort_by(f64::total_cmp);
            if let Some(median) = speeds.get(speeds.len() / 2) {
                println!(
                    "K = {particles:<7} {name:<16} {median:8.2} million a second, log-evidence {:.2}",
                    evidence[way]
                );
            }
        }
    }
}
