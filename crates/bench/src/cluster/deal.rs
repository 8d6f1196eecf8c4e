//! Units dealt to tasks: shares of about the same length, and what units have in common computed by few.

use std::collections::BTreeMap;

use crate::unit::UnitConfig;

/// The numbers of the units of each task, for at most `tasks` tasks, none of which is empty.
///
/// Units with the same proposal that is learned once go to one task: it is not learned twice. Units with the same reference do as long as they are
/// no more than its share. The longest pieces are dealt first, each to the task that has least: no task is then longer
/// than 4/3 of the best that these pieces allow (Graham 1969).
pub(super) fn deal(units: &[&UnitConfig], seconds: &[f64], tasks: usize) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<(bool, String), Vec<usize>> = BTreeMap::new();
    for (number, unit) in units.iter().enumerate() {
        groups.entry(in_common(unit)).or_default().push(number);
    }
    let share = seconds.iter().sum::<f64>() / tasks as f64;
    let mut pieces: Vec<(f64, Vec<usize>)> = Vec::new();
    for ((is_learned_once, _), group) in groups {
        let share = if is_learned_once { f64::INFINITY } else { share };
        let (mut length, mut piece) = (0.0, Vec::new());
        for number in group {
            if !piece.is_empty() && length + seconds[number] > share {
                pieces.push((std::mem::take(&mut length), std::mem::take(&mut piece)));
            }
            length += seconds[number];
            piece.push(number);
        }
        pieces.push((length, piece));
    }
    // Stable: pieces of one length keep the order of their keys, so that the same units are dealt in the same way.
    pieces.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    let mut dealt: Vec<(f64, Vec<usize>)> = vec![(0.0, Vec::new()); tasks.min(pieces.len())];
    for (length, piece) in pieces {
        let least = dealt.iter_mut().min_by(|(one, of_one), (other, of_other)| {
            one.total_cmp(other).then(of_one.len().cmp(&of_other.len()))
        });
        let Some((sum, numbers)) = least else { break };
        *sum += length;
        numbers.extend(piece);
    }
    dealt.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    dealt.into_iter().map(|(_, numbers)| numbers).collect()
}

/// The key of what a unit shares with others, and whether that is a proposal.
fn in_common(unit: &UnitConfig) -> (bool, String) {
    match (unit.learned_once(), unit.reference_key()) {
        (Some((key, _)), _) => (true, key),
        (None, Some(key)) => (false, key),
        (None, None) => (false, unit.key()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Learning;
    use crate::learned_once::{LearnedOnce, OnceFamily};
    use crate::method_config::MethodConfig;
    use crate::unit::tests::unit;
    use motes_proposals::{AmortisedConfig, Backend, Sees};

    const LEARNING: &str = r#"
        horizon = 12
        learning_rate = 0.001
        rows = 64
        base = "transition"
        head = { kind = "gaussian", covariance = "shared" }
        elbo = { particles = 8, sequences = 1, steps_for_one = 1, trajectories = 8 }
    "#;

    fn units(count: usize) -> Vec<UnitConfig> {
        (0..count).map(|repetition| UnitConfig { repetition, ..unit(10, 12, 10) }).collect()
    }

    #[test]
    fn every_unit_has_one_task() {
        let units = units(23);
        let units: Vec<&UnitConfig> = units.iter().collect();
        let seconds: Vec<f64> = (0..23).map(|number| 1.0 + f64::from(number)).collect();
        for tasks in [1, 4, 23, 100] {
            let shares = deal(&units, &seconds, tasks);
            assert_eq!(shares.len(), tasks.min(23));
            assert!(shares.iter().all(|share| !share.is_empty()));
            let mut all = shares.concat();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..23));
        }
    }

    #[test]
    fn shares_are_about_as_long() {
        let units = units(40);
        let units: Vec<&UnitConfig> = units.iter().collect();
        let seconds: Vec<f64> = (0..40).map(|number| f64::from(1 + number % 7)).collect();
        let lengths = deal(&units, &seconds, 6)
            .into_iter()
            .map(|share| share.into_iter().map(|number| seconds[number]).sum::<f64>());
        let longest = lengths.fold(0.0, f64::max);
        let best = seconds.iter().sum::<f64>() / 6.0;
        assert!(longest <= 4.0 / 3.0 * best, "{longest} where {best} is best");
    }

    #[test]
    fn a_proposal_that_is_learned_once_is_learned_by_one_task() {
        let learning: Learning = toml::from_str(LEARNING).unwrap();
        let (base, head) = (learning.base, learning.head);
        let family = OnceFamily::Fcnn(AmortisedConfig {
            widths: vec![4],
            sees: Sees::All,
            base,
            head,
            ..AmortisedConfig::gaussian()
        });
        let once = LearnedOnce { family, learning, steps: 5, backend: Backend::Native };
        let once = UnitConfig { method: MethodConfig::Once(Box::new(once)), ..unit(10, 12, 10) };
        let units: Vec<UnitConfig> =
            (0..8).map(|repetition| UnitConfig { repetition, ..once.clone() }).collect();
        let units: Vec<&UnitConfig> = units.iter().collect();
        assert_eq!(deal(&units, &[1.0; 8], 4).len(), 1);
    }

    #[test]
    fn units_of_one_reference_stay_together_unless_they_are_too_many() {
        let with = |repetition, particles| {
            let mut unit = UnitConfig { repetition, reference_particles: Some(100), ..unit(10, 12, 10) };
            unit.filter.particles = particles;
            unit
        };
        let units: Vec<UnitConfig> =
            (0..3).flat_map(|repetition| [10, 20].map(|particles| with(repetition, particles))).collect();
        let units: Vec<&UnitConfig> = units.iter().collect();
        for share in deal(&units, &[1.0; 6], 3) {
            let [one, other] = share[..] else { panic!("{share:?}") };
            assert_eq!(units[one].repetition, units[other].repetition);
        }
        assert_eq!(deal(&units, &[1.0; 6], 6).len(), 6);
    }
}
