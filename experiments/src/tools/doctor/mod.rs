//! `csat doctor`: who is in the network, what they say, and why a subscriber hears nothing.
//!
//! | module | what it does |
//! |---|---|
//! | [`finding`] | what it tells |
//! | [`place`] | endpoints: configured, reachable? |
//! | [`run`](mod@run) | what was heard of each run |
//! | [`judge`] | what follows from that |
//!
//! It goes the way that a sample goes, from the configuration to the key, so that the first problem
//! is mostly the cause of those below it.

pub mod finding;
pub mod judge;
pub mod place;
pub mod run;

use std::time::Duration;

use clap::Args;
use serde::Serialize;
use zenoh::key_expr::KeyExpr;
use zenoh::{Session, Wait};

pub use finding::{Finding, Level};
use place::Places;
use run::{Heard, Run};

use super::ear::{Ear, Listen};
use super::keys::{self, BadKey, key_expression};
use csat_mission::timing::Stopwatch;
use csat_mission::words::counted;
use csat_peer::wire::config::config;
use csat_peer::wire::session::{self, Role, WireArguments, WireError};

/// How long it listens.
const LISTENING: Duration = Duration::from_secs(2);
/// How long a connection may take.
const PEERS_LIMIT: Duration = Duration::from_secs(2);
/// The same where no process takes connections.
const HOPELESS_LIMIT: Duration = Duration::from_millis(300);
/// How often that is looked at.
const LOOK: Duration = Duration::from_millis(20);
/// How long questions may take.
const ANSWER_LIMIT: Duration = Duration::from_secs(1);

/// `csat doctor`.
#[derive(Debug, Clone, Default, Args)]
#[command(after_help = HELP)]
pub struct DoctorArguments {
    /// Look at this run only, a mission's seed [default: all that are heard]
    #[arg(long, value_name = "N")]
    pub run: Option<u64>,
    /// A key expression as given to `csat echo`: does anybody say what it stands for?
    #[arg(long, value_name = "KEYEXPR")]
    pub key: Option<String>,
    /// Print the findings as JSON
    #[arg(long)]
    pub json: bool,
    /// How to reach the fleet.
    #[command(flatten)]
    pub wire: WireArguments,
}

const HELP: &str = "\
It listens for two seconds and changes nothing.

Examples:
  csat doctor
  csat doctor --key view/0/targets                  why nothing is heard there
  csat doctor --connect tcp/192.168.1.7:7447 --json

Exit codes:
  0  all is well; there may be warnings
  1  there are problems
  2  bad input: nothing was examined";

/// Why nothing was examined.
#[derive(Debug, thiserror::Error)]
pub enum DoctorError {
    /// The configuration.
    #[error(transparent)]
    Wire(#[from] WireError),
    /// The key expression.
    #[error(transparent)]
    Key(#[from] BadKey),
    /// Something else of Zenoh.
    #[error("Zenoh: {0}")]
    Zenoh(String),
}

impl DoctorError {
    /// Whether the user asked for something that cannot be.
    pub fn is_mistake(&self) -> bool {
        matches!(self, Self::Wire(_) | Self::Key(_))
    }
}

fn zenoh_error(error: zenoh::Error) -> DoctorError {
    DoctorError::Zenoh(error.to_string())
}

/// All that was found.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Diagnosis {
    /// How many findings are problems.
    pub problems: usize,
    /// How many are warnings.
    pub warnings: usize,
    /// From the configuration to the keys.
    pub findings: Vec<Finding>,
    /// The runs that were heard.
    pub runs: Vec<Run>,
}

impl Diagnosis {
    /// In a line.
    pub fn verdict(&self) -> String {
        match (self.problems, self.warnings) {
            (0, 0) => "all is well".to_owned(),
            (0, warnings) => format!("no problems, {}", counted(warnings, "warning")),
            (problems, 0) => counted(problems, "problem"),
            (p, w) => format!("{}, {}", counted(p, "problem"), counted(w, "warning")),
        }
    }
}

/// Takes down what is found and tells it at once.
struct Examination<'a> {
    tell: &'a mut dyn FnMut(&Finding),
    diagnosis: Diagnosis,
}

impl Examination<'_> {
    fn found(&mut self, findings: impl IntoIterator<Item = Finding>) {
        for finding in findings {
            (self.tell)(&finding);
            self.diagnosis.problems += usize::from(finding.level == Level::Problem);
            self.diagnosis.warnings += usize::from(finding.level == Level::Warning);
            self.diagnosis.findings.push(finding);
        }
    }
}

/// Examines the network; `tell` hears each finding when it is made.
///
/// # Errors
/// When the arguments are mistaken, or Zenoh refuses to be asked.
pub fn examine(
    arguments: &DoctorArguments,
    tell: &mut dyn FnMut(&Finding),
) -> Result<Diagnosis, DoctorError> {
    let key = arguments.key.as_deref().map(|key| key_expression(Some(key))).transpose()?;
    let config = config(&arguments.wire, Role::Spectator)?;
    let mut examination = Examination { tell, diagnosis: Diagnosis::default() };
    let places = Places::of(&config);
    examination.found(places.configured());
    let reached = places.reach();
    let is_hopeless = reached.is_hopeless && places.listen.is_empty();
    examination.found(reached.findings);
    let session = match session::open(&arguments.wire, Role::Spectator) {
        Ok(session) => session,
        Err(error @ (WireError::Open { .. } | WireError::Protocol(_))) => {
            examination.found([judge::unopened(&error.problem(), error.advice())]);
            return Ok(examination.diagnosis);
        }
        Err(error) => return Err(error.into()),
    };
    let listened = listen(&session, is_hopeless);
    let examined = listened.and_then(|heard| {
        examination.found([judge::session(
            &session.zid().to_string(),
            heard.peers,
            &places,
            is_hopeless,
        )]);
        if heard.peers > 0 {
            fleet(&mut examination, arguments, heard, key.as_ref(), &session)?;
        }
        Ok(())
    });
    session::close(session);
    examined?;
    examination.found([judge::other_tools(&places)]);
    Ok(examination.diagnosis)
}

/// Explains to a process why no world answers: what came of connecting, in a line for each endpoint.
pub fn why_no_world(session: &Session, wire: &WireArguments, role: Role) -> String {
    let places = config(wire, role).map(|config| Places::of(&config)).unwrap_or_default();
    let reached = places.reach();
    let mut lines: Vec<String> = reached.findings.iter().map(|f| f.text.clone()).collect();
    let peers = peers(session);
    if peers > 0 {
        lines.push(format!("connected to {}, none of them a world", counted(peers, "process")));
    } else if !reached.is_hopeless {
        lines.push(format!("connected to nobody: {}", judge::LOCKED_OUT));
    }
    lines.join("\n")
}

/// Waits for others, and listens to them if there are any.
fn listen(session: &Session, is_hopeless: bool) -> Result<Heard, DoctorError> {
    let mut heard = Heard::default();
    let everything = KeyExpr::new(keys::ALL).map_err(zenoh_error)?;
    let ear = Ear::open(session, &everything, Listen::Bodies).map_err(zenoh_error)?;
    let limit = if is_hopeless { HOPELESS_LIMIT } else { PEERS_LIMIT };
    let watch = Stopwatch::start();
    while peers(session) == 0 && !watch.left(limit).is_zero() {
        std::thread::sleep(LOOK);
    }
    if peers(session) == 0 {
        return Ok(heard);
    }
    let watch = Stopwatch::start();
    while !watch.left(LISTENING).is_zero() {
        if let Some(sample) = ear.next(watch.left(LISTENING)) {
            heard.add(&sample);
        }
    }
    heard.seconds = watch.elapsed_s();
    heard.missed = ear.missed();
    // Only now: others connect one after the other.
    heard.peers = peers(session);
    let tokens = session.liveliness().get(everything).timeout(ANSWER_LIMIT).wait();
    for reply in tokens.map_err(zenoh_error)? {
        if let Ok(sample) = reply.into_result() {
            heard.add_token(sample.key_expr().as_str());
        }
    }
    Ok(heard)
}

fn peers(session: &Session) -> usize {
    let info = session.info();
    info.peers_zid().wait().count() + info.routers_zid().wait().count()
}

/// Judges what was heard of each run and of a key.
fn fleet(
    examination: &mut Examination<'_>,
    arguments: &DoctorArguments,
    mut heard: Heard,
    key: Option<&KeyExpr<'static>>,
    session: &Session,
) -> Result<(), DoctorError> {
    let runs = std::mem::take(&mut heard.runs);
    let (runs, others): (Vec<Run>, Vec<Run>) =
        runs.into_values().partition(|run| arguments.run.is_none_or(|wanted| run.run == wanted));
    if runs.is_empty() {
        examination.found([judge::nobody(arguments.run, &others, heard.peers)]);
    }
    for mut run in runs {
        let fleet = fleet_size(session, run.run)?;
        run.uavs = fleet.map(|(uavs, _)| uavs);
        run.expected = fleet.map(|(uavs, stations)| uavs.saturating_add(stations)).or(run.flown());
        examination.found(judge::run(&run, heard.seconds));
        examination.diagnosis.runs.push(run);
    }
    examination.found(judge::missed(heard.missed));
    if let Some(key) = key {
        examination.found([judge::key(key, &heard.keys, heard.seconds)]);
    }
    Ok(())
}

/// How many UAVs and stations a run has, if its world tells.
fn fleet_size(session: &Session, run: u64) -> Result<Option<(u16, u16)>, DoctorError> {
    let replies = session.get(format!("csat/{run}/truth/town")).timeout(ANSWER_LIMIT).wait();
    let mut towns = replies.map_err(zenoh_error)?.into_iter().filter_map(|reply| {
        let sample = reply.into_result().ok()?;
        let town: serde_json::Value = serde_json::from_slice(&sample.payload().to_bytes()).ok()?;
        let uavs = u16::try_from(town.get("agents")?.as_u64()?).ok()?;
        let stations = town.get("stations").and_then(|all| all.as_array()).map_or(0, Vec::len);
        Some((uavs, u16::try_from(stations).ok()?))
    });
    Ok(towns.next())
}
