//! The parameters that are fitted.

use motes_formulas::Prior;
use motes_models::equations::normal_quantile;

use crate::error::MotesError;
use crate::model::Model;
use crate::priors::free;

/// The parameters of a model that have a prior and were given no value: those that a fit finds.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeParameters {
    priors: Vec<Prior>,
}

impl FreeParameters {
    /// Those of a model.
    ///
    /// # Errors
    /// [`MotesError::Setting`] if it has none.
    pub fn of(model: &Model) -> Result<Self, MotesError> {
        let priors: Vec<Prior> = free(model).cloned().collect();
        if !priors.is_empty() {
            return Ok(FreeParameters { priors });
        }
        let reason = match (model.priors().is_empty(), model.parameters().first()) {
            (false, _) => {
                "every parameter that has a prior was given a value by --set; leave one of them free"
                    .to_string()
            }
            (true, Some((name, value))) => format!(
                "no parameter of {} has a prior, so there is nothing to fit; write what is known of one before the data instead of its value, as in \
                 {name} = \"log_normal(log({value}), 1)\"",
                model.name()
            ),
            (true, None) => format!(
                "{} has no parameters, so there is nothing to fit; name the unknown numbers in [parameters], as in q = \"half_normal(1)\"",
                model.name()
            ),
        };
        Err(MotesError::Setting(reason))
    }

    /// The priors, in the order of the file.
    pub fn priors(&self) -> &[Prior] {
        &self.priors
    }

    /// The names of the parameters, those of entries of lists one by one: `D` of them.
    pub fn names(&self) -> Vec<String> {
        self.priors.iter().flat_map(|prior| prior.entries().iter().cloned()).collect()
    }

    /// `D`.
    pub fn len(&self) -> usize {
        self.priors.iter().map(|prior| prior.entries().len()).sum()
    }

    /// How many numbers are free: the shares of a dirichlet sum to 1.
    pub fn dimension(&self) -> usize {
        let of_prior = |prior: &Prior| match prior.entries().len() {
            1 => 1,
            several => several - 1,
        };
        self.priors.iter().map(of_prior).sum()
    }

    /// Whether there are none, which is never so.
    pub fn is_empty(&self) -> bool {
        self.priors.is_empty()
    }

    /// The values (`D`) at a position `v` (`D`) of standard normal numbers: each a quantile of its prior.
    pub fn at(&self, v: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; v.len()];
        self.write(v, &mut values);
        values
    }

    /// Writes the values (`K×D`) at some positions (`K×D`).
    pub(super) fn write(&self, positions: &[f64], values: &mut [f64]) {
        let d = self.len();
        for (mut v, mut out) in positions.chunks_exact(d).zip(values.chunks_exact_mut(d)) {
            for prior in &self.priors {
                let count = prior.entries().len();
                prior.write(&v[..count], &mut out[..count]);
                (v, out) = (&v[count..], &mut out[count..]);
            }
        }
    }

    /// `count` quantiles of the prior of each parameter, in the middles of intervals of equal probability; none of a share of a dirichlet, which has no number of its own.
    pub fn quantiles(&self, count: usize) -> Vec<Vec<f64>> {
        let at = |place: usize| normal_quantile((place as f64 + 0.5) / count as f64);
        let of_prior = |prior: &Prior| match prior.entries().len() {
            1 => vec![(0..count).flat_map(|place| prior.at(&[at(place)])).collect()],
            several => vec![Vec::new(); several],
        };
        self.priors.iter().flat_map(of_prior).collect()
    }
}
