//! Means of numbers that are given by their logarithms.

/// The mean of positive numbers given by their logarithms, such as unbiased estimates of a likelihood: its logarithm, how far that may be off, and what each number
/// has of the sum.
///
/// The logarithm of a mean is too low on average, by about half of the square of its standard error.
///
/// ```
/// use motes_inference::LogMean;
///
/// let mean = LogMean::of(&[-1000.0, -1000.0 + 3.0_f64.ln()]);
/// assert!((mean.log() - (-1000.0 + 2.0_f64.ln())).abs() < 1e-12);
/// assert!((mean.shares()[1] - 0.75).abs() < 1e-12);
/// assert!((mean.standard_error().ok_or("one number")? - 0.5).abs() < 1e-12);
/// # Ok::<(), &str>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LogMean {
    log: f64,
    shares: Vec<f64>,
}

impl LogMean {
    /// That of `N` numbers by their logarithms, −∞ for 0. It is NaN of none, and where one of them is.
    pub fn of(logs: &[f64]) -> Self {
        let count = logs.len() as f64;
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if largest == f64::NEG_INFINITY && !logs.iter().any(|log| log.is_nan()) {
            let log = if logs.is_empty() { f64::NAN } else { largest };
            return LogMean { log, shares: vec![1.0 / count; logs.len()] };
        }
        let ratios: Vec<f64> = logs.iter().map(|log| (log - largest).exp()).collect();
        let sum: f64 = ratios.iter().sum();
        LogMean {
            log: largest + (sum / count).ln(),
            shares: ratios.into_iter().map(|ratio| ratio / sum).collect(),
        }
    }

    /// `log (1/N) Σ zᵢ`; −∞ where all are 0.
    pub fn log(&self) -> f64 {
        self.log
    }

    /// `zᵢ/Σ z` (`N`), which add up to 1; equal ones where all are 0.
    pub fn shares(&self) -> &[f64] {
        &self.shares
    }

    /// `1/Σ shares²`, between 1 and `N`: how many numbers count.
    pub fn effective(&self) -> f64 {
        1.0 / self.shares.iter().map(|share| share * share).sum::<f64>()
    }

    /// The standard error of the logarithm, to first order that of the mean over the mean: `√(Σ (N·shareᵢ − 1)²/(N(N − 1)))`. It is at most 1, which is where one
    /// number is all of the sum. None of fewer than two numbers, and where all are 0.
    pub fn standard_error(&self) -> Option<f64> {
        let count = self.shares.len() as f64;
        let squares: f64 = self.shares.iter().map(|share| (share * count - 1.0).powi(2)).sum();
        (self.shares.len() > 1 && self.log > f64::NEG_INFINITY)
            .then(|| (squares / (count * (count - 1.0))).sqrt())
    }
}
