//! Products of batches of particles with matrices of weights, each by the kernel that suits its sizes.

mod by_faer;
mod dispatch;
mod eigen_matrices;
mod eigen_panels;
mod eigen_products;
mod few_rows;
mod large_weights;
mod matrix;
mod multiply;
mod outer_products;
mod some_rows;
mod some_rows_transposed;
mod tap_blocks;
mod threads;
mod tiles;
mod turn;
mod vectors;
mod weight_gradients;

pub(crate) use eigen_products::EigenProducts;
pub(crate) use multiply::{Multiply, column_sums, times, times_transposed, transpose, transposed_times};
pub(crate) use outer_products::{OuterProducts, Take, Terms};
pub(crate) use weight_gradients::add_whole;
