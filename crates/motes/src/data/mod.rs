//! Data: rows of measurements from CSV or from memory, as one or several series.

mod blocks;
mod cell;
mod columns;
mod error;
mod rows;
mod seen;
mod series;
mod shown;
mod table;
mod times;
mod warnings;

pub use columns::Columns;
pub use error::{DataError, Place, RowNumbering, RowSource};
pub use rows::{Row, Rows};
pub use series::Data;
pub use table::{InputTable, Table};
pub use times::RowOrder;
