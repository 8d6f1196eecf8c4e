//! The numbers of an experiment file: each in its range, or named.

mod epidemic;
mod learning;
mod proposals;

use motes_cli::one_of;
use motes_models::Noise;
use motes_train::Schedule;

use super::args::MOST_REPETITIONS;
use super::checks::Checks;
use super::densities::Densities;
use super::error::ConfigError;
use super::method::Method;
use super::schema::{Axis, Estimand, Experiment, Gradient, Profile, System};

/// Checks every number that a run would use, for all profiles.
pub(super) fn check(file: &str, experiment: &Experiment) -> Result<(), ConfigError> {
    let checks = Checks { file };
    let Experiment { axis, methods, system, epidemic, filter, training, proposals, panels, profiles, .. } =
        experiment;
    match (system, epidemic) {
        (Some(system), None) => {
            checks.system(system)?;
            let over_time = experiment.series.is_some();
            checks.that(!over_time, "series", "there", "only an [epidemic] is shown over time")?;
            let printed = !experiment.printed.is_empty();
            checks.that(!printed, "printed", "there", "the paper prints numbers of its [epidemic] only")?;
        }
        (None, Some(epidemic)) => {
            let expected = "smoothed states of an [epidemic] have no reference to be held against";
            checks.that(experiment.estimand.is_of_filters(), "estimand", "smoothing", expected)?;
            checks.epidemic(experiment, epidemic)?;
        }
        (None, None) => {
            checks.that(false, "system", "absent", "a file describes a [system] or an [epidemic]")?
        }
        (Some(_), Some(_)) => {
            checks.that(
                false,
                "epidemic",
                "there",
                "a file describes a [system] or an [epidemic], not both",
            )?;
        }
    }
    checks.count("filter.particles", filter.particles)?;
    let fraction = filter.ess_threshold > 0.0 && filter.ess_threshold <= 1.0;
    checks.that(
        fraction,
        "filter.ess_threshold",
        filter.ess_threshold,
        "it must be above 0 and at most 1",
    )?;
    if let Some(weight) = filter.defensive_weight {
        let fine = weight > 0.0 && weight < 1.0;
        let expected = "it must be between 0 and 1, both excluded";
        checks.that(fine, "filter.defensive_weight", weight, expected)?;
    }
    checks.positive_in_32_bits("training.learning_rate", training.learning_rate)?;
    checks.positive_in_32_bits("training.epsilon", training.epsilon)?;
    let changes = training.schedule != Some(Schedule::Constant);
    let expected = "a learning rate that does not change has no schedule: leave it out";
    checks.that(changes, "training.schedule", "constant", expected)?;
    for (key, value) in [("beta_1", training.beta_1), ("beta_2", training.beta_2)] {
        let fine = (0.0..1.0).contains(&(value as f32));
        checks.that(fine, &format!("training.{key}"), value, "it must be at least 0 and below 1")?;
    }
    match (training.gradient, training.gradient_window) {
        (Gradient::Full, Some(window)) => {
            let expected = "a full gradient has no window: leave it out, or set gradient = \"truncated\"";
            checks.that(false, "training.gradient_window", window, expected)?;
        }
        (Gradient::Truncated, window) => {
            let value = window.map_or("absent".to_string(), |window| window.to_string());
            let expected = "a truncated gradient needs a window of at least 1";
            checks.that(
                window.is_some_and(|window| window > 0),
                "training.gradient_window",
                value,
                expected,
            )?;
        }
        (Gradient::Full, None) => {}
    }
    let clip_norm = training.clip_norm.unwrap_or(1.0);
    let fine = clip_norm > 0.0 && clip_norm.is_finite();
    checks.that(fine, "training.clip_norm", clip_norm, "it must be positive and finite")?;
    // What is off is left out: a file and its unit keys say one thing in one way.
    let penalty = training.weight_penalty.unwrap_or(1.0);
    let fine = penalty > 0.0 && penalty.is_finite();
    checks.that(fine, "training.weight_penalty", penalty, "it must be positive and finite, or left out")?;
    if let Some(dropout) = training.dropout {
        let fine = dropout > 0.0 && dropout < 1.0;
        let expected = "it must be between 0 and 1, both excluded, or left out";
        checks.that(fine, "training.dropout", dropout, expected)?;
        let expected = "the method psi has no units that can be left out";
        let is_psi = |method: &Method| matches!(method, Method::Psi | Method::PsiAnchored);
        checks.that(!methods.iter().any(is_psi), "training.dropout", dropout, expected)?;
    }
    proposals.check(&checks)?;
    if let Some(learning) = &experiment.learning {
        checks.learning(experiment, learning)?;
    }

    checks.distinct("methods", methods.iter().map(|method| method.name().to_string()))?;
    for method in methods {
        checks.method(experiment, *method)?;
    }
    checks.distinct("panels", panels.iter().map(|panel| panel.name.clone()))?;
    let dimension = experiment.sizes().map_or(0, |(dimension, _)| dimension);
    for panel in panels {
        let key = format!("panels.{}.dimension", panel.name);
        match (system, panel.dimension) {
            (Some(system), Some(dimension)) => checks.system_of(system, dimension, &key)?,
            (Some(system), None) => checks.system_of(system, dimension, "system.dimension")?,
            (None, Some(dimension)) => {
                checks.that(false, &key, dimension, "an epidemic has three coordinates")?
            }
            (None, None) => {}
        }
    }
    // Panels differ in N or in densities: units of equal configuration would be one and the same.
    let own = system.as_ref().map(|system| system.densities);
    let own = own.or_else(|| epidemic.as_ref().map(|epidemic| epidemic.densities));
    let differences = panels.iter().map(|panel| {
        let densities = panel.densities.or(own).unwrap_or(Densities::Gaussian);
        match densities {
            Densities::Gaussian => panel.dimension.unwrap_or(dimension).to_string(),
            Densities::Exact => format!("{} with exact densities", panel.dimension.unwrap_or(dimension)),
        }
    });
    checks.distinct("panels.*.dimension", differences)?;
    let one_panel = *axis != Axis::Dimension || panels.len() == 1;
    checks.that(
        one_panel,
        "panels",
        panels.len(),
        "where the x axis is the dimension there must be one panel",
    )?;
    for (name, profile) in profiles {
        let key = |key: &str| format!("profiles.{name}.{key}");
        checks.distinct(&key("x"), profile.x.iter().map(usize::to_string))?;
        for &x in &profile.x {
            checks.count(&key("x"), x)?;
            checks.memory(&key("x"), x, experiment, profile)?;
            if let (Axis::Dimension, Some(system)) = (axis, system) {
                checks.system_of(system, x, &key("x"))?;
            }
        }
        checks.within(&key("repetitions"), profile.repetitions, 1, MOST_REPETITIONS)?;
        checks.count(&key("filter_runs"), profile.filter_runs)?;
        checks.count(&key("training_steps"), profile.training_steps)?;
        checks.count(&key("reference_particles"), profile.reference_particles)?;
        profile.sizes.check(name, &checks)?;
        if methods.contains(&Method::LookAheadLearned) {
            let found = profile.potential_steps.map_or("absent".to_string(), |steps| steps.to_string());
            let fine = profile.potential_steps.is_some_and(|steps| steps > 0);
            let expected = "the method look-ahead-learned needs it: at least 1";
            checks.that(fine, &key("potential_steps"), found, expected)?;
        }
        let on_graph = methods.iter().find(|method| method.is_on_graph());
        if let (Some(method), None) = (on_graph, &profile.sizes.gnn) {
            let expected = format!("the method {} needs it", method.name());
            checks.that(false, &key("sizes.gnn"), "absent", &expected)?;
        }
        if let Some(chosen) = &profile.panels {
            checks.distinct(&key("panels"), chosen.iter().cloned())?;
            for panel in chosen {
                let names = panels.iter().map(|panel| panel.name.as_str());
                let known = names.clone().any(|name| name == panel);
                checks.that(known, &key("panels"), panel, &one_of(panel, names))?;
            }
        }
    }
    Ok(())
}

/// As many numbers as a machine may hold: 400 GB of them.
const MOST_NUMBERS: u128 = 50_000_000_000;
/// Numbers of coordinates of which matrices are made.
const MOST_COORDINATES: usize = 65_536;

impl Checks<'_> {
    /// What the filters of a unit hold at once, and what is recorded of them over time.
    fn memory(
        &self,
        key: &str,
        x: usize,
        experiment: &Experiment,
        profile: &Profile,
    ) -> Result<(), ConfigError> {
        let Some((dimension, horizon)) = experiment.sizes() else { return Ok(()) };
        let of_panels = experiment.panels.iter().filter_map(|panel| panel.dimension).chain([dimension]);
        let (mut n, mut t, mut k) =
            (of_panels.max().unwrap_or(dimension), horizon, experiment.filter.particles);
        match experiment.axis {
            Axis::Particles => k = x,
            Axis::Horizon => t = x,
            Axis::Dimension => n = x,
        }
        let [n, t, k, runs, of_references] =
            [n, t, k, profile.filter_runs, profile.reference_particles].map(|number| number as u128);
        let numbers = n * (runs * (k + t) + of_references);
        let expected =
            format!("filter_runs·(K + T)·N and reference_particles·N must not exceed {MOST_NUMBERS} numbers");
        self.that(numbers <= MOST_NUMBERS, key, x, &expected)
    }

    /// The optimiser computes in 32 bits.
    pub(super) fn positive_in_32_bits(&self, key: &str, value: f64) -> Result<(), ConfigError> {
        let fine = value as f32 > 0.0 && (value as f32).is_finite();
        self.that(fine, key, format!("{value:?}"), "it must be positive and finite in 32 bits")
    }

    fn system(&self, system: &System) -> Result<(), ConfigError> {
        self.count("system.neighbours", system.neighbours)?;
        self.count("system.dimension", system.dimension)?;
        self.count("system.horizon", system.horizon)?;
        let decibels = (-200.0..=200.0).contains(&system.snr_db);
        self.that(decibels, "system.snr_db", system.snr_db, "it must be a number of dB from -200 to 200")
    }

    /// What a method needs beside what every experiment has.
    fn method(&self, experiment: &Experiment, method: Method) -> Result<(), ConfigError> {
        let Experiment { epidemic, proposals, reference, .. } = experiment;
        let name = method.name();
        if method.is_on_graph() {
            let expected = format!("an epidemic has no graph, which {name} needs");
            self.that(epidemic.is_none(), "methods", name, &expected)?;
            let expected = format!("the method {name} needs it");
            self.that(proposals.gnn.is_some(), "proposals.gnn", "absent", &expected)?;
            let is_set = method == Method::Gnn || proposals.gnn_short_steps.is_some();
            self.that(is_set, "proposals.gnn-short-steps", "absent", &expected)?;
        }
        if method.is_anchored() {
            let there = proposals.standardised.is_some();
            self.that(there, "proposals.standardised", "absent", "anchored methods need it")?;
        }
        if proposals.standardised.is_some() {
            let expected =
                "networks work in the units of simulated trajectories only where the system is an [epidemic]";
            self.that(epidemic.is_some(), "proposals.standardised", "there", expected)?;
        }
        if method.looks_ahead() {
            let is_smoothing = experiment.estimand == Estimand::Smoothing;
            let is_gaussian = experiment.system.as_ref().is_some_and(|system| {
                system.noise == Noise::Gaussian || system.densities == Densities::Gaussian
            });
            let expected = "only Gaussian densities on a graph can be looked ahead of here";
            self.that(is_gaussian, "methods", name, expected)?;
            let expected = "at each time its weights say what comes later: it needs estimand = \"smoothing\"";
            self.that(is_smoothing, "methods", name, expected)?;
        }
        if method.is_reference() {
            self.that(epidemic.is_some(), "methods", name, "only an [epidemic] has reference methods")?;
            self.that(reference.is_some(), "reference", "absent", "reference methods need it")?;
        }
        Ok(())
    }

    /// N against what the graph and the measurement matrix need of it.
    fn system_of(&self, system: &System, dimension: usize, key: &str) -> Result<(), ConfigError> {
        self.within(key, dimension, 1, MOST_COORDINATES)?;
        let enough = dimension > system.neighbours;
        self.that(enough, key, dimension, &format!("N must exceed the {} neighbours", system.neighbours))?;
        let half = 2 * system.unmeasured <= dimension;
        self.that(
            half,
            "system.unmeasured",
            system.unmeasured,
            &format!("it must be at most half of N = {dimension}"),
        )
    }
}
