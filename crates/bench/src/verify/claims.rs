//! The paper's claims, each as the predicates that were fixed for it beforehand.

use std::collections::BTreeMap;

use super::judge::{
    Finding, below_at_every_point, best, in_general_below, most_spread, no_difference, relatively_better,
    smaller_ratio, somewhere_no_better, steadier, steadier_than_in, trend, worst,
};
use super::numbers::{Figure, METRICS, STATES};
use super::predicates::Verdict;
use crate::config::Method::{self, Fcnn, Gnn, Psi, Rnn};

/// One claim: a figure and what the paper says of it.
pub(super) struct Claim {
    pub(super) figure: &'static str,
    pub(super) parts: Vec<Part>,
}

/// A part of a claim.
pub(super) struct Part {
    pub(super) says: &'static str,
    /// One for each metric that it is judged on.
    pub(super) judgements: Vec<Judgement>,
}

/// A part judged on one metric.
pub(super) struct Judgement {
    pub(super) metric: String,
    pub(super) findings: Vec<Finding>,
}

impl Judgement {
    pub(super) fn verdict(&self) -> Verdict {
        Verdict::all(self.findings.iter().map(|finding| finding.verdict))
    }
}

/// The figures that claims are about.
pub(super) const FIGURES: [&str; 7] = ["fig1", "fig2", "fig3", "fig4", "fig5", "fig6", "table1"];

const LEARNED: [Method; 4] = [Fcnn, Rnn, Gnn, Psi];

/// Judges all claims.
pub(super) fn claims(figures: &BTreeMap<&str, Figure>) -> Vec<Claim> {
    let of = |name: &str| &figures[name];
    let (fig1, fig4) = (of("fig1"), of("fig4"));
    let below = |figure| {
        part("the four learned proposals are below minimum degeneracy", |metric| {
            each(&LEARNED, |method| below_at_every_point(figure, method, metric))
        })
    };
    let gnn_worst =
        |figure| part("gnn is the worst of the four", |metric| worst(figure, &[Gnn, Fcnn, Rnn, Psi], metric));
    let smaller = |figure| {
        part("by a smaller ratio than in fig1", |metric| {
            each(&LEARNED, |method| smaller_ratio(figure, fig1, method, metric))
        })
    };
    let mut claims = vec![
        claim(
            "fig1",
            vec![
                below(fig1),
                part("no significant difference between fcnn, rnn and psi", |metric| {
                    no_difference(fig1, &[Fcnn, Rnn, Psi], metric)
                }),
                part("psi has the largest standard deviation of these at N = 50", |metric| {
                    most_spread(fig1, "N50", &[Psi, Fcnn, Rnn], metric)
                }),
                gnn_worst(fig1),
            ],
        ),
        claim(
            "fig2",
            vec![
                below(of("fig2")),
                part("rnn is independent of T", |metric| trend(of("fig2"), Rnn, metric, false)),
                part("fcnn and psi improve with T", |metric| {
                    each(&[Fcnn, Psi], |method| trend(of("fig2"), method, metric, true))
                }),
                gnn_worst(of("fig2")),
            ],
        ),
        claim(
            "fig3",
            vec![
                below(of("fig3")),
                part("fcnn, rnn and psi are independent of N", |metric| {
                    each(&[Fcnn, Rnn, Psi], |method| trend(of("fig3"), method, metric, false))
                }),
                gnn_worst(of("fig3")),
            ],
        ),
        claim(
            "fig4",
            vec![
                part("the learned proposals are in general below minimum degeneracy", |metric| {
                    each(&LEARNED, |method| in_general_below(fig4, method, metric))
                }),
                smaller(fig4),
                part("rnn and gnn are steadier in K than fcnn and psi", |metric| {
                    steadier(fig4, &[Rnn, Gnn], &[Fcnn, Psi], metric)
                }),
                part("gnn is relatively better than in fig1", |metric| {
                    relatively_better(fig4, fig1, Gnn, &[Fcnn, Rnn, Psi], metric)
                }),
                part("fcnn and psi are at some K no better than minimum degeneracy", |metric| {
                    each(&[Fcnn, Psi], |method| somewhere_no_better(fig4, method, metric))
                }),
            ],
        ),
    ];
    for name in ["fig5", "fig6"] {
        let figure = of(name);
        claims.push(claim(
            name,
            vec![
                below(figure),
                smaller(figure),
                part("fcnn is steadier in K than in fig4", |metric| {
                    steadier_than_in(figure, fig4, Fcnn, metric)
                }),
                part("psi is the least steady", |metric| steadier(figure, &[Fcnn, Rnn, Gnn], &[Psi], metric)),
                part("rnn is the steadiest", |metric| steadier(figure, &[Rnn], &[Fcnn, Gnn, Psi], metric)),
                part("psi is close to minimum degeneracy as N grows (N = 50)", |metric| {
                    let mut found = no_difference(figure, &[Psi, Method::MinDegeneracy], metric);
                    found.retain(|finding| finding.subject == "N50");
                    found
                }),
            ],
        ));
    }
    claims.push(table1(of("table1")));
    claims
}

/// The epidemic model is judged on the squared error of each state.
fn table1(table: &Figure) -> Claim {
    let on = |says, metrics: &[&str], judge: &dyn Fn(&str) -> Vec<Finding>| Part {
        says,
        judgements: metrics
            .iter()
            .map(|metric| Judgement { metric: (*metric).into(), findings: judge(metric) })
            .collect(),
    };
    let rnn: Vec<Finding> =
        STATES.iter().flat_map(|metric| below_at_every_point(table, Rnn, metric)).collect();
    let somewhere_not = match Verdict::all(rnn.iter().map(|finding| finding.verdict)) {
        Verdict::Reproduced => Verdict::NotReproduced,
        Verdict::NotReproduced => Verdict::Reproduced,
        Verdict::NotRun => Verdict::NotRun,
    };
    let numbers = rnn.iter().map(|finding| finding.numbers.as_str()).filter(|numbers| !numbers.is_empty());
    let numbers = numbers.collect::<Vec<_>>().join("; ");
    let rnn = Finding { subject: "rnn".into(), verdict: somewhere_not, numbers };
    claim(
        "table1",
        vec![
            on("fcnn is best on S and I", &STATES[..2], &|metric| {
                best(table, &[Fcnn, Method::MinDegeneracy, Rnn, Psi], metric)
            }),
            on("psi is best on R", &STATES[2..], &|metric| {
                best(table, &[Psi, Method::MinDegeneracy, Fcnn, Rnn], metric)
            }),
            on("fcnn and psi are below minimum degeneracy on every state", &STATES, &|metric| {
                each(&[Fcnn, Psi], |method| below_at_every_point(table, method, metric))
            }),
            Part {
                says: "rnn is not below minimum degeneracy on every state",
                judgements: vec![Judgement { metric: STATES.join(", "), findings: vec![rnn] }],
            },
        ],
    )
}

fn claim(figure: &'static str, parts: Vec<Part>) -> Claim {
    Claim { figure, parts }
}

fn part(says: &'static str, judge: impl Fn(&str) -> Vec<Finding>) -> Part {
    let judgements =
        METRICS.iter().map(|metric| Judgement { metric: (*metric).into(), findings: judge(metric) });
    Part { says, judgements: judgements.collect() }
}

fn each(methods: &[Method], judge: impl Fn(Method) -> Vec<Finding>) -> Vec<Finding> {
    methods.iter().flat_map(|method| judge(*method)).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::numbers::Place;
    use super::*;

    /// A figure of one panel in which every method's error at every x and repetition is given.
    fn figure(panel: &str, xs: &[usize], error: impl Fn(Method, usize, usize) -> f64) -> Figure {
        let places: Vec<Place> = xs.iter().map(|x| Place { panel: panel.into(), x: *x }).collect();
        let mut values = BTreeMap::new();
        for method in [Method::MinDegeneracy, Fcnn, Rnn, Gnn, Psi] {
            for place in &places {
                for metric in METRICS {
                    let key = (method.name().to_string(), place.clone(), metric.to_string());
                    let of = |repetition| (repetition, error(method, place.x, repetition));
                    values.insert(key, (0..20).map(of).collect());
                }
            }
        }
        Figure::of(places, values)
    }

    fn verdicts(figures: BTreeMap<&'static str, Figure>, of: &str) -> Vec<Verdict> {
        let mut all: BTreeMap<&str, Figure> = FIGURES.iter().map(|name| (*name, Figure::default())).collect();
        all.extend(figures);
        let claims = claims(&all);
        let parts = claims.iter().filter(|claim| claim.figure == of).flat_map(|claim| &claim.parts);
        parts.map(|part| part.judgements[0].verdict()).collect()
    }

    /// Differs from repetition to repetition, the more the larger `width`.
    fn scatter(repetition: usize, width: f64) -> f64 {
        (width * (repetition as f64 - 9.5) / 20.0).exp()
    }

    #[test]
    fn a_world_as_the_paper_describes_it_is_reproduced_and_its_opposite_is_not() {
        let as_claimed = |method, _x, repetition| match method {
            Method::MinDegeneracy => 1.0,
            Gnn => 0.3 * scatter(repetition, 0.1),
            Psi => 0.1 * scatter(repetition, 0.4),
            _ => 0.1 * scatter(repetition, 0.1),
        };
        let fig1 = figure("N50", &[10, 20, 30], as_claimed);
        assert_eq!(verdicts([("fig1", fig1)].into(), "fig1"), [Verdict::Reproduced; 4]);
        let opposite = figure("N50", &[10, 20, 30], |method, x, repetition| match method {
            Psi => 0.3 * scatter(repetition, 0.01),
            Method::MinDegeneracy => 0.01,
            _ => as_claimed(method, x, repetition),
        });
        let found = verdicts([("fig1", opposite)].into(), "fig1");
        assert_eq!(found[..3], [Verdict::NotReproduced; 3]);
        assert_eq!(verdicts([].into(), "fig1"), [Verdict::NotRun; 4]);
    }

    #[test]
    fn trends_are_told_from_their_absence() {
        let fig2 = figure("all", &[12, 16, 20, 24, 28], |method, x, repetition| {
            let x = x as f64;
            match method {
                Method::MinDegeneracy => 1.0,
                Rnn => 0.1 * scatter(repetition, 1.0),
                Gnn => 0.5,
                _ => 0.1 * (12.0 / x).powi(2) * scatter(repetition, 0.2),
            }
        });
        assert_eq!(verdicts([("fig2", fig2)].into(), "fig2"), [Verdict::Reproduced; 4]);
        let flat = figure("all", &[12, 16, 20], |_, _, repetition| scatter(repetition, 1.0));
        let found = verdicts([("fig2", flat)].into(), "fig2");
        assert_eq!(found[0], Verdict::NotReproduced);
        assert_eq!(found[1], Verdict::Reproduced);
        assert_eq!(found[2], Verdict::NotReproduced);
    }

    #[test]
    fn a_method_with_few_repetitions_takes_none_from_the_others() {
        // With K the error of psi grows, that of fcnn falls in late repetitions only.
        let steadiest = |gnn: f64| {
            let mut fig5 = figure("N10", &[10, 20], |method, x, repetition| match (method, x) {
                (Gnn, 20) => gnn,
                (Psi, 20) => 3.0,
                (Fcnn, 20) if repetition >= 5 => 0.5,
                _ => 1.0,
            });
            for ((method, ..), values) in &mut fig5.values {
                values.retain(|repetition, _| method != "gnn" || *repetition < 5);
            }
            verdicts([("fig5", fig5)].into(), "fig5")[4]
        };
        assert_eq!(steadiest(1.1), Verdict::Reproduced);
        assert_eq!(steadiest(1.0), Verdict::NotReproduced, "level is not steadier");
    }

    #[test]
    fn a_method_that_was_not_run_leaves_a_comparison_open_unless_the_others_contradict_it() {
        let without_rnn = |gnn: f64, psi: fn(usize) -> f64| {
            let mut fig1 = figure("N50", &[10, 20], |method, _, repetition| match method {
                Method::MinDegeneracy => 1.0,
                Gnn => gnn,
                Psi => psi(repetition),
                _ => 0.1 * scatter(repetition, 0.1),
            });
            fig1.values.retain(|(method, ..), _| method != "rnn");
            verdicts([("fig1", fig1)].into(), "fig1")[1..].to_vec()
        };
        let as_claimed = without_rnn(0.3, |repetition| 0.1 * scatter(repetition, 0.4));
        assert_eq!(as_claimed, [Verdict::NotRun; 3]);
        let opposite = without_rnn(0.01, |_| 0.2);
        assert_eq!(opposite, [Verdict::NotReproduced; 3]);
        let infinite = without_rnn(f64::INFINITY, |_| f64::INFINITY);
        assert_eq!(infinite[2], Verdict::NotReproduced, "one of two that failed is not the worst");
    }

    #[test]
    fn a_point_that_was_not_run_leaves_a_claim_open_unless_another_contradicts_it() {
        let missing = |error: f64| {
            let mut fig1 = figure("N50", &[10, 20], |method, _, _| match method {
                Method::MinDegeneracy => 1.0,
                _ => error,
            });
            fig1.values.retain(|(method, place, _), _| method != "gnn" || place.x == 10);
            verdicts([("fig1", fig1)].into(), "fig1")[0]
        };
        assert_eq!(missing(0.5), Verdict::NotRun);
        assert_eq!(missing(2.0), Verdict::NotReproduced);
    }
}
