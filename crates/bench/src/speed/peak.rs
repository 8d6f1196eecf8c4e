//! What the machine can do at most: the fastest large product of f32 matrices.

use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// Floating-point operations a second.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(super) struct Peak {
    /// On one thread while nothing else of ours runs.
    pub(super) one_thread: f64,
    /// On each of two at once, added up.
    pub(super) two_threads: f64,
}

const WIDTH: usize = 1024;

/// The best of several products on one thread and on two.
pub(super) fn measure() -> Peak {
    let two = std::thread::scope(|scope| {
        let other = scope.spawn(best);
        let mine = best();
        mine + other.join().unwrap_or(0.0)
    });
    Peak { one_thread: best(), two_threads: two }
}

fn best() -> f64 {
    let a = Mat::<f32>::from_fn(WIDTH, WIDTH, |i, j| ((i * 7 + j * 3) % 11) as f32 * 0.1);
    let mut product = Mat::<f32>::zeros(WIDTH, WIDTH);
    let operations = 2.0 * (WIDTH as f64).powi(3);
    let rate = |_| {
        let start = Instant::now();
        matmul(&mut product, Accum::Replace, &a, &a, 1.0, Par::Seq);
        operations / start.elapsed().as_secs_f64()
    };
    (0..20).map(rate).fold(0.0, f64::max)
}
