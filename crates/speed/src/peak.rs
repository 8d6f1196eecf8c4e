//! What the machine can do at most: the fastest large product of f32 matrices, and the fastest way through memory.

use std::time::Instant;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

/// What limits arithmetic and what limits traffic.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(crate) struct Peak {
    /// Floating-point operations a second of the product.
    pub(crate) product: Rates,
    /// Bytes a second, read and written, of adding a long vector to another.
    pub(crate) memory: Rates,
}

/// So much a second.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(crate) struct Rates {
    /// On one thread while nothing else of ours runs.
    pub(crate) one_thread: f64,
    /// On each of two at once, added up.
    pub(crate) two_threads: f64,
}

const WIDTH: usize = 1024;

/// Numbers of a vector that no cache holds: 128 MB.
const LONG: usize = 1 << 25;

/// The best of several products and sums, on one thread and on two.
pub(crate) fn measure() -> Peak {
    let rates = |best: fn() -> f64| Rates { one_thread: best(), two_threads: on_two_threads(best) };
    Peak { product: rates(product), memory: rates(memory) }
}

/// The best of several products on two threads now: there are minutes in which a machine is half as fast as in others.
pub(crate) fn product_on_two_threads() -> f64 {
    on_two_threads(product)
}

fn on_two_threads(best: fn() -> f64) -> f64 {
    std::thread::scope(|scope| {
        let other = scope.spawn(best);
        let mine = best();
        mine + other.join().unwrap_or(0.0)
    })
}

fn product() -> f64 {
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

fn memory() -> f64 {
    let (mut sums, terms) = (vec![0.5_f32; LONG], vec![0.25_f32; LONG]);
    let bytes = (3 * LONG * size_of::<f32>()) as f64;
    let rate = |_| {
        let start = Instant::now();
        for (sum, term) in sums.iter_mut().zip(&terms) {
            *sum += term;
        }
        std::hint::black_box(&mut sums);
        bytes / start.elapsed().as_secs_f64()
    };
    (0..20).map(rate).fold(0.0, f64::max)
}
