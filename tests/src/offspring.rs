//! How often each particle is drawn by a resampling scheme.

use motes_models::{Seed, Stream};

use crate::score;

/// The normalised weights that schemes are tested with.
pub const OFFSPRING_WEIGHTS: [f64; 5] = [0.1, 0.5, 0.1, 0.15, 0.15];

const REPETITIONS: u64 = 20_000;

/// The offspring of five particles in 20,000 resamplings.
pub struct Offspring(Vec<[usize; 5]>);

impl Offspring {
    /// Lets `draw` choose `count` ancestors, again and again.
    pub fn of(count: usize, mut draw: impl FnMut(&mut Stream, &mut [usize])) -> Self {
        let mut stream = Seed::from_u64(40).nth(count as u64).stream();
        let mut ancestors = vec![0; count];
        let counts = (0..REPETITIONS).map(|_| {
            draw(&mut stream, &mut ancestors);
            assert!(ancestors.is_sorted());
            let mut counts = [0; 5];
            ancestors.iter().for_each(|&ancestor| counts[ancestor] += 1);
            counts
        });
        Offspring(counts.collect())
    }

    /// The counts of one particle.
    pub fn counts(&self, particle: usize) -> impl Iterator<Item = f64> {
        self.0.iter().map(move |counts| counts[particle] as f64)
    }

    /// How far a particle's mean count is from the expected one, in standard errors by the variance that the scheme promises.
    pub fn score(&self, particle: usize, expected: f64, promised: f64) -> f64 {
        let n = self.0.len() as f64;
        // A count may never vary; then it has to be right to rounding.
        (self.counts(particle).sum::<f64>() / n - expected) / (promised / n).sqrt().max(1e-9)
    }

    /// How far the variance of a particle's count is from the one that the scheme promises, in standard errors.
    pub fn variance_score(&self, particle: usize, promised: f64) -> f64 {
        let mean = self.counts(particle).sum::<f64>() / self.0.len() as f64;
        let squares: Vec<f64> = self.counts(particle).map(|count| (count - mean).powi(2)).collect();
        match squares.iter().all(|square| *square < 1e-18) {
            true => promised / 1e-9,
            false => score(&squares, promised),
        }
    }
}
