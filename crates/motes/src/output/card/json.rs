//! The report card as JSON.

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::comparing::{Card, Comparison, Figure, Paired};

/// The keys of a proposal's figures.
#[derive(Serialize)]
struct CardObject {
    ess_fraction: Option<f64>,
    ess_fraction_q01: Option<f64>,
    log_evidence_gap: Option<f64>,
    e_l: Option<f64>,
    e_x: Option<f64>,
    pareto_k: Option<f64>,
    coverage_50: Option<f64>,
    coverage_90: Option<f64>,
    particle_steps_per_second: f64,
    ms_per_step: f64,
    lost: usize,
    /// Half the widths of the intervals of means.
    half_widths: HalfWidths,
}

#[derive(Serialize)]
struct HalfWidths {
    ess_fraction: Option<f64>,
    log_evidence_gap: Option<f64>,
    e_l: Option<f64>,
    e_x: Option<f64>,
}

fn mean(figure: Option<Figure>) -> Option<f64> {
    figure.map(|figure| figure.mean)
}

fn half_width(figure: Option<Figure>) -> Option<f64> {
    figure.and_then(|figure| figure.half_width)
}

impl From<&Card> for CardObject {
    fn from(card: &Card) -> Self {
        // One that collapsed has no evidence.
        let gap = card.log_evidence_gap.filter(|_| card.lost == 0);
        CardObject {
            ess_fraction: mean(card.ess_fraction),
            ess_fraction_q01: card.ess_fraction_q01,
            log_evidence_gap: mean(gap),
            e_l: mean(card.e_l),
            e_x: mean(card.e_x),
            pareto_k: card.pareto_k,
            coverage_50: card.coverage_50,
            coverage_90: card.coverage_90,
            particle_steps_per_second: card.particle_steps_per_second,
            ms_per_step: card.ms_per_step,
            lost: card.lost,
            half_widths: HalfWidths {
                ess_fraction: half_width(card.ess_fraction),
                log_evidence_gap: half_width(gap),
                e_l: half_width(card.e_l),
                e_x: half_width(card.e_x),
            },
        }
    }
}

/// Differences from the baseline.
fn paired_object(paired: &Paired) -> Value {
    json!({
        "ess_fraction": mean(paired.ess_fraction),
        "log_evidence": mean(paired.log_evidence),
        "half_widths": {
            "ess_fraction": half_width(paired.ess_fraction),
            "log_evidence": half_width(paired.log_evidence),
        },
    })
}

/// The object of a comparison: the figures of each method by its name, differences from one of them, error against time, and how long it took to learn.
pub fn card_json(comparison: &Comparison, training_seconds: Option<f64>) -> String {
    let methods: Map<String, Value> = comparison
        .cards
        .iter()
        .map(|(name, card)| {
            (name.to_string(), serde_json::to_value(CardObject::from(card)).unwrap_or(Value::Null))
        })
        .collect();
    let paired = comparison.paired.as_ref().map(|(baseline, paired)| {
        let methods: Map<String, Value> =
            paired.iter().map(|paired| (paired.contender.to_string(), paired_object(paired))).collect();
        json!({ "less": baseline.to_string(), "methods": methods })
    });
    let points = comparison.equal_time.points.iter().map(|point| {
        json!({
            "method": point.contender.name(),
            "particles": point.particles,
            "ms_per_step": point.ms_per_step,
            "log_evidence_rmse": point.error(),
        })
    });
    let reached: Map<String, Value> = comparison
        .equal_time
        .reaching(1.0)
        .into_iter()
        .map(|(name, reached)| (name.to_string(), json!(reached.ms())))
        .collect();
    let gains = comparison.equal_time.gains().map(|(over, gains)| {
        let gains = gains.iter().map(|gain| {
            let [low, high] = gain.interval.map_or([None; 2], |ends| ends.map(Some));
            (gain.contender.to_string(), json!({ "ratio": gain.ratio, "low": low, "high": high }))
        });
        json!({ "over": over.name(), "methods": gains.collect::<Map<String, Value>>() })
    });
    let object = json!({
        "methods": methods,
        "training_seconds": training_seconds,
        "reference": comparison.reference,
        "reference_errors": comparison.reference_errors,
        "paired": paired,
        "equal_time": points.collect::<Vec<_>>(),
        "gains": gains,
        "ms_per_step_for_error_1": reached,
    });
    object.to_string() + "\n"
}
