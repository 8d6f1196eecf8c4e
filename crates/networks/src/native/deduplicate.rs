//! Particles that know the same, for which networks need to compute once: before the first state all, and after resampling those of one
//! ancestor, which lie side by side.

use crate::networks::Inputs;
use crate::values::{Real, SliceMut};

/// Numbers of rows are rounded up to a multiple of this, as memory is kept for each number of rows that there was.
const AT_ONCE: usize = 32;

/// Particles at a time: so few that what a layer says of them stays near, and so many that its weights are read seldom.
const BLOCK: usize = 256;

/// How many rows a batch in training has, where no particle has a twin: one before the first state, else one for each.
pub(super) fn distinct(inputs: &Inputs<'_>) -> usize {
    if inputs.previous.is_some() { inputs.particles } else { inputs.particles.min(1) }
}

/// Copies the first row into all others.
pub(super) fn repeat_first<T: Copy>(rows: &mut [T], width: usize) {
    let (first, others) = rows.split_at_mut(width);
    others.chunks_exact_mut(width.max(1)).for_each(|row| row.copy_from_slice(first));
}

/// Which particles to compute: the others know the same as the last of these before them.
#[derive(Default)]
pub(crate) struct DistinctParticles {
    particles: Vec<usize>,
    /// Of each particle.
    is_computed: Vec<bool>,
}

impl DistinctParticles {
    /// Finds the particles that differ, in what is known or in `hidden`, from the one before them, and as many more as make their number round.
    pub(super) fn find<T: Real>(&mut self, inputs: &Inputs<'_>, hidden: &mut [SliceMut<'_>]) {
        let all = inputs.particles;
        self.is_computed.clear();
        match inputs.previous {
            Some(previous) => {
                let mut differs = |row| {
                    row == 0
                        || differ(previous, all, row)
                        || hidden.iter_mut().any(|values| differ(T::pick_mut(values), all, row))
                };
                self.is_computed.extend((0..all).map(&mut differs));
                let found = self.is_computed.iter().filter(|is| **is).count();
                let more = found.next_multiple_of(AT_ONCE).min(all) - found;
                self.is_computed.iter_mut().filter(|is| !**is).take(more).for_each(|is| *is = true);
            }
            None => self.is_computed.extend((0..all).map(|row| row == 0)),
        }
        self.particles.clear();
        self.particles.extend((0..all).filter(|&row| self.is_computed[row]));
    }

    /// Some of them.
    pub(super) fn particles(&self, first: usize, count: usize) -> &[usize] {
        &self.particles[first..first + count]
    }

    /// How many of them to compute at a time: no rest of a few, for which products have ways of their own that round otherwise.
    pub(super) fn blocks(&self) -> impl Iterator<Item = usize> + use<> {
        let count = self.particles.len();
        let (whole, rest) = (count / BLOCK, count % BLOCK);
        let [last_but_one, last] = match rest {
            1..AT_ONCE if whole > 0 => [BLOCK + rest - AT_ONCE, AT_ONCE],
            _ => [BLOCK, rest],
        };
        let before = (0..whole).map(move |block| if block + 1 < whole { BLOCK } else { last_but_one });
        before.chain((last > 0).then_some(last))
    }

    /// Hands the first rows, each of which is that of a particle that was computed, to all particles.
    pub(super) fn hand_out<T: Copy>(&self, rows: &mut [T], width: usize) {
        let mut end = self.is_computed.len();
        // From the last one on: none is overwritten before it was copied.
        for (from, &first) in self.particles.iter().enumerate().rev() {
            let in_place = from == first;
            for into in first + usize::from(in_place)..end {
                rows.copy_within(from * width..(from + 1) * width, into * width);
            }
            if in_place {
                // So are all before it.
                return;
            }
            end = first;
        }
    }
}

/// Whether one of `all` rows differs from the one before it.
fn differ<T: PartialEq>(rows: &[T], all: usize, row: usize) -> bool {
    let width = rows.len() / all;
    rows[(row - 1) * width..row * width] != rows[row * width..(row + 1) * width]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs(previous: &[f64]) -> Inputs<'_> {
        Inputs { time: 1, width: 1, previous: Some(previous), measurement: &[], particles: previous.len() }
    }

    #[test]
    fn particles_that_know_the_same_are_computed_once() {
        // Four particles of each state; one differs in what it carries.
        let previous: Vec<f64> = (0..80).map(|row| f64::from(row / 4)).collect();
        let mut carried: Vec<f64> = previous.iter().flat_map(|value| [*value, 0.5]).collect();
        carried[2 * 7 + 1] = 0.25;
        let mut computed = DistinctParticles::default();
        computed.find::<f64>(&inputs(&previous), &mut [SliceMut::F64(&mut carried.clone())]);
        let found = computed.particles.clone();
        assert_eq!(found.len(), 32, "{found:?}");
        let differ = |row: usize| row == 7 || row.is_multiple_of(4);
        assert!((0..80).filter(|&row| differ(row)).all(|row| found.contains(&row)), "{found:?}");
        let mut rows = vec![f64::NAN; 160];
        for (into, &from) in found.iter().enumerate() {
            rows[2 * into..2 * into + 2].copy_from_slice(&carried[2 * from..2 * from + 2]);
        }
        computed.hand_out(&mut rows, 2);
        assert_eq!(rows, carried);
    }

    #[test]
    fn blocks_have_all_that_is_computed_and_none_is_small() {
        let mut computed = DistinctParticles::default();
        for count in (0..1100).chain([25_345, 30_000, 65_281]) {
            let previous: Vec<f64> = (0..count).map(f64::from).collect();
            computed.find::<f64>(&inputs(&previous), &mut []);
            let all = computed.particles.len();
            let blocks: Vec<usize> = computed.blocks().collect();
            assert_eq!(blocks.iter().sum::<usize>(), all, "{blocks:?}");
            let least = blocks.iter().min().copied().unwrap_or(0);
            assert!(least >= all.min(AT_ONCE) && blocks.iter().all(|&rows| rows <= BLOCK), "{blocks:?}");
        }
    }

    #[test]
    fn particles_that_differ_or_are_few_are_all_computed() {
        let found = |inputs: &Inputs<'_>| {
            let mut computed = DistinctParticles::default();
            computed.find::<f64>(inputs, &mut []);
            computed.particles
        };
        let differ: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(found(&inputs(&differ)), (0..100).collect::<Vec<_>>());
        assert_eq!(found(&inputs(&[1.0; 10])), (0..10).collect::<Vec<_>>());
        assert_eq!(found(&inputs(&[1.0; 100])).len(), 32);
        assert!(found(&inputs(&[])).is_empty());
        assert_eq!(found(&Inputs { previous: None, ..inputs(&differ) }), [0]);
    }
}
