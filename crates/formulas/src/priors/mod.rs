//! Parameters that have a distribution: what is known of them before there are data.

mod law;
mod read;

use motes_models::equations::Distribution;
use motes_models::{Stream, fill_standard_normal};

pub(crate) use law::Law;
pub(crate) use read::{Names, law_of};

/// The distribution of a parameter, or of all entries of a list, before there are data.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    pub(crate) name: String,
    pub(crate) entries: Vec<String>,
    pub(crate) text: String,
    pub(crate) start: Vec<f64>,
    pub(crate) origin: Origin,
    pub(crate) law: Law,
}

/// Where the value of a parameter that has a prior comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// It is the median of the prior.
    Median,
    /// It is the mean of the prior.
    Mean,
    /// The file gives it beside the prior.
    Given,
    /// It was set from outside.
    Set,
}

impl Prior {
    /// The name of the parameter, or of the list.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of the parameters: its own, or those of a list's entries, as `share[0]`.
    pub fn entries(&self) -> &[String] {
        &self.entries
    }

    /// Whether it gives whole numbers alone.
    pub fn is_discrete(&self) -> bool {
        self.law.is_discrete()
    }

    /// The distribution, as the file states it.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The values that the model has, one for each entry.
    pub fn start(&self) -> &[f64] {
        &self.start
    }

    /// Where these values come from.
    pub fn origin(&self) -> Origin {
        self.origin
    }

    /// Whether it is uniform between two ends.
    pub fn is_uniform(&self) -> bool {
        matches!(self.law, Law::Of(Distribution::Uniform(_)))
    }

    /// The log density of values, one for each entry; −∞ where they cannot be. That of a dirichlet is one of all entries but the last.
    ///
    /// # Panics
    /// If there is not one value for each entry.
    pub fn log_density(&self, values: &[f64]) -> f64 {
        assert_eq!(values.len(), self.entries.len(), "one value for each of {:?}", self.entries);
        self.law.log_density(values)
    }

    /// The values, one for each entry, that as many independent standard normal numbers are turned into: `F⁻¹(Φ(v))` with the distribution function F of a
    /// number; of a dirichlet the shares of gamma variables that are made so.
    ///
    /// # Panics
    /// If there is not one number for each entry.
    pub fn at(&self, noise: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; noise.len()];
        self.write(noise, &mut values);
        values
    }

    /// [`Prior::at`] that writes into memory of one's own.
    ///
    /// # Panics
    /// If there is not one number, or no place for one, for each entry.
    pub fn write(&self, noise: &[f64], values: &mut [f64]) {
        let lengths = [noise.len(), values.len()];
        assert_eq!(lengths, [self.entries.len(); 2], "one number for each of {:?}", self.entries);
        self.law.write(noise, values);
    }

    /// Values that are drawn from it, one for each entry.
    pub fn sample(&self, stream: &mut Stream) -> Vec<f64> {
        let mut noise = vec![0.0; self.entries.len()];
        fill_standard_normal(stream, &mut noise);
        self.at(&noise)
    }
}
