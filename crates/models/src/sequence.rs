//! Rows over time: a sequence of vectors, and the measurements among them.

use crate::ModelError;

/// `T` rows of equal width, stored one after another.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    width: usize,
    values: Vec<f64>,
}

impl Sequence {
    /// Splits `values` (row-major, `T·width` numbers) into rows.
    ///
    /// # Errors
    /// [`ModelError::RaggedSequence`] if `width` is 0 or does not divide the number of values.
    pub fn new(width: usize, values: Vec<f64>) -> Result<Self, ModelError> {
        if width == 0 || !values.len().is_multiple_of(width) {
            return Err(ModelError::RaggedSequence { values: values.len(), width });
        }
        Ok(Sequence { width, values })
    }

    /// Numbers in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows, `T`.
    pub fn len(&self) -> usize {
        self.values.len() / self.width
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The row at `time`.
    ///
    /// # Panics
    /// If `time` is not below [`Sequence::len`], as slices do.
    pub fn row(&self, time: usize) -> &[f64] {
        &self.values[time * self.width..(time + 1) * self.width]
    }

    /// All rows in order of time.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.values.chunks_exact(self.width)
    }

    /// All values, row after row.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

/// What was measured: `T` finite rows of `M` numbers, `y_0 … y_{T−1}`.
///
/// A type of its own, so that what learns from measurements cannot be handed states by mistake.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurements(Sequence);

impl Measurements {
    /// Takes row-major `values` (`T·width` numbers).
    ///
    /// # Errors
    /// [`ModelError::RaggedSequence`] if the values do not divide into rows, [`ModelError::NotFinite`] with
    /// row and column if one is NaN or infinite.
    pub fn new(width: usize, values: Vec<f64>) -> Result<Self, ModelError> {
        let sequence = Sequence::new(width, values)?;
        if let Some(at) = sequence.values.iter().position(|value| !value.is_finite()) {
            let value = sequence.values[at];
            return Err(ModelError::NotFinite { row: at / width, column: at % width, value });
        }
        Ok(Measurements(sequence))
    }

    /// Checks that these can be measurements of a model with `expected` numbers at each time.
    ///
    /// # Errors
    /// [`ModelError::MeasurementWidth`] if the width differs.
    pub fn check_width(&self, expected: usize) -> Result<(), ModelError> {
        let width = self.0.width;
        if width == expected { Ok(()) } else { Err(ModelError::MeasurementWidth { width, expected }) }
    }
}

impl std::ops::Deref for Measurements {
    type Target = Sequence;

    fn deref(&self) -> &Sequence {
        &self.0
    }
}

/// What was measured, with gaps: `T` rows of `M` entries, each a finite number or missing.
///
/// An entry that is missing carries no information, neither by its value nor by being missing.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialMeasurements {
    width: usize,
    values: Vec<Option<f64>>,
}

impl PartialMeasurements {
    /// Takes row-major `values` (`T·width` entries).
    ///
    /// # Errors
    /// As [`Measurements::new`]; a missing entry is `None`, never NaN.
    pub fn new(width: usize, values: Vec<Option<f64>>) -> Result<Self, ModelError> {
        if width == 0 || !values.len().is_multiple_of(width) {
            return Err(ModelError::RaggedSequence { values: values.len(), width });
        }
        for (row, values) in values.chunks_exact(width).enumerate() {
            PartialMeasurements::check_row(row, values)?;
        }
        Ok(PartialMeasurements { width, values })
    }

    /// Refuses entries of row `row` of which one that is there is not finite.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`] with row and column.
    pub fn check_row(row: usize, entries: &[Option<f64>]) -> Result<(), ModelError> {
        let bad = |(column, entry): (usize, &Option<f64>)| {
            Some((column, (*entry)?)).filter(|(_, value)| !value.is_finite())
        };
        match entries.iter().enumerate().find_map(bad) {
            Some((column, value)) => Err(ModelError::NotFinite { row, column, value }),
            None => Ok(()),
        }
    }

    /// Entries in a row, `M`.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows, `T`.
    pub fn len(&self) -> usize {
        self.values.len() / self.width
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// All rows in order of time.
    pub fn rows(&self) -> impl DoubleEndedIterator<Item = &[Option<f64>]> + ExactSizeIterator {
        self.values.chunks_exact(self.width)
    }
}

/// Measurements without a gap.
impl From<&Measurements> for PartialMeasurements {
    fn from(measurements: &Measurements) -> Self {
        let values = measurements.values().iter().copied().map(Some).collect();
        PartialMeasurements { width: measurements.width(), values }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measurement_that_is_not_finite_is_named_by_row_and_column() {
        let error = Measurements::new(2, vec![1.0, 2.0, 3.0, f64::NAN]).unwrap_err();
        assert_eq!(error.to_string(), "the measurement at row 1, column 1 is NaN; it must be finite");
    }

    #[test]
    fn a_gap_is_none_and_never_nan() {
        let error = PartialMeasurements::new(2, vec![None, Some(1.0), Some(f64::NAN), None]).unwrap_err();
        assert_eq!(error.to_string(), "the measurement at row 1, column 0 is NaN; it must be finite");
        assert!(PartialMeasurements::new(2, vec![None; 3]).is_err());
        let gaps = PartialMeasurements::new(2, vec![None, Some(1.0), Some(2.0), None]).unwrap();
        assert_eq!((gaps.width(), gaps.len()), (2, 2));
        assert_eq!(gaps.rows().next(), Some(&[None, Some(1.0)][..]));
    }

    #[test]
    fn ragged_and_empty_rows_are_refused() {
        assert!(Sequence::new(2, vec![1.0; 3]).is_err());
        assert!(Sequence::new(0, vec![]).is_err());
    }
}
