//! Times that labels of rows state: what a filter takes for consecutive may have been measured at other times.

mod calendar;
mod column;
mod cycle;
mod order;
mod spacing;
mod steps;

pub(super) use column::{Kind, Times, is_named_as_time};
pub use order::RowOrder;
pub(super) use spacing::{Irregular, irregular};
