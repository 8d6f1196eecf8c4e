//! The sweep on a real Slurm: a controller and two nodes of one core each on this machine, with faults.

mod cluster;
mod faults;
mod sweep;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::Args;
use motes_cli::status;

use crate::process::{build, built};
use cluster::Cluster;
use sweep::Sweep;

/// Tasks of an array: more than there are nodes, so that some wait.
const TASKS: usize = 4;

#[derive(Args)]
pub(crate) struct SlurmArgs {
    /// The folder of the cluster and of the results, new or left by an earlier test; a temporary one, which goes afterwards, if absent
    #[arg(long, value_name = "FOLDER")]
    folder: Option<PathBuf>,
}

/// Runs a figure's smoke profile locally, as an array, and as an array with faults, and holds the tables against each other.
pub(crate) fn test(root: &Path, args: &SlurmArgs) -> ExitCode {
    if let Err(missing) = cluster::check() {
        status(&format!("error: {missing}"));
        return ExitCode::from(3);
    }
    if let Err(exit_status) = build(root, "motes-bench", &[], "") {
        return exit_status;
    }
    let temporary = std::env::temp_dir().join(format!("motes-slurm-{}", std::process::id()));
    let folder = args.folder.clone().unwrap_or_else(|| temporary.clone());
    let is_ours = folder.join("cluster/slurm.conf").exists();
    let is_taken = std::fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_some());
    if is_taken && !is_ours {
        status(&format!("error: --folder {}: it has other files; give an empty one", folder.display()));
        return ExitCode::from(2);
    }
    let _ = std::fs::remove_dir_all(&folder);
    let tested = run(root, &folder);
    if tested.is_ok() && args.folder.is_none() {
        let _ = std::fs::remove_dir_all(&folder);
    }
    match tested {
        Ok(()) => {
            println!("slurm: all tables are the same bytes");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            status(&format!("error: {reason}; what is left lies in {}", folder.display()));
            ExitCode::FAILURE
        }
    }
}

/// The same as part of the thorough run, where the packages are there.
pub(crate) fn check(root: &Path) -> Result<(), ExitCode> {
    if let Err(missing) = cluster::check() {
        println!("ci: the sweep on a real Slurm is left out: {missing}");
        return Ok(());
    }
    match test(root, &SlurmArgs { folder: None }) {
        status if status == ExitCode::SUCCESS => Ok(()),
        status => Err(status),
    }
}

fn run(root: &Path, folder: &Path) -> Result<(), String> {
    let start = Instant::now();
    let said = |what: &str| println!("slurm: {:4.0} s  {what}", start.elapsed().as_secs_f64());
    let cluster = Cluster::start(&folder.join("cluster"))?;
    said("a controller and two nodes are up");
    let sweep = |name: &str| Sweep {
        cluster: &cluster,
        program: built("release", "motes-bench"),
        experiments: root.join("experiments"),
        out: folder.join(name),
        tasks: TASKS,
    };
    said(&sweep("refused").refuses_what_slurm_refuses()?);

    let local = sweep("local");
    local.run_here()?;
    let expected = local.tables()?;
    said("a local run is done");

    let array = sweep("array");
    array.submit()?;
    array.wait()?;
    array.is(&expected)?;
    said(&format!("an array of {TASKS} tasks made the same tables, by the job after it"));
    said(&array.submits_nothing()?);

    let faulty = sweep("faulty");
    faulty.submit()?;
    for (what, fault) in faults::ALL {
        fault(&faulty)?;
        said(what);
    }
    said(faulty.wait_or_take_back()?);
    let rounds = faulty.again_until_all_is_there()?;
    faulty.is(&expected)?;
    said(&format!("with these faults the same tables; the command was given {rounds} more times"));
    Ok(())
}
