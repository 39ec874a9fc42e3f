//! `provenance.json`: what it takes to fly the same mission again.

use serde::{Deserialize, Serialize};

/// Where a run comes from.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of `csat`.
    pub version: String,
    /// Git revision it was built from; `None` when not built in a repository.
    pub git_revision: Option<String>,
    /// Whether that tree had changes that were not committed.
    pub git_dirty: Option<bool>,
    /// The compiler.
    pub rustc: String,
    /// `debug` or `release`.
    pub profile: String,
    /// The command line of the user: that of `csat spawn` for the world it spawned.
    pub arguments: Vec<String>,
    /// Name of the scenario.
    pub scenario: String,
    /// Its seed.
    pub seed: u64,
    /// The line that every program that shows the map has to show with it.
    pub map_attribution: Option<String>,
    /// What it ran on.
    pub machine: Machine,
}

/// A computer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Operating system and architecture.
    pub platform: String,
    /// Model of the processor, if it says so.
    pub cpu: Option<String>,
    /// Cores available to the process.
    pub cores: usize,
    /// Threads used.
    pub threads: usize,
}

/// Which build of `csat` flew something.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Build {
    /// Version of `csat`.
    pub version: String,
    /// Git revision it was built from; `None` when not built in a repository.
    pub git_revision: Option<String>,
    /// Whether that tree had changes that were not committed.
    pub git_dirty: Option<bool>,
    /// Operating system and architecture.
    pub platform: String,
}

impl Build {
    /// This program.
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            git_revision: option_env!("CSAT_GIT_REVISION").map(str::to_owned),
            git_dirty: option_env!("CSAT_GIT_DIRTY").map(|dirty| dirty == "true"),
            platform: format!("{}-{}", std::env::consts::OS, std::env::consts::ARCH),
        }
    }

    /// Whether the same mission is the same to the last bit, as far as the program's source tells.
    pub fn is_same_source(&self, other: &Self) -> bool {
        let source = |b: &Self| (b.version.clone(), b.git_revision.clone(), b.git_dirty);
        source(self) == source(other)
    }
}

impl std::fmt::Display for Build {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let revision = self.git_revision.as_deref().unwrap_or("unknown");
        let dirty = if self.git_dirty == Some(true) {
            ", with changes that were not committed"
        } else {
            ""
        };
        write!(f, "{}, revision {revision}{dirty}, {}", self.version, self.platform)
    }
}

impl Provenance {
    /// Of this program and process, for a run of `scenario` with `seed`.
    pub fn collect(scenario: &str, seed: u64, map_attribution: Option<String>) -> Self {
        let Build { version, git_revision, git_dirty, platform } = Build::this();
        Self {
            version,
            git_revision,
            git_dirty,
            rustc: option_env!("CSAT_RUSTC").unwrap_or("unknown").to_owned(),
            profile: if cfg!(debug_assertions) { "debug" } else { "release" }.to_owned(),
            arguments: command_line(),
            scenario: scenario.to_owned(),
            seed,
            map_attribution,
            machine: Machine {
                platform,
                cpu: cpu_model(),
                cores: std::thread::available_parallelism().map_or(1, usize::from),
                threads: rayon::current_num_threads(),
            },
        }
    }
}

const SPAWNED_BY: &str = "CSAT_SPAWNED_BY";

/// The environment variable, and its value, in which `csat spawn` tells its world the user's command
/// line.
pub fn spawned_by() -> (&'static str, String) {
    (SPAWNED_BY, serde_json::Value::from(command_line()).to_string())
}

fn command_line() -> Vec<String> {
    let spawned_by = std::env::var(SPAWNED_BY).ok();
    let told = spawned_by.and_then(|line| serde_json::from_str(&line).ok());
    told.unwrap_or_else(|| std::env::args().collect())
}

fn cpu_model() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
