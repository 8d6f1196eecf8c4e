//! The matrices behind formulas that are linear with Gaussian noise: such a model has exact answers.

use faer::Mat;
use motes_models::equations::{Coordinates, Distribution, Draws, Equations, Normal, Wrapped};
use motes_models::{Gaussian, LinearGaussian, Step};

use crate::model::FormulaModel;

/// Means and variances of normal coordinates; none once another one came.
struct Normals(Option<[Vec<f64>; 2]>);

impl Draws<f64> for Normals {
    fn draw(&mut self, distribution: Distribution<f64>) -> f64 {
        self.push(distribution);
        f64::NAN
    }
}

impl Coordinates<f64> for Normals {
    fn push(&mut self, distribution: Distribution<f64>) {
        self.0 = match (self.0.take(), distribution) {
            (Some([mut means, mut variances]), Distribution::Normal(Normal { mean, sd })) => {
                means.push(mean);
                variances.push(sd * sd);
                Some([means, variances])
            }
            _ => None,
        };
    }

    fn push_wrapped(&mut self, _: &Wrapped<'_, f64>) {
        self.0 = None;
    }
}

/// Means and variances of what is stated.
fn normals(state: impl FnOnce(&mut Normals)) -> Option<[Vec<f64>; 2]> {
    let mut found = Normals(Some([Vec::new(), Vec::new()]));
    state(&mut found);
    found.0
}

fn diagonal(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), values.len(), |i, j| if i == j { values[i] } else { 0.0 })
}

impl FormulaModel {
    /// The linear Gaussian model that this is: all coordinates are normal, with means that are linear in the states and 0 where these are, standard deviations without
    /// states, and nothing that depends on the time. `None` of any other.
    pub fn linear_gaussian(&self) -> Option<LinearGaussian> {
        if !self.is_linear() {
            return None;
        }
        let equations = self.equations();
        let [n, _] = equations.dimensions();
        let unused = || vec![0.0; n];
        let [mean, variances] = normals(|sink| equations.initial(&Step::of_index(0), sink, &mut unused()))?;
        let initial = Gaussian::new("p(x_0)", mean, diagonal(&variances)).ok()?;
        let transition =
            |x: &[f64]| normals(|sink| equations.transition(&Step::of_index(1), x, sink, &mut unused()));
        let measurement = |x: &[f64]| normals(|sink| equations.measurement(&Step::of_index(0), x, sink));
        let (matrix, noise) = matrix_of(n, transition)?;
        let (seen, error) = matrix_of(n, measurement)?;
        LinearGaussian::new(initial, matrix, diagonal(&noise), seen, diagonal(&error)).ok()
    }
}

/// The matrix of a linear map, and the variances of its noise; none if it does not map 0 to 0.
fn matrix_of(n: usize, of: impl Fn(&[f64]) -> Option<[Vec<f64>; 2]>) -> Option<(Mat<f64>, Vec<f64>)> {
    let mut x = vec![0.0; n];
    let [at_zero, variances] = of(&x)?;
    if at_zero.iter().any(|mean| *mean != 0.0) {
        return None;
    }
    let mut matrix = Mat::zeros(at_zero.len(), n);
    for j in 0..n {
        x[j] = 1.0;
        let [column, _] = of(&x)?;
        x[j] = 0.0;
        column.iter().enumerate().for_each(|(i, entry)| matrix[(i, j)] = *entry);
    }
    Some((matrix, variances))
}

#[cfg(test)]
mod tests {
    use motes_models::{Seed, StateSpaceModel, Step, simulate};

    use crate::{FileModel, parse};

    fn linear(transition: &str, measurement: &str) -> Option<f64> {
        let text = format!(
            "[initial]\na = \"normal(1, 2)\"\nb = \"normal(0, 1)\"\n[transition]\na = \"{transition}\"\nb = \"normal(b, 1)\"\n[measurement]\ny = \"{measurement}\"\n"
        );
        let FileModel::Formulas(formulas) = parse(&text, "text", &[]).unwrap().model else {
            panic!("no matrices")
        };
        let exact = formulas.linear_gaussian()?;
        let drawn = simulate(&formulas, 5, &mut Seed::from_u64(1).stream()).unwrap();
        let (states, y) = (drawn.states.values(), drawn.measurements.values());
        let densities = |model: &dyn StateSpaceModel| {
            let density = model.density().unwrap();
            density.log_density(&Step::of_index(0), None, &states[..2])
                + density.log_density(&Step::of_index(3), Some(&states[2..4]), &states[4..6])
                + model.log_likelihood(&Step::of_index(2), &states[4..6], &y[2..3]).unwrap()
        };
        Some((densities(&exact) - densities(&formulas)).abs())
    }

    #[test]
    fn a_linear_model_has_the_densities_of_its_formulas() {
        let difference = linear("0.5*a - b/3 + normal(0, 0.7)", "normal(2*a + b, sqrt(3))");
        assert!(difference.is_some_and(|difference| difference < 1e-12), "{difference:?}");
    }

    #[test]
    fn what_is_not_linear_has_none() {
        let right = "normal(2*a + b, 1)";
        for transition in [
            "normal(sin(a), 1)",
            "normal(a*b, 1)",
            "normal(a, exp(b))",
            "normal(a + 1, 1)",
            "normal(a*cos(t), 1)",
            "laplace(a, 1)",
        ] {
            assert_eq!(linear(transition, right), None, "{transition}");
        }
        assert_eq!(linear("normal(a, 1)", "student_t(4, a, 1)"), None);
        assert!(linear("normal(a, 1)", right).is_some());
    }
}
