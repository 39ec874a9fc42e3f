//! `csat spawn`: one world and its agents as processes of this machine, and none left behind.
//!
//! Every child holds the reading end of a pipe as its standard input, a leash: when this process
//! ends, however it does, the pipe closes and the child ends itself. Children are in process groups
//! of their own, so that Ctrl-C reaches this process only and the mission ends in order.

use std::ffi::OsString;
use std::io;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{ExitStatus, Stdio};
use std::time::Duration;

use clap::Args;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tempfile::TempDir;
use tokio::process::{Child, Command};
use tokio::signal::unix::{SignalKind, signal};
use tokio::sync::watch;
use tokio::task::JoinSet;

use crate::cli::RunArguments;
use crate::provenance::spawned_by;
use crate::scenario::Loaded;
use crate::verdict::{FAILED, INTERRUPTED};
use csat_mission::words::named;
use csat_peer::arguments::PaceArguments;
use csat_peer::tell;
use csat_peer::wire::config::{DEFAULT_ADDRESS, scheme};
use csat_peer::wire::session::{self, WireError};

/// How long agents may take to hear of the end of their world, and how long to end when they are let go.
const FAREWELLS: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(4)];
/// How often a world is woken that goes on, or does not, after all its agents have ended.
const WAKE_PERIOD: Duration = Duration::from_secs(5);
/// How long a process is gone before it is restarted.
const RESTART_DELAY: Duration = Duration::from_millis(500);
/// How often one agent is restarted; more is a program that cannot run.
const MAX_RESTARTS: u32 = 100;
/// Zenoh's threads, all on one: a fleet has many processes and few cores.
const ZENOH_RUNTIME: &str = "(rx:(handover:app),acc:(handover:app),tx:(handover:app),\
                             net:(handover:app),app:(worker_threads:1))";

/// `csat spawn`.
#[derive(Debug, Clone, Args)]
pub struct SpawnArguments {
    /// What to fly and where to write it down.
    #[command(flatten)]
    pub run: RunArguments,
    /// How time passes and how long to wait.
    #[command(flatten)]
    pub pace: PaceArguments,
    /// Start an agent's process again when it ends before the mission
    #[arg(long)]
    pub restart: bool,
    /// Where the world listens [default: tcp/127.0.0.1:7447, or any free port if that is taken]
    #[arg(long, value_name = "ENDPOINT")]
    pub listen: Option<String>,
    /// A Zenoh configuration (JSON5) for all processes, such as TLS and access control
    #[arg(long, value_name = "FILE")]
    pub zenoh_config: Option<PathBuf>,
}

/// Why processes could not be had.
#[derive(Debug, thiserror::Error)]
pub enum SpawnError {
    /// Its Zenoh configuration.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// No port.
    #[error("there is no free port on 127.0.0.1: {0}")]
    Port(io::Error),
    /// Nowhere to write logs to.
    #[error("there is no temporary folder for logs: {0}")]
    Logs(io::Error),
    /// No process.
    #[error("cannot start `{what}`: {error}")]
    Start {
        /// Which.
        what: String,
        /// The system's reason.
        error: io::Error,
    },
    /// No runtime or signals.
    #[error("cannot watch processes: {0}")]
    Watch(io::Error),
}

/// Starts a world and all agents of a scenario and stays until all have ended. Gives the world's exit
/// code.
///
/// # Errors
/// When a process cannot be started or watched.
pub fn spawn(arguments: &SpawnArguments, loaded: &Loaded) -> Result<u8, SpawnError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(SpawnError::Watch)?.block_on(supervise(arguments, loaded))
}

/// A process that ended, and which agent's it was.
type Ended = (u16, io::Result<ExitStatus>);

/// Waits for the end of an agent's process, and lets go of it when all are let go of.
async fn stay_with(id: u16, mut child: Child, mut leash_end: watch::Receiver<()>) -> Ended {
    // `wait` closes standard input: the leash must outlive it.
    let leash = child.stdin.take();
    let status = tokio::select! {
        status = child.wait() => status,
        _ = leash_end.changed() => {
            drop(leash);
            wake(child.id());
            child.wait().await
        }
    };
    (id, status)
}

/// The same for one that is started after a while.
async fn start_again(id: u16, mut agent: Command, mut leash_end: watch::Receiver<()>) -> Ended {
    tokio::select! {
        () = tokio::time::sleep(RESTART_DELAY) => {}
        _ = leash_end.changed() => return (id, Ok(ExitStatus::default())),
    }
    match agent.spawn() {
        Ok(child) => {
            tell!("agent {id} is process {} now", child.id().unwrap_or_default());
            stay_with(id, child, leash_end).await
        }
        Err(error) => (id, Err(error)),
    }
}

async fn all_ended(agents: &mut JoinSet<Ended>) {
    while agents.join_next().await.is_some() {}
}

/// A process that is stopped cannot end in order; for any other this is nothing.
fn wake(pid: Option<u32>) {
    if let Some(pid) = pid.and_then(|pid| i32::try_from(pid).ok()) {
        let _ = kill(Pid::from_raw(pid), Signal::SIGCONT);
    }
}

async fn supervise(arguments: &SpawnArguments, loaded: &Loaded) -> Result<u8, SpawnError> {
    let endpoint = match &arguments.listen {
        Some(endpoint) => session::with_a_port(endpoint),
        None => {
            let scheme = scheme(arguments.zenoh_config.as_deref())?;
            format!("{scheme}/{}", free_address().map_err(SpawnError::Port)?)
        }
    };
    let logs = tempfile::Builder::new().prefix("csat-logs-").tempdir().map_err(SpawnError::Logs)?;
    let (leashes, leash_end) = watch::channel(());
    let nursery = Nursery {
        arguments,
        endpoint,
        seed: loaded.scenario.seed,
        logs: logs.path().to_owned(),
        leash_end,
    };
    let stop = |kind| signal(kind).map_err(SpawnError::Watch);
    let mut stops = (stop(SignalKind::interrupt())?, stop(SignalKind::terminate())?);
    let mut world = nursery.world()?;
    let mut leash = world.stdin.take();
    let mut is_stopped = false;
    let mut agents: JoinSet<Ended> = JoinSet::new();
    let count = loaded.scenario.agent_count();
    let mut pids = String::new();
    for id in 0..count {
        let child = start(nursery.agent(id)?, "csat agent")?;
        pids += &format!(" {}", child.id().unwrap_or_default());
        agents.spawn(stay_with(id, child, nursery.leash_end.clone()));
    }
    if !arguments.run.json {
        let endpoint = &nursery.endpoint;
        tell!("{count} agents on {endpoint}; look on with `csat watch --connect {endpoint}`");
        let pid = world.id().unwrap_or_default();
        tell!("processes: world {pid}, agents from 0 on{pids}");
    }
    let mut restarts = vec![0; usize::from(count)];
    let status = loop {
        tokio::select! {
            status = world.wait() => break status.map_err(SpawnError::Watch)?,
            _ = async { tokio::select! { _ = stops.0.recv() => (), _ = stops.1.recv() => () } } => {
                if is_stopped { break end_at_once(&mut world).await?; }
                is_stopped = true;
                leash.take();
                wake(world.id());
                tell!("\nending after this step; Ctrl-C again ends at once");
            }
            // One that is stopped would not notice that nobody is left.
            () = tokio::time::sleep(WAKE_PERIOD), if agents.is_empty() => wake(world.id()),
            Some(Ok((id, status))) = agents.join_next() => {
                let count = &mut restarts[usize::from(id)];
                // Whose mission is over ended well, be it before the world did.
                let is_over = status.as_ref().is_ok_and(ExitStatus::success);
                let is_restarted = arguments.restart && !is_over && *count < MAX_RESTARTS;
                let name = named([id], loaded.scenario.agents.count);
                tell(&name, &status, is_restarted);
                if is_restarted {
                    *count += 1;
                    let again = nursery.agent(id)?;
                    agents.spawn(start_again(id, again, nursery.leash_end.clone()));
                }
            }
        }
    };
    // They have been told; those that were not in time are let go.
    if !is_stopped {
        let _ = tokio::time::timeout(FAREWELLS[0], all_ended(&mut agents)).await;
    }
    drop(leashes);
    let _ = tokio::time::timeout(FAREWELLS[1], all_ended(&mut agents)).await;
    // Any that are left then are killed with their handles.
    agents.shutdown().await;
    Ok(conclude(status, is_stopped, logs))
}

/// The exit code that the world's end amounts to.
fn conclude(world: ExitStatus, is_stopped: bool, logs: TempDir) -> u8 {
    match world.code() {
        Some(code) => u8::try_from(code).unwrap_or(FAILED),
        None if is_stopped => INTERRUPTED,
        None => {
            // Nobody took them over.
            let logs = logs.keep();
            tell!("the world was killed ({world}); the agents' logs are in `{}`", logs.display());
            FAILED
        }
    }
}

async fn end_at_once(child: &mut Child) -> Result<ExitStatus, SpawnError> {
    child.kill().await.map_err(SpawnError::Watch)?;
    child.wait().await.map_err(SpawnError::Watch)
}

fn tell(name: &str, status: &io::Result<ExitStatus>, is_restarted: bool) {
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

/// Zenoh's own port, or any other if that is taken.
fn free_address() -> io::Result<String> {
    if TcpListener::bind(DEFAULT_ADDRESS).is_ok() {
        return Ok(DEFAULT_ADDRESS.to_owned());
    }
    Ok(TcpListener::bind("127.0.0.1:0")?.local_addr()?.to_string())
}

/// Starts processes.
struct Nursery<'a> {
    arguments: &'a SpawnArguments,
    endpoint: String,
    seed: u64,
    /// Where agents write their logs; the world takes them over at the end.
    logs: PathBuf,
    /// Changes when agents' processes are let go of.
    leash_end: watch::Receiver<()>,
}

impl Nursery<'_> {
    fn world(&self) -> Result<Child, SpawnError> {
        let SpawnArguments { run, pace, .. } = self.arguments;
        let mut command = self.command("world")?;
        command.envs([spawned_by()]);
        command.args(&run.scenario.scenario);
        for set in &run.scenario.sets {
            command.arg("--set").arg(set);
        }
        option(&mut command, "--seed", run.scenario.seed.as_ref());
        if let Some(out) = &run.out {
            command.arg("--out").arg(out);
        }
        if run.json {
            command.arg("--json");
        }
        option(&mut command, "--threads", run.threads.as_ref());
        if let Some(period_s) = run.record {
            command.arg(format!("--record={period_s}"));
        }
        option(&mut command, "--realtime", pace.realtime.as_ref());
        if self.arguments.restart {
            command.arg("--restarts");
        }
        command.args(["--patience", &pace.patience.as_secs().to_string()]);
        command.args(["--listen", &self.endpoint]).arg("--logs").arg(&self.logs);
        start(command, "csat world")
    }

    fn agent(&self, id: u16) -> Result<Command, SpawnError> {
        let mut command = self.command("agent")?;
        command.args(["--id", &id.to_string(), "--run", &self.seed.to_string()]);
        command.args(["--patience", &self.arguments.pace.patience.as_secs().to_string()]);
        command.arg("--log").arg(self.logs.join(format!("agent-{id}.log")));
        command.args(["--connect", &self.endpoint]).stdout(Stdio::null());
        Ok(command)
    }

    fn command(&self, what: &str) -> Result<Command, SpawnError> {
        let program = std::env::current_exe()
            .map_err(|error| SpawnError::Start { what: "csat".to_owned(), error })?;
        let mut command = Command::new(program);
        command.arg(what).arg("--leashed").stdin(Stdio::piped()).kill_on_drop(true);
        command.process_group(0);
        if std::env::var_os("ZENOH_RUNTIME").is_none() {
            command.env("ZENOH_RUNTIME", ZENOH_RUNTIME);
        }
        if let Some(path) = &self.arguments.zenoh_config {
            command.arg("--zenoh-config").arg(path);
        }
        Ok(command)
    }
}

fn option(command: &mut Command, name: &str, value: Option<&impl ToString>) {
    if let Some(value) = value {
        command.arg(name).arg(OsString::from(value.to_string()));
    }
}

fn start(mut command: Command, what: &str) -> Result<Child, SpawnError> {
    command.spawn().map_err(|error| SpawnError::Start { what: what.to_owned(), error })
}
