//! Which kernel computes a product, by its sizes and its precision.

use faer::Accum;

use super::eigen_products::EigenProducts;
use super::matrix::{Columns, ColumnsMut, Factor, Product, Task};
use super::multiply::Multiply;
use super::outer_products::{OuterProducts, Take};
use super::threads::{Kernel, share};
use super::{
    by_faer, eigen_matrices, eigen_panels, few_rows, large_weights, some_rows, some_rows_transposed,
    weight_gradients,
};
use crate::native::buffers::Buffers;

/// Up to so many rows, the large factor is best read where it lies, ...
const FEW: usize = 12;
/// ... up to so many in pieces, and from there on a copy of it in another order, as a general product makes it, costs little.
const MANY: usize = 256;
/// A factor narrower than this is not large.
const WIDE: usize = 64;
/// A matrix of so many numbers, 32 MB, is too large for a core's own cache and a share of the last one; a gradient already of half as many.
const LARGE: usize = 8 << 20;

/// So many terms of a sum faer 0.24 adds up at a time, where it has vectors with fused multiplication on x86.
const SHORT: usize = 512;

impl Multiply for f64 {
    fn times(product: Product<'_, f64>, _: &mut Buffers<f64>) {
        by_faer::times(product);
    }

    fn times_transposed(product: Product<'_, f64>, _: &mut Buffers<f64>) {
        by_faer::times_transposed(product);
    }

    fn transposed_times(product: Product<'_, f64>, _: &mut Buffers<f64>) {
        by_faer::transposed_times(product);
    }

    fn by_eigenvalue(products: EigenProducts<'_, f64>, buffers: &mut Buffers<f64>) {
        eigen_matrices::one_by_one(products, buffers);
    }

    fn outer(sums: &OuterProducts<'_, f64>, buffers: &mut Buffers<f64>, take: Take<'_, f64>) {
        match sums.affine() {
            Some(_) => weight_gradients::whole(sums, buffers, take),
            None => weight_gradients::each_row(sums, buffers, take),
        }
    }
}

impl Multiply for f32 {
    fn times(product: Product<'_, f32>, buffers: &mut Buffers<f32>) {
        let [rows, inner, columns] = product.sizes;
        if rows > MANY && inner * columns >= LARGE {
            by_kernel(product, [false, false], large_weights::times, buffers);
        } else if columns < WIDE || rows > MANY {
            by_faer::times(product);
        } else if rows <= FEW {
            few_rows::times(product);
        } else {
            by_kernel(product, [false, false], some_rows::times, buffers);
        }
    }

    fn times_transposed(product: Product<'_, f32>, buffers: &mut Buffers<f32>) {
        let [rows, inner, columns] = product.sizes;
        if rows > MANY && inner * columns >= LARGE {
            by_kernel(product, [false, true], large_weights::times, buffers);
        } else if inner < WIDE || columns < WIDE || rows > MANY {
            by_faer::times_transposed(product);
        } else if rows <= FEW {
            few_rows::times_transposed(product);
        } else {
            by_kernel(product, [false, true], some_rows_transposed::times_transposed, buffers);
        }
    }

    fn transposed_times(product: Product<'_, f32>, buffers: &mut Buffers<f32>) {
        let [rows, inner, columns] = product.sizes;
        if inner > MANY && rows * columns >= LARGE {
            by_kernel(product, [true, false], large_weights::times, buffers);
        } else if inner > MANY && rows * columns >= LARGE / 2 {
            in_short_sums(product, buffers);
        } else {
            by_faer::transposed_times(product);
        }
    }

    fn by_eigenvalue(products: EigenProducts<'_, f32>, buffers: &mut Buffers<f32>) {
        let [rows, ..] = products.sizes();
        if rows > MANY {
            eigen_matrices::one_by_one(products, buffers);
        } else {
            eigen_panels::times(products, buffers);
        }
    }

    fn outer(sums: &OuterProducts<'_, f32>, buffers: &mut Buffers<f32>, take: Take<'_, f32>) {
        match sums.affine() {
            // A product at once is as fast where sums are long, and a tile's rows would be used too seldom.
            Some(term) if term.inputs.len() > MANY * sums.shape.inputs => {
                weight_gradients::whole(sums, buffers, take)
            }
            _ => weight_gradients::each_tile(sums, buffers, take),
        }
    }
}

/// The product of the factors, or of the transposes of what lies there, on several threads if that is worth it.
fn by_kernel(product: Product<'_, f32>, [of_a, of_b]: [bool; 2], kernel: Kernel, buffers: &mut Buffers<f32>) {
    let Product { out, accum, a, b, sizes: [rows, inner, columns] } = product;
    let b = Columns { values: b, stride: if of_b { inner } else { columns } };
    let (a, b) = (Factor { lies: a, transposed: of_a }, Factor { lies: b, transposed: of_b });
    share(Task { out: by_faer::matrix_mut(out, rows, columns), accum, a, b, inner }, kernel, buffers);
}

/// `aᵀ b` in blocks, in sums as short as faer's, so that results are to the last bit what they were when it computed gradients of this size.
fn in_short_sums(product: Product<'_, f32>, buffers: &mut Buffers<f32>) {
    let Product { out: ColumnsMut { values, stride }, mut accum, a, b, sizes: [rows, inner, columns] } =
        product;
    for first in (0..inner).step_by(SHORT) {
        let part = Product {
            out: ColumnsMut { values: &mut *values, stride },
            accum,
            a: Columns { values: &a.values[first * a.stride..], stride: a.stride },
            b: &b[first * columns..],
            sizes: [rows, SHORT.min(inner - first), columns],
        };
        by_kernel(part, [true, false], large_weights::times, buffers);
        accum = Accum::Add;
    }
}

#[cfg(test)]
mod tests {
    use super::super::multiply::times;
    use super::*;

    const SIZES: [[usize; 3]; 16] = [
        [1, 5, 64],
        [10, 33, 70],
        [9, 2, 65],
        [12, 300, 64],
        [13, 64, 97],
        [17, 64, 64],
        [29, 130, 66],
        [40, 65, 128],
        [50, 7, 1024],
        [50, 200, 100],
        [64, 65, 70],
        [65, 100, 77],
        [200, 90, 130],
        [256, 64, 65],
        [300, 64, 64],
        [30, 0, 64],
    ];

    fn numbers(count: usize, rate: f64) -> Vec<f32> {
        (0..count).map(|k| (rate * k as f64 + 0.3).sin() as f32).collect()
    }

    /// Every way and every size of its tiles, with and without a rest, against sums of 64 bits.
    #[test]
    fn products_are_those_of_the_definition() {
        for sizes in SIZES {
            let [rows, inner, columns] = sizes;
            let (stride_a, stride_out) = (inner + 3, columns + 5);
            let a = numbers(rows * stride_a, 0.7);
            let b = numbers(inner * columns, 1.3);
            let mut buffers = Buffers::default();
            for accum in [Accum::Replace, Accum::Add] {
                let before = numbers(rows * stride_out, 2.1);
                let mut found = before.clone();
                let out = ColumnsMut { values: &mut found, stride: stride_out };
                let a_rows = Columns { values: &a, stride: stride_a };
                f32::times(Product { out, accum, a: a_rows, b: &b, sizes }, &mut buffers);
                check(&found, &before, stride_out, accum, sizes, |r, c| {
                    (0..inner).map(|k| f64::from(a[r * stride_a + k]) * f64::from(b[k * columns + c])).sum()
                });
                let mut found = before.clone();
                let out = ColumnsMut { values: &mut found, stride: stride_out };
                let a_rows = Columns { values: &a, stride: stride_a };
                f32::times_transposed(Product { out, accum, a: a_rows, b: &b, sizes }, &mut buffers);
                check(&found, &before, stride_out, accum, sizes, |r, c| {
                    (0..inner).map(|k| f64::from(a[r * stride_a + k]) * f64::from(b[c * inner + k])).sum()
                });
            }
        }
    }

    type Way = fn(Product<'_, f32>, &mut Buffers<f32>);

    /// `a b`, `a bᵀ` and `aᵀ b`.
    const IN_BLOCKS: [Way; 3] = [
        |product, buffers| by_kernel(product, [false, false], large_weights::times, buffers),
        |product, buffers| by_kernel(product, [false, true], large_weights::times, buffers),
        |product, buffers| by_kernel(product, [true, false], large_weights::times, buffers),
    ];

    const IN_PANELS: Way = |product, buffers| by_kernel(product, [false, false], some_rows::times, buffers);
    const ACROSS: Way =
        |product, buffers| by_kernel(product, [false, true], some_rows_transposed::times_transposed, buffers);

    /// What `way` makes of the first numbers of `a` and `b`.
    fn made(way: Way, sizes: [usize; 3], a: Columns<'_, f32>, b: &[f32]) -> Vec<f32> {
        let [rows, inner, columns] = sizes;
        let mut found = vec![0.0; rows * columns];
        let out = ColumnsMut { values: &mut found, stride: columns };
        let b = &b[..inner * columns];
        way(Product { out, accum: Accum::Replace, a, b, sizes }, &mut Buffers::default());
        found
    }

    #[test]
    fn panels_and_blocks_agree_to_the_last_bit() {
        let (sizes, a, b) = ([50, 200, 100], numbers(50 * 200, 0.7), numbers(200 * 100, 1.3));
        let a = Columns { values: &a, stride: 200 };
        assert!(made(IN_PANELS, sizes, a, &b) == made(IN_BLOCKS[0], sizes, a, &b));
        assert!(made(ACROSS, sizes, a, &b) == made(IN_BLOCKS[1], sizes, a, &b));
    }

    /// Filters leave rows out that are the same as others.
    #[test]
    fn a_row_does_not_depend_on_the_others() {
        let single = numbers(256 * 2048, 0.7);
        rows_do_not_depend_on_others(&single, &numbers(2048 * 600, 1.3));
        let double = |values: Vec<f32>| values.into_iter().map(f64::from).collect::<Vec<_>>();
        rows_do_not_depend_on_others(&double(single), &double(numbers(2048 * 600, 1.3)));
    }

    /// As many rows as filters compute at a time: [more than a few](FEW).
    fn rows_do_not_depend_on_others<T: Multiply>(a: &[T], b: &[T]) {
        for (inner, columns) in [(2048, 3), (1024, 10), (32, 3), (128, 32), (13, 64), (300, 600)] {
            for accum in [Accum::Replace, Accum::Add] {
                let product = |first: usize, rows: usize| {
                    let mut out = b[first * columns..(first + rows) * columns].to_vec();
                    let (a, b) = (&a[first * inner..(first + rows) * inner], &b[..inner * columns]);
                    times(&mut out, accum, a, b, [rows, inner, columns], &mut Buffers::default());
                    out
                };
                let all = product(0, 256);
                for (first, rows) in [(1, 13), (100, 32), (9, 47), (128, 128), (63, 193)] {
                    let expected = &all[first * columns..(first + rows) * columns];
                    assert!(product(first, rows) == expected, "{inner}×{columns}, {rows} rows from {first}");
                }
            }
        }
    }

    /// In blocks, with either factor transposed or none, and by the kernels of fewer rows.
    #[test]
    fn products_are_the_same_on_any_number_of_threads() {
        let kinds: [(Way, [usize; 3], usize); 5] = [
            (f32::times, [257, 2048, 4096], 2048),
            (f32::times_transposed, [257, 2048, 4096], 2048),
            (f32::transposed_times, [2048, 300, 4096], 2048),
            (f32::times, [101, 600, 3000], 600),
            (f32::times_transposed, [101, 600, 3000], 600),
        ];
        for (kind, (way, sizes, stride)) in kinds.into_iter().enumerate() {
            let [rows, inner, columns] = sizes;
            let (a, b) = (numbers(rows * inner, 0.7), numbers(inner * columns, 1.3));
            let a = Columns { values: &a, stride };
            let one = made(way, sizes, a, &b);
            for threads in [2, 3] {
                let pool = rayon_core::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                assert!(pool.install(|| made(way, sizes, a, &b)) == one, "kind {kind}, {threads} threads");
            }
        }
    }

    /// Each kind of product where blocks begin, and of a smaller matrix. The last bits tell which way was taken.
    #[test]
    fn large_matrices_are_multiplied_in_blocks() {
        let kinds: [Way; 3] = [f32::times, f32::times_transposed, f32::transposed_times];
        let ways_of_faer: [Way; 3] = [
            |product, _| by_faer::times(product),
            |product, _| by_faer::times_transposed(product),
            |product, _| by_faer::transposed_times(product),
        ];
        // Of the gradient, the matrix is the product; its sums must be longer for their last bits to differ.
        let least = [[257, 2048, 4096], [257, 2048, 4096], [2048, 600, 4096]];
        for (kind, sizes) in least.into_iter().enumerate() {
            let [rows, inner, columns] = sizes;
            let (a, b) = (numbers(rows * inner, 0.7), numbers(inner * columns, 1.3));
            let a = Columns { values: &a, stride: if kind == 2 { rows } else { inner } };
            let found = made(kinds[kind], sizes, a, &b);
            assert!(found == made(IN_BLOCKS[kind], sizes, a, &b), "kind {kind}");
            assert!(
                found != made(ways_of_faer[kind], sizes, a, &b),
                "kind {kind}: the last bits tell nothing"
            );
            let smaller = [rows, inner, columns - 1];
            let found = made(kinds[kind], smaller, a, &b);
            if kind < 2 || cfg!(target_arch = "x86_64") {
                assert!(found == made(ways_of_faer[kind], smaller, a, &b), "kind {kind}");
            }
        }
    }

    fn check(
        found: &[f32],
        before: &[f32],
        stride: usize,
        accum: Accum,
        [rows, inner, columns]: [usize; 3],
        product: impl Fn(usize, usize) -> f64,
    ) {
        for r in 0..rows {
            for c in 0..stride {
                let at = r * stride + c;
                let old = if accum == Accum::Add || c >= columns { f64::from(before[at]) } else { 0.0 };
                let expected = old + if c < columns { product(r, c) } else { 0.0 };
                let error = (f64::from(found[at]) - expected).abs();
                assert!(error < 1e-6 * (inner as f64 + 1.0), "row {r}, column {c}: {error:e}");
            }
        }
    }
}
