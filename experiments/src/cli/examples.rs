//! Examples in the help of each command; a test runs the parser over them.

/// `csat run`.
pub const RUN: &str = "\
Examples:
  csat run                                            the paper's city with seed 1
  csat run helsinki-05 --seed 7 --set agents.count=6
  csat run city --set netem.radio.range_m=150 --set netem.radio.loss=0.3
  csat run my.toml --out runs/first --record=5        with a recording, every 5 s
  csat run runs/city-seed1/scenario.resolved.toml     the same mission again
  csat run city --json --set run.duration_s=60        the summary for another program

`csat keys` lists what --set changes, `csat scenarios` what is shipped.";

/// `csat spawn`.
pub const SPAWN: &str = "\
Examples:
  csat spawn                                 the paper's city, a process for each UAV
  csat spawn city-storm --realtime 1         nobody waits, one simulated second per second
  csat spawn city --restart --seed 3         processes that end are started again
  csat spawn city --listen tcp/0.0.0.0:7447  other machines may look on";

/// `csat world`.
pub const WORLD: &str = "\
Examples:
  csat world city --seed 3                                   waits for four agents
  csat world city --set agents.count=2 --listen tcp/0.0.0.0:7447
  csat world my.toml --realtime 1 --patience 300

Each agent is a `csat agent --id N --connect ENDPOINT`, on this machine or another.";

/// `csat agent`.
pub const AGENT: &str = "\
Examples:
  csat agent --id 0                                UAV 0 of the world on this machine
  csat agent --id 1 --connect tcp/192.168.1.7:7447
  csat agent --id 2 --run 3 --patience 300         of the mission with seed 3";

/// `csat compare`.
pub const COMPARE: &str = "\
Examples:
  csat compare runs/city-seed1 runs/city-seed2
  csat compare sweeps/before sweeps/after --json";

/// `csat check`.
pub const CHECK: &str = "\
Examples:
  csat check my.toml
  csat check city --set map.file=my-town.geojson   what of a map is used, and what is left out";

/// `csat replay`.
pub const REPLAY: &str = "\
Examples:
  csat replay runs/city-seed1
  csat replay runs/city-seed1 --speed 10 --loop";

/// `csat plot`.
pub const PLOT: &str = "\
Examples:
  csat plot runs/city-seed1
  csat plot runs/city-seed1 --agent 2      a map of what UAV 2 knows
  csat plot runs/city-seed1 --agent all    of all, as small multiples";

/// `csat scenarios`.
pub const SCENARIOS: &str = "\
Examples:
  csat scenarios                    what is shipped
  csat scenarios city               its TOML, to begin a file of your own with:
  csat scenarios city > my.toml";

/// `csat keys`.
pub const KEYS: &str = "\
Examples:
  csat keys                         all keys
  csat keys netem.radio             those of a table
  csat keys agents.speed_m_s
  csat keys --json                  for another program";

/// `csat completions`.
pub const COMPLETIONS: &str = "\
Examples:
  csat completions bash > ~/.local/share/bash-completion/completions/csat
  csat completions zsh > ~/.zfunc/_csat              with ~/.zfunc in fpath
  csat completions fish > ~/.config/fish/completions/csat.fish";

/// `csat man`.
pub const MAN: &str = "\
Examples:
  csat man | man -l -                                the first page
  csat man --out ~/.local/share/man/man1             all pages";
