//! What a process can be asked to do.

use crate::task::Answer;

/// Something to be done again and again.
pub(crate) trait Work {
    fn check(&mut self) -> Result<Answer, String>;
    fn run(&mut self) -> Result<(), String>;
}

/// What a check of filters answers: the mean of their log-evidences, and its standard error.
pub(crate) fn of_evidences(found: &[f64]) -> Answer {
    let count = found.len() as f64;
    let mean = found.iter().sum::<f64>() / count;
    let variance = found.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let log_evidence_error = Some((variance / count).sqrt());
    Answer { mean_log_evidence: Some(mean), log_evidence_error, ..Answer::default() }
}
