//! `motes fit`.

use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use motes::output::{
    FitReport, MaximumReport, Output, fit_json, fit_report, fit_summary, fit_text, maximum_json,
    maximum_report, maximum_summary, maximum_text,
};
use motes::{
    Data, DataError, FitFolder, FitOptions, FitRecord, Model, ModelNames, MotesError, Warning, at_prior_draw,
    fit_from, maximise, on_threads,
};
use motes_cli::{Interrupt, status};
use serde::Serialize;

use super::failure::Failure;
use super::fit_args::{FitArgs, Method};
use super::fit_states::{FitStates, StateRequest};
use super::input;
use super::progress::Progress;
use super::say::{say_ignored, warn, write};
use super::spinner::Spinner;
use super::summary::{command_line, in_one_line};

/// Where a fit stands is written down so often at most, and so seldom that writing is at most this share of the work.
const EVERY: (Duration, u32) = (Duration::from_millis(200), 50);

pub(super) fn run(args: &FitArgs, interrupt: &Interrupt) -> Result<u8, Failure> {
    let model = args.model.read_beside(Some(&args.data))?;
    let options = args.options(&model)?;
    let data = data(args, &model, interrupt)?;
    say_ignored(&data.columns, args.model.quiet);
    if let Some(path) = &args.report {
        let output = Output::File(path.clone());
        output.check().map_err(|source| MotesError::Output { file: output.name(), source })?;
    }
    let ahead = args.inputs.as_ref().map(|path| Data::open_inputs(path, &model)).transpose()?;
    let ahead = ahead.map(Arc::new);
    let asked = FitRequest { args, model: &model, data: &data, options: &options, ahead, interrupt };
    asked.state_request().check()?;
    let start = Instant::now();
    let found = match args.method {
        Method::Posterior => asked.posterior(),
        Method::Maximum => asked.maximum(),
    }?;
    let seconds = start.elapsed().as_secs_f64();
    let exit_status = warn(&found.warnings, args.model.quiet, args.strict);
    write(&Output::Standard, &if args.json { (found.json)(seconds) } else { found.text })?;
    if !args.model.quiet {
        status(&format!("motes: {}; {seconds:.1} s", in_one_line(&found.figures)));
    }
    Ok(exit_status)
}

/// The data. What measurements can be may depend on parameters, which are not known yet: they are data if they are so at some draw from the priors.
fn data(args: &FitArgs, model: &Model, interrupt: &Interrupt) -> Result<Data, MotesError> {
    let refused = match input::data(&args.data, model, interrupt) {
        Err(error @ MotesError::Data(DataError::Impossible { .. })) if args.data != Path::new("-") => error,
        found => return found,
    };
    let at_draw = |number| Data::open(&args.data, &at_prior_draw(model, number)?).ok();
    (0..PRIOR_DRAWS).find_map(at_draw).ok_or(refused)
}

/// Draws from the priors at which data are looked at.
const PRIOR_DRAWS: u64 = 100;

/// What a fit found, as it is said.
struct FitOutput {
    text: String,
    json: Box<dyn FnOnce(f64) -> String>,
    figures: Vec<(String, String)>,
    warnings: Vec<Warning>,
}

/// What is to be fitted.
struct FitRequest<'a> {
    args: &'a FitArgs,
    model: &'a Model,
    data: &'a Data,
    options: &'a FitOptions,
    /// Times and inputs of rows after the data.
    ahead: Option<Arc<Data>>,
    interrupt: &'a Interrupt,
}

/// Where a fit stands, written down now and then, and where it is stopped.
struct FitState<'a> {
    folder: &'a FitFolder,
    interrupt: &'a Interrupt,
    last: Cell<Instant>,
    /// How long it took to write it down.
    cost: Cell<Duration>,
    is_stopped: Cell<bool>,
}

impl FitState<'_> {
    /// Writes it down if it is time to, or if it stops here.
    fn keep(&self, state: &impl Serialize, is_stopped: bool) -> Result<(), MotesError> {
        let is_interrupted = self.interrupt.check().is_break();
        let is_stopped = is_stopped || is_interrupted;
        if is_stopped || self.last.get().elapsed() >= EVERY.0.max(self.cost.get() * EVERY.1) {
            let start = Instant::now();
            self.folder.keep(state)?;
            self.cost.set(start.elapsed());
            self.last.set(Instant::now());
        }
        self.is_stopped.set(is_stopped);
        match is_interrupted {
            true => Err(MotesError::Interrupted),
            false => Ok(()),
        }
    }
}

impl FitRequest<'_> {
    fn folder(&self, record: FitRecord) -> Result<FitFolder, MotesError> {
        FitFolder::open(&self.args.output, record)
    }

    /// Says that a fit with other options is gone, where there was one.
    fn say_replaced(&self, is_replaced: bool) {
        if is_replaced && !self.args.model.quiet {
            let folder = self.args.output.display();
            status(&format!("motes: {folder}: the fit that was in it had other options, and is replaced"));
        }
    }

    /// Says that a fit goes on, where it does.
    fn say_before<S>(&self, before: &Option<S>) {
        if before.is_some() && !self.args.model.quiet {
            status(&format!("motes: {}: going on from where it was stopped", self.args.output.display()));
        }
    }

    /// Does the work of a fit that writes down where it stands, and says how one goes on that was stopped.
    fn fitted<R: Send>(
        &self,
        folder: &FitFolder,
        work: impl FnOnce(&FitState<'_>) -> Result<R, MotesError> + Send,
    ) -> Result<(R, bool), Failure> {
        let (fitted, is_stopped) = on_threads(self.args.model.threads, || {
            let (interrupt, last) = (self.interrupt, Cell::new(Instant::now()));
            let cost = Cell::new(Duration::ZERO);
            let kept = FitState { folder, interrupt, last, cost, is_stopped: Cell::new(false) };
            let fitted = work(&kept);
            (fitted, kept.is_stopped.get())
        })?;
        let on = format!(
            "{} keeps where it stood: the same command goes on from there",
            self.args.output.display()
        );
        match fitted {
            Ok(fitted) => {
                if is_stopped && !self.args.model.quiet {
                    status(&format!("motes: --budget ended it; {on}"));
                }
                Ok((fitted, is_stopped))
            }
            Err(MotesError::Interrupted) if is_stopped => Err(Failure::stopped(format!("stopped; {on}"))),
            Err(error) if is_stopped => {
                let failure = Failure::from(error);
                Err(Failure::new(failure.exit_status(), format!("{failure}; {on}")))
            }
            Err(error) => Err(error.into()),
        }
    }

    fn posterior(&self) -> Result<FitOutput, Failure> {
        let FitRequest { args, model, data, options, interrupt, .. } = self;
        if !options.profiles.is_empty() {
            return Err(Failure::new(
                2,
                "--profile: draws of the posterior have no profiles; take --method maximum",
            ));
        }
        if options.passes.is_some() {
            return Err(Failure::new(2, "--passes: they seek a maximum; take --method maximum"));
        }
        let folder = self.folder(FitRecord::of(model, data, options)?)?;
        let (is_replaced, before) = (folder.has_other_options(), folder.progress()?);
        self.say_before(&before);
        let (fitted, is_stopped) = self.fitted(&folder, |kept| {
            let mut spinner = Spinner::new(args.model.quiet);
            let fitted = fit_from(model, data, options, before, &|| interrupt.check(), &mut |progress| {
                spinner.say(&|| progress.describe());
                kept.keep(progress.posterior, progress.is_stopped)
            });
            spinner.finish();
            fitted
        })?;
        folder.write_so_far(&fitted)?;
        self.say_replaced(is_replaced);
        let (states, warnings) =
            self.states(&folder, &fitted.warnings, |asked| asked.over_posterior(&fitted, interrupt))?;
        if !is_stopped {
            folder.complete()?;
        }
        if let Some(path) = &args.report {
            let names = ModelNames::from(*model);
            let report = FitReport {
                model: model.name(),
                fitted: &fitted,
                states: states.as_ref().map(|states| states.report(data, &names)),
                settings: &self.settings(),
                command: &command_line(),
            };
            let page = fit_report(&report).map_err(|error| MotesError::Report(error.to_string()))?;
            write(&Output::File(path.clone()), &page)?;
        }
        Ok(FitOutput {
            text: fit_text(&fitted),
            figures: fit_summary(&fitted),
            warnings,
            json: Box::new(move |seconds| fit_json(&fitted, Some(seconds))),
        })
    }

    fn maximum(&self) -> Result<FitOutput, Failure> {
        let FitRequest { args, model, data, options, interrupt, .. } = self;
        if args.draws.is_some() {
            let line =
                "--method maximum draws nothing: leave --draws out; --chains is its number of searches";
            return Err(Failure::new(2, line));
        }
        let folder = self.folder(FitRecord::of_maximum(model, data, options)?)?;
        let (is_replaced, before) = (folder.has_other_options(), folder.progress()?);
        self.say_before(&before);
        let (found, is_stopped) = self.fitted(&folder, |kept| {
            let progress = Progress::new(PARTS, args.model.quiet);
            let found = maximise(model, data, options, before, &|| interrupt.check(), &mut |search| {
                progress.done((search.share() * PARTS as f64) as usize);
                kept.keep(search.search, search.is_stopped)
            });
            progress.finish();
            found
        })?;
        folder.write_maximum_so_far(&found)?;
        self.say_replaced(is_replaced);
        let (states, warnings) =
            self.states(&folder, &found.warnings, |asked| asked.at_maximum(&found, interrupt))?;
        if !is_stopped {
            folder.complete()?;
        }
        if let Some(path) = &args.report {
            let names = ModelNames::from(*model);
            let report = MaximumReport {
                model: model.name(),
                found: &found,
                states: states.as_ref().map(|states| states.report(data, &names)),
                settings: &self.settings(),
                command: &command_line(),
            };
            let page = maximum_report(&report).map_err(|error| MotesError::Report(error.to_string()))?;
            write(&Output::File(path.clone()), &page)?;
        }
        Ok(FitOutput {
            text: maximum_text(&found),
            figures: maximum_summary(&found),
            warnings,
            json: Box::new(move |seconds| maximum_json(&found, Some(seconds))),
        })
    }

    /// What a page says that it was made with.
    fn settings(&self) -> Vec<(String, String)> {
        let FitRequest { args, options, .. } = self;
        let mut settings = vec![
            ("model".to_string(), args.model.model.display().to_string()),
            ("data".into(), args.data.display().to_string()),
            ("chains".into(), options.chains.to_string()),
            ("seed".into(), options.seed.to_string()),
        ];
        settings
            .extend(args.model.set.iter().map(|(name, value)| (format!("--set {name}"), value.to_string())));
        settings
    }

    fn state_request(&self) -> StateRequest<'_> {
        let FitRequest { args, model, data, options, .. } = self;
        let (seed, forecast, ahead) = (options.seed, args.forecast, self.ahead.clone());
        StateRequest { model, data, seed, forecast, ahead }
    }

    /// States at what was fitted, in the folder, and the warnings of the fit with theirs.
    fn states(
        &self,
        folder: &FitFolder,
        warnings: &[Warning],
        find: impl Fn(&StateRequest<'_>) -> Result<FitStates, MotesError> + Send + Sync,
    ) -> Result<(Option<FitStates>, Vec<Warning>), Failure> {
        let FitRequest { args, .. } = self;
        let (asked, mut warnings) = (self.state_request(), warnings.to_vec());
        let mut found = on_threads(args.model.threads, || find(&asked))?;
        if let Err(error) = &found
            && !matches!(error, MotesError::Interrupted)
            && (asked.forecast > 0 || asked.ahead.is_some())
        {
            // States need no forecasts.
            let without = on_threads(args.model.threads, || find(&asked.without_forecasts()))?;
            if without.is_ok() {
                warnings.push(Warning { series: None, text: format!("there are no forecasts: {error}") });
                found = without;
            }
        }
        match found {
            Ok(states) => {
                folder.write_states(&states.table)?;
                warnings.extend(states.warnings.iter().cloned());
                Ok((Some(states), warnings))
            }
            Err(MotesError::Interrupted) => Err(Failure::stopped(format!(
                "stopped; {} is complete, without its states",
                args.output.display()
            ))),
            // The fit is done: that its states cannot be filtered takes nothing of it away.
            Err(error) => {
                let text = format!("there are no states: {error}");
                warnings.push(Warning { series: None, text });
                Ok((None, warnings))
            }
        }
    }
}

/// Parts that the progress of a search is told in.
const PARTS: usize = 1000;
