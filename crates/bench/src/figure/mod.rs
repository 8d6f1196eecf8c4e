//! figure.svg: curves over the x axis, dots where it has one value, or estimates over time.

mod across;
mod counts;
mod curves;
mod dots;
mod metrics;
mod series;
mod style;

pub(crate) use curves::figure;
pub(crate) use series::series_figure;
