//! Predicates over the points of a figure: each gives findings with their numbers.

use std::collections::BTreeMap;

use super::numbers::{Figure, Place, ratio};
use super::predicates::{Below, CLOSE, IN_GENERAL, Slope, Verdict, below, unsteadiness};
use crate::config::Method;
use crate::statistics::median;

/// A verdict on one subject, with the numbers that it rests on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Finding {
    pub(super) subject: String,
    pub(super) verdict: Verdict,
    pub(super) numbers: String,
}

impl Finding {
    fn new(subject: String, verdict: Verdict, numbers: String) -> Self {
        Finding { subject, verdict, numbers }
    }

    fn not_run(subject: String) -> Self {
        Finding::new(subject, Verdict::NotRun, String::new())
    }
}

fn named(panel: &str, name: &str) -> String {
    if panel == "all" { name.to_string() } else { format!("{panel}, {name}") }
}

/// Which of a panel's points were run, in words; nothing if all were.
fn gaps(run: &[&Place], all: usize) -> String {
    if run.len() == all {
        return String::new();
    }
    let xs: Vec<String> = run.iter().map(|place| place.x.to_string()).collect();
    format!(" (run at x = {} only)", xs.join(", "))
}

/// `method` is below minimum degeneracy at every point: one finding for each panel.
pub(super) fn below_at_every_point(figure: &Figure, method: Method, metric: &str) -> Vec<Finding> {
    let figure = &figure.comparing(&[method, Method::MinDegeneracy]);
    let of_panel = |panel: &&str| {
        let subject = named(panel, method.name());
        let places: Vec<&Place> = figure.of_panel(panel).collect();
        let ratios = |place: &Place| figure.log_ratios(method, Method::MinDegeneracy, place, metric);
        let points: Vec<(&Place, Below)> =
            places.iter().filter_map(|place| Some((*place, below(&ratios(place)?)))).collect();
        let Some((place, worst)) = points.iter().max_by(|a, b| a.1.ratio.total_cmp(&b.1.ratio)) else {
            return Finding::not_run(subject);
        };
        let missing = (points.len() < places.len()).then_some(Verdict::NotRun);
        let verdict = Verdict::all(points.iter().map(|(_, below)| below.verdict).chain(missing));
        let p = points.iter().map(|(_, below)| below.p).fold(0.0, f64::max);
        let run: Vec<&Place> = points.iter().map(|(place, _)| *place).collect();
        let numbers = format!(
            "median ratio to min-degeneracy at most {} (x = {}), sign test p at most {}, n = {}{}",
            short(worst.ratio),
            place.x,
            short(p),
            worst.n,
            gaps(&run, places.len())
        );
        Finding::new(subject, verdict, numbers)
    };
    figure.panels().iter().map(of_panel).collect()
}

/// `method` is below minimum degeneracy at four fifths of all points.
pub(super) fn in_general_below(figure: &Figure, method: Method, metric: &str) -> Vec<Finding> {
    let ratios = median_log_ratios(figure, method, metric);
    let subject = method.name().to_string();
    if ratios.is_empty() {
        return vec![Finding::not_run(subject)];
    }
    let below = ratios.iter().filter(|ratio| **ratio < 0.0).count();
    let complete = ratios.len() == figure.places.len();
    let holds = below as f64 >= IN_GENERAL * figure.places.len() as f64;
    let hopeless =
        ((figure.places.len() - ratios.len() + below) as f64) < IN_GENERAL * figure.places.len() as f64;
    let verdict = if complete || hopeless { Verdict::of(holds) } else { Verdict::NotRun };
    let numbers = format!("below at {below} of {} points run, of {}", ratios.len(), figure.places.len());
    vec![Finding::new(subject, verdict, numbers)]
}

/// The median log-ratio of `method` to minimum degeneracy at each point that was run.
fn median_log_ratios(figure: &Figure, method: Method, metric: &str) -> Vec<f64> {
    let figure = figure.comparing(&[method, Method::MinDegeneracy]);
    let at = |place| figure.log_ratios(method, Method::MinDegeneracy, place, metric).map(median);
    figure.places.iter().filter_map(at).collect()
}

/// The gain over minimum degeneracy, the median over all points, is smaller in `figure` than in `other`.
pub(super) fn smaller_ratio(figure: &Figure, other: &Figure, method: Method, metric: &str) -> Vec<Finding> {
    let gain = |figure: &Figure| {
        let ratios = median_log_ratios(figure, method, metric);
        (!ratios.is_empty()).then(|| (-median(ratios.clone()), ratios.len() == figure.places.len()))
    };
    let subject = method.name().to_string();
    let (Some((here, all_here)), Some((there, all_there))) = (gain(figure), gain(other)) else {
        return vec![Finding::not_run(subject)];
    };
    let verdict = if all_here && all_there { Verdict::of(here < there) } else { Verdict::NotRun };
    let numbers = format!(
        "min-degeneracy's error is {} times its own here and {} times in fig1, medians over points",
        short(here.exp()),
        short(there.exp())
    );
    vec![Finding::new(subject, verdict, numbers)]
}

/// The medians of all `methods` are within a factor 1.5 of each other at every point: one finding for each panel.
pub(super) fn no_difference(figure: &Figure, methods: &[Method], metric: &str) -> Vec<Finding> {
    let figure = &figure.comparing(methods);
    let judge = |medians: &[f64]| {
        let factor = unsteadiness(medians);
        (factor <= CLOSE, factor, format!("medians differ by a factor of up to {}", short(factor)))
    };
    let median = |method, place: &Place| figure.median(method, place, metric);
    let of_panel =
        |panel: &&str| at_every_point(figure, panel, metric, (*panel).into(), methods, median, judge);
    figure.panels().iter().map(of_panel).collect()
}

/// The first of `methods` has the largest median at every point: one finding for each panel.
pub(super) fn worst(figure: &Figure, methods: &[Method], metric: &str) -> Vec<Finding> {
    let figure = &figure.comparing(methods);
    let median = |method, place: &Place| figure.median(method, place, metric);
    let judge = |medians: &[f64]| {
        let others = medians[1..].iter().copied().fold(0.0, f64::max);
        let factor = 1.0 / ratio(others, medians[0]);
        (factor > 1.0, -factor, format!("at least {} times the next worst", short(factor)))
    };
    first_in_each_panel(figure, metric, methods, median, judge)
}

/// The first of `methods` has the smallest median at every point: one finding for each panel.
pub(super) fn best(figure: &Figure, methods: &[Method], metric: &str) -> Vec<Finding> {
    let figure = &figure.comparing(methods);
    let median = |method, place: &Place| figure.median(method, place, metric);
    let judge = |medians: &[f64]| {
        let least = medians[1..].iter().copied().fold(f64::INFINITY, f64::min);
        let factor = ratio(medians[0], least);
        (factor < 1.0, factor, format!("at most {} times the best other", short(factor)))
    };
    first_in_each_panel(figure, metric, methods, median, judge)
}

/// The standard deviation of the first of `methods` is the largest at every point of a panel.
pub(super) fn most_spread(figure: &Figure, panel: &str, methods: &[Method], metric: &str) -> Vec<Finding> {
    let figure = &figure.comparing(methods);
    let deviation = |method, place: &Place| figure.deviation(method, place, metric);
    let judge = |deviations: &[f64]| {
        let factor = 1.0 / ratio(deviations[1..].iter().copied().fold(0.0, f64::max), deviations[0]);
        (factor > 1.0, -factor, format!("at least {} times the next largest deviation", short(factor)))
    };
    let subject = named(panel, methods[0].name());
    vec![about_the_first(figure, panel, metric, subject, methods, deviation, judge)]
}

fn first_in_each_panel(
    figure: &Figure,
    metric: &str,
    methods: &[Method],
    value: impl Fn(Method, &Place) -> Option<f64>,
    judge: impl Fn(&[f64]) -> (bool, f64, String),
) -> Vec<Finding> {
    let of_panel = |panel: &&str| {
        about_the_first(figure, panel, metric, named(panel, methods[0].name()), methods, &value, &judge)
    };
    figure.panels().iter().map(of_panel).collect()
}

/// [`at_every_point`] at which the first of `methods` was run.
fn about_the_first(
    figure: &Figure,
    panel: &str,
    metric: &str,
    subject: String,
    methods: &[Method],
    value: impl Fn(Method, &Place) -> Option<f64>,
    judge: impl Fn(&[f64]) -> (bool, f64, String),
) -> Finding {
    let if_first = |method, place: &Place| value(methods[0], place).and_then(|_| value(method, place));
    at_every_point(figure, panel, metric, subject, methods, if_first, judge)
}

/// Judges the values of `methods` at every point of a panel where two of them or more were run; the point with the largest severity
/// is the one reported. What holds of some methods only may not hold of all; what does not hold of some does not hold of all.
fn at_every_point(
    figure: &Figure,
    panel: &str,
    metric: &str,
    subject: String,
    methods: &[Method],
    value: impl Fn(Method, &Place) -> Option<f64>,
    judge: impl Fn(&[f64]) -> (bool, f64, String),
) -> Finding {
    let places: Vec<&Place> = figure.of_panel(panel).collect();
    let mut run: Vec<&Place> = Vec::new();
    let mut verdicts: Vec<Verdict> = Vec::new();
    let mut reported: Option<(f64, String)> = None;
    for place in &places {
        let found: Vec<(Method, f64)> =
            methods.iter().filter_map(|method| Some((*method, value(*method, place)?))).collect();
        if found.len() < 2 {
            continue;
        }
        let (holds, severity, numbers) = judge(&found.iter().map(|(_, value)| *value).collect::<Vec<_>>());
        verdicts.push(match (holds, found.len() == methods.len()) {
            (true, false) => Verdict::NotRun,
            (holds, _) => Verdict::of(holds),
        });
        let absent: Vec<&str> = methods
            .iter()
            .filter(|method| found.iter().all(|(other, _)| other != *method))
            .map(|method| method.name())
            .collect();
        let without =
            if absent.is_empty() { String::new() } else { format!(", without {}", absent.join(", ")) };
        if reported.as_ref().is_none_or(|(most, _)| severity.total_cmp(most).is_ge()) {
            reported = Some((severity, format!("{numbers} (x = {}{without})", place.x)));
        }
        run.push(place);
    }
    let Some((_, numbers)) = reported else { return Finding::not_run(subject) };
    let missing = (run.len() < places.len()).then_some(Verdict::NotRun);
    Finding::new(
        subject,
        Verdict::all(verdicts.into_iter().chain(missing)),
        format!("{numbers}, n = {}{}", figure.compared(panel, metric), gaps(&run, places.len())),
    )
}

/// How the error goes with x: flat, or falling. One finding for each panel.
pub(super) fn trend(figure: &Figure, method: Method, metric: &str, falls: bool) -> Vec<Finding> {
    let of_panel = |panel: &&str| {
        let subject = named(panel, method.name());
        let places: Vec<&Place> = figure.of_panel(panel).collect();
        let run: Option<Vec<_>> = places.iter().map(|place| figure.at(method, place, metric)).collect();
        let Some(run) = run.filter(|run| !run.is_empty()) else { return Finding::not_run(subject) };
        let log_x = |at: usize| (places[at].x as f64).ln();
        let curve = |repetition: &usize| -> Option<Vec<(f64, f64)>> {
            let point = |(at, values): (usize, &&BTreeMap<usize, f64>)| {
                Some((log_x(at), values.get(repetition)?.ln()))
            };
            run.iter().enumerate().map(point).collect()
        };
        let curves: Vec<_> = run[0].keys().filter_map(curve).collect();
        let Some(line) = Slope::over(&curves) else { return Finding::not_run(subject) };
        let verdict = Verdict::of(if falls { line.falls() } else { line.is_flat() });
        let numbers = format!(
            "slope {:.2}, standard error {:.2}, n = {}",
            line.slope,
            line.standard_error,
            curves.len()
        );
        Finding::new(subject, verdict, numbers)
    };
    figure.panels().iter().map(of_panel).collect()
}

/// The unsteadiness of a method in a panel; none if a point is missing.
fn unsteadiness_of(figure: &Figure, panel: &str, method: Method, metric: &str) -> Option<f64> {
    let medians: Option<Vec<f64>> =
        figure.of_panel(panel).map(|place| figure.median(method, place, metric)).collect();
    medians.filter(|medians| !medians.is_empty()).map(|medians| unsteadiness(&medians))
}

/// Every one of `steady` is steadier than every one of `others`, two at a time: one finding for each panel. The pair is reported
/// in which the ratio of the two is largest.
pub(super) fn steadier(figure: &Figure, steady: &[Method], others: &[Method], metric: &str) -> Vec<Finding> {
    let pairs: Vec<(Method, Method)> =
        steady.iter().flat_map(|one| others.iter().map(move |other| (*one, *other))).collect();
    let of_panel = |panel: &&str| {
        let compare = |(one, other): &(Method, Method)| {
            let figure = figure.comparing(&[*one, *other]);
            let of = |method| unsteadiness_of(&figure, panel, method, metric);
            let (first, second) = (of(*one)?, of(*other)?);
            let n = figure.compared(panel, metric);
            let (one, other, factors) = (one.name(), other.name(), [first, second].map(short));
            let numbers = format!("{one} {} beside {other} {}, n = {n}", factors[0], factors[1]);
            Some((first < second, ratio(first, second), numbers))
        };
        let compared: Vec<(bool, f64, String)> = pairs.iter().filter_map(compare).collect();
        let Some((_, _, numbers)) = compared.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Finding::not_run((*panel).to_string());
        };
        let missing = (compared.len() < pairs.len()).then_some(Verdict::NotRun);
        let verdict = Verdict::all(compared.iter().map(|(holds, ..)| Verdict::of(*holds)).chain(missing));
        let numbers = format!("largest over smallest median: {numbers}");
        Finding::new((*panel).to_string(), verdict, numbers)
    };
    figure.panels().iter().map(of_panel).collect()
}

/// `method` is steadier in `figure` than in `other`: one finding for each panel.
pub(super) fn steadier_than_in(
    figure: &Figure,
    other: &Figure,
    method: Method,
    metric: &str,
) -> Vec<Finding> {
    let of_panel = |panel: &&str| {
        let subject = named(panel, method.name());
        let of = |figure: &Figure| unsteadiness_of(&figure.comparing(&[method]), panel, method, metric);
        let (Some(here), Some(there)) = (of(figure), of(other)) else { return Finding::not_run(subject) };
        let numbers = format!("largest over smallest median: {} here, {} there", short(here), short(there));
        Finding::new(subject, Verdict::of(here < there), numbers)
    };
    figure.panels().iter().map(of_panel).collect()
}

/// `method` relative to the median of `others`, medians over points, is smaller in `figure` than in `other`.
pub(super) fn relatively_better(
    figure: &Figure,
    other: &Figure,
    method: Method,
    others: &[Method],
    metric: &str,
) -> Vec<Finding> {
    let relative = |figure: &Figure| {
        let figure = figure.comparing(&[others, &[method]].concat());
        let at = |place: &Place| {
            let peers: Option<Vec<f64>> =
                others.iter().map(|other| figure.median(*other, place, metric)).collect();
            Some(ratio(figure.median(method, place, metric)?, median(peers?)))
        };
        let ratios: Vec<f64> = figure.places.iter().filter_map(at).collect();
        (ratios.len() == figure.places.len() && !ratios.is_empty()).then(|| median(ratios))
    };
    let subject = method.name().to_string();
    let (Some(here), Some(there)) = (relative(figure), relative(other)) else {
        return vec![Finding::not_run(subject)];
    };
    let numbers = format!("{} times the other learned ones here, {} in fig1", short(here), short(there));
    vec![Finding::new(subject, Verdict::of(here < there), numbers)]
}

/// At some point `method` is no better than minimum degeneracy.
pub(super) fn somewhere_no_better(figure: &Figure, method: Method, metric: &str) -> Vec<Finding> {
    let ratios = median_log_ratios(figure, method, metric);
    let subject = method.name().to_string();
    if ratios.is_empty() {
        return vec![Finding::not_run(subject)];
    }
    let largest = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let somewhere = ratios.iter().any(|ratio| ratio.is_nan() || *ratio >= 0.0);
    let verdict = match (somewhere, ratios.len() == figure.places.len()) {
        (true, _) => Verdict::Reproduced,
        (false, true) => Verdict::NotReproduced,
        (false, false) => Verdict::NotRun,
    };
    let numbers = format!("largest median ratio to min-degeneracy {}", short(largest.exp()));
    vec![Finding::new(subject, verdict, numbers)]
}

/// Three digits.
pub(super) fn short(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) {
        return format!("{value:.1e}");
    }
    format!("{value:.3}")
}
