//! Random geometric graphs: points on the unit square, each joined to its nearest others.

use faer::{Mat, MatRef, Side};
use rand::RngExt;

use crate::{ModelError, Stream};

/// A weighted, symmetric, connected nearest-neighbour graph of random points.
#[derive(Debug, Clone)]
pub struct RandomGeometricGraph {
    adjacency: Mat<f64>,
}

impl RandomGeometricGraph {
    /// Draws `nodes` points uniformly on the unit square and joins each to its `neighbours` nearest others
    /// with weight `exp(−‖rᵢ − rⱼ‖²)`.
    ///
    /// The directed graph is averaged with its transpose and divided by its spectral norm. It has no self-loops. It is drawn
    /// again until it is connected.
    ///
    /// # Errors
    /// [`ModelError::Parameter`] unless `1 ≤ neighbours < nodes`, or if none of a thousand draws was connected.
    pub fn draw(nodes: usize, neighbours: usize, stream: &mut Stream) -> Result<Self, ModelError> {
        const MOST_DRAWS: usize = 1000;
        if neighbours == 0 || neighbours >= nodes {
            return Err(ModelError::Parameter {
                name: "number of neighbours",
                value: format!("{neighbours} for {nodes} nodes"),
                expected: "at least 1 and below the number of nodes",
            });
        }
        for _ in 0..MOST_DRAWS {
            let points: Vec<[f64; 2]> = (0..nodes).map(|_| stream.random()).collect();
            let mut adjacency = nearest_neighbour_weights(&points, neighbours);
            if is_connected(adjacency.as_ref()) {
                let norm = spectral_norm(adjacency.as_ref())?;
                adjacency /= faer::Scale(norm);
                return Ok(RandomGeometricGraph { adjacency });
            }
        }
        Err(ModelError::Parameter {
            name: "number of neighbours",
            value: format!("{neighbours} for {nodes} nodes"),
            expected: "enough for the graph to be connected, which none of a thousand draws was",
        })
    }

    /// The weighted adjacency matrix, symmetric with spectral norm 1 (`N×N`).
    pub fn adjacency(&self) -> MatRef<'_, f64> {
        self.adjacency.as_ref()
    }
}

/// Gaussian-kernel weights to the nearest other nodes, averaged with the transpose.
fn nearest_neighbour_weights(points: &[[f64; 2]], neighbours: usize) -> Mat<f64> {
    let nodes = points.len();
    let squared_distance =
        |i: usize, j: usize| (points[i][0] - points[j][0]).powi(2) + (points[i][1] - points[j][1]).powi(2);
    let mut weights = Mat::zeros(nodes, nodes);
    for i in 0..nodes {
        let mut others: Vec<usize> = (0..nodes).filter(|&j| j != i).collect();
        others.sort_by(|&a, &b| squared_distance(i, a).total_cmp(&squared_distance(i, b)));
        for &j in &others[..neighbours] {
            let half = 0.5 * (-squared_distance(i, j)).exp();
            weights[(i, j)] += half;
            weights[(j, i)] += half;
        }
    }
    weights
}

fn is_connected(adjacency: MatRef<'_, f64>) -> bool {
    let nodes = adjacency.nrows();
    let mut reached = vec![false; nodes];
    let mut frontier = vec![0];
    reached[0] = true;
    while let Some(i) = frontier.pop() {
        for j in 0..nodes {
            if adjacency[(i, j)] != 0.0 && !reached[j] {
                reached[j] = true;
                frontier.push(j);
            }
        }
    }
    reached.into_iter().all(|reached| reached)
}

/// The largest absolute eigenvalue of a symmetric matrix.
fn spectral_norm(symmetric: MatRef<'_, f64>) -> Result<f64, ModelError> {
    let eigenvalues =
        symmetric.self_adjoint_eigenvalues(Side::Lower).map_err(|error| ModelError::Numerical {
            computation: "eigenvalues of an adjacency matrix",
            time: 0,
            reason: format!("{error:?}"),
        })?;
    Ok(eigenvalues.iter().fold(0.0, |norm: f64, value| norm.max(value.abs())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Seed;

    #[test]
    fn the_graph_is_what_the_protocol_says() {
        for nodes in [10, 25, 50] {
            let mut stream = Seed::from_u64(3).child("graph").stream();
            let graph = RandomGeometricGraph::draw(nodes, 3, &mut stream).unwrap();
            let a = graph.adjacency();
            assert!(is_connected(a));
            assert!((spectral_norm(a).unwrap() - 1.0).abs() < 1e-12);
            for i in 0..nodes {
                assert_eq!(a[(i, i)], 0.0);
                let degree = (0..nodes).filter(|&j| a[(i, j)] > 0.0).count();
                assert!(degree >= 3, "node {i} has {degree} neighbours");
                assert!((0..nodes).all(|j| a[(i, j)] == a[(j, i)]));
            }
        }
    }

    #[test]
    fn weights_follow_the_kernel_of_the_distance() {
        // Four points on a line: with one neighbour each, 0–1 and 2–3 choose each other.
        let points = [[0.0, 0.0], [0.1, 0.0], [0.5, 0.0], [0.65, 0.0]];
        let weights = nearest_neighbour_weights(&points, 1);
        assert!((weights[(0, 1)] - (-0.01_f64).exp()).abs() < 1e-15);
        assert!((weights[(2, 3)] - (-0.0225_f64).exp()).abs() < 1e-15);
        assert_eq!(weights[(1, 2)], 0.0);
        assert!(!is_connected(weights.as_ref()));
        // With two, 0 and 3 reach past their twin, and one-sided choices count half.
        let weights = nearest_neighbour_weights(&points, 2);
        assert!((weights[(0, 2)] - 0.5 * (-0.25_f64).exp()).abs() < 1e-15);
        assert!(is_connected(weights.as_ref()));
    }

    #[test]
    fn an_impossible_number_of_neighbours_is_refused() {
        let mut stream = Seed::from_u64(1).stream();
        assert!(RandomGeometricGraph::draw(3, 3, &mut stream).is_err());
        assert!(RandomGeometricGraph::draw(3, 0, &mut stream).is_err());
    }
}
