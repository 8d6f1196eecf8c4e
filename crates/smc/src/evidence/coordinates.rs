//! Coordinates whose particles descend from too few ancestors to know their spread.

use serde::{Deserialize, Serialize};

use crate::weights::LogWeights;

/// Effective ancestors from which on a standard deviation can be told to a sixth.
const LEAST_ANCESTORS: f64 = 20.0;

/// Steps after which a coordinate that moves has moved: one that follows from its past within a step or two has not lost anything.
const LEAST_STEPS: usize = 8;

/// The share of a coordinate's variance that lies between families, from which on it hardly moves by itself.
const REMEMBERED: f64 = 0.99;

/// The share of the variance of before that a single family must have kept: a mode that was pinned down keeps more, a constant less.
const LEAST_SPREAD: f64 = 1e-4;

/// A coordinate of the state whose standard deviation cannot be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct AncestorShortage {
    pub(super) coordinate: usize,
    /// The step at which it was found, and the earlier one whose particles the present ones descend from.
    pub(super) step: usize,
    pub(super) since: usize,
    /// How many of them, effectively.
    pub(super) ancestors: f64,
}

/// Watches how the values of each coordinate descend from those of an earlier step.
///
/// Particles of an earlier step, the *marks*, found families. Once the weights `G_i` of the families leave fewer than 20 effective ones, `1/Σ G_i²`, and at
/// least 8 steps are over, each coordinate is looked at: where more than 99 % of its variance lies between families, and most of them lie ten times further apart than each is wide, the coordinate hardly moved since, and
/// all that is known of it rests on those few values. New marks are set then.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Coordinates {
    /// Of each particle, the mark that it descends from.
    marks: Vec<usize>,
    next: Vec<usize>,
    marked_at: usize,
    /// The weighted variance of each coordinate when marks were set.
    spread: Vec<f64>,
    families: Vec<f64>,
    sums: Vec<f64>,
    found: Vec<Option<AncestorShortage>>,
}

impl Coordinates {
    /// Takes in a step of a filter: its particles (`K×N`), their weights, and whom they descend from, if they were resampled.
    pub(super) fn step(
        &mut self,
        step: usize,
        particles: &[f64],
        weights: &LogWeights,
        ancestors: Option<&[usize]>,
    ) {
        let (weights, k) = (weights.normalised(), weights.len());
        let width = particles.len() / k;
        if self.marks.len() != k {
            self.found = vec![None; width];
            self.families = vec![0.0; k];
            self.sums = vec![0.0; k];
            self.next = vec![0; k];
            return self.mark(step, particles, weights);
        }
        let Some(ancestors) = ancestors else { return };
        for (next, ancestor) in self.next.iter_mut().zip(ancestors) {
            *next = self.marks[*ancestor];
        }
        std::mem::swap(&mut self.marks, &mut self.next);
        if step - self.marked_at < LEAST_STEPS {
            return;
        }
        self.families.fill(0.0);
        for (mark, weight) in self.marks.iter().zip(weights) {
            self.families[*mark] += weight;
        }
        let effective = 1.0 / self.families.iter().map(|weight| weight * weight).sum::<f64>();
        if effective < LEAST_ANCESTORS {
            for coordinate in 0..width {
                if self.found[coordinate].is_none() && self.hardly_moved(coordinate, particles, weights) {
                    let since = self.marked_at;
                    self.found[coordinate] =
                        Some(AncestorShortage { coordinate, step, since, ancestors: effective });
                }
            }
            self.mark(step, particles, weights);
        }
    }

    /// Lets the present particles found families.
    fn mark(&mut self, step: usize, particles: &[f64], weights: &[f64]) {
        let width = self.found.len();
        self.marks.clear();
        self.marks.extend(0..weights.len());
        self.marked_at = step;
        self.spread.clear();
        self.spread.extend((0..width).map(|coordinate| {
            let values = || particles.iter().skip(coordinate).step_by(width).zip(weights);
            let mean: f64 = values().map(|(value, weight)| weight * value).sum();
            values().map(|(value, weight)| weight * (value - mean).powi(2)).sum::<f64>()
        }));
    }

    /// Whether a coordinate's values are those of its families' founders, nearly.
    fn hardly_moved(&mut self, coordinate: usize, particles: &[f64], weights: &[f64]) -> bool {
        let width = self.found.len();
        let values = || particles.iter().skip(coordinate).step_by(width).zip(weights);
        self.sums.fill(0.0);
        for ((value, weight), mark) in values().zip(&self.marks) {
            self.sums[*mark] += weight * value;
        }
        let mean: f64 = self.sums.iter().sum();
        let whole: f64 = values().map(|(value, weight)| weight * (value - mean).powi(2)).sum();
        let alive = || self.families.iter().zip(&self.sums).filter(|(family, _)| **family > 0.0);
        let between: f64 = alive().map(|(family, sum)| family * (sum / family - mean).powi(2)).sum();
        let rest = (whole - between).max(0.0);
        let mut means: Vec<f64> = alive().map(|(family, sum)| sum / family).collect();
        match means.len() {
            // Of a single family there is nothing between: it is held against the spread of before.
            1 => self.spread[coordinate] > 0.0 && rest <= LEAST_SPREAD * self.spread[coordinate],
            0 | 2 => false,
            _ => {
                // Families of one mode are no founders of their own: most neighbours must be ten times further apart than a family is wide.
                means.sort_unstable_by(f64::total_cmp);
                let mut gaps: Vec<f64> = means.windows(2).map(|pair| pair[1] - pair[0]).collect();
                let middle = gaps.len() / 2;
                let (_, gap, _) = gaps.select_nth_unstable_by(middle, f64::total_cmp);
                whole > 0.0 && rest <= (1.0 - REMEMBERED) * whole && *gap * *gap > 100.0 * rest
            }
        }
    }

    /// What was found so far, at most once a coordinate.
    pub(super) fn found(&self) -> impl Iterator<Item = AncestorShortage> {
        self.found.iter().flatten().copied()
    }
}
