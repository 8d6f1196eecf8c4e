//! Bulk normal, exponential and uniform numbers: distribution, tails, independence, and what they take of a stream.

use motes_models::{Seed, Stream, fill_standard_exponential, fill_standard_normal, fill_uniform};
use rand::Rng;

fn stream(label: &str) -> Stream {
    Seed::from_u64(90).child(label).stream()
}

/// Four million numbers in calls of several sizes, so that every way through the code is in them.
fn drawn(fill: fn(&mut Stream, &mut [f64]), label: &str) -> Vec<f64> {
    let mut stream = stream(label);
    let mut values = vec![f64::NAN; 1 << 22];
    let mut rest = values.as_mut_slice();
    for size in [1, 7, 16, 31, 32, 33, 100, 128, 500, 4096, 10_000].into_iter().cycle() {
        let (now, later) = rest.split_at_mut(size.min(rest.len()));
        fill(&mut stream, now);
        rest = later;
        if rest.is_empty() {
            break;
        }
    }
    values
}

/// `Φ(x)`, by the continued fraction of Mills' ratio or the series, whichever is short.
fn normal_cumulative(x: f64) -> f64 {
    let density = (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    if x.abs() < 3.0 {
        let (mut term, mut sum) = (x, x);
        for i in 1..100 {
            term *= x * x / (2 * i + 1) as f64;
            sum += term;
        }
        0.5 + density * sum
    } else {
        let ratio = (1..200).rev().fold(x.abs(), |below, i| x.abs() + i as f64 / below);
        let tail = density / ratio;
        if x > 0.0 { 1.0 - tail } else { tail }
    }
}

/// Kolmogorov and Smirnov's `√n sup |F_n − F|`, which is above 2.2 once in ten thousand times.
fn kolmogorov_smirnov(mut values: Vec<f64>, cumulative: impl Fn(f64) -> f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let distance = values.iter().enumerate().fold(0.0_f64, |largest, (i, &x)| {
        let f = cumulative(x);
        largest.max(f - i as f64 / n).max((i + 1) as f64 / n - f)
    });
    distance * n.sqrt()
}

fn assert_moment(name: &str, values: impl Iterator<Item = f64>, expected: f64, variance: f64, n: f64) {
    let z = (values.sum::<f64>() / n - expected) / (variance / n).sqrt();
    assert!(z.abs() < 4.0, "{name}: z = {z}");
}

#[test]
fn normals_are_normal() {
    let values = drawn(fill_standard_normal, "normal");
    let n = values.len() as f64;
    assert!(values.iter().all(|x| x.is_finite()));
    assert_moment("mean", values.iter().copied(), 0.0, 1.0, n);
    assert_moment("variance", values.iter().map(|x| x * x), 1.0, 2.0, n);
    assert_moment("third moment", values.iter().map(|x| x.powi(3)), 0.0, 15.0, n);
    assert_moment("fourth moment", values.iter().map(|x| x.powi(4)), 3.0, 96.0, n);
    for bound in [2.0, 3.0, 4.0, 4.5] {
        for side in [-1.0, 1.0] {
            let p = normal_cumulative(-bound);
            let beyond = values.iter().map(|x| f64::from(u8::from(side * x > bound)));
            assert_moment(&format!("share beyond {bound}"), beyond, p, p * (1.0 - p), n);
        }
    }
    let distance = kolmogorov_smirnov(values, normal_cumulative);
    assert!(distance < 2.2, "Kolmogorov–Smirnov {distance}");
}

#[test]
fn exponentials_and_uniforms_are_what_they_are_called() {
    let distance = kolmogorov_smirnov(drawn(fill_standard_exponential, "exponential"), |x| -(-x).exp_m1());
    assert!(distance < 2.2, "exponential: {distance}");
    let distance = kolmogorov_smirnov(drawn(fill_uniform, "uniform"), |x| x);
    assert!(distance < 2.2, "uniform: {distance}");
}

#[test]
fn normals_near_each_other_are_independent() {
    // Neighbours, members of a pair of Box and Muller's (8 and 64 apart), one generator's next (8), and one batch apart.
    let mut values = vec![0.0; 1 << 21];
    fill_standard_normal(&mut stream("neighbours"), &mut values);
    for lag in [1, 2, 8, 16, 32, 64, 128, 256] {
        let pairs = || values[lag..].iter().zip(&values);
        let n = (values.len() - lag) as f64;
        assert_moment(&format!("product at {lag}"), pairs().map(|(x, y)| x * y), 0.0, 1.0, n);
        let squares = pairs().map(|(x, y)| (x * x - 1.0) * (y * y - 1.0));
        assert_moment(&format!("squares at {lag}"), squares, 0.0, 4.0, n);
        let signs = pairs().map(|(x, y)| (x * x - 1.0) * y);
        assert_moment(&format!("square and value at {lag}"), signs, 0.0, 2.0, n);
    }
}

#[test]
fn what_is_taken_of_a_stream_is_what_is_documented() {
    let mut out = [0.0; 5000];
    for fill in [fill_standard_normal, fill_standard_exponential, fill_uniform] {
        for (count, bytes) in [(0, 0), (1, 128), (16, 128), (17, 256), (32, 256), (33, 256), (5000, 256)] {
            let (mut used, mut skipped) = (stream("position"), stream("position"));
            fill(&mut used, &mut out[..count]);
            let mut skip = vec![0; bytes];
            skipped.fill_bytes(&mut skip);
            assert_eq!(used.next_u64(), skipped.next_u64(), "{count}");
        }
    }
}
