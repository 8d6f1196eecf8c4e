//! Transposing into memory where the rows of the result are far apart.

/// As many rows and columns at a time as there are single numbers in the shortest vectors.
const SIDE: usize = 4;

/// Writes rows as columns, both with so many numbers from one to the next.
#[inline(always)]
pub(super) fn turn(
    values: &[f32],
    from_apart: usize,
    [rows, columns]: [usize; 2],
    out: &mut [f32],
    apart: usize,
) {
    let whole = |count: usize| count / SIDE * SIDE;
    for row in (0..whole(rows)).step_by(SIDE) {
        let squares: [_; SIDE] = std::array::from_fn(|next| {
            let (squares, _) = values[(row + next) * from_apart..][..columns].as_chunks::<SIDE>();
            squares
        });
        let [first, second, third, fourth] = squares;
        let squares = first.iter().zip(second).zip(third.iter().zip(fourth));
        for (number, ((first, second), (third, fourth))) in squares.enumerate() {
            let into = &mut out[number * SIDE * apart + row..][..(SIDE - 1) * apart + SIDE];
            for (next, numbers) in transpose([*first, *second, *third, *fourth]).into_iter().enumerate() {
                into[next * apart..][..SIDE].copy_from_slice(&numbers);
            }
        }
    }
    for row in 0..rows {
        let turned = if row < whole(rows) { whole(columns) } else { 0 };
        for column in turned..columns {
            out[column * apart + row] = values[row * from_apart + column];
        }
    }
}

/// In registers of four numbers: the compiler would move numbers one by one.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose(square: [[f32; SIDE]; SIDE]) -> [[f32; SIDE]; SIDE] {
    let Some(sse) = pulp::core_arch::x86::Sse::try_new() else { return one_by_one(square) };
    let [a, b, c, d] = square.map(pulp::cast);
    let (low, other_low) = (sse._mm_unpacklo_ps(a, b), sse._mm_unpacklo_ps(c, d));
    let (high, other_high) = (sse._mm_unpackhi_ps(a, b), sse._mm_unpackhi_ps(c, d));
    [
        sse._mm_movelh_ps(low, other_low),
        sse._mm_movehl_ps(other_low, low),
        sse._mm_movelh_ps(high, other_high),
        sse._mm_movehl_ps(other_high, high),
    ]
    .map(pulp::cast)
}

#[cfg(not(target_arch = "x86_64"))]
#[inline(always)]
fn transpose(square: [[f32; SIDE]; SIDE]) -> [[f32; SIDE]; SIDE] {
    one_by_one(square)
}

#[inline(always)]
fn one_by_one(square: [[f32; SIDE]; SIDE]) -> [[f32; SIDE]; SIDE] {
    std::array::from_fn(|column| square.map(|row| row[column]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns() {
        for (rows, columns) in [(1, 1), (4, 4), (3, 9), (16, 20), (7, 3), (18, 5)] {
            let stride = rows + 3;
            let values: Vec<f32> = (0..rows * columns).map(|k| k as f32).collect();
            let mut out = vec![-1.0; columns * stride];
            turn(&values, columns, [rows, columns], &mut out, stride);
            for (at, found) in out.into_iter().enumerate() {
                let (column, row) = (at / stride, at % stride);
                let expected = if row < rows { (row * columns + column) as f32 } else { -1.0 };
                assert_eq!(found, expected, "{rows} by {columns}, row {row}, column {column}");
            }
        }
    }
}
