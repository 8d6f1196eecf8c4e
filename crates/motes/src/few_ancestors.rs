//! Warning where a smoother's trajectories rest on a few particles.

use motes_smc::SmoothedPaths;

use crate::warning::Warning;

/// As few particles at a time say little of a distribution.
const FEW: f64 = 20.0;

/// Below how many distinct particles at a time `paths` trajectories have collapsed; none if nothing is said of so few.
///
/// `B` trajectories that come from `K` particles of equal weight at random pass through `K (1 − (1 − 1/K)^B)` of them on average. Where half of that is less
/// than 20, it is what few paths can be held to. Of few particles, unequal weights leave a quarter at least.
fn fewest(paths: usize, particles: usize) -> Option<usize> {
    if paths < 2 {
        return None;
    }
    let k = particles as f64;
    let at_random = k * (1.0 - (1.0 - 1.0 / k).powf(paths as f64));
    // All paths in one particle are said in any case, for then figures are missing.
    Some((at_random / 2.0).min(k / 4.0).min(FEW).ceil().max(2.0) as usize)
}

/// What is to be said of trajectories that were drawn from a filter of so many particles; `label` is what the data call a time.
pub(crate) fn of_paths<'a>(
    series: Option<&str>,
    paths: &SmoothedPaths,
    particles: usize,
    label: impl Fn(usize) -> Option<&'a str>,
) -> Option<Warning> {
    let fewest = fewest(paths.len(), particles)?;
    let at: Vec<usize> = (0..paths.times()).filter(|time| paths.distinct_particles(*time) < fewest).collect();
    let (first, last) = (*at.first()?, *at.last()?);
    let worst = at.iter().copied().min_by_key(|time| paths.distinct_particles(*time))?;
    let least = paths.distinct_particles(worst);
    let called = |time: usize| {
        let label = label(time).map_or_else(String::new, |label| format!(" ({label})"));
        format!("t = {time}{label}")
    };
    let place = match (at.len(), first) {
        (1, _) => format!("at {}", called(last)),
        (count, 0) if count == last + 1 => format!("up to {}", called(last)),
        (count, _) => format!("at {count} times from {} to {}", called(first), called(last)),
    };
    let missing = match least {
        1 => "; where it is 1 particle, standard deviations and quantiles cannot be given",
        _ => "",
    };
    let why = match paths.follow_ancestors() {
        true => " (they follow the filter's ancestors: the transition has no density to draw others by)",
        false => "",
    };
    let remedy = if (paths.len() as f64) < 2.0 * FEW { "more particles or paths" } else { "more particles" };
    let text = format!(
        "{place} all {} paths pass through fewer than {fewest} particles ({least} at t = {worst}){why}: means there rest on them, standard deviations are too \
         small, later ones too of states that hardly change{missing}; take {remedy}",
        paths.len()
    );
    Some(Warning { series: series.map(String::from), text })
}

#[cfg(test)]
mod tests {
    use super::fewest;

    #[test]
    fn few_is_less_than_chance_leaves() {
        assert_eq!(fewest(200, 1000), Some(20));
        assert_eq!(fewest(1_000_000, 1_000_000_000), Some(20));
        // Few paths or particles pass through few.
        assert_eq!(fewest(10, 1000), Some(5));
        assert_eq!(fewest(500, 10), Some(3));
        assert_eq!([fewest(1, 1000), fewest(2, 1000), fewest(500, 1)], [None, Some(2), Some(2)]);
    }
}
