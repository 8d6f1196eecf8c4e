//! What happens on clusters.

use super::cluster::{NODES, children, kill, wait_until};
use super::sweep::Sweep;

type Fault = fn(&Sweep) -> Result<(), String>;

/// One after the other, while units are being done.
pub(super) const ALL: [(&str, Fault); 4] = [
    ("the controller was killed and started again", controller),
    ("a task was killed", task),
    ("the process by which a node watches a task was killed; the task went on", watcher),
    ("a node was killed with its task, and started again", node),
];

/// Slurm calls it failed, and does not run it again.
fn task(sweep: &Sweep) -> Result<(), String> {
    let step = first_step(sweep, NODES[0])?;
    children(step).into_iter().try_for_each(kill)
}

/// Slurm takes the task for lost, and may start it a second time beside the first.
fn watcher(sweep: &Sweep) -> Result<(), String> {
    kill(first_step(sweep, NODES[0])?)
}

/// Jobs do not notice.
fn controller(sweep: &Sweep) -> Result<(), String> {
    sweep.wait_for_units()?;
    sweep.cluster.write_down()?;
    sweep.cluster.kill_controller()?;
    sweep.cluster.start_controller()?;
    sweep.wait_for_an_answer()
}

/// Slurm finds it out after a while, and runs its tasks again.
fn node(sweep: &Sweep) -> Result<(), String> {
    first_step(sweep, NODES[1])?;
    sweep.cluster.kill_node(NODES[1])?;
    sweep.cluster.start_node(NODES[1])
}

/// The process that watches the first task of a node, or of the other where this one has none: once there is one.
fn first_step(sweep: &Sweep, node: &str) -> Result<u32, String> {
    let steps = || {
        let mut steps = sweep.cluster.steps_of(node)?;
        for other in NODES {
            steps.extend(sweep.cluster.steps_of(other)?);
        }
        Ok::<_, String>(steps)
    };
    wait_until("a task", || Ok(!steps()?.is_empty()))?;
    steps()?.first().copied().ok_or_else(|| format!("no task is left on {node}"))
}
