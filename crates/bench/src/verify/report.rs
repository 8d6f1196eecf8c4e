//! verdict.md: a table of verdicts, and below it the numbers of each.

use std::collections::BTreeMap;

use super::claims::{Claim, Judgement};
use super::numbers::{ENOUGH, Figure, METRICS};
use super::predicates::{CLOSE, IN_GENERAL, Verdict};

/// In the place of a verdict that there is none of.
const NONE: &str = "–";

/// The report as Markdown.
pub(super) fn report(profile: &str, figures: &BTreeMap<&str, Figure>, claims: &[Claim]) -> String {
    let mut text = format!("# The paper's claims, held against runs of profile {profile}\n\n");
    if profile != "paper" {
        text += "**This profile trains far less than the protocol does: these verdicts say nothing about the paper.**\n\n";
    }
    text += "Made by `cargo xtask verify`. A claim is judged on the error of the estimate averaged over all filter runs \
             (`nmse_final`, the paper's metric) and on that of a single run (`nmse_final_single`), of table 1 on the errors of S, I and R together, \
             paired over repetitions:\n\n";
    text += &format!(
        "- *below*: median log-ratio below 0 and a one-sided sign test with p < 0.05, at every point; *in general below*: median \
         log-ratio below 0 at {}% of the points;\n\
         - *independent of x*: the slope of log error on log x, the mean over repetitions, is less than 2 standard errors from 0; \
         *improves*: it is more than 2 below 0;\n\
         - *by a smaller ratio*: the gain, minus the median log-ratio to minimum degeneracy, the median over points, is smaller than in figure 1;\n\
         - *steadier*: a smaller ratio of the largest to the smallest median over K, for each of the one sort than for each of the other, two at a time;\n\
         - *best*, *worst*, *largest standard deviation*: of medians or standard deviations, at every point; *relatively better*: the \
         ratio to the median of the other learned ones' medians, the median over points, is smaller;\n\
         - *at some K no better*: a median log-ratio of 0 or more at one point; no test, so that a method that is level is no better;\n\
         - *close*, *no significant difference*: medians within a factor {CLOSE};\n\
         - a comparison is over the repetitions that all its methods have in a panel, at least {ENOUGH} or all that the profile has;\n\
         - one point that contradicts a claim, or one method that does, is enough for *not reproduced*; otherwise one that is \
         missing, or has too few repetitions for the test, makes it *not run*. A unit that failed counts as an infinite error.\n\n",
        (100.0 * IN_GENERAL).round()
    );
    text += "| figure | the paper says | averaged | single run |\n|---|---|---|---|\n";
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for claim in claims {
        for part in &claim.parts {
            let cells: Vec<&str> =
                match part.judgements.iter().any(|of| METRICS.contains(&of.metric.as_str())) {
                    true => part.judgements.iter().map(|judgement| judgement.verdict().name()).collect(),
                    // Judged on metrics of its own, all of which must hold.
                    false => {
                        vec![Verdict::all(part.judgements.iter().map(Judgement::verdict)).name(), NONE]
                    }
                };
            for cell in cells.iter().filter(|cell| **cell != NONE) {
                *counts.entry(cell).or_default() += 1;
            }
            text += &format!("| {} | {} | {} |\n", claim.figure, part.says, cells.join(" | "));
        }
    }
    let counts: Vec<String> = counts.iter().map(|(name, count)| format!("{count} {name}")).collect();
    text += &format!("\nOf these judgements: {}.\n", counts.join(", "));
    for claim in claims {
        text += &format!("\n## {}", claim.figure);
        text += "\n";
        if !figures[claim.figure].was_run {
            text += "\nNot run.\n";
            continue;
        }
        for part in &claim.parts {
            text +=
                &format!("\n**{}**\n\n| metric | of | verdict | numbers |\n|---|---|---|---|\n", part.says);
            for judgement in &part.judgements {
                for finding in &judgement.findings {
                    let (subject, verdict) = (&finding.subject, finding.verdict.name());
                    text +=
                        &format!("| {} | {subject} | {verdict} | {} |\n", judgement.metric, finding.numbers);
                }
            }
        }
    }
    text
}
