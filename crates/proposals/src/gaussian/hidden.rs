//! What particles carry beside their state.

use motes_networks::{Precision, SliceMut, Values};
use motes_smc::{MemoryRows, ParticleMemory};
use serde::{Deserialize, Serialize};

/// The hidden state of each particle, a row in each of a few matrices; empty for a family without memory.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(into = "StoredHidden", from = "StoredHidden")]
pub struct Hidden {
    widths: Vec<usize>,
    /// `R×width` each.
    values: Vec<Values>,
    /// As large as `values`, to be moved into.
    spare: Vec<Values>,
}

impl Hidden {
    /// Zeros of the given widths for `particles` particles.
    pub(crate) fn zeros(precision: Precision, particles: usize, widths: &[usize]) -> Self {
        let zeros = |width: &usize| Values::none(precision).zeros_like(particles * width);
        let values: Vec<Values> = widths.iter().map(zeros).collect();
        Hidden { widths: widths.to_vec(), spare: values.clone(), values }
    }

    /// Numbers of 64 bits for each particle: values and where they are moved into.
    pub(crate) fn per_particle(precision: Precision, widths: &[usize]) -> usize {
        let values = widths.iter().fold(0, |sum: usize, width| sum.saturating_add(*width));
        match precision {
            Precision::F32 => values,
            Precision::F64 => values.saturating_mul(2),
        }
    }

    /// Each matrix (`R×width`, row-major) in 64 bits.
    pub fn host(&self) -> Vec<Vec<f64>> {
        self.values.iter().map(|values| values.host(0..values.len())).collect()
    }
}

/// Hidden states as they are written down.
#[derive(Serialize, Deserialize)]
struct StoredHidden {
    widths: Vec<usize>,
    values: Vec<Values>,
}

impl From<Hidden> for StoredHidden {
    fn from(hidden: Hidden) -> Self {
        StoredHidden { widths: hidden.widths, values: hidden.values }
    }
}

impl From<StoredHidden> for Hidden {
    fn from(stored: StoredHidden) -> Self {
        let StoredHidden { widths, values } = stored;
        Hidden { widths, spare: values.clone(), values }
    }
}

/// The hidden states of consecutive particles, to be advanced.
pub struct HiddenRows<'a> {
    /// Of each matrix, how wide its rows are, and some of them.
    matrices: Vec<(usize, SliceMut<'a>)>,
}

impl<'a> HiddenRows<'a> {
    /// Each matrix, for networks to advance.
    pub(super) fn into_slices(self) -> Vec<SliceMut<'a>> {
        self.matrices.into_iter().map(|(_, rows)| rows).collect()
    }
}

impl MemoryRows for HiddenRows<'_> {
    fn split(self, particles: usize) -> (Self, Self) {
        let halves = self.matrices.into_iter().map(|(width, rows)| {
            let [first, others] = rows.split(particles * width);
            ((width, first), (width, others))
        });
        let (first, others) = halves.unzip();
        (HiddenRows { matrices: first }, HiddenRows { matrices: others })
    }
}

impl ParticleMemory for Hidden {
    type Rows<'a> = HiddenRows<'a>;

    fn rows(&mut self) -> HiddenRows<'_> {
        let rows = self.values.iter_mut().map(Values::as_slice_mut);
        HiddenRows { matrices: self.widths.iter().copied().zip(rows).collect() }
    }

    fn resample(&mut self, ancestors: &[usize]) {
        for ((values, spare), width) in self.values.iter_mut().zip(&mut self.spare).zip(&self.widths) {
            match (&*values, &mut *spare) {
                (Values::F32(from), Values::F32(into)) => gather(from, *width, ancestors, into),
                (Values::F64(from), Values::F64(into)) => gather(from, *width, ancestors, into),
                _ => unreachable!("both were made in one precision"),
            }
            std::mem::swap(values, spare);
        }
    }

    fn is_laid_out_as(&self, other: &Hidden) -> bool {
        let is_same = |(mine, other): (&Values, &Values)| {
            mine.len() == other.len() && std::mem::discriminant(mine) == std::mem::discriminant(other)
        };
        self.widths == other.widths
            && self.values.len() == other.values.len()
            && self.values.iter().zip(&other.values).all(is_same)
    }
}

fn gather<T: Copy>(from: &[T], width: usize, ancestors: &[usize], into: &mut [T]) {
    for (row, &ancestor) in into.chunks_exact_mut(width).zip(ancestors) {
        row.copy_from_slice(&from[ancestor * width..(ancestor + 1) * width]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_counted_of_a_particle_is_what_is_kept() {
        for precision in [Precision::F32, Precision::F64] {
            let hidden = Hidden::zeros(precision, 3, &[2, 6]);
            let bytes: usize = hidden.values.iter().chain(&hidden.spare).map(Values::len).sum::<usize>()
                * if precision == Precision::F32 { 4 } else { 8 };
            assert_eq!(bytes, 3 * 8 * Hidden::per_particle(precision, &[2, 6]));
        }
    }

    #[test]
    fn what_is_read_is_what_was_written_and_can_be_moved() {
        for precision in [Precision::F32, Precision::F64] {
            let mut hidden = Hidden::zeros(precision, 3, &[2, 1]);
            for values in &mut hidden.values {
                match values {
                    Values::F32(values) => {
                        values.iter_mut().zip(1u8..).for_each(|(value, at)| *value = f32::from(at) / 3.0)
                    }
                    Values::F64(values) => {
                        values.iter_mut().zip(1u8..).for_each(|(value, at)| *value = f64::from(at) / 3.0)
                    }
                }
            }
            let mut bytes = Vec::new();
            ciborium::into_writer(&hidden, &mut bytes).unwrap();
            let mut again: Hidden = ciborium::from_reader(&bytes[..]).unwrap();
            assert!(again.is_laid_out_as(&hidden) && again.host() == hidden.host());
            hidden.resample(&[2, 2, 0]);
            again.resample(&[2, 2, 0]);
            assert_eq!(again.host(), hidden.host());
            assert!(!again.is_laid_out_as(&Hidden::zeros(precision, 4, &[2, 1])));
            assert!(!again.is_laid_out_as(&Hidden::zeros(precision, 3, &[2, 2])));
        }
    }
}
