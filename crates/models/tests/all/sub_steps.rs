//! Derivatives of steps with sub-steps.

use motes_models::Step;
use motes_models::batch::LANES;
use motes_models::equations::{Coordinates, Draws, Equations, NoiseSpace, Scalar, log_normal, normal};

/// Three states by two draws in each sub-step, and a third in the first.
struct Chain;

impl Equations for Chain {
    fn dimensions(&self) -> [usize; 2] {
        [3, 1]
    }

    fn inputs(&self) -> &[f64] {
        &[f64::NAN]
    }

    fn has_density(&self) -> bool {
        false
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
        x.fill_with(|| draws.draw(normal(0.0, 1.0)));
    }

    fn transition<S: Scalar>(
        &self,
        step: &Step<'_, S>,
        before: &[S],
        draws: &mut impl Draws<S>,
        x: &mut [S],
    ) {
        let push = if step.sub_step == 0 { draws.draw(normal(before[2], 0.5)) } else { S::from(0.0) };
        let growth = draws.draw(log_normal(before[0] * step.inputs[0], 0.3));
        x[0] = before[0] * 0.9 + before[1].sin() * step.length + push;
        x[1] = growth + before[2] * before[0];
        x[2] = draws.draw(normal(before[1].tanh(), (before[0] * before[0] + 0.1).sqrt()));
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
        y.push(normal(x[0], 1.0));
    }
}

/// Catches derivatives that are multiplied in the wrong order, and draws of one sub-step taken for those of another.
#[test]
fn derivatives_of_sub_steps_are_those_of_differences() {
    const SIZE: f64 = 1e-6;
    let inputs: Vec<f64> = (0..11).map(|part| 0.3 * f64::from(part).cos()).collect();
    // Few are linearised at once, many one by one.
    for sub_steps in [1, 2, 3, 6, 10] {
        let step = Step { length: 2.0, sub_steps, inputs: &inputs[..sub_steps + 1], ..Step::of_index(5) };
        let (n, q) = (3, 2 * sub_steps + 1);
        assert_eq!(Chain.draws(&step).len(), q);
        let tile = |count: usize, phase: f64| -> Vec<f64> {
            (0..count * LANES).map(|at| (at as f64 * 0.7 + phase).sin()).collect()
        };
        let (previous, noise) = (tile(n, 0.3), tile(q, 1.1));
        let states = |previous: &[f64], noise: &[f64]| {
            let mut states = vec![0.0; n * LANES];
            Chain.tile_states(&step, Some(previous), noise, &mut states);
            states
        };
        let middle = states(&previous, &noise);
        for directions in [q, q + n] {
            // Fewer particles than a tile, but more than stand side by side.
            let particles = 21;
            let (mut found, mut jacobian) = (vec![0.0; n * LANES], vec![0.0; n * directions * LANES]);
            Chain.tile_linearised(&step, Some(&previous), &noise, particles, &mut found, &mut jacobian);
            for direction in 0..directions {
                let moved = |size: f64| {
                    let (mut previous, mut noise) = (previous.clone(), noise.clone());
                    let (rows, row) =
                        if direction < q { (&mut noise, direction) } else { (&mut previous, direction - q) };
                    rows[row * LANES..(row + 1) * LANES].iter_mut().for_each(|value| *value += size);
                    states(&previous, &noise)
                };
                let [above, below] = [SIZE, -SIZE].map(moved);
                for (i, lane) in (0..n).flat_map(|i| (0..particles).map(move |lane| (i, lane))) {
                    let at = i * LANES + lane;
                    assert!((found[at] - middle[at]).abs() < 1e-12 * (1.0 + middle[at].abs()));
                    let expected = (above[at] - below[at]) / (2.0 * SIZE);
                    let derivative = jacobian[(i * directions + direction) * LANES + lane];
                    let off = (derivative - expected).abs();
                    assert!(
                        off < 1e-6 * (1.0 + expected.abs()),
                        "{sub_steps} {direction} {i}: {derivative} {expected}"
                    );
                }
            }
        }
        // A number that no draw takes, or that is missing.
        for q in [q - 1, q + 1] {
            let mut found = vec![0.0; n * LANES];
            let mut jacobian = vec![0.0; n * (q + n) * LANES];
            Chain.tile_linearised(&step, Some(&previous), &tile(q, 0.0), 8, &mut found, &mut jacobian);
            assert!((0..8).all(|lane| (0..n).any(|i| found[i * LANES + lane].is_nan())), "{sub_steps} {q}");
        }
    }
}
