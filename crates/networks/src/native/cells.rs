//! Recurrent layers beyond their products, forward and backward.

use faer::Accum;
use motes_models::batch::by_widest_vectors;

use super::buffers::Buffers;
use super::derivatives::Derivatives;
use super::step::{At, Kind, Native, Node, Step};
use crate::gradients::Gradients;
use crate::values::{Real, sigmoid};

/// `c' = σ(f) ∘ c + σ(i) ∘ tanh(g)` and `h' = σ(o) ∘ tanh(c')`; the activated gates stay where the gates were.
pub(super) fn lstm<T: Real>(step: &mut Step<T>, buffers: &mut Buffers<T>, gates: At, cells: At) -> (At, At) {
    let (rows, h) = step.size(cells);
    let [mut next, mut bounded, mut hidden] = [(); 3].map(|()| buffers.take(rows * h));
    // Out and back in again: three matrices of one step at a time.
    let mut activated = std::mem::take(&mut step.nodes[gates.0].values);
    let given = step.values(cells);
    by_widest_vectors(
        #[inline(always)]
        || {
            for row in 0..rows {
                let [i, f, g, o] = quarters_mut(&mut activated[row * 4 * h..(row + 1) * 4 * h]);
                i.iter_mut().chain(f.iter_mut()).for_each(|a| *a = sigmoid(*a));
                g.iter_mut().for_each(|a| *a = a.tanh());
                o.iter_mut().for_each(|a| *a = sigmoid(*a));
                let at = row * h..(row + 1) * h;
                let (next, c) = (&mut next[at.clone()], &given[at.clone()]);
                for ((((next, c), i), f), g) in next.iter_mut().zip(c).zip(&*i).zip(&*f).zip(&*g) {
                    *next = *f * *c + *i * *g;
                }
                let (bounded, hidden) = (&mut bounded[at.clone()], &mut hidden[at]);
                for (((bounded, hidden), next), o) in bounded.iter_mut().zip(hidden).zip(&*next).zip(&*o) {
                    *bounded = next.tanh();
                    *hidden = *o * *bounded;
                }
            }
        },
    );
    step.nodes[gates.0].values = activated;
    let cells = step.push(Kind::LstmCells { gates, cells }, rows, h, next);
    (step.push(Kind::LstmHidden { gates, cells, bounded }, rows, h, hidden), cells)
}

fn quarters_mut<T>(row: &mut [T]) -> [&mut [T]; 4] {
    let h = row.len() / 4;
    let (first, rest) = row.split_at_mut(h);
    let (second, rest) = rest.split_at_mut(h);
    let (third, fourth) = rest.split_at_mut(h);
    [first, second, third, fourth]
}

fn quarters<T>(row: &[T]) -> [&[T]; 4] {
    let h = row.len() / 4;
    [&row[..h], &row[h..2 * h], &row[2 * h..3 * h], &row[3 * h..]]
}

/// From `h̄'`: `ō = h̄' ∘ tanh c' ∘ o(1 − o)` into the gates' place, and `c̄' += h̄' ∘ o ∘ (1 − tanh²c')`.
pub(super) fn lstm_hidden_backward<T: Real>(
    below: &[Node<T>],
    (gates, cells, bounded): (At, At, &[T]),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
) {
    let h = below[cells.0].width;
    let activated = &below[gates.0].values;
    let (mut d_gates, _) = derivatives.take(gates, activated.len());
    let (mut d_cells, accum) = derivatives.take(cells, d.len());
    by_widest_vectors(
        #[inline(always)]
        || {
            if accum == Accum::Replace {
                d_cells.fill(T::ZERO);
            }
            for (row, d) in d.chunks_exact(h).enumerate() {
                let at = row * h..(row + 1) * h;
                let [.., o] = quarters(&activated[row * 4 * h..(row + 1) * 4 * h]);
                let [.., d_o] = quarters_mut(&mut d_gates[row * 4 * h..(row + 1) * 4 * h]);
                let (bounded, d_cells) = (&bounded[at.clone()], &mut d_cells[at]);
                for ((((d, o), d_o), b), d_c) in d.iter().zip(o).zip(d_o).zip(bounded).zip(d_cells) {
                    *d_o = *d * *b * *o * (T::ONE - *o);
                    *d_c += *d * *o * (T::ONE - *b * *b);
                }
            }
        },
    );
    derivatives.put(gates, d_gates);
    derivatives.put(cells, d_cells);
    derivatives.buffers.put(d);
}

/// From `c̄'`, the other gates' derivatives into their place, and `c̄ = c̄' ∘ f`.
pub(super) fn lstm_cells_backward<T: Real>(
    below: &[Node<T>],
    (gates, cells): (At, At),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
) {
    let h = below[cells.0].width;
    let (activated, c) = (&below[gates.0].values, &below[cells.0].values);
    let (mut d_gates, present) = derivatives.take(gates, activated.len());
    if present == Accum::Replace {
        // The hidden state that came of it was not used: nothing flows through the output gate.
        d_gates.fill(T::ZERO);
    }
    by_widest_vectors(
        #[inline(always)]
        || {
            for (row, d) in d.chunks_exact(h).enumerate() {
                let at = row * h..(row + 1) * h;
                let [i, f, g, _] = quarters(&activated[row * 4 * h..(row + 1) * 4 * h]);
                let [d_i, d_f, d_g, _] = quarters_mut(&mut d_gates[row * 4 * h..(row + 1) * 4 * h]);
                for (((d, i), g), (d_i, d_g)) in d.iter().zip(i).zip(g).zip(d_i.iter_mut().zip(d_g)) {
                    *d_i = *d * *g * *i * (T::ONE - *i);
                    *d_g = *d * *i * (T::ONE - *g * *g);
                }
                for (((d, c), f), d_f) in d.iter().zip(&c[at]).zip(f).zip(d_f) {
                    *d_f = *d * *c * *f * (T::ONE - *f);
                }
            }
        },
    );
    derivatives.put(gates, d_gates);
    if derivatives.wanted(cells) {
        let (mut d_cells, accum) = derivatives.take(cells, d.len());
        by_widest_vectors(
            #[inline(always)]
            || {
                if accum == Accum::Replace {
                    d_cells.fill(T::ZERO);
                }
                let rows =
                    d.chunks_exact(h).zip(d_cells.chunks_exact_mut(h)).zip(activated.chunks_exact(4 * h));
                for ((d, d_cells), activated) in rows {
                    let [_, f, ..] = quarters(activated);
                    d.iter().zip(f).zip(d_cells).for_each(|((d, f), d_c)| *d_c += *d * *f);
                }
            },
        );
        derivatives.put(cells, d_cells);
    }
    derivatives.buffers.put(d);
}

/// `r, s = σ(u + v)`, `ĥ = tanh(u + r ∘ (v + d))`, `h' = ĥ + s ∘ (h − ĥ)`, with `u` and `v` a third of the products each.
pub(super) fn gru<T: Real>(
    native: &mut Native<'_, T>,
    from_input: At,
    from_hidden: At,
    offset: usize,
    hidden: At,
) -> At {
    let (rows, h) = native.step.size(hidden);
    let (mut next, mut parts) = (native.buffers.take(rows * h), native.buffers.take(rows * 4 * h));
    let d = native.weights.get(offset);
    let [u, v, given] = [from_input, from_hidden, hidden].map(|at| native.step.values(at));
    by_widest_vectors(
        #[inline(always)]
        || {
            for row in 0..rows {
                let (u, v) = (&u[row * 3 * h..(row + 1) * 3 * h], &v[row * 3 * h..(row + 1) * 3 * h]);
                let [r, s, candidate, inner] = quarters_mut(&mut parts[row * 4 * h..(row + 1) * 4 * h]);
                let at = row * h..(row + 1) * h;
                let (next, given) = (&mut next[at.clone()], &given[at]);
                for j in 0..h {
                    r[j] = sigmoid(u[j] + v[j]);
                    s[j] = sigmoid(u[h + j] + v[h + j]);
                    inner[j] = v[2 * h + j] + d[j];
                    candidate[j] = (u[2 * h + j] + r[j] * inner[j]).tanh();
                    next[j] = candidate[j] + s[j] * (given[j] - candidate[j]);
                }
            }
        },
    );
    native.step.push(Kind::Gru { from_input, from_hidden, offset, hidden, parts }, rows, h, next)
}

/// From `h̄'` to the derivatives of both products, the offset and `h`.
pub(super) fn gru_backward<T: Real>(
    below: &[Node<T>],
    (from_input, from_hidden, offset, hidden, parts): (At, At, usize, At, &[T]),
    d: Vec<T>,
    derivatives: &mut Derivatives<'_, T>,
    gradients: &mut Gradients,
) {
    let (rows, h) = (below[hidden.0].rows, below[hidden.0].width);
    let given = &below[hidden.0].values;
    let (mut d_u, _) = derivatives.take(from_input, rows * 3 * h);
    let (mut d_v, _) = derivatives.take(from_hidden, rows * 3 * h);
    let (d_offset, accum) = gradients.place::<T>(offset);
    if accum == Accum::Replace {
        d_offset.fill(T::ZERO);
    }
    let mut d_hidden = derivatives.buffers.take(rows * h);
    by_widest_vectors(
        #[inline(always)]
        || {
            for row in 0..rows {
                let [r, s, candidate, inner] = quarters(&parts[row * 4 * h..(row + 1) * 4 * h]);
                let wide = row * 3 * h..(row + 1) * 3 * h;
                let (d_u, d_v) = (&mut d_u[wide.clone()], &mut d_v[wide]);
                let at = row * h..(row + 1) * h;
                let (d, given, d_hidden) = (&d[at.clone()], &given[at.clone()], &mut d_hidden[at]);
                for j in 0..h {
                    d_hidden[j] = d[j] * s[j];
                    let d_candidate = d[j] * (T::ONE - s[j]) * (T::ONE - candidate[j] * candidate[j]);
                    let d_s = d[j] * (given[j] - candidate[j]) * s[j] * (T::ONE - s[j]);
                    let d_r = d_candidate * inner[j] * r[j] * (T::ONE - r[j]);
                    (d_u[j], d_u[h + j], d_u[2 * h + j]) = (d_r, d_s, d_candidate);
                    (d_v[j], d_v[h + j], d_v[2 * h + j]) = (d_r, d_s, d_candidate * r[j]);
                    d_offset[j] += d_candidate * r[j];
                }
            }
        },
    );
    derivatives.put(from_input, d_u);
    derivatives.put(from_hidden, d_v);
    derivatives.add(hidden, d_hidden);
    derivatives.buffers.put(d);
}
