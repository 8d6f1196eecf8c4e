//! Which matrices read hidden units: what dropout asks of networks.

/// A matrix whose rows read the units of a hidden layer, and nothing else.
///
/// Row `r` reads unit `r mod H`, where the matrix has `copies · H` rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HiddenReader {
    /// Its index among the parameters.
    pub matrix: usize,
    /// The index of the matrix that the layer's values come from: it tells layers apart, and readers of one layer read the same units.
    pub fed_by: usize,
    /// How often the units are repeated down the rows: the taps of a graph filter, or the nodes of a graph; 1 elsewhere.
    pub copies: usize,
}

impl HiddenReader {
    /// One of a fully connected layer.
    pub fn plain(matrix: usize, fed_by: usize) -> Self {
        HiddenReader { matrix, fed_by, copies: 1 }
    }
}
