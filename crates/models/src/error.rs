//! What can be wrong with a model or with the numbers handed to it.

use faer::MatRef;
use thiserror::Error;

/// Why a matrix is not a covariance.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CovarianceFault {
    /// The matrix has the wrong number of rows or columns.
    #[error("is {rows}×{columns}; it must be {expected}×{expected}")]
    Shape {
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
        /// Rows and columns needed.
        expected: usize,
    },
    /// An entry is NaN or infinite.
    #[error("has the entry {value} at row {row}, column {column}; every entry must be finite")]
    NotFinite {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// Two mirrored entries differ.
    #[error(
        "differs from its transpose by {difference:.2e} at row {row}, column {column}; it must be symmetric"
    )]
    NotSymmetric {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// Absolute difference of the two mirrored entries.
        difference: f64,
    },
    /// The smallest eigenvalue is not positive.
    #[error("has the smallest eigenvalue {smallest_eigenvalue:.2e}; it must be positive definite")]
    NotPositiveDefinite {
        /// The smallest eigenvalue.
        smallest_eigenvalue: f64,
    },
}

/// Checks the shape of a matrix, and that every entry is finite.
pub(crate) fn check_matrix(
    name: &'static str,
    matrix: MatRef<'_, f64>,
    rows: usize,
    columns: usize,
) -> Result<(), ModelError> {
    if matrix.shape() != (rows, columns) {
        return Err(ModelError::Shape {
            name,
            rows: matrix.nrows(),
            columns: matrix.ncols(),
            expected_rows: rows,
            expected_columns: columns,
        });
    }
    for row in 0..rows {
        for column in 0..columns {
            let value = matrix[(row, column)];
            if !value.is_finite() {
                return Err(ModelError::NotFiniteEntry { name, row, column, value });
            }
        }
    }
    Ok(())
}

/// An error of this crate. Every variant is bad input but [`ModelError::Numerical`].
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// A matrix that should be a covariance is not one.
    #[error("{name} {fault}")]
    Covariance {
        /// Which matrix.
        name: &'static str,
        /// What is wrong with it.
        fault: CovarianceFault,
    },
    /// A matrix or vector has the wrong shape.
    #[error("{name} is {rows}×{columns}; it must be {expected_rows}×{expected_columns}")]
    Shape {
        /// Which matrix.
        name: &'static str,
        /// Rows found.
        rows: usize,
        /// Columns found.
        columns: usize,
        /// Rows needed.
        expected_rows: usize,
        /// Columns needed.
        expected_columns: usize,
    },
    /// An entry of a matrix is NaN or infinite.
    #[error("{name} has the entry {value} at row {row}, column {column}; every entry must be finite")]
    NotFiniteEntry {
        /// Which matrix.
        name: &'static str,
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        column: usize,
        /// The entry.
        value: f64,
    },
    /// A parameter is outside its range.
    #[error("{name} is {value}; it must be {expected}")]
    Parameter {
        /// Which parameter.
        name: &'static str,
        /// The value found, as text.
        value: String,
        /// What would be right.
        expected: &'static str,
    },
    /// A sequence does not divide into rows of the given width.
    #[error(
        "{values} values do not divide into rows of width {width}; they must fill rows of a width of at least 1"
    )]
    RaggedSequence {
        /// Number of values found.
        values: usize,
        /// Width of a row.
        width: usize,
    },
    /// Measurements have the wrong width.
    #[error("measurements have width {width}; this model measures {expected} numbers at each time")]
    MeasurementWidth {
        /// Width found.
        width: usize,
        /// Width needed.
        expected: usize,
    },
    /// A measurement is NaN or infinite.
    #[error("the measurement at row {row}, column {column} is {value}; it must be finite")]
    NotFinite {
        /// Row (time) of the value.
        row: usize,
        /// Column of the value.
        column: usize,
        /// The value.
        value: f64,
    },
    /// A computation failed although its input was valid.
    #[error("{computation} failed at time {time}: {reason}")]
    Numerical {
        /// What was being computed.
        computation: &'static str,
        /// The time step.
        time: usize,
        /// Why it failed.
        reason: String,
    },
}
