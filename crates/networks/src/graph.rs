//! The graph that filters run on, in every form that computing with it asks for.

use std::sync::Arc;

use faer::{Mat, Side};

use crate::values::{Both, Real};

/// A system's graph: its matrix `S` and the adapter `A_y` that brings measurements to the nodes.
#[derive(Clone)]
pub struct Graph {
    /// Shared by the steps that a derivative is still wanted of.
    forms: Arc<Forms>,
}

struct Forms {
    /// `S`, `N×N`.
    shift: Mat<f64>,
    /// `A_y`, `N×M`.
    adapter: Mat<f64>,
    entries: Both,
    transposed: Both,
    adapter_entries: Both,
    /// `U`, `Uᵀ` and `λ` of a symmetric `S`.
    spectrum: Option<[Both; 3]>,
}

/// A graph in one precision; matrices are row-major.
#[derive(Clone, Copy)]
pub(crate) struct GraphOf<'a, T> {
    /// `N`.
    pub(crate) nodes: usize,
    /// `S`.
    pub(crate) shift: &'a [T],
    /// `Sᵀ`.
    pub(crate) shift_transposed: &'a [T],
    /// `A_y`.
    pub(crate) adapter: &'a [T],
    /// Of a symmetric `S`.
    pub(crate) spectrum: Option<Spectrum<'a, T>>,
}

/// `S = U diag(λ) Uᵀ`.
#[derive(Clone, Copy)]
pub(crate) struct Spectrum<'a, T> {
    /// `U`.
    pub(crate) basis: &'a [T],
    /// `Uᵀ`.
    pub(crate) basis_transposed: &'a [T],
    /// `λ`.
    pub(crate) eigenvalues: &'a [T],
}

/// The size of one graph filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// `F_in`.
    pub inputs: usize,
    /// `F_out`.
    pub outputs: usize,
    /// `D + 1`.
    pub taps: usize,
}

impl Graph {
    /// Takes `S` (`N×N`) and `A_y` (`N×M`).
    pub fn new(shift: Mat<f64>, adapter: Mat<f64>) -> Self {
        // The eigenvectors of a matrix that is symmetric but for rounding are not orthogonal but for rounding.
        let symmetric = shift == shift.transpose();
        let eigen = if symmetric { shift.self_adjoint_eigen(Side::Lower).ok() } else { None };
        let spectrum = eigen.map(|eigen| {
            let (basis, eigenvalues) = (eigen.U().to_owned(), eigen.S().column_vector());
            let eigenvalues = Both::of(eigenvalues.iter().copied());
            [both(&basis), both(&basis.transpose().to_owned()), eigenvalues]
        });
        let (entries, transposed) = (both(&shift), both(&shift.transpose().to_owned()));
        let adapter_entries = both(&adapter);
        Graph { forms: Arc::new(Forms { shift, adapter, entries, transposed, adapter_entries, spectrum }) }
    }

    /// `N`.
    pub fn nodes(&self) -> usize {
        self.forms.shift.nrows()
    }

    /// `S`.
    pub fn shift(&self) -> &Mat<f64> {
        &self.forms.shift
    }

    /// `A_y`.
    pub fn adapter(&self) -> &Mat<f64> {
        &self.forms.adapter
    }

    /// In the precision of `T`.
    pub(crate) fn of<T: Real>(&self) -> GraphOf<'_, T> {
        let forms = &*self.forms;
        GraphOf {
            nodes: forms.shift.nrows(),
            shift: T::pick(&forms.entries),
            shift_transposed: T::pick(&forms.transposed),
            adapter: T::pick(&forms.adapter_entries),
            spectrum: forms.spectrum.as_ref().map(|[basis, basis_transposed, eigenvalues]| Spectrum {
                basis: T::pick(basis),
                basis_transposed: T::pick(basis_transposed),
                eigenvalues: T::pick(eigenvalues),
            }),
        }
    }
}

/// Row-major entries.
fn both(matrix: &Mat<f64>) -> Both {
    let columns = matrix.ncols();
    Both::of((0..matrix.nrows() * columns).map(|at| matrix[(at / columns, at % columns)]))
}
