//! The checks of a message before it is believed. Its bytes may be anything.

use std::f64::consts::FRAC_PI_2;

use csat_proto::envelope::{Envelope, EnvelopeError, decode_whole};
use csat_proto::raster::Grid;
use csat_proto::time::Step;

use super::held::Held;
use super::message::{MAX_PLAN, Message, Plan};
use crate::config::AgentConfig;
use crate::factor::{Factor, ReportedPose};
use crate::search_map::CELL_M;

/// The most factors of a message: an answer to an agent that joins late has all.
pub const MAX_FACTORS: usize = 65_536;
/// How far from the region an aircraft may be, metres.
const MARGIN_M: f64 = 2000.0;
/// Aircraft fly lower than this, metres.
const MAX_HEIGHT_M: f64 = 10_000.0;
/// How far from the middle of the region the sender of a message may be, metres. It may be a ground station.
const MAX_SENDER_M: f64 = 1e6;
/// The most steps between two poses of a plan.
const MAX_PLAN_PERIOD: u32 = 10_000;

/// Why a message, or one factor of it, is not believed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Rejection {
    /// The envelope is damaged, or not one of csat.
    #[error(transparent)]
    Envelope(#[from] EnvelopeError),
    /// The message belongs to another run.
    #[error("message of another run")]
    Run,
    /// The sender is no agent of this mission, or is the receiver itself.
    #[error("sender {got} is not another one of {agents} agents")]
    Sender {
        /// The sender's index.
        got: u16,
        /// Number of agents.
        agents: u16,
    },
    /// The sender has restarted since.
    #[error("incarnation {got}, but {known} was heard already")]
    Incarnation {
        /// The message's.
        got: u32,
        /// The newest one of that agent.
        known: u32,
    },
    /// Its step is later than a clock error can explain.
    #[error("step {got} is ahead of step {now}")]
    Future {
        /// The message's step.
        got: u32,
        /// The receiver's step.
        now: u32,
    },
    /// It is older than `max_age_s`.
    #[error("{age_s} s old, at most {max_s} s are accepted")]
    TooOld {
        /// Its age, seconds.
        age_s: f64,
        /// The limit, seconds.
        max_s: f64,
    },
    /// The body does not decode, or bytes are left over.
    #[error("malformed body")]
    Malformed,
    /// Too many factors.
    #[error("{got} factors, at most {max} are accepted")]
    TooManyFactors {
        /// Their number.
        got: usize,
        /// The limit.
        max: usize,
    },
    /// A factor of an agent that is no aircraft.
    #[error("a factor of agent {got}, which is none of {aircraft} aircraft")]
    Source {
        /// The agent.
        got: u16,
        /// Number of aircraft.
        aircraft: u16,
    },
    /// A factor of a later step than its message.
    #[error("a factor of step {got} in a message of step {message}")]
    FactorStep {
        /// The factor's step.
        got: u32,
        /// The message's step.
        message: u32,
    },
    /// More factors than there were frames.
    #[error("factor number {got} at step {step}")]
    Number {
        /// The factor's number.
        got: u32,
        /// Its step.
        step: u32,
    },
    /// A pose that no aircraft of this mission has, or a sender that is too far away.
    #[error("no aircraft is at {p_world:?} m with yaw, pitch and roll {angles_rad:?}")]
    Pose {
        /// The position, `world`, metres.
        p_world: [f64; 3],
        /// Yaw, pitch and roll, radians.
        angles_rad: [f64; 3],
    },
    /// A sighting that is not in the image.
    #[error("a sighting at {got:?} in an image of {columns} × {rows} pixels")]
    Sighting {
        /// Column and row.
        got: [f32; 2],
        /// Columns of the image.
        columns: u16,
        /// Rows of the image.
        rows: u16,
    },
    /// A factor of the receiver that the receiver did not state.
    #[error("factor {number} of the own incarnation {incarnation}, which stated {stated}")]
    Forged {
        /// The factor's incarnation.
        incarnation: u32,
        /// The factor's number.
        number: u32,
        /// How many factors the receiver stated.
        stated: u32,
    },
    /// The factors that it says are held cannot be.
    #[error(
        "{incarnations} incarnations with {factors} factors do not fit the fleet at step {step}"
    )]
    Held {
        /// Incarnations that are listed.
        incarnations: usize,
        /// Factors that are listed.
        factors: u64,
        /// The message's step.
        step: u32,
    },
    /// A plan that is too long, or of other times.
    #[error("a plan of {poses} poses from step {first}, one in {period} steps, at step {step}")]
    Plan {
        /// Number of poses.
        poses: usize,
        /// The step of the first pose.
        first: u32,
        /// Steps between poses.
        period: u32,
        /// The message's step.
        step: u32,
    },
    /// A belief that does not have each place of the region once.
    #[error("a belief of {tiles} tiles does not cover the region")]
    Belief {
        /// Number of tiles.
        tiles: usize,
    },
}

impl Rejection {
    /// A short name, by which dropped messages are counted.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Envelope(EnvelopeError::Checksum) => "checksum",
            Self::Envelope(_) => "envelope",
            Self::Run => "run",
            Self::Sender { .. } => "sender",
            Self::Incarnation { .. } => "incarnation",
            Self::Future { .. } => "future",
            Self::TooOld { .. } => "too-old",
            Self::Malformed => "malformed",
            Self::TooManyFactors { .. } => "factors",
            Self::Source { .. } => "source",
            Self::FactorStep { .. } => "factor-step",
            Self::Number { .. } => "number",
            Self::Pose { .. } => "pose",
            Self::Sighting { .. } => "sighting",
            Self::Forged { .. } => "forged",
            Self::Held { .. } => "held",
            Self::Plan { .. } => "plan",
            Self::Belief { .. } => "belief",
        }
    }
}

/// Checks header and body of a message that arrived at step `now`: all that does not depend on what the receiver
/// stated itself.
///
/// # Errors
/// The first check that fails.
pub fn check(config: &AgentConfig, now: Step, envelope: &Envelope) -> Result<Message, Rejection> {
    check_header(config, now, envelope)?;
    let message: Message = decode_whole(&envelope.body).ok_or(Rejection::Malformed)?;
    let step = envelope.step;
    let (got, max) = (message.factors.len(), MAX_FACTORS);
    if got > max {
        return Err(Rejection::TooManyFactors { got, max });
    }
    for factor in &message.factors {
        check_factor(config, step, factor)?;
    }
    message.held.as_ref().map_or(Ok(()), |held| check_held(config, step, held))?;
    check_plan(config, step, &message.plan)?;
    if let Some(belief) = &message.belief
        && !belief.is_cover(&Grid::covering(&config.ground, CELL_M))
    {
        return Err(Rejection::Belief { tiles: belief.0.len() });
    }
    Ok(message)
}

fn check_header(config: &AgentConfig, now: Step, envelope: &Envelope) -> Result<(), Rejection> {
    if envelope.run != config.run {
        return Err(Rejection::Run);
    }
    let (got, agents) = (envelope.src, config.agents());
    if got.0 >= agents || got == config.id {
        return Err(Rejection::Sender { got: got.0, agents });
    }
    // Another agent may already be in the step of this agent's next frame.
    if envelope.step > now.after(1) {
        return Err(Rejection::Future { got: envelope.step.0, now: now.0 });
    }
    let age_s = f64::from(now.0.saturating_sub(envelope.step.0)) * config.period_s;
    let max_s = config.exchange.max_age_s;
    if age_s > max_s {
        return Err(Rejection::TooOld { age_s, max_s });
    }
    let csat_proto::camera::Pose { p_world, yaw_rad, pitch_rad, roll_rad } = envelope.pose.into();
    if p_world.iter().any(|x| x.abs() > MAX_SENDER_M) {
        return Err(Rejection::Pose { p_world, angles_rad: [yaw_rad, pitch_rad, roll_rad] });
    }
    Ok(())
}

/// Checks a factor in a message of step `message`: all that does not depend on who receives it.
///
/// # Errors
/// The first check that fails.
pub fn check_factor(config: &AgentConfig, message: Step, factor: &Factor) -> Result<(), Rejection> {
    let Factor { id, step, pose, sighting } = factor;
    if id.source.0 >= config.fleet.count {
        return Err(Rejection::Source { got: id.source.0, aircraft: config.fleet.count });
    }
    if *step > message {
        return Err(Rejection::FactorStep { got: step.0, message: message.0 });
    }
    if id.number > step.0 {
        return Err(Rejection::Number { got: id.number, step: step.0 });
    }
    check_pose(config, pose)?;
    let (columns, rows) = (config.camera.columns, config.camera.rows);
    match *sighting {
        Some(got) if !is_in_image(got, [columns, rows]) => {
            Err(Rejection::Sighting { got, columns, rows })
        }
        _ => Ok(()),
    }
}

/// Borders included; no number that is not finite is between them.
fn is_in_image([c, r]: [f32; 2], [columns, rows]: [u16; 2]) -> bool {
    (0.0..=f32::from(columns)).contains(&c) && (0.0..=f32::from(rows)).contains(&r)
}

/// Checks that an aircraft of this mission can have a pose.
///
/// # Errors
/// [`Rejection::Pose`] when it cannot.
pub fn check_pose(config: &AgentConfig, pose: &ReportedPose) -> Result<(), Rejection> {
    let (p_world, angles_rad) = (pose.p_world.map(f64::from), pose.angles_rad.map(f64::from));
    let [yaw, pitch, roll] = angles_rad;
    let is_near = |axis: usize| p_world[axis].abs() <= config.ground.size_m[axis] / 2.0 + MARGIN_M;
    let is_valid = is_near(0)
        && is_near(1)
        && p_world[2] > 0.0
        && p_world[2] < MAX_HEIGHT_M
        && yaw.is_finite()
        && [pitch, roll].iter().all(|angle| angle.abs() < FRAC_PI_2);
    if is_valid { Ok(()) } else { Err(Rejection::Pose { p_world, angles_rad }) }
}

/// Checks that a factor was not forged in the name of the receiver, which stated `stated` factors. Only the receiver
/// can know: others believe such a factor and relay it, so the rest of their message is honest.
///
/// # Errors
/// [`Rejection::Forged`] if it was.
pub fn check_own(config: &AgentConfig, stated: u32, factor: &Factor) -> Result<(), Rejection> {
    let (id, own) = (factor.id, config.incarnation);
    let is_earlier = id.incarnation < own || id.incarnation == own && id.number < stated;
    if id.source != config.id || is_earlier {
        return Ok(());
    }
    Err(Rejection::Forged { incarnation: id.incarnation.0, number: id.number, stated })
}

fn check_held(config: &AgentConfig, step: Step, held: &Held) -> Result<(), Rejection> {
    // The sender may hold a factor of an agent that is ahead of it.
    if held.is_sane(config.fleet.count, step.after(1).0) {
        return Ok(());
    }
    Err(Rejection::Held { incarnations: held.0.len(), factors: held.count(), step: step.0 })
}

/// Checks that a plan in a message of this step is of its time, not too long, and of possible poses.
///
/// # Errors
/// The first check that fails.
pub fn check_plan(config: &AgentConfig, step: Step, plan: &Plan) -> Result<(), Rejection> {
    let Plan { first, period, ref poses } = *plan;
    if poses.is_empty() {
        return Ok(());
    }
    let is_sane = poses.len() <= MAX_PLAN
        && (1..=MAX_PLAN_PERIOD).contains(&period)
        && first <= step.after(period);
    if !is_sane {
        return Err(Rejection::Plan { poses: poses.len(), first: first.0, period, step: step.0 });
    }
    poses.iter().try_for_each(|pose| check_pose(config, pose))
}

#[cfg(test)]
mod tests;
