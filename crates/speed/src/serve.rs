//! Our side of a contest: a process that takes tasks on its standard input and answers on its standard output.

use std::io::{BufRead, Write};
use std::ops::ControlFlow;
use std::time::Instant;

use motes_models::{GraphDiffusion, Measurements, ModelShape, Stream};
use motes_proposals::{Backend, Family, Fcnn, Gnn, Learnable, Psi, Rnn, load};
use motes_smc::{Bootstrap, FilterBank, FilterSettings, MinDegeneracy, Proposal, Resampling};
use motes_train::{GradientFlow, Objective, TrainConfig, rollout, train};
use rayon_core::{ThreadPoolBuilder, current_num_threads, current_thread_index};

use crate::draws::Drawing;
use crate::folder::{DIMENSION, seed, system, trajectory};
use crate::learned;
use crate::task::{Answer, FilterTask, Request, Task, TrainTask};
use crate::work::{Work, of_evidences};

/// Serves requests, a line each, until there are no more.
pub(crate) fn serve() {
    let mut work: Option<Box<dyn Work>> = None;
    for line in std::io::stdin().lock().lines() {
        let Ok(line) = line else { break };
        let answer = match serde_json::from_str::<Request>(&line) {
            Ok(Request::Quit(_)) => break,
            Ok(request) => answer(request, &mut work),
            Err(error) => Err(error.to_string()),
        };
        let answer = answer.unwrap_or_else(|error| Answer { error: Some(error), ..Answer::default() });
        let mut out = std::io::stdout().lock();
        let text = serde_json::to_string(&answer).unwrap_or_default();
        if writeln!(out, "{text}").and_then(|()| out.flush()).is_err() {
            break;
        }
    }
}

fn answer(request: Request, work: &mut Option<Box<dyn Work>>) -> Result<Answer, String> {
    let nothing = || "nothing is prepared".to_string();
    match request {
        Request::Prepare(task) => {
            *work = None;
            have_threads(task.threads())?;
            let mut prepared = prepare(&task)?;
            // Once unseen, as the others compile and warm up.
            prepared.run()?;
            *work = Some(prepared);
            let versions = serde_json::json!({ "motes": env!("CARGO_PKG_VERSION") });
            Ok(Answer { ready: Some(true), versions: Some(versions), ..Answer::default() })
        }
        Request::Check(_) => work.as_mut().ok_or_else(nothing)?.check(),
        Request::Run(_) | Request::Quit(_) => {
            let work = work.as_mut().ok_or_else(nothing)?;
            let start = Instant::now();
            work.run()?;
            Ok(Answer { seconds: Some(start.elapsed().as_secs_f64()), ..Answer::default() })
        }
    }
}

/// Makes the process one of so many threads: the calling one, and others beside it.
fn have_threads(threads: usize) -> Result<(), String> {
    if current_thread_index().is_none() {
        return ThreadPoolBuilder::new()
            .num_threads(threads)
            .use_current_thread()
            .build_global()
            .map_err(told);
    }
    match current_num_threads() {
        found if found == threads => Ok(()),
        found => Err(format!("this process has {found} threads and was asked for {threads}")),
    }
}

fn prepare(task: &Task) -> Result<Box<dyn Work>, String> {
    match task {
        Task::Filter(task) => {
            let text = std::fs::read_to_string(&task.problem).map_err(told)?;
            let problem: serde_json::Value = serde_json::from_str(&text).map_err(told)?;
            let horizon = problem["measurements"].as_array().map_or(0, Vec::len);
            let dimension = problem["A"].as_array().map_or(0, Vec::len);
            let system = system(dimension).map_err(told)?;
            let measurements = trajectory(&system, horizon).map_err(told)?.measurements;
            let task = task.clone();
            match task.method.as_str() {
                "bootstrap" => {
                    Ok(Box::new(Filtering { task, system, measurements, proposal: Bootstrap, runs: 0 }))
                }
                "min-degeneracy" => {
                    let proposal = MinDegeneracy::new(&system).map_err(told)?;
                    Ok(Box::new(Filtering { task, system, measurements, proposal, runs: 0 }))
                }
                other => Err(format!("there is no method {other}")),
            }
        }
        Task::Learn(task) => learned::learning(task),
        Task::Learned(task) => learned::filtering(task),
        Task::Draws(task) => Ok(Box::new(Drawing::of(task)?)),
        Task::Train(task) => {
            let learned: Box<dyn Learnable> = match task.family.as_str() {
                Fcnn::NAME => Box::new(loaded::<Fcnn>(task)?),
                Rnn::NAME => Box::new(loaded::<Rnn>(task)?),
                Gnn::NAME => Box::new(loaded::<Gnn>(task)?),
                Psi::NAME => Box::new(loaded::<Psi>(task)?),
                other => return Err(format!("there is no family {other}")),
            };
            let system = system(DIMENSION).map_err(told)?;
            let bytes = std::fs::metadata(task.folder.join("noise.f64")).map_err(told)?.len();
            let horizon = bytes as usize / 8 / task.particles / learned.state_dim();
            let measurements = trajectory(&system, horizon).map_err(told)?.measurements;
            let stream = seed().child("training").stream();
            Ok(Box::new(Training {
                task: task.clone(),
                system,
                measurements,
                learned,
                stream,
                at_first: None,
            }))
        }
    }
}

fn told(error: impl ToString) -> String {
    error.to_string()
}

fn loaded<F: Family + Learnable>(task: &TrainTask) -> Result<F, String> {
    let system = system(DIMENSION).map_err(told)?;
    load(&task.folder, &system, &ModelShape::on_graph(&system), Backend::Native.into()).map_err(told)
}

struct Filtering<P> {
    task: FilterTask,
    system: GraphDiffusion,
    measurements: Measurements,
    proposal: P,
    runs: u64,
}

impl<P: Proposal<GraphDiffusion> + Clone + Send> Filtering<P> {
    fn evidence(&mut self) -> Result<Vec<f64>, String> {
        let settings = FilterSettings {
            resampling: match self.task.resampling.as_str() {
                "multinomial" => Resampling::Multinomial,
                "systematic" => Resampling::Systematic,
                other => return Err(format!("there is no resampling {other}")),
            },
            ..FilterSettings::new(self.task.particles)
        };
        self.runs += 1;
        let seed = seed().child("filter").nth(self.task.seed).nth(self.runs);
        let proposal = self.proposal.clone();
        let mut bank =
            FilterBank::new(&self.system, proposal, settings, self.task.filters, &seed).map_err(told)?;
        bank.run(&self.measurements, |_| ()).map_err(told)?;
        Ok((0..self.task.filters).map(|filter| bank.log_evidence(filter)).collect())
    }
}

impl<P: Proposal<GraphDiffusion> + Clone + Send> Work for Filtering<P> {
    fn check(&mut self) -> Result<Answer, String> {
        let mut found = Vec::new();
        for _ in 0..20 {
            found.extend(self.evidence()?);
        }
        Ok(of_evidences(&found))
    }

    fn run(&mut self) -> Result<(), String> {
        self.evidence().map(|_| ())
    }
}

struct Training {
    task: TrainTask,
    system: GraphDiffusion,
    measurements: Measurements,
    learned: Box<dyn Learnable>,
    stream: Stream,
    /// Loss and gradient norm at the weights that were given.
    at_first: Option<(f64, f64)>,
}

impl Training {
    fn at_first(&mut self) -> Result<(f64, f64), String> {
        if let Some(found) = self.at_first {
            return Ok(found);
        }
        // The noise in the folder came from this stream.
        let mut stream = seed().child("noise").stream();
        let (objective, flow) = (Objective::LogLikelihood, GradientFlow::Full);
        let particles = self.task.particles;
        let found = rollout(
            self.learned.as_ref(),
            &self.system,
            &self.measurements,
            objective,
            flow,
            particles,
            &mut stream,
        )
        .map_err(told)?;
        Ok(*self.at_first.insert((-found.objective, found.workspace.into_gradients().norm())))
    }
}

impl Work for Training {
    fn check(&mut self) -> Result<Answer, String> {
        let (loss, norm) = self.at_first()?;
        Ok(Answer { loss: Some(loss), gradient_norm: Some(norm), ..Answer::default() })
    }

    fn run(&mut self) -> Result<(), String> {
        self.at_first()?;
        let config = TrainConfig { steps: self.task.steps, ..TrainConfig::paper(self.task.particles) };
        let proceed = |_, _| ControlFlow::Continue(());
        let learned = self.learned.as_mut();
        train(learned, &self.system, &self.measurements, &config, &mut self.stream, proceed)
            .map(|_| ())
            .map_err(told)
    }
}
