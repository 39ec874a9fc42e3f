//! The command lines of the processes that `csat spawn` starts.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Stdio;

use tokio::process::{Child, Command};

use super::error::SpawnError;
use crate::cli::fleet::SpawnArguments;
use crate::provenance::spawned_by;

/// Zenoh's threads, all in one: a fleet has many processes and few cores.
const ZENOH_RUNTIME: &str = "(rx:(handover:app),acc:(handover:app),tx:(handover:app),\
                             net:(handover:app),app:(worker_threads:1))";

/// What the command lines are made of.
pub struct Commands<'a> {
    /// Those of `csat spawn`.
    pub arguments: &'a SpawnArguments,
    /// Where the world listens.
    pub endpoint: String,
    /// The seed of the mission, which names the run.
    pub seed: u64,
    /// Where agents write their logs; the world moves them into its run folder at the end.
    pub logs: PathBuf,
}

impl Commands<'_> {
    /// The world.
    pub fn world(&self) -> Result<Command, SpawnError> {
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
        Ok(command)
    }

    /// An agent.
    pub fn agent(&self, id: u16) -> Result<Command, SpawnError> {
        let mut command = self.command("agent")?;
        command.args(["--id", &id.to_string(), "--run", &self.seed.to_string()]);
        command.args(["--patience", &self.arguments.pace.patience.as_secs().to_string()]);
        command.arg("--log").arg(self.logs.join(format!("agent-{id}.log")));
        command.args(["--connect", &self.endpoint]).stdout(Stdio::null());
        Ok(command)
    }

    fn command(&self, what: &str) -> Result<Command, SpawnError> {
        let program =
            std::env::current_exe().map_err(|source| SpawnError::Start { what: "csat", source })?;
        let mut command = Command::new(program);
        command.arg(what).arg("--end-with-parent").stdin(Stdio::piped()).kill_on_drop(true);
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

/// Starts a process.
pub fn start(mut command: Command, what: &'static str) -> Result<Child, SpawnError> {
    command.spawn().map_err(|source| SpawnError::Start { what, source })
}

fn option(command: &mut Command, name: &str, value: Option<&impl ToString>) {
    if let Some(value) = value {
        command.arg(name).arg(OsString::from(value.to_string()));
    }
}
