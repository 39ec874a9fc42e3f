//! Watches the processes of a fleet: starts agents again, and ends all processes with the world.

use std::io;
use std::process::ExitStatus;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tempfile::TempDir;
use tokio::process::{Child, ChildStdin, Command};
use tokio::signal::unix::{self, SignalKind, signal};
use tokio::sync::watch;
use tokio::task::JoinSet;

use super::command::{Commands, start};
use super::error::SpawnError;
use crate::scenario::Scenario;
use crate::verdict::{FAILED, INTERRUPTED};
use csat_mission::words::named;
use csat_peer::tell;

/// How long agents may take to end by themselves after their world, and how long once their pipes are
/// closed.
const END_LIMITS: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(4)];
/// How often a stopped world is woken after all its agents have ended.
const WAKE_PERIOD: Duration = Duration::from_secs(5);
/// How long after its end an agent's process is started again.
const RESTART_DELAY: Duration = Duration::from_millis(500);
/// How often one agent is started again: a program that cannot run would end for ever.
const MAX_RESTARTS: u32 = 100;

/// Ctrl-C and SIGTERM.
pub struct Signals {
    interrupt: unix::Signal,
    terminate: unix::Signal,
}

impl Signals {
    /// From now on they do not end this process.
    pub fn install() -> Result<Self, SpawnError> {
        let install = |kind| signal(kind).map_err(SpawnError::Watch);
        Ok(Self {
            interrupt: install(SignalKind::interrupt())?,
            terminate: install(SignalKind::terminate())?,
        })
    }

    /// Waits for either.
    async fn next(&mut self) {
        tokio::select! { _ = self.interrupt.recv() => (), _ = self.terminate.recv() => () }
    }
}

/// The end of an agent's process.
struct AgentEnd {
    id: u16,
    status: io::Result<ExitStatus>,
}

/// A world and its agents.
pub struct Supervisor<'a> {
    commands: Commands<'a>,
    world: Child,
    /// The world ends when this pipe closes.
    world_pipe: Option<ChildStdin>,
    /// Tasks that each watch an agent's process.
    agents: JoinSet<AgentEnd>,
    /// The agents' pipes close when this is dropped.
    pipes: watch::Sender<()>,
    /// By agent, how often it was started again.
    restarts: Vec<u32>,
    /// How many of the agents are UAVs.
    uavs: u16,
    /// Whether a signal has ended the mission.
    is_stopped: bool,
}

impl<'a> Supervisor<'a> {
    /// Starts all processes.
    pub fn start(commands: Commands<'a>, scenario: &Scenario) -> Result<Self, SpawnError> {
        let mut world = start(commands.world()?, "csat world")?;
        let count = scenario.agent_count();
        let mut supervisor = Self {
            commands,
            world_pipe: world.stdin.take(),
            world,
            agents: JoinSet::new(),
            pipes: watch::channel(()).0,
            restarts: vec![0; usize::from(count)],
            uavs: scenario.agents.count,
            is_stopped: false,
        };
        let mut pids = String::new();
        for id in 0..count {
            let child = start(supervisor.commands.agent(id)?, "csat agent")?;
            pids += &format!(" {}", child.id().unwrap_or_default());
            supervisor.agents.spawn(stay_with(id, child, supervisor.pipes.subscribe()));
        }
        supervisor.tell_processes(count, &pids);
        Ok(supervisor)
    }

    fn tell_processes(&self, count: u16, pids: &str) {
        if !self.commands.arguments.run.json {
            let endpoint = &self.commands.endpoint;
            tell!("{count} agents on {endpoint}; look on with `csat watch --connect {endpoint}`");
            let pid = self.world.id().unwrap_or_default();
            tell!("processes: world {pid}, agents from 0 on{pids}");
        }
    }

    /// Watches all processes until the world has ended.
    pub async fn run(&mut self, mut signals: Signals) -> Result<ExitStatus, SpawnError> {
        loop {
            tokio::select! {
                status = self.world.wait() => return status.map_err(SpawnError::Watch),
                () = signals.next() => {
                    if self.is_stopped {
                        self.world.kill().await.map_err(SpawnError::Watch)?;
                        return self.world.wait().await.map_err(SpawnError::Watch);
                    }
                    self.stop();
                }
                // A stopped world would not notice that no agent is left.
                () = tokio::time::sleep(WAKE_PERIOD), if self.agents.is_empty() => {
                    wake(self.world.id());
                }
                Some(Ok(end)) = self.agents.join_next() => self.agent_ended(end)?,
            }
        }
    }

    /// Ends the mission in order.
    fn stop(&mut self) {
        self.is_stopped = true;
        self.world_pipe.take();
        wake(self.world.id());
        tell!("\nending after this step; Ctrl-C again ends at once");
    }

    /// Starts an agent's process again, if it is to be.
    fn agent_ended(&mut self, AgentEnd { id, status }: AgentEnd) -> Result<(), SpawnError> {
        let restarts = &mut self.restarts[usize::from(id)];
        // A process that ends well knows that the mission is over, even if the world has not ended yet.
        let is_over = status.as_ref().is_ok_and(ExitStatus::success);
        let is_restarted = self.commands.arguments.restart && !is_over && *restarts < MAX_RESTARTS;
        tell_end(&named([id], self.uavs), &status, is_restarted);
        if is_restarted {
            *restarts += 1;
            let command = self.commands.agent(id)?;
            self.agents.spawn(start_again(id, command, self.pipes.subscribe()));
        }
        Ok(())
    }

    /// Ends all agents after the world. Returns whether a signal has ended the mission.
    pub async fn end(mut self) -> bool {
        if !self.is_stopped {
            let _ = tokio::time::timeout(END_LIMITS[0], all_ended(&mut self.agents)).await;
        }
        drop(self.pipes);
        let _ = tokio::time::timeout(END_LIMITS[1], all_ended(&mut self.agents)).await;
        // The end of a task kills its process.
        self.agents.shutdown().await;
        self.is_stopped
    }
}

async fn all_ended(agents: &mut JoinSet<AgentEnd>) {
    while agents.join_next().await.is_some() {}
}

/// Waits for the end of an agent's process, and closes its pipe when all pipes are to be closed.
async fn stay_with(id: u16, mut child: Child, mut pipe_end: watch::Receiver<()>) -> AgentEnd {
    // `wait` closes standard input: the pipe must outlive it.
    let pipe = child.stdin.take();
    let status = tokio::select! {
        status = child.wait() => status,
        _ = pipe_end.changed() => {
            drop(pipe);
            wake(child.id());
            child.wait().await
        }
    };
    AgentEnd { id, status }
}

/// The same for a process that is started after a while.
async fn start_again(id: u16, mut agent: Command, mut pipe_end: watch::Receiver<()>) -> AgentEnd {
    tokio::select! {
        () = tokio::time::sleep(RESTART_DELAY) => {}
        _ = pipe_end.changed() => return AgentEnd { id, status: Ok(ExitStatus::default()) },
    }
    match agent.spawn() {
        Ok(child) => {
            tell!("agent {id} is process {} now", child.id().unwrap_or_default());
            stay_with(id, child, pipe_end).await
        }
        Err(error) => AgentEnd { id, status: Err(error) },
    }
}

/// Lets a stopped process go on, because it cannot end in order; does nothing to any other.
fn wake(pid: Option<u32>) {
    if let Some(pid) = pid.and_then(|pid| i32::try_from(pid).ok()) {
        let _ = kill(Pid::from_raw(pid), Signal::SIGCONT);
    }
}

fn tell_end(name: &str, status: &io::Result<ExitStatus>, is_restarted: bool) {
    match status {
        // The mission is over.
        Ok(status) if status.success() => {}
        Ok(status) => {
            let then = if is_restarted { "starting it again" } else { "the others carry on" };
            tell!("the process of {name} ended ({status}); {then}");
        }
        Err(error) => tell!("the process of {name} is out of sight: {error}"),
    }
}

/// The exit code of `csat spawn` after the end of the world.
pub fn exit_code(world: ExitStatus, is_stopped: bool, logs: TempDir) -> u8 {
    match world.code() {
        Some(code) => u8::try_from(code).unwrap_or(FAILED),
        None if is_stopped => INTERRUPTED,
        None => {
            // The world, which moves the logs into its run folder, did not.
            let logs = logs.keep();
            tell!("the world was killed ({world}); the agents' logs are in `{}`", logs.display());
            FAILED
        }
    }
}
