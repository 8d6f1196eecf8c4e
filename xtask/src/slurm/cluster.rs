//! A Slurm of one machine, from Debian's packages.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

/// The nodes; each has one core.
pub(super) const NODES: [&str; 2] = ["n1", "n2"];
const PATIENCE: Duration = Duration::from_secs(60);
const PAUSE: Duration = Duration::from_millis(200);

/// A controller and two nodes; they end with this value.
pub(super) struct Cluster {
    folder: PathBuf,
}

/// Says what is missing on this machine.
pub(super) fn check() -> Result<(), String> {
    for program in ["slurmctld", "slurmd", "sbatch", "munged"] {
        let found = Command::new(program).arg("-V").stdout(Stdio::null()).stderr(Stdio::null()).status();
        if found.is_err() {
            return Err(format!("{program} is not there; on Debian: apt-get install slurm-wlm munge"));
        }
    }
    match capture(Command::new("id").arg("-u"))?.as_str() {
        "0" => Ok(()),
        _ => Err("a Slurm of one's own needs root; run this in a container".into()),
    }
}

impl Cluster {
    /// Starts it and waits until its nodes are idle.
    pub(super) fn start(folder: &Path) -> Result<Cluster, String> {
        let cluster = Cluster { folder: folder.to_path_buf() };
        for part in ["state", "log", NODES[0], NODES[1]] {
            let path = folder.join(part);
            std::fs::create_dir_all(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        }
        let path = cluster.configuration();
        let text = configuration(folder)?;
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        start_munge()?;
        cluster.start_controller()?;
        NODES.iter().try_for_each(|node| cluster.start_node(node))?;
        wait_until("two idle nodes", || Ok(cluster.idle_nodes()? == NODES.len()))?;
        Ok(cluster)
    }

    /// A command that talks to this cluster.
    pub(super) fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command.env("SLURM_CONF", self.configuration());
        command
    }

    pub(super) fn start_controller(&self) -> Result<(), String> {
        self.spawn("slurmctld", &["-D"], "controller")
    }

    pub(super) fn start_node(&self, node: &str) -> Result<(), String> {
        self.spawn("slurmd", &["-D", "-N", node], node)
    }

    /// Kills the controller, as a machine that loses its power does.
    pub(super) fn kill_controller(&self) -> Result<(), String> {
        kill(self.process("controller")?)
    }

    /// Waits until the controller has written down which jobs run. One that is killed before forgets them: it sets their nodes aside, and
    /// somebody has to look after these.
    pub(super) fn write_down(&self) -> Result<(), String> {
        let since = SystemTime::now();
        let mut squeue = self.command("squeue");
        let running = capture(squeue.args(["--noheader", "--states=running", "--format=%A"]))?;
        for job in running.lines() {
            // It writes after changes, some seconds later.
            let mut scontrol = self.command("scontrol");
            // One that has just ended cannot be changed, and that is a change itself.
            let _ = scontrol
                .args(["update", &format!("JobId={job}"), "Comment=runs"])
                .stderr(Stdio::null())
                .status();
        }
        let jobs = self.folder.join("state/job_state");
        wait_until("what the controller writes down", || {
            let written = std::fs::metadata(&jobs).and_then(|file| file.modified());
            Ok(written.is_ok_and(|written| written > since))
        })
    }

    /// Kills a node with all that runs on it.
    pub(super) fn kill_node(&self, node: &str) -> Result<(), String> {
        kill(self.process(node)?)?;
        for process in self.steps_of(node)? {
            // Those of a process that is gone are gone with it.
            children(process).into_iter().chain([process]).for_each(|process| drop(kill(process)));
        }
        Ok(())
    }

    /// Takes back all jobs.
    pub(super) fn cancel_all(&self) {
        let mut scancel = self.command("scancel");
        let _ = scancel.args(["--user", "root"]).stderr(Stdio::null()).status();
    }

    /// Puts nodes to use again that Slurm set aside; those that it did not it refuses to resume.
    pub(super) fn resume_nodes(&self) {
        for node in NODES {
            let mut scontrol = self.command("scontrol");
            let resume = ["update", &format!("NodeName={node}"), "State=RESUME"];
            let _ = scontrol.args(resume).stderr(Stdio::null()).status();
        }
    }

    /// The processes by which a node watches its jobs.
    pub(super) fn steps_of(&self, node: &str) -> Result<Vec<u32>, String> {
        let steps = processes("slurmstepd")?;
        let mark = format!("SLURMD_NODENAME={node}");
        let is_of_node = |step: &u32| children(*step).iter().any(|child| environment(*child).contains(&mark));
        Ok(steps.into_iter().filter(is_of_node).collect())
    }

    fn idle_nodes(&self) -> Result<usize, String> {
        let mut sinfo = self.command("sinfo");
        // The controller may not answer yet.
        let nodes = capture(sinfo.args(["--noheader", "--Node", "--format=%t"])).unwrap_or_default();
        Ok(nodes.lines().filter(|state| state.trim() == "idle").count())
    }

    fn configuration(&self) -> PathBuf {
        self.folder.join("slurm.conf")
    }

    /// In the foreground of its own log, so that its number is known.
    fn spawn(&self, program: &str, arguments: &[&str], name: &str) -> Result<(), String> {
        let log = self.folder.join("log").join(format!("{name}.out"));
        let file = File::options()
            .append(true)
            .create(true)
            .open(&log)
            .map_err(|error| format!("{}: {error}", log.display()))?;
        let mut command = self.command(program);
        command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
        let child = command.spawn().map_err(|error| format!("{program}: {error}"))?;
        let path = self.folder.join(format!("{name}.process"));
        std::fs::write(&path, child.id().to_string())
            .map_err(|error| format!("{}: {error}", path.display()))?;
        // Nobody leaves it a zombie.
        std::thread::spawn(move || {
            let mut child = child;
            let _ = child.wait();
        });
        Ok(())
    }

    fn process(&self, name: &str) -> Result<u32, String> {
        let path = self.folder.join(format!("{name}.process"));
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        text.parse().map_err(|_| format!("{} has no number", path.display()))
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        self.cancel_all();
        for node in NODES {
            let _ = self.kill_node(node);
        }
        let _ = self.kill_controller();
    }
}

fn configuration(folder: &Path) -> Result<String, String> {
    let (host, folder) = (capture(Command::new("hostname").arg("-s"))?, folder.display());
    let nodes: String = NODES
        .iter()
        .zip(17001..)
        .map(|(node, port)| {
            format!(
                "NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs=1 State=UNKNOWN\n"
            )
        })
        .collect();
    Ok(format!(
        "ClusterName=motes\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser=root\nStateSaveLocation={folder}/state\n\
         SlurmdSpoolDir={folder}/%n\nSlurmctldPidFile={folder}/controller.pid\nSlurmdPidFile={folder}/%n.pid\n\
         SlurmctldLogFile={folder}/log/controller.log\nSlurmdLogFile={folder}/log/%n.log\n\
         ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nSelectType=select/cons_tres\n\
         SelectTypeParameters=CR_Core\nSlurmdParameters=config_overrides\nReturnToService=2\nSlurmdTimeout=10\n\
         {nodes}PartitionName=test Nodes=ALL Default=YES MaxTime=INFINITE State=UP\n"
    ))
}

/// The service by which Slurm's parts know each other, if it does not run yet.
fn start_munge() -> Result<(), String> {
    let answers = || Command::new("munge").arg("-n").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if answers().is_ok_and(|status| status.success()) {
        return Ok(());
    }
    capture(Command::new("install").args(["-d", "-o", "munge", "-g", "munge", "-m", "0755", "/run/munge"]))?;
    capture(Command::new("runuser").args(["-u", "munge", "--", "munged", "--force"]))?;
    wait_until("munge", || Ok(answers().is_ok_and(|status| status.success())))
}

/// Waits until something holds, for as long as that may take.
pub(super) fn wait_until(what: &str, holds: impl Fn() -> Result<bool, String>) -> Result<(), String> {
    wait_for(what, PATIENCE, holds)
}

pub(super) fn wait_for(
    what: &str,
    patience: Duration,
    holds: impl Fn() -> Result<bool, String>,
) -> Result<(), String> {
    let start = Instant::now();
    while !holds()? {
        if start.elapsed() > patience {
            return Err(format!("waited in vain for {what}"));
        }
        std::thread::sleep(PAUSE);
    }
    Ok(())
}

/// What a command prints, if it succeeds.
pub(super) fn capture(command: &mut Command) -> Result<String, String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| format!("{name}: {error}"))?;
    if !output.status.success() {
        return Err(format!("{name}: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_string())
}

/// Kills a process at once.
pub(super) fn kill(process: u32) -> Result<(), String> {
    capture(Command::new("kill").args(["-KILL", &process.to_string()])).map(drop)
}

/// The processes of a name.
pub(super) fn processes(name: &str) -> Result<Vec<u32>, String> {
    // None is no success for pgrep.
    let found =
        Command::new("pgrep").args(["-x", name]).output().map_err(|error| format!("pgrep: {error}"))?;
    Ok(numbers(&String::from_utf8_lossy(&found.stdout)))
}

pub(super) fn children(process: u32) -> Vec<u32> {
    let found = Command::new("pgrep").args(["-P", &process.to_string()]).output();
    found.map_or(Vec::new(), |output| numbers(&String::from_utf8_lossy(&output.stdout)))
}

fn numbers(text: &str) -> Vec<u32> {
    text.lines().filter_map(|line| line.trim().parse().ok()).collect()
}

/// The variables that a process was started with.
fn environment(process: u32) -> Vec<String> {
    let bytes = std::fs::read(format!("/proc/{process}/environ")).unwrap_or_default();
    bytes.split(|byte| *byte == 0).map(|part| String::from_utf8_lossy(part).into_owned()).collect()
}
