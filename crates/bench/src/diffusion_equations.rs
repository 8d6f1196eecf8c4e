//! A graph diffusion with Gaussian noise by its equations, from which potentials of all later measurements follow.

use faer::MatRef;
use motes_models::equations::{Coordinates, Draws, Equations, Scalar, normal};
use motes_models::{AdditiveGaussian, Drift, GraphDiffusion, Step};

/// A matrix by rows, without its zeros.
struct SparseMatrix(Vec<Vec<(usize, f64)>>);

/// `x_t = φ(A x_{t−1}) + v_t`, `y_t = C x_t + w_t` with independent Gaussian noises: the same densities as those of a [`GraphDiffusion`] with Gaussian noise.
pub(crate) struct DiffusionEquations {
    drift: Drift,
    transition: SparseMatrix,
    measurement: SparseMatrix,
    /// Mean and standard deviation of each coordinate of `x_0`.
    initial: Vec<[f64; 2]>,
    state_sd: f64,
    measurement_sd: f64,
}

impl SparseMatrix {
    fn of(matrix: MatRef<'_, f64>) -> Self {
        let row = |i: usize| {
            (0..matrix.ncols()).map(|j| (j, matrix[(i, j)])).filter(|(_, entry)| *entry != 0.0).collect()
        };
        SparseMatrix((0..matrix.nrows()).map(row).collect())
    }

    /// Each row times a vector.
    fn times<'a, S: Scalar>(&'a self, vector: &'a [S]) -> impl Iterator<Item = S> + 'a {
        let of_row = |row: &'a Vec<(usize, f64)>| {
            row.iter().fold(S::from(0.0), |sum, (at, entry)| sum + vector[*at] * S::from(*entry))
        };
        self.0.iter().map(of_row)
    }
}

impl DiffusionEquations {
    /// Those of a system, whose noises are taken to be Gaussian.
    pub(crate) fn of(system: &GraphDiffusion, drift: Drift) -> Self {
        let initial = system.initial();
        let of_coordinate = |at: usize| [initial.mean()[at], initial.covariance()[(at, at)].sqrt()];
        DiffusionEquations {
            drift,
            transition: SparseMatrix::of(system.adjacency()),
            measurement: SparseMatrix::of(system.measurement_matrix()),
            initial: (0..initial.mean().len()).map(of_coordinate).collect(),
            state_sd: system.transition_covariance()[(0, 0)].sqrt(),
            measurement_sd: system.measurement_covariance()[(0, 0)].sqrt(),
        }
    }
}

impl Equations for DiffusionEquations {
    fn dimensions(&self) -> [usize; 2] {
        [self.initial.len(), self.measurement.0.len()]
    }

    fn initial<S: Scalar>(&self, _: &Step<'_, S>, draws: &mut impl Draws<S>, state: &mut [S]) {
        for (x, [mean, sd]) in state.iter_mut().zip(&self.initial) {
            *x = draws.draw(normal(*mean, *sd));
        }
    }

    fn transition<S: Scalar>(
        &self,
        _: &Step<'_, S>,
        previous: &[S],
        draws: &mut impl Draws<S>,
        state: &mut [S],
    ) {
        for (x, sum) in state.iter_mut().zip(self.transition.times(previous)) {
            let mean = match self.drift {
                Drift::Identity => sum,
                Drift::Abs => sum.abs(),
            };
            *x = draws.draw(normal(mean, self.state_sd));
        }
    }

    fn measurement<S: Scalar>(&self, _: &Step<'_, S>, state: &[S], measurement: &mut impl Coordinates<S>) {
        for mean in self.measurement.times(state) {
            measurement.push(normal(mean, self.measurement_sd));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motes_models::batch::Rows;
    use motes_models::{GraphDiffusionConfig, Noise, Seed, StateSpaceModel, simulate};

    #[test]
    fn densities_are_those_of_the_system() {
        for drift in [Drift::Identity, Drift::Abs] {
            let config =
                GraphDiffusionConfig { drift, noise: Noise::Gaussian, ..GraphDiffusionConfig::new(6) };
            let seed = Seed::from_u64(3);
            let system = GraphDiffusion::random(&config, &mut seed.child("graph").stream()).unwrap();
            let equations = DiffusionEquations::of(&system, drift);
            let data = simulate(&system, 4, &mut seed.child("data").stream()).unwrap();
            for time in 0..4 {
                let previous = (time > 0).then(|| Rows::all(data.states.row(time - 1), 6));
                let (step, state) = (Step::of_index(time), data.states.row(time));
                let measurement: Vec<Option<f64>> =
                    data.measurements.row(time).iter().copied().map(Some).collect();
                let densities = |model: &dyn StateSpaceModel| {
                    let (mut transition, mut likelihood) = ([0.0], [0.0]);
                    model.density().unwrap().log_densities(&step, previous, state, &mut transition);
                    model.log_likelihoods(&step, state, &measurement, &mut likelihood).unwrap();
                    [transition[0], likelihood[0]]
                };
                for (own, other) in densities(&equations).into_iter().zip(densities(&system)) {
                    assert!((own - other).abs() < 1e-10, "{drift:?} at {time}: {own} for {other}");
                }
            }
        }
    }
}
