//! Data: rows of measurements from CSV or from memory, as one or several series.

mod cell;
mod columns;
mod error;
mod rows;
mod seen;
mod series;
mod table;

pub use columns::Columns;
pub use error::{Counted, DataError, Place};
pub use rows::{Row, Rows};
pub use series::Data;
pub use table::Table;
