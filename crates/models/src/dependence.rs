//! The graph of what depends on what in a model, found by trying.

use faer::Mat;

use crate::batch::LANES;
use crate::equations::{Lanes, Linearise};
use crate::{Seed, Simulator, SystemGraph, simulate};

/// When states are varied: after noise has come in twice.
const TIME: usize = 2;

/// How far a coordinate is varied, as a share of its size, and at least.
const STEP: f64 = 0.1;

impl SystemGraph {
    /// The graph of a model's coordinates.
    ///
    /// Two are joined if the mean or the variance of one in `x_t` changes with the other in `x_{t−1}`. `S = D^{−½} A D^{−½}` with the adjacency `A`, without self-loops, and the
    /// degrees `D`. A coordinate of the measurement belongs, in equal shares, to those that its location changes with; to all of them if there are none.
    ///
    /// Both are looked for at 32 simulated states, so that a dependence which is rare may be missed. That costs a proposal along this graph some of its worth, never
    /// its weights' being right.
    pub fn of_dependences<M: Linearise + Simulator + ?Sized>(model: &M, seed: &Seed) -> Self {
        let (n, m) = (model.state_dim(), model.measurement_dim());
        let (previous, states, measured) = simulated(model, seed);
        let moments = |previous: &[f64]| {
            let (mut means, mut variances) = (vec![0.0; n * LANES], vec![0.0; n * LANES]);
            model.tile_moments(&model.step_of_index(TIME), Some(previous), &mut means, &mut variances);
            [means, variances]
        };
        let usual = moments(&previous);
        let mut adjacency = Mat::zeros(n, n);
        for j in 0..n {
            let mut varied = previous.clone();
            for value in &mut varied[j * LANES..(j + 1) * LANES] {
                *value += STEP * (1.0 + value.abs());
            }
            let varied = moments(&varied);
            for i in (0..n).filter(|i| *i != j) {
                let row = i * LANES..(i + 1) * LANES;
                if usual.iter().zip(&varied).any(|(usual, varied)| usual[row.clone()] != varied[row.clone()])
                {
                    adjacency[(i, j)] = 1.0;
                    adjacency[(j, i)] = 1.0;
                }
            }
        }
        let (mut slopes, mut information) = (vec![0.0; m * LANES], vec![0.0; m * LANES]);
        let mut jacobian = vec![0.0; m * n * LANES];
        model.tile_scores(
            &model.step_of_index(TIME),
            &states,
            &measured,
            &mut slopes,
            &mut information,
            &mut jacobian,
        );
        let mut adapter = Mat::zeros(n, m);
        for k in 0..m {
            let rows = jacobian[k * n * LANES..(k + 1) * n * LANES].chunks_exact(LANES);
            let heard: Vec<bool> = rows.map(|row| row.iter().any(|slope| *slope != 0.0)).collect();
            let count = heard.iter().filter(|heard| **heard).count();
            for (i, heard) in heard.into_iter().enumerate() {
                adapter[(i, k)] = match count {
                    0 => 1.0 / n as f64,
                    _ if heard => 1.0 / count as f64,
                    _ => 0.0,
                };
            }
        }
        SystemGraph { shift: normalised(&adjacency), adapter }
    }
}

/// `D^{−½} A D^{−½}`.
fn normalised(adjacency: &Mat<f64>) -> Mat<f64> {
    let n = adjacency.nrows();
    let degree = |i: usize| (0..n).map(|j| adjacency[(i, j)]).sum::<f64>();
    let degrees: Vec<f64> = (0..n).map(degree).collect();
    Mat::from_fn(n, n, |i, j| match adjacency[(i, j)] {
        0.0 => 0.0,
        entry => entry / (degrees[i] * degrees[j]).sqrt(),
    })
}

/// States at [`TIME`] − 1 and at [`TIME`], tiles of `N` rows, and measurements at [`TIME`]; zeros where a simulation overflowed.
fn simulated<M: Simulator + ?Sized>(model: &M, seed: &Seed) -> (Vec<f64>, Vec<f64>, Vec<Option<Lanes>>) {
    let (n, m) = (model.state_dim(), model.measurement_dim());
    let mut tiles = [vec![0.0; n * LANES], vec![0.0; n * LANES]];
    let mut measured = vec![Lanes::from(0.0); m];
    for lane in 0..LANES {
        let Ok(trajectory) = simulate(model, TIME + 1, &mut seed.nth(lane as u64).stream()) else { continue };
        let (states, measurements) = (trajectory.states.values(), trajectory.measurements.values());
        for (tile, time) in tiles.iter_mut().zip([TIME - 1, TIME]) {
            for (i, state) in states[time * n..(time + 1) * n].iter().enumerate() {
                tile[i * LANES + lane] = *state;
            }
        }
        for (lanes, entry) in measured.iter_mut().zip(&measurements[TIME * m..]) {
            lanes.0[lane] = *entry;
        }
    }
    let [previous, states] = tiles;
    (previous, states, measured.into_iter().map(Some).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Step;
    use crate::equations::{Coordinates, Draws, Equations, Scalar, normal};

    /// A chain whose coordinates hear from the one before; the second entry of the measurement sees the first two.
    struct Chain;

    impl Equations for Chain {
        fn dimensions(&self) -> [usize; 2] {
            [3, 2]
        }

        fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, x: &mut [S]) {
            for x in x {
                *x = draws.draw(normal(S::from(0.0), S::from(1.0)));
            }
        }

        fn transition<S: Scalar>(
            &self,
            _: &Step<'_, S>,
            before: &[S],
            draws: &mut impl Draws<S>,
            x: &mut [S],
        ) {
            x[0] = draws.draw(normal(before[0].sin(), S::from(1.0)));
            x[1] = draws.draw(normal(before[1] * 0.5, before[0].exp()));
            x[2] = draws.draw(normal(before[1] * before[2], S::from(1.0)));
        }

        fn measurement<S: Scalar>(&self, _: &Step<'_, S>, x: &[S], y: &mut impl Coordinates<S>) {
            y.push(normal(x[2], S::from(1.0)));
            y.push(normal(x[0] * x[1], S::from(1.0)));
        }
    }

    #[test]
    fn the_graph_joins_what_depends_on_each_other() {
        let graph = SystemGraph::of_dependences(&Chain, &Seed::from_u64(1));
        let half = 0.5_f64.sqrt();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
        for (i, row) in [[0.0, half, 0.0], [half, 0.0, half], [0.0, half, 0.0]].iter().enumerate() {
            for (j, expected) in row.iter().enumerate() {
                assert!(near(graph.shift[(i, j)], *expected), "({i}, {j}): {}", graph.shift[(i, j)]);
            }
        }
        for (i, row) in [[0.0, 0.5], [0.0, 0.5], [1.0, 0.0]].iter().enumerate() {
            for (k, expected) in row.iter().enumerate() {
                assert!(near(graph.adapter[(i, k)], *expected), "({i}, {k}): {}", graph.adapter[(i, k)]);
            }
        }
    }
}
