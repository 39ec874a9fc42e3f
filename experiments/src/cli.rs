//! The command line of `csat`.

pub mod advice;
mod examples;
pub mod fleet;
pub mod run;

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use clap_complete::Shell;

use crate::plot::Whose;
use crate::scenario::shipped;
use crate::tools::doctor::DoctorArguments;
use crate::tools::echo::EchoArguments;
use crate::watch::arguments::WatchArguments;
use csat_peer::arguments::{AgentArguments, speed};
use csat_peer::wire::session::WireArguments;
use fleet::{SpawnArguments, WorldArguments};
pub use run::{RunArguments, ScenarioArguments};

/// Cooperative search and tracking: a fleet of UAVs finds and follows the cars of an unknown town
/// with guaranteed sets.
#[derive(Debug, Clone, Parser)]
#[command(name = "csat", version, propagate_version = true, after_help = AFTER_HELP)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  csat run                                  fly the paper's city with seed 1
  csat run helsinki-05 --seed 7 --set agents.count=6 --set netem.radio.range_m=150
  csat sweep city --vary netem.radio.range_m=25,50,100,200,400,inf --seeds 1..5
  csat reproduce chapter5                   the thesis's tables and figures, ours beside theirs
  csat check my.toml                        every mistake at once, with its line
  csat spawn                                the same as processes, each a Zenoh peer
  csat watch                                watch a fleet that flies in the browser
  csat echo view/0/targets                  what a UAV says it knows
  csat doctor                               why nothing is heard
  csat run --record && csat replay runs/city-seed1 --speed 10
  csat compare runs/city-seed1 runs/city-seed2
  csat plot runs/city-seed1                 draw the pictures of a run again
  csat keys agents                          what --set can change, with defaults and units
  csat scenarios city > my.toml             a file of your own to begin with

Exit codes:
  0    done
  1    something failed, such as a full disk
  2    bad input: nothing was run
  3    the mission flew, and the guarantee or a separation was violated
  130  ended early by Ctrl-C: the run folder is whole up to there, a sweep can be resumed";

/// What to do.
#[derive(Debug, Clone, Subcommand)]
pub enum Command {
    /// Fly one mission in this process, in virtual time, as fast as it goes
    #[command(after_help = examples::RUN)]
    Run(RunArguments),
    /// Fly one mission as a world and its agents in processes of their own, each a Zenoh peer
    #[command(after_help = examples::SPAWN)]
    Spawn(SpawnArguments),
    /// Fly the world's side of a mission whose agents are processes of their own
    #[command(after_help = examples::WORLD)]
    World(WorldArguments),
    /// Fly one agent of a mission whose world is another process
    #[command(after_help = examples::AGENT)]
    Agent(AgentArguments),
    /// Fly every combination of values with every seed; tables, plots and a report
    Sweep(SweepArguments),
    /// Make the published tables and figures again, ours beside theirs
    Reproduce(ReproduceArguments),
    /// Put two runs, two sweeps or two reproductions side by side
    #[command(after_help = examples::COMPARE)]
    Compare(CompareArguments),
    /// Report every mistake of a scenario at once; flies nothing
    #[command(after_help = examples::CHECK)]
    Check(ScenarioArguments),
    /// Play a recording again for whoever listens on Zenoh, at its own pace or another
    #[command(after_help = examples::REPLAY)]
    Replay(ReplayArguments),
    /// Show a fleet that flies, or a recorded run, as a live map in the browser
    Watch(WatchArguments),
    /// Show what a fleet that flies says, a line for each, or how much
    Echo(EchoArguments),
    /// Tell who is in the network, what they say, and why a subscriber hears nothing
    Doctor(DoctorArguments),
    /// Draw the pictures of a run folder again, from its view.json, summary.json and metrics.csv
    #[command(after_help = examples::PLOT)]
    Plot {
        /// The run folder
        #[arg(value_hint = ValueHint::DirPath)]
        dir: PathBuf,
        /// Draw what agent N knew at the end as map-agent-N.svg instead, or with `all` every agent as
        /// map-agents.svg; map.svg shows agent 0
        #[arg(long, value_name = "N|all")]
        agent: Option<Whose>,
    },
    /// List the shipped scenarios, or print one
    #[command(after_help = examples::SCENARIOS)]
    Scenarios {
        /// The one whose TOML to print
        #[arg(value_parser = PossibleValuesParser::new(shipped::scenario_names()))]
        name: Option<String>,
    },
    /// List the keys of a scenario with default, unit, what they may be and what they mean
    #[command(after_help = examples::KEYS)]
    Keys {
        /// Only those whose path begins so, such as netem.radio
        #[arg(default_value = "", hide_default_value = true)]
        prefix: String,
        /// As JSON
        #[arg(long)]
        json: bool,
    },
    /// Print what makes a shell complete the words of `csat`
    #[command(after_help = examples::COMPLETIONS)]
    Completions {
        /// Which shell
        shell: Shell,
    },
    /// Print the manual page, or write those of all commands
    #[command(after_help = examples::MAN)]
    Man {
        /// Write csat.1, csat-run.1 and so on into this folder
        #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
        out: Option<PathBuf>,
    },
}

/// What to play and how.
#[derive(Debug, Clone, Args)]
pub struct ReplayArguments {
    /// The folder of a run flown with --record, or a recording
    pub dir: PathBuf,
    /// Simulated seconds per second
    #[arg(long, value_name = "X", default_value = "1", value_parser = speed)]
    pub speed: f64,
    /// Begin again at the end, until Ctrl-C
    #[arg(long = "loop")]
    pub repeat: bool,
    /// How to reach whoever listens; without it, they connect to this process.
    #[command(flatten)]
    pub wire: WireArguments,
}

/// What to sweep and how.
#[derive(Debug, Clone, Args)]
#[command(after_help = SWEEP_HELP)]
pub struct SweepArguments {
    /// A shipped scenario or a TOML file.
    #[arg(help = shipped::scenario_help(), value_hint = ValueHint::FilePath)]
    #[arg(conflicts_with = "merge")]
    pub scenario: Option<String>,
    /// Values of a key, separated by commas; may be repeated for every combination
    #[arg(long, value_name = "KEY=A,B,C", conflicts_with = "merge")]
    pub vary: Vec<String>,
    /// The seeds of every combination: `1..5` is 1, 2, 3, 4 and 5; `1,4,7` is a list
    #[arg(long, value_name = "SEEDS", required_unless_present = "merge", conflicts_with = "merge")]
    pub seeds: Option<String>,
    /// Change one value in all runs, such as run.duration_s=60; may be repeated, later ones win
    #[arg(long = "set", value_name = "KEY=VALUE", conflicts_with = "merge")]
    pub sets: Vec<String>,
    /// Also fly perfect links, to compare with [default: when a key of netem varies]
    #[arg(long, conflicts_with_all = ["merge", "no_baseline"])]
    pub baseline: bool,
    /// Do not fly perfect links
    #[arg(long, conflicts_with = "merge")]
    pub no_baseline: bool,
    /// What the report's differences within a seed are from: a value of what varies, or `perfect` for
    /// perfect links [default: perfect links where they are flown to compare with, else the first value]
    #[arg(long, value_name = "KEY=VALUE")]
    pub against: Option<String>,
    /// Missions at a time, each on one thread; files are the same for any number [default: one per
    /// core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Fly only the i-th of n parts (from 1), in a folder that all parts may share; needs --out
    #[arg(long, value_name = "I/N", requires = "out", conflicts_with = "merge")]
    pub shard: Option<String>,
    /// Go on with the same sweep, or let it grow by seeds, values or keys: what is flown stays, what
    /// failed is flown again
    #[arg(long, conflicts_with = "merge")]
    pub resume: bool,
    /// With --resume or --merge: take runs of other versions of csat, too; the report names them
    #[arg(long)]
    pub mix_versions: bool,
    /// Go on when a run fails or violates a guarantee; this is the default
    #[arg(long, conflicts_with_all = ["merge", "fail_fast"])]
    pub keep_going: bool,
    /// Stop at the first run that fails or violates a guarantee
    #[arg(long, conflicts_with = "merge")]
    pub fail_fast: bool,
    /// Keep the run folders too, in DIR/folders
    #[arg(long, conflicts_with = "merge")]
    pub keep_runs: bool,
    /// The sweep's folder, new or empty without --resume [default: sweeps/SCENARIO-KEYS, numbered]
    #[arg(long, value_name = "DIR", conflicts_with = "merge")]
    pub out: Option<PathBuf>,
    /// Bring the runs of these folders into the first and make its tables and report; seeds and values
    /// may differ
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub merge: Vec<PathBuf>,
    /// Print what became of the runs as JSON on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// What to compare.
#[derive(Debug, Clone, Args)]
pub struct CompareArguments {
    /// The folder of a run, of a sweep or of a reproduction
    pub a: PathBuf,
    /// Another one of the same kind; differences are those of B less A
    pub b: PathBuf,
    /// Print all numbers as JSON on stdout, and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// What to make again and how.
#[derive(Debug, Clone, Args)]
#[command(after_help = REPRODUCE_HELP)]
pub struct ReproduceArguments {
    /// Which results
    pub what: Published,
    /// The seeds of the missions, or in chapter4 and chapter6 of the depth noise [default: 1..10, chapter4:
    /// 1..100, chapter6: 1..100, tisdale: 1..20]
    #[arg(long, value_name = "SEEDS")]
    pub seeds: Option<String>,
    /// Shorter missions, seconds; their means are over the second half all the same
    #[arg(long, value_name = "S")]
    pub duration: Option<f64>,
    /// Change one value besides what is reproduced, such as camera.columns=240; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// Missions at a time, each on one thread; in chapter4 and chapter6, threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: Option<u16>,
    /// Go on with the same reproduction: what is flown stays
    #[arg(long)]
    pub resume: bool,
    /// The folder, new or empty without --resume [default: reproductions/WHAT, numbered]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the tables as JSON on stdout, and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Published results that can be made again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Published {
    /// Thesis §5.4: five criteria, ten missions of 300 s each (9 minutes of one core)
    Chapter5,
    /// The paper's table I: three criteria, ten missions of 300 s each (6 minutes of one core)
    Table1,
    /// Thesis §4.7 and A.1.4: one look of one UAV at five cars (2 minutes of one core)
    Chapter4,
    /// Thesis §6.6 and A.4: one look at five cars from a pose that is only known to a box (1 minute of one core)
    Chapter6,
    /// Tisdale et al. 2008: table II, figures 2 to 7; twenty flights, each filtered by four representations (6 minutes
    /// of one core)
    Tisdale,
    /// Gagliardi et al. 2014: figures 8 to 10; ten networks, 1800 s each (3 minutes of one core)
    Clearing,
}

const REPRODUCE_HELP: &str = "\
Examples:
  csat reproduce chapter5
  csat reproduce table1 --seeds 1..3 --duration 60 --jobs 2
  csat reproduce chapter4 --out reproductions/look
  csat reproduce clearing --seeds 1..3

DIR holds report.html (tables and plots, needs no network), tables.txt and tables.json; chapter5, table1
and clearing are sweeps, so it also holds what `csat sweep --keep-runs` leaves: sweep.json, runs/, folders/,
sweep.csv, sweep_means.csv and sweep_pairs.csv. With more --seeds, --resume flies those that are new.

Exit codes:
  0    done
  1    a run failed; the others were flown
  2    bad input: nothing was run
  3    a run violated a guarantee or a separation
  130  ended early by Ctrl-C: the same command with --resume goes on";

const SWEEP_HELP: &str = "\
Examples:
  csat sweep city --vary netem.radio.range_m=25,50,inf --seeds 1..5
  csat sweep city --vary agents.count=2,4,8 --seeds 1..10 --resume --out sweeps/fleets
  csat sweep city --vary agents.count=2,4 --seeds 1..10 --shard 1/2 --out sweeps/shared

Values are TOML or plain words, split at the commas outside of brackets and quotes:
  --vary netem.radio.range_m=25,50,inf
  --vary 'netem.radio.loss={model=\"iid\",p=0.1},bad:{model=\"iid\",p=0.5}'   `bad` is a label
  --vary 'agents.count,targets.count=(2,4),(4,8)'                           together
Several --vary make every combination; the report has the first one along its axes, the second one
as colours.

DIR holds sweep.json (what belongs to the sweep), runs/ (a file per finished run), sweep.csv (a row
per run), sweep_means.csv (means, deviations, confidence), sweep_pairs.csv (differences within a
seed) and report.html.

With --resume a sweep grows: the same command with more seeds, more values or further keys flies
what is new.

Exit codes:
  0    done
  1    a run failed; the others were flown (report.html says how to fly it again)
  2    bad input: nothing was run
  3    a run violated a guarantee or a separation
  130  ended early by Ctrl-C: the same command with --resume goes on";

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    /// The commands that a help text shows, without what a shell does with them.
    fn shown(help: &str) -> impl Iterator<Item = Vec<String>> {
        let commands = help.lines().filter_map(|line| line.strip_prefix("  csat "));
        commands.map(|line| {
            let ends = ["   ", "  ", " > ", " | ", " && "].iter().filter_map(|end| line.find(end));
            let line = &line[..ends.min().unwrap_or(line.len())];
            let words = line.split_whitespace().map(|word| word.replace('\'', ""));
            std::iter::once("csat".to_owned()).chain(words).collect()
        })
    }

    #[test]
    fn every_command_has_examples_that_the_parser_takes() {
        let cli = Cli::command();
        let help = |command: &clap::Command| {
            command.get_after_help().map(ToString::to_string).unwrap_or_default()
        };
        let mut examples: Vec<Vec<String>> = shown(&help(&cli)).collect();
        for command in cli.get_subcommands() {
            let own: Vec<_> = shown(&help(command)).collect();
            let begin = ["csat", command.get_name()];
            assert!(own.iter().any(|words| words[..2] == begin), "{}", command.get_name());
            examples.extend(own);
        }
        assert!(examples.len() > 40, "{}", examples.len());
        for words in examples {
            if let Err(error) = Cli::try_parse_from(&words) {
                panic!("{words:?}: {error}");
            }
        }
    }
}
