//! The pieces of work: filters and banks of them, training of every family at the paper's sizes, and filters of growing size.

use std::path::Path;

use motes_proposals::{Fcnn, FcnnConfig, Gnn, GnnConfig, Psi, PsiConfig, Rnn, RnnConfig};

use crate::error::SpeedError;
use crate::folder::{BANK_HORIZON, DIMENSION, write_problem, write_training};
use crate::task::{DrawsTask, FilterTask, LearnTask, LearnedTask, Task, TrainTask};
use crate::{learned, operations};

/// A piece of work, with those who do it.
pub(crate) struct Workload {
    /// A name that sorts and filters well.
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// Ours.
    pub(crate) ours: Vec<Task>,
    /// Others' by name: each a process, or two that work side by side.
    pub(crate) peers: Vec<(String, Vec<Task>)>,
}

/// What is counted.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Kind {
    /// This many particle-steps a run.
    Filter {
        /// `B·K·T`.
        particle_steps: f64,
    },
    /// This many draws a run.
    Draws {
        /// How many.
        draws: usize,
    },
    /// This many training steps a run, in each process.
    Train {
        /// Steps.
        steps: usize,
        /// Floating-point operations of one, by the algorithm that is used; psi's are too small to matter.
        operations: f64,
    },
    /// This many gradient steps a run of a proposal that is learned once.
    Learn {
        /// Steps.
        steps: usize,
        /// Floating-point operations of the networks in one.
        operations: f64,
        /// How many threads may work.
        threads: usize,
    },
    /// This many particle-steps a run, with networks in each.
    Learned {
        /// `K·T`.
        particle_steps: f64,
        /// Floating-point operations of the networks in a run, were each particle computed; those that know the same are computed once.
        operations: f64,
        /// How many threads may work.
        threads: usize,
    },
}

impl Kind {
    /// How often the work is done in a round.
    pub(crate) fn runs(self) -> usize {
        match self {
            Kind::Filter { particle_steps } => (PARTICLE_STEPS / particle_steps).ceil() as usize,
            Kind::Learned { particle_steps, .. } => (LEARNED_STEPS / particle_steps).ceil() as usize,
            Kind::Train { .. } | Kind::Learn { .. } | Kind::Draws { .. } => 1,
        }
    }
}

const FILTER_HORIZON: usize = 50;
/// A round of filters takes at least so many: what is done in a few milliseconds measures how a process wakes up.
const PARTICLE_STEPS: f64 = 5e6;
const LEARNED_STEPS: f64 = 1e6;
/// Gradient steps of a run.
const LEARN_STEPS: usize = 600;
const BANK: usize = 100;

/// Draws of a run.
const DRAWS: usize = 1 << 20;

/// What is drawn: counts with these means, and gammas of these shapes.
const DRAWN: [(&str, [f64; 3]); 3] =
    [("binomial", [1.0, 20.0, 1000.0]), ("poisson", [1.0, 20.0, 1000.0]), ("gamma", [0.35, 1.5, 20.0])];

const METHODS: [&str; 2] = ["bootstrap", "min-degeneracy"];

/// Those that others do too, with their files under `scratch`.
pub(crate) fn all(scratch: &Path) -> Result<Vec<Workload>, SpeedError> {
    let mut all = Vec::new();
    let one = Size::usual();
    for method in METHODS {
        for particles in [100, 1_000, 10_000, 100_000] {
            all.push(filter(scratch, method, Size { particles, ..one }, &["particles", "cuthbert"])?);
        }
        for particles in [10, 50] {
            let bank = Size { filters: BANK, particles, horizon: BANK_HORIZON, ..one };
            all.push(filter(scratch, method, bank, &["numpy"])?);
        }
    }
    for (distribution, sizes) in DRAWN {
        all.extend(sizes.map(|size| draws(distribution, size)));
    }
    for particles in [10, 50] {
        let fcnn = FcnnConfig::paper();
        all.push(train::<Fcnn>(scratch, &fcnn, particles, 40, operations::fcnn(&fcnn, particles))?);
        let rnn = RnnConfig::paper();
        all.push(train::<Rnn>(scratch, &rnn, particles, 20, operations::rnn(&rnn, particles))?);
        let gnn = GnnConfig::paper();
        all.push(train::<Gnn>(scratch, &gnn, particles, 4, operations::gnn(&gnn, particles))?);
        all.push(train::<Psi>(scratch, &PsiConfig::paper(), particles, 500, 0.0)?);
    }
    for model in learned::MODELS {
        let folder = scratch.join(format!("learned-{model}"));
        learned::write(&folder, model)?;
        for threads in [1, 2] {
            all.push(learn(&folder, model, threads, false));
        }
        // Rows are simulated by a thread of their own, which the steps wait for.
        all.push(learn(&folder, model, 2, true));
        for (particles, threads) in
            [(100, 1), (1_000, 1), (10_000, 1), (10_000, 2), (100_000, 1), (100_000, 2)]
        {
            all.push(with_learned(&folder, model, particles, threads));
        }
    }
    Ok(all)
}

/// Draws by one thread.
fn draws(distribution: &str, size: f64) -> Workload {
    let task = |peer: Option<&str>| {
        let (peer, distribution) = (peer.map(String::from), distribution.into());
        vec![Task::Draws(DrawsTask { peer, distribution, size, draws: DRAWS })]
    };
    Workload {
        name: format!("draws {distribution} {size}"),
        kind: Kind::Draws { draws: DRAWS },
        ours: task(None),
        peers: vec![("numpy".into(), task(Some("numpy")))],
    }
}

/// The same work in JAX, on as many threads or fewer, with densities in 32 and in 64 bits: the best of them counts.
fn in_jax(threads: usize, task: impl Fn(u8, usize) -> Task) -> Vec<(String, Vec<Task>)> {
    let arrangements = (1..=threads).flat_map(|threads| [32, 64].map(|bits| (bits, threads)));
    let named =
        |(bits, threads)| (format!("JAX, {bits} bits, threads: {threads}"), vec![task(bits, threads)]);
    arrangements.map(named).collect()
}

/// Gradient steps of a proposal that is learned once.
fn learn(folder: &Path, model: &str, threads: usize, simulates: bool) -> Workload {
    let task = |peer: Option<&str>, bits, threads| {
        let (model, peer, folder) = (model.into(), peer.map(String::from), folder.into());
        Task::Learn(LearnTask { model, peer, folder, steps: LEARN_STEPS, simulates, bits, threads })
    };
    let rest = if simulates { "simulated".into() } else { format!("threads: {threads}") };
    let operations = learned::operations_of_step(model, learned::ROWS);
    Workload {
        name: format!("learn {model}, {rest}"),
        kind: Kind::Learn { steps: LEARN_STEPS, operations, threads },
        ours: vec![task(None, 64, threads)],
        peers: match simulates {
            true => Vec::new(),
            false => in_jax(threads, |bits, threads| task(Some("jax"), bits, threads)),
        },
    }
}

/// A filter with a proposal that is learned once.
fn with_learned(folder: &Path, model: &str, particles: usize, threads: usize) -> Workload {
    let particle_steps = (particles * learned::HORIZON) as f64;
    let operations = learned::operations(model, particles);
    let task = |peer: Option<&str>, bits, threads| {
        let (model, peer, folder) = (model.into(), peer.map(String::from), folder.into());
        // Evidences of many particles differ little, and take long.
        let check_passes = if particles < 100_000 { 20 } else { 8 };
        Task::Learned(LearnedTask { model, peer, folder, check_passes, bits, particles, threads })
    };
    Workload {
        name: format!("learned {model} K={particles}, threads: {threads}"),
        kind: Kind::Learned { particle_steps, operations, threads },
        ours: vec![task(None, 64, threads)],
        peers: in_jax(threads, |bits, threads| task(Some("jax"), bits, threads)),
    }
}

/// Filters of a method that differ in one size.
pub(crate) struct Growing {
    pub(crate) method: &'static str,
    /// The name of the size, as in formulas.
    pub(crate) size: char,
    /// Its values, and a filter for each.
    pub(crate) filters: Vec<(usize, Workload)>,
}

/// Gives one of the sizes another value.
type Resize = fn(Size, usize) -> Size;

/// Filters of each method that grow with K, with T and with N.
pub(crate) fn growing(scratch: &Path) -> Result<Vec<Growing>, SpeedError> {
    let one = Size::usual();
    let mut all = Vec::new();
    for method in METHODS {
        let sizes: [(char, [usize; 3], Resize); 3] = [
            ('K', [10_000, 30_000, 100_000], |one, particles| Size { particles, ..one }),
            ('T', [50, 100, 200], |one, horizon| Size { horizon, ..one }),
            ('N', [10, 20, 40], |one, dimension| Size { dimension, ..one }),
        ];
        for (size, values, of) in sizes {
            let filters =
                values.into_iter().map(|value| Ok((value, filter(scratch, method, of(one, value), &[])?)));
            all.push(Growing { method, size, filters: filters.collect::<Result<_, SpeedError>>()? });
        }
    }
    Ok(all)
}

/// How large filters are.
#[derive(Clone, Copy)]
struct Size {
    dimension: usize,
    filters: usize,
    particles: usize,
    horizon: usize,
}

impl Size {
    /// What the others differ from in one number.
    fn usual() -> Self {
        Size { dimension: DIMENSION, filters: 1, particles: 10_000, horizon: FILTER_HORIZON }
    }

    /// What such work is called.
    fn name(self, method: &str) -> String {
        let Size { dimension, filters, particles, horizon } = self;
        format!("filter {method} N={dimension} B={filters} K={particles} T={horizon}")
    }
}

fn filter(scratch: &Path, method: &str, size: Size, peers: &[&str]) -> Result<Workload, SpeedError> {
    let Size { dimension, filters, particles, horizon } = size;
    let problem = scratch.join(format!("problem-{dimension}-{horizon}.json"));
    write_problem(&problem, dimension, horizon)?;
    let task = |peer: Option<&str>, threads| {
        Task::Filter(FilterTask {
            peer: peer.map(String::from),
            problem: problem.clone(),
            method: method.into(),
            particles,
            filters,
            resampling: "multinomial".into(),
            seed: 1,
            threads,
        })
    };
    let arrangements = |peer: &&str| {
        [1, 2].map(|threads| {
            (
                format!("{peer}, {threads} thread{}", if threads == 1 { "" } else { "s" }),
                vec![task(Some(*peer), threads)],
            )
        })
    };
    Ok(Workload {
        name: size.name(method),
        kind: Kind::Filter { particle_steps: (filters * particles * horizon) as f64 },
        // A single filter of fewer particles is not worth a second thread.
        ours: vec![task(None, if filters == 1 && particles < 10_000 { 1 } else { 2 })],
        peers: peers.iter().flat_map(arrangements).collect(),
    })
}

fn train<
    F: motes_proposals::Family + motes_proposals::Learnable + motes_smc::Proposal<motes_models::GraphDiffusion>,
>(
    scratch: &Path,
    config: &F::Config,
    particles: usize,
    steps: usize,
    operations: f64,
) -> Result<Workload, SpeedError> {
    let folder = scratch.join(format!("{}-{particles}", F::NAME));
    write_training::<F>(&folder, config, BANK_HORIZON, particles)?;
    let task = |compile, threads| {
        let (family, folder) = (F::NAME.into(), folder.clone());
        Task::Train(TrainTask { family, folder, particles, compile, steps, threads })
    };
    let mut peers = Vec::new();
    for (label, compile) in [("torch", false), ("torch.compile", true)] {
        peers.push((format!("{label}, 1 process of 2 threads"), vec![task(compile, 2)]));
        peers.push((format!("{label}, 2 processes of 1 thread"), vec![task(compile, 1), task(compile, 1)]));
    }
    Ok(Workload {
        name: format!("train {} K={particles}", F::NAME),
        kind: Kind::Train { steps, operations },
        ours: vec![task(false, 1), task(false, 1)],
        peers,
    })
}
