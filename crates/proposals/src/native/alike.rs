//! Particles that know the same, for which networks need to compute once: before the first state all, and after resampling those of one
//! ancestor, which lie side by side.

use motes_smc::Past;

use crate::values::{Real, Values};

/// Rows that are computed are so many, or a multiple of it: memory is kept for each number of rows that there was.
const AT_ONCE: usize = 32;

/// How many particles know something that others do not, if they all have other states: before the first state none does.
pub(super) fn distinct(past: &Past<'_>) -> usize {
    if past.previous.is_some() { past.particles } else { past.particles.min(1) }
}

/// Copies the first row into all others.
pub(super) fn repeat_first<T: Copy>(rows: &mut [T], width: usize) {
    let (first, others) = rows.split_at_mut(width);
    others.chunks_exact_mut(width.max(1)).for_each(|row| row.copy_from_slice(first));
}

/// Which particles to compute: the others know the same as the last of these before them.
#[derive(Default)]
pub(super) struct Computed {
    particles: Vec<usize>,
    /// Of each particle, whether it is one of them.
    is: Vec<bool>,
}

impl Computed {
    /// Finds particles that carry `hidden` and differ from the one before them; if these are few, as many more as make good use of memory.
    pub(super) fn find<T: Real>(&mut self, past: &Past<'_>, hidden: &[Values]) -> &[usize] {
        let all = past.particles;
        self.is.clear();
        match past.previous {
            Some(previous) => {
                let differs = |row| {
                    row == 0
                        || differ(previous, all, row)
                        || hidden.iter().any(|values| differ(T::slice(values), all, row))
                };
                self.is.extend((0..all).map(differs));
                let found = self.is.iter().filter(|is| **is).count();
                let more = found.next_multiple_of(AT_ONCE).min(all) - found;
                self.is.iter_mut().filter(|is| !**is).take(more).for_each(|is| *is = true);
            }
            None => self.is.extend((0..all).map(|row| row == 0)),
        }
        self.particles.clear();
        self.particles.extend((0..all).filter(|&row| self.is[row]));
        &self.particles
    }

    /// Hands the first rows, each of which is that of a particle that was computed, to all particles.
    pub(super) fn hand_out<T: Copy>(&self, rows: &mut [T], width: usize) {
        let mut end = self.is.len();
        // From the last one on: none is overwritten before it was copied.
        for (from, &first) in self.particles.iter().enumerate().rev() {
            for into in first..end {
                rows.copy_within(from * width..(from + 1) * width, into * width);
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

    fn past(previous: &[f64]) -> Past<'_> {
        Past { time: 1, previous: Some(previous), measurement: &[], particles: previous.len() }
    }

    #[test]
    fn particles_that_know_the_same_are_computed_once() {
        // Four particles of each state; one differs in what it carries.
        let previous: Vec<f64> = (0..80).map(|row| f64::from(row / 4)).collect();
        let mut carried: Vec<f64> = previous.iter().flat_map(|value| [*value, 0.5]).collect();
        carried[2 * 7 + 1] = 0.25;
        let mut computed = Computed::default();
        let found = computed.find::<f64>(&past(&previous), &[Values::F64(carried.clone())]).to_vec();
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
    fn particles_that_differ_or_are_few_are_all_computed() {
        let mut computed = Computed::default();
        let differ: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(computed.find::<f64>(&past(&differ), &[]), (0..100).collect::<Vec<_>>());
        assert_eq!(computed.find::<f64>(&past(&[1.0; 10]), &[]), (0..10).collect::<Vec<_>>());
        assert_eq!(computed.find::<f64>(&past(&[1.0; 100]), &[]).len(), 32);
        assert!(computed.find::<f64>(&past(&[]), &[]).is_empty());
        let first = Past { previous: None, ..past(&differ) };
        assert_eq!(computed.find::<f64>(&first, &[]), [0]);
    }
}
