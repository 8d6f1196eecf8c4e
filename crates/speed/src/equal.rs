//! Whether two contestants do the same work, by what they answer to a check.

use crate::task::Answer;

/// Of the same weights and noise, losses, norms of gradients and densities differ by rounding in 32 bits, relative to them.
const ROUNDING: f64 = 1e-5;

/// The mean log-evidences of filters that do the same differ by no more of their standard errors.
const STANDARD_ERRORS: f64 = 5.0;

/// What shows that the work of one is not that of the other, if anything does.
pub(crate) fn difference(ours: &Answer, theirs: &Answer) -> Option<String> {
    let loss = ("loss", ours.loss, theirs.loss);
    let norm = ("gradient norm", ours.gradient_norm, theirs.gradient_norm);
    let evidence = |answer: &Answer| answer.mean_log_evidence.zip(answer.log_evidence_error);
    let draws = |answer: &Answer| answer.mean_draw.zip(answer.mean_draw_error);
    if let (Some(mine), Some(its)) = (draws(ours), draws(theirs)) {
        return by_chance(mine, its).map(|by| format!("its mean draw differs from ours by {by}"));
    }
    match (evidence(ours), evidence(theirs)) {
        (Some(mine), Some(its)) => density(ours.loss, theirs.loss).or_else(|| {
            by_chance(mine, its).map(|by| format!("its mean log-evidence differs from ours by {by}"))
        }),
        (None, None) => [loss, norm].into_iter().find_map(|(name, mine, its)| match (mine, its) {
            (Some(mine), Some(its)) => {
                let equal = (its - mine).abs() <= ROUNDING * mine.abs();
                (!equal).then(|| format!("its {name} is {its}, ours {mine}"))
            }
            _ => Some(format!("its {name} is not known, or not ours")),
        }),
        _ => Some("one of us filters and the other trains".into()),
    }
}

/// By how much two means with their standard errors differ, if it is more than chance.
fn by_chance((mine, error): (f64, f64), (its, its_error): (f64, f64)) -> Option<String> {
    let (difference, error) = (its - mine, error.hypot(its_error));
    // Written so that what is not a number is a difference.
    let equal = difference.abs() <= STANDARD_ERRORS * error;
    (!equal).then(|| format!("{difference} ± {error}"))
}

/// What shows that filters draw from other proposals, where they say how likely these find fixed states.
fn density(mine: Option<f64>, its: Option<f64>) -> Option<String> {
    let equal = match (mine, its) {
        (None, None) => true,
        (Some(mine), Some(its)) => (its - mine).abs() <= ROUNDING * mine.abs(),
        _ => false,
    };
    (!equal).then(|| format!("its proposal finds states {its:?} likely, ours {mine:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter(log_evidence: f64, error: f64) -> Answer {
        let (mean_log_evidence, log_evidence_error) = (Some(log_evidence), Some(error));
        Answer { mean_log_evidence, log_evidence_error, ..Answer::default() }
    }

    fn training(loss: f64, norm: f64) -> Answer {
        Answer { loss: Some(loss), gradient_norm: Some(norm), ..Answer::default() }
    }

    #[test]
    fn rounding_and_chance_are_no_difference() {
        assert_eq!(difference(&filter(-50.0, 0.3), &filter(-51.0, 0.4)), None);
        assert_eq!(difference(&training(427.0, 33.0), &training(427.002, 33.0001)), None);
    }

    #[test]
    fn filters_with_other_proposals_do_other_work() {
        let with = |loss| Answer { loss, ..filter(-50.0, 0.3) };
        assert_eq!(difference(&with(Some(2.0)), &with(Some(2.00001))), None);
        for theirs in [Some(2.0001), Some(f64::NAN), None] {
            assert!(difference(&with(Some(2.0)), &with(theirs)).is_some(), "{theirs:?}");
        }
    }

    #[test]
    fn draws_are_equal_where_their_means_are() {
        let drawn =
            |mean, error| Answer { mean_draw: Some(mean), mean_draw_error: Some(error), ..Answer::default() };
        assert_eq!(difference(&drawn(8.0, 0.01), &drawn(8.03, 0.01)), None);
        for theirs in [drawn(8.1, 0.01), drawn(f64::NAN, 0.01), filter(8.0, 0.01), Answer::default()] {
            assert!(difference(&drawn(8.0, 0.01), &theirs).is_some(), "{theirs:?}");
        }
    }

    #[test]
    fn other_work_is() {
        for theirs in [filter(-53.0, 0.4), filter(f64::NAN, 0.4), training(427.0, 33.0), Answer::default()] {
            assert!(difference(&filter(-50.0, 0.3), &theirs).is_some(), "{theirs:?}");
        }
        for theirs in [training(427.01, 33.0), training(427.0, 33.001), training(427.0, f64::NAN)] {
            assert!(difference(&training(427.0, 33.0), &theirs).is_some(), "{theirs:?}");
        }
        let without_gradient = Answer { gradient_norm: None, ..training(427.0, 33.0) };
        assert!(difference(&training(427.0, 33.0), &without_gradient).is_some());
        assert!(difference(&Answer::default(), &Answer::default()).is_some());
    }
}
