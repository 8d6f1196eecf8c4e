//! figure.svg: curves over the x axis, or estimates over time.

mod counts;
mod curves;
mod series;
mod style;

pub(crate) use curves::figure;
pub(crate) use series::series_figure;
