//! Data: rows of measurements from CSV, as one or several series.

mod cell;
mod columns;
mod error;
mod rows;
mod series;

pub use columns::Columns;
pub use error::{DataError, Place};
pub use rows::{Row, Rows};
pub use series::Data;
