//! The metrics that figures show.

/// A row of plots: which metric, what its axis says, and whether the axis is logarithmic.
pub(super) struct Metric {
    pub(super) name: &'static str,
    pub(super) label: &'static str,
    pub(super) logarithmic: bool,
}

/// All metrics, in the order of rows.
pub(super) const METRICS: [Metric; 10] = [
    Metric { name: "log_evidence_mse", label: "squared error of log ẑ", logarithmic: true },
    Metric { name: "nmse_smoothed_single", label: "NMSE, smoothed, one run", logarithmic: true },
    Metric { name: "nmse_final", label: "NMSE, last time", logarithmic: true },
    Metric { name: "nmse_posterior", label: "NMSE to posterior mean", logarithmic: true },
    Metric { name: "nmse_all", label: "NMSE, all times", logarithmic: true },
    Metric { name: "mse_S", label: "squared error of S", logarithmic: true },
    Metric { name: "mse_I", label: "squared error of I", logarithmic: true },
    Metric { name: "mse_R", label: "squared error of R", logarithmic: true },
    Metric { name: "ess", label: "effective sample size", logarithmic: false },
    Metric { name: "lost_runs", label: "runs that lost all weight", logarithmic: false },
];
