//! What is expected of a measurement's entries, from the distributions that a model states.

use super::distribution::Distribution;
use super::statement::Coordinates;
use super::wrapped::Wrapped;
use crate::Marginal;

/// Replaces what draws say of the entries of a measurement by what their distributions say, as far as there are formulas.
pub(crate) struct Marginals<'a> {
    entries: &'a [Option<f64>],
    out: &'a mut [Marginal],
}

impl<'a> Marginals<'a> {
    /// Of a measurement (`M`), and what draws say of it (`M`).
    pub(crate) fn of(entries: &'a [Option<f64>], out: &'a mut [Marginal]) -> Self {
        Marginals { entries, out }
    }

    /// The next entry: what was measured, and what is said of it.
    fn next(&mut self) -> Option<(Option<f64>, &'a mut Marginal)> {
        let (entry, entries) = self.entries.split_first()?;
        let (out, rest) = std::mem::take(&mut self.out).split_first_mut()?;
        (self.entries, self.out) = (entries, rest);
        Some((*entry, out))
    }
}

impl Marginal {
    /// With mean, variance and place by formulas, where there are such.
    fn replace(&mut self, moments: Option<[f64; 2]>, place: Option<[f64; 2]>) {
        if let Some([mean, variance]) = moments {
            (self.mean, self.variance) = (mean, variance);
        }
        if let Some([below, at]) = place {
            (self.below, self.at) = (below, at);
        }
    }
}

impl Coordinates<f64> for Marginals<'_> {
    fn push(&mut self, distribution: Distribution<f64>) {
        let Some((measured, out)) = self.next() else { return };
        out.replace(Some(distribution.mean_and_variance()), measured.map(|value| distribution.place(value)));
    }

    fn push_wrapped(&mut self, wrapped: &Wrapped<'_, f64>) {
        let Some((measured, out)) = self.next() else { return };
        out.is_angle = wrapped.is_angle();
        out.replace(wrapped.moments(), measured.and_then(|value| wrapped.place(value)));
    }
}
