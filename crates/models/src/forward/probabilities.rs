//! Probabilities of a few states.

/// `K` states with their probabilities, which add up to 1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateProbabilities {
    width: usize,
    /// `K×N`.
    states: Vec<f64>,
    probabilities: Vec<f64>,
}

impl StateProbabilities {
    /// Those of states (row-major `K×N`, with `N` the `width`).
    ///
    /// # Panics
    /// If there are not `K` probabilities.
    pub fn of(width: usize, states: Vec<f64>, probabilities: Vec<f64>) -> Self {
        assert_eq!(states.len(), width * probabilities.len(), "each state has a probability");
        StateProbabilities { width, states, probabilities }
    }

    /// The states, `K×N`.
    pub fn states(&self) -> &[f64] {
        &self.states
    }

    /// The probabilities, `K`.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// `N`.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The states with their probabilities.
    pub fn iter(&self) -> impl Iterator<Item = (&[f64], f64)> {
        self.states.chunks_exact(self.width.max(1)).zip(self.probabilities.iter().copied())
    }

    /// The values of a coordinate with their probabilities.
    fn values(&self, coordinate: usize) -> impl Iterator<Item = (f64, f64)> {
        self.iter().map(move |(state, probability)| (state[coordinate], probability))
    }

    /// The mean of a coordinate.
    ///
    /// # Panics
    /// If there is no such coordinate.
    pub fn mean(&self, coordinate: usize) -> f64 {
        self.values(coordinate).map(|(value, probability)| value * probability).sum()
    }

    /// The standard deviation of a coordinate.
    ///
    /// # Panics
    /// If there is no such coordinate.
    pub fn standard_deviation(&self, coordinate: usize) -> f64 {
        let mean = self.mean(coordinate);
        let squares = self.values(coordinate).map(|(value, p)| p * (value - mean) * (value - mean));
        squares.sum::<f64>().sqrt()
    }

    /// The quantile of a coordinate at a probability: the smallest value that is not exceeded with at least this probability.
    ///
    /// # Panics
    /// If there is no such coordinate.
    pub fn quantile(&self, coordinate: usize, probability: f64) -> f64 {
        // Sums of probabilities are rounded.
        const ROUNDED: f64 = 1e-12;
        let mut values: Vec<(f64, f64)> = self.values(coordinate).filter(|(_, p)| *p > 0.0).collect();
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut below = 0.0;
        let reached = values.iter().find(|(_, own)| {
            below += own;
            below >= probability - ROUNDED
        });
        reached.or(values.last()).map_or(f64::NAN, |(value, _)| *value)
    }

    /// The number of the state at a place between 0 and 1 on the sum of probabilities.
    pub fn at(&self, place: f64) -> usize {
        let mut below = 0.0;
        let all: f64 = self.probabilities.iter().sum();
        let reached = self.probabilities.iter().position(|own| {
            below += own;
            *own > 0.0 && place * all < below
        });
        let last = || self.probabilities.iter().rposition(|own| *own > 0.0);
        reached.or_else(last).unwrap_or(0)
    }

    /// A state by its number.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn state(&self, number: usize) -> &[f64] {
        &self.states[number * self.width..][..self.width]
    }
}
