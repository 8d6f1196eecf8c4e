//! How often each particle is drawn by a resampling scheme.

use motes_models::{Seed, Stream};

use crate::{REFUSED, score};

/// The normalised weights that schemes are tested with.
pub const OFFSPRING_WEIGHTS: [f64; 5] = [0.1, 0.5, 0.1, 0.15, 0.15];

const REPETITIONS: u64 = 20_000;

/// The offspring of five particles in 20,000 resamplings.
pub struct Offspring {
    count: usize,
    counts: Vec<[usize; 5]>,
}

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
        Offspring { count, counts: counts.collect() }
    }

    /// The counts of one particle.
    pub fn counts(&self, particle: usize) -> impl Iterator<Item = f64> {
        self.counts.iter().map(move |counts| counts[particle] as f64)
    }

    /// What tests of resamplers ask of counts: means and variances as promised, and every count within bounds of what is expected.
    ///
    /// # Errors
    /// What does not hold, in words.
    pub fn check(
        &self,
        variance_of: impl Fn(usize, usize) -> f64,
        bounds: impl Fn(f64) -> (f64, f64),
    ) -> Result<(), String> {
        for (particle, weight) in OFFSPRING_WEIGHTS.into_iter().enumerate() {
            let (expected, promised) = (self.count as f64 * weight, variance_of(self.count, particle));
            let z = self.score(particle, expected, promised);
            if z.abs() >= REFUSED {
                return Err(format!("the mean count of particle {particle} has z = {z:.1}"));
            }
            let z = self.variance_score(particle, promised);
            if z.abs() >= 5.0 {
                return Err(format!("the variance of the count of particle {particle} has z = {z:.1}"));
            }
            let (least, most) = bounds(expected);
            if let Some(count) = self.counts(particle).find(|count| !(least..=most).contains(count)) {
                return Err(format!(
                    "particle {particle} has {count} offspring instead of {least} to {most}"
                ));
            }
        }
        Ok(())
    }

    /// How far a particle's mean count is from the expected one, in standard errors by the variance that the scheme promises.
    pub fn score(&self, particle: usize, expected: f64, promised: f64) -> f64 {
        let n = self.counts.len() as f64;
        // A count may never vary; then it has to be right to rounding.
        (self.counts(particle).sum::<f64>() / n - expected) / (promised / n).sqrt().max(1e-9)
    }

    /// How far the variance of a particle's count is from the one that the scheme promises, in standard errors.
    pub fn variance_score(&self, particle: usize, promised: f64) -> f64 {
        let mean = self.counts(particle).sum::<f64>() / self.counts.len() as f64;
        let squares: Vec<f64> = self.counts(particle).map(|count| (count - mean).powi(2)).collect();
        match squares.iter().all(|square| *square < 1e-18) {
            true => promised / 1e-9,
            false => score(&squares, promised),
        }
    }
}

/// The variance of a particle's count by systematic resampling: ⌊KW⌋ or one more.
pub fn systematic_variance(count: usize, particle: usize) -> f64 {
    let expected = count as f64 * OFFSPRING_WEIGHTS[particle];
    let rest = expected - (expected + ROUNDING).floor();
    rest * (1.0 - rest)
}

/// The counts that systematic resampling allows.
pub fn systematic_bounds(expected: f64) -> (f64, f64) {
    // On a boundary of the cumulative sum a rounding error of the weights may move one point.
    ((expected + ROUNDING).floor(), (expected + ROUNDING).ceil())
}

/// Rounding of the weights' decimals, so that 0.5·10 is 5 and not a hair less.
const ROUNDING: f64 = 1e-9;
