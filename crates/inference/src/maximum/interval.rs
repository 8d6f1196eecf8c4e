//! Intervals by profiles of the likelihood, wider by what its estimates do not tell (Ionides, Breto, Park, Smith and King, 2017).

use motes_models::equations::normal_quantile;

use super::point::{Maximum, Profile, ProfilePoint};
use super::quadratic::Quadratic;

/// Whether a height is so low, with its standard error, that an interval ends before.
pub(super) fn is_low(best: &Maximum, (height, error): (f64, f64), level: f64) -> bool {
    let z = normal_quantile(0.5 + 0.5 * level);
    best.log_likelihood - height > z * z + 3.0 * error
}

/// The interval that follows from points of the profile of coordinate `at`, which are spread in units of `sd`. A point at which the likelihood is 0 is the last one on its side, and is left
/// out of the profile.
pub(super) fn interval(
    mut found: Vec<ProfilePoint>,
    best: &Maximum,
    at: usize,
    sd: f64,
    level: f64,
) -> Profile {
    found.sort_by(|a, b| a.v.total_cmp(&b.v));
    let top_at = best.v[at];
    let end = |side: f64| {
        let mut there: Vec<&ProfilePoint> =
            found.iter().filter(|point| side * (point.v - top_at) > 0.0).collect();
        there.sort_by(|a, b| (side * a.v).total_cmp(&(side * b.v)));
        let points = there.iter().map(|point| DropPoint::of(point, best, top_at));
        top_at + side * reach(points.collect(), delta(&found, best, at, sd, level))
    };
    let (low, high) = (end(-1.0), end(1.0));
    found.retain(|point| point.log_likelihood.is_finite());
    Profile { at, low, high, points: found }
}

/// How far below its top the profile is at the ends of the interval: `½ z²`, and more by how far the top itself may lie from where it was found, by the curvature of a quadratic that is
/// like the profile.
fn delta(found: &[ProfilePoint], best: &Maximum, at: usize, sd: f64, level: f64) -> f64 {
    let z = normal_quantile(0.5 + 0.5 * level);
    let half = 0.5 * z * z;
    if found.iter().all(|point| point.standard_error == 0.0 || !point.log_likelihood.is_finite()) {
        return half;
    }
    // Weights as they would be of a profile that is known at its top above all.
    let weighted = |point: &ProfilePoint| {
        let error = point.standard_error;
        let weight = (-0.25 * (best.log_likelihood - point.log_likelihood).max(0.0)).exp();
        (vec![(point.v - best.v[at]) / sd], point.log_likelihood, weight / (error * error + 0.05))
    };
    let points: Vec<_> =
        found.iter().filter(|point| point.log_likelihood.is_finite()).map(weighted).collect();
    let Some(fitted) = Quadratic::fit(&points) else { return half };
    let curvature = (-fitted.curvature[(0, 0)]).max(1e-3);
    let centre = (fitted.b[0] / curvature).clamp(-1.0, 1.0);
    let error = fitted.slope_error_at(&[centre], 0) / curvature;
    half * (1.0 + curvature * error * error)
}

/// A point on one side of the top, by the root of how far it is below: a line where the profile is a parabola.
struct DropPoint {
    distance: f64,
    root: f64,
    weight: f64,
}

impl DropPoint {
    fn of(point: &ProfilePoint, best: &Maximum, top_at: f64) -> Self {
        let drop = (best.log_likelihood - point.log_likelihood).max(0.0);
        let error = point.standard_error;
        let weight = if drop.is_finite() { 1.0 / (error * error + 1e-6) } else { 1.0 };
        DropPoint { distance: (point.v - top_at).abs(), root: drop.sqrt(), weight }
    }
}

/// How far from the top the profile is `δ` below it on one side: between points, which are in the order of their distance, the root of the drop is a line. Points that rise again are noise, and become one level with those before. Where
/// nothing is as low, the last point.
fn reach(points: Vec<DropPoint>, delta: f64) -> f64 {
    let mut levels: Vec<DropPoint> = Vec::new();
    for point in points {
        let mut last = point;
        while let Some(before) = levels.pop_if(|before| before.root > last.root) {
            let weight = before.weight + last.weight;
            let mean = |a: f64, b: f64| (before.weight * a + last.weight * b) / weight;
            let distance = mean(before.distance, last.distance);
            last = DropPoint { distance, root: mean(before.root, last.root), weight };
        }
        levels.push(last);
    }
    let (wanted, mut before) = (delta.sqrt(), (0.0, 0.0));
    for DropPoint { distance, root, .. } in &levels {
        if *root >= wanted {
            let share = if root.is_finite() { (wanted - before.1) / (root - before.1) } else { 1.0 };
            return before.0 + share * (distance - before.0);
        }
        before = (*distance, *root);
    }
    before.0
}
