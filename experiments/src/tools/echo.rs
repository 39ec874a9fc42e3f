//! `csat echo`: what is said on which keys.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use zenoh::Session;
use zenoh::key_expr::KeyExpr;

use super::ear::{Ear, Heard, Listen};
use super::keys::{BadKey, key_expression};
use super::line;
use super::rates::{self, Rates};
use csat_mission::timing::Stopwatch;
use csat_peer::tell;
use csat_peer::wire::session::{self, Role, WireArguments, WireError};

/// How often the flag of Ctrl-C is looked at.
const LOOK: Duration = Duration::from_millis(100);
/// How often rates are shown.
const RATES_PERIOD: Duration = Duration::from_secs(1);
/// How long nothing comes until that is said.
const HINT_AFTER: Duration = Duration::from_secs(5);
/// How many keys a table has that is drawn again and again.
const TERMINAL_ROWS: usize = 20;

/// `csat echo`.
#[derive(Debug, Clone, Default, Args)]
#[command(after_help = HELP)]
pub struct EchoArguments {
    /// Which keys, a Zenoh key expression; what does not begin with `csat/` is taken as below
    /// `csat/*/` [default: csat/**]
    #[arg(value_name = "KEYEXPR")]
    pub keys: Option<String>,
    /// End after the first one
    #[arg(long)]
    pub once: bool,
    /// A line of JSON for each, in full
    #[arg(long)]
    pub json: bool,
    /// Show every second how many come and how long they are, by key
    #[arg(long, conflicts_with = "once")]
    pub rates: bool,
    /// Show who comes and goes (liveliness tokens) instead of what is said
    #[arg(long, conflicts_with = "rates")]
    pub alive: bool,
    /// Fail when nothing comes within so long, seconds [default: wait for ever]
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    pub patience: Option<u64>,
    /// How to reach the fleet.
    #[command(flatten)]
    pub wire: WireArguments,
}

const HELP: &str = "\
Keys are in docs/topics.md. Ctrl-C ends. Ctrl-Z, which stops without ending, may hold up a fleet in
lockstep for some seconds.

Examples:
  csat echo                           all that is said
  csat echo view/0/targets            what UAV 0 knows of targets
  csat echo 'link/**' --rates         who says how much
  csat echo clock --once --json       one order of the world
  csat echo --alive                   processes that come and go
  csat echo 'view/*/pose' --connect tcp/10.0.0.7:7447";

/// Why nothing was shown.
#[derive(Debug, thiserror::Error)]
pub enum EchoError {
    /// The session.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// The key expression.
    #[error(transparent)]
    Key(#[from] BadKey),
    /// Something else of Zenoh.
    #[error("Zenoh: {0}")]
    Zenoh(String),
    /// Nothing came.
    #[error(
        "got nothing on `{keys}` within {limit_s} s, connected to {connect}\n  = `csat doctor --key \
         '{keys}'` tells why"
    )]
    Silence {
        /// The key expression.
        keys: String,
        /// How long.
        limit_s: u64,
        /// Endpoints.
        connect: String,
    },
    /// The reader of what is shown.
    #[error("cannot write to stdout: {0}")]
    Output(#[from] io::Error),
}

impl EchoError {
    /// Whether the user asked for something that cannot be.
    pub fn is_mistake(&self) -> bool {
        matches!(self, Self::Wire(_) | Self::Key(_))
    }
}

/// Shows what comes until `interrupted`. With `redraw`, tables are drawn over each other.
///
/// # Errors
/// When there is no session, no such key, or nothing comes. A reader that has seen enough is none.
pub fn echo(
    arguments: &EchoArguments,
    interrupted: &AtomicBool,
    out: &mut dyn Write,
    redraw: bool,
) -> Result<(), EchoError> {
    let keys = key_expression(arguments.keys.as_deref())?;
    let session = session::open(&arguments.wire, Role::Spectator)?;
    let shown = listen(&session, &keys, arguments, interrupted, &mut Screen::new(out, redraw));
    session::close(session);
    match shown {
        Err(EchoError::Output(error)) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        shown => shown,
    }
}

fn listen(
    session: &Session,
    keys: &KeyExpr<'static>,
    arguments: &EchoArguments,
    interrupted: &AtomicBool,
    screen: &mut Screen<'_>,
) -> Result<(), EchoError> {
    let what = match arguments {
        EchoArguments { alive: true, .. } => Listen::Tokens,
        EchoArguments { rates: true, .. } => Listen::Sizes,
        _ => Listen::Bodies,
    };
    let ear = Ear::open(session, keys, what);
    let ear = ear.map_err(|error| EchoError::Zenoh(error.to_string()))?;
    let mut silence = Some(Silence::new(arguments, keys));
    while !interrupted.load(Ordering::SeqCst) {
        if let Some(heard) = ear.next(LOOK) {
            silence = None;
            screen.show(&heard, arguments)?;
            if arguments.once {
                break;
            }
        }
        if arguments.rates {
            screen.show_rates(arguments.json)?;
        }
        if let Some(silence) = &mut silence {
            silence.check()?;
        }
    }
    if arguments.rates {
        screen.show_sums(arguments.json)?;
    }
    match ear.missed() {
        0 => {}
        missed => tell!("{missed} more came faster than they could be shown"),
    }
    Ok(())
}

/// Nothing came yet.
struct Silence<'a> {
    arguments: &'a EchoArguments,
    keys: &'a KeyExpr<'static>,
    since: Stopwatch,
    is_told: bool,
}

impl<'a> Silence<'a> {
    fn new(arguments: &'a EchoArguments, keys: &'a KeyExpr<'static>) -> Self {
        Self { arguments, keys, since: Stopwatch::start(), is_told: false }
    }

    fn check(&mut self) -> Result<(), EchoError> {
        if let Some(limit_s) = self.arguments.patience
            && self.since.left(Duration::from_secs(limit_s)).is_zero()
        {
            let connect = session::shown_endpoints(&self.arguments.wire, Role::Spectator);
            return Err(EchoError::Silence { keys: self.keys.to_string(), limit_s, connect });
        }
        if !self.is_told && self.since.left(HINT_AFTER).is_zero() {
            self.is_told = true;
            let keys = self.keys;
            tell!("nothing on `{keys}` yet; `csat doctor --key '{keys}'` tells why");
        }
        Ok(())
    }
}

/// Where it is shown.
struct Screen<'a> {
    out: &'a mut dyn Write,
    redraw: bool,
    rates: Rates,
    /// Since the first table's beginning, and since the last one.
    since: [Stopwatch; 2],
    /// Lines of the last table, to be drawn over.
    lines: usize,
}

impl<'a> Screen<'a> {
    fn new(out: &'a mut dyn Write, redraw: bool) -> Self {
        let since = [Stopwatch::start(); 2];
        Self { out, redraw, rates: Rates::default(), since, lines: 0 }
    }

    fn show(&mut self, heard: &Heard, arguments: &EchoArguments) -> io::Result<()> {
        let EchoArguments { rates, alive, json, .. } = arguments;
        let line = match (alive, json) {
            _ if *rates => {
                self.rates.add(&heard.key, heard.bytes);
                return Ok(());
            }
            (false, false) => line::text(heard),
            (false, true) => line::json(heard).to_string(),
            (true, false) => line::token_text(heard),
            (true, true) => line::token_json(heard).to_string(),
        };
        writeln!(self.out, "{line}")?;
        self.out.flush()
    }

    /// Shows rates when it is time to.
    fn show_rates(&mut self, json: bool) -> io::Result<()> {
        let [_, last] = &mut self.since;
        if !last.left(RATES_PERIOD).is_zero() {
            return Ok(());
        }
        let seconds = last.elapsed_s();
        *last = Stopwatch::start();
        let counts = self.rates.take_lately();
        if json {
            writeln!(self.out, "{}", rates::table_json(&counts, seconds))?;
        } else if self.redraw {
            let table = rates::table(&counts, seconds, TERMINAL_ROWS);
            // Up to where the last table began, and clear from there.
            let up =
                if self.lines > 0 { format!("\x1b[{}A\x1b[J", self.lines) } else { String::new() };
            self.lines = table.lines().count();
            write!(self.out, "{up}{table}")?;
        } else {
            writeln!(self.out, "{}", rates::table(&counts, seconds, usize::MAX))?;
        }
        self.out.flush()
    }

    fn show_sums(&mut self, json: bool) -> io::Result<()> {
        let seconds = self.since[0].elapsed_s();
        let counts = self.rates.total();
        if json {
            writeln!(self.out, "{}", rates::table_json(counts, seconds))?;
        } else {
            let total: rates::Traffic = counts.values().copied().sum();
            write!(
                self.out,
                "\nin {seconds:.1} s: {} messages, {}\n{}",
                total.messages,
                rates::size(total.bytes as f64),
                rates::table(counts, seconds, usize::MAX)
            )?;
        }
        self.out.flush()
    }
}
