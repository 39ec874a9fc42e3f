//! The checks of a message before it is believed. Its bytes may be anything.

use csat_proto::envelope::{Envelope, EnvelopeError, decode_whole};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::radio::Reception;
use csat_proto::time::Step;

use super::message::{Duty, Formation, Message};
use crate::bitmap::Bitmap;
use crate::config::AgentConfig;

/// No radio measures a greater offset than this, metres.
const MAX_OFFSET_M: f64 = 1e5;

/// Why a message is not believed.
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
    /// It says that it was sent on another channel, or the mission does not use the channel.
    #[error("a message of channel {got} on channel {on}")]
    Channel {
        /// The channel in the message.
        got: ChannelId,
        /// The one that it arrived on.
        on: ChannelId,
    },
    /// The sender has restarted since.
    #[error("incarnation {got}, but {known} was heard already")]
    Incarnation {
        /// The message's.
        got: Incarnation,
        /// The newest one of that agent.
        known: Incarnation,
    },
    /// Its step is later than a clock error can explain.
    #[error("step {got} is ahead of step {now}")]
    Future {
        /// The message's step.
        got: Step,
        /// The receiver's step.
        now: Step,
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
    /// A duty that the sender cannot have, or parts that do not belong to it.
    #[error("{duty:?} {from} says what it cannot")]
    Duty {
        /// The sender.
        from: AgentId,
        /// What it says it does.
        duty: Duty,
    },
    /// A formation with agents that are no UAVs, or are in it twice.
    #[error("a formation of agents that cannot be one")]
    Formation,
    /// A request for something outside the image.
    #[error("a request for rows {rows:?} and columns {columns:?} of an image of {size} pixels")]
    Request {
        /// First and last row.
        rows: [u16; 2],
        /// First and last column.
        columns: [u16; 2],
        /// The side of the image.
        size: u16,
    },
    /// A mask that is no set of pixels of an image.
    #[error("a mask that is none of an image of {size} pixels")]
    Mask {
        /// The side of the image.
        size: u16,
    },
    /// It arrived without an offset, or with an impossible one.
    #[error("the offset {got:?}")]
    Offset {
        /// What was measured, metres.
        got: Option<[f64; 2]>,
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
            Self::Channel { .. } => "channel",
            Self::Incarnation { .. } => "incarnation",
            Self::Future { .. } => "future",
            Self::TooOld { .. } => "too-old",
            Self::Malformed => "malformed",
            Self::Duty { .. } => "duty",
            Self::Formation => "formation",
            Self::Request { .. } => "request",
            Self::Mask { .. } => "mask",
            Self::Offset { .. } => "offset",
        }
    }
}

/// A message that is believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Received {
    /// The sender.
    pub from: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// Its step.
    pub step: Step,
    /// What it says.
    pub message: Message,
    /// The mask in it.
    pub safe: Option<Bitmap>,
    /// Where it was, from where the receiver is: east and north, metres; on `hbsr` only.
    pub offset_m: Option<[f64; 2]>,
}

/// Checks what arrived at step `now`.
///
/// # Errors
/// The first check that fails.
pub fn check(config: &AgentConfig, now: Step, got: &Reception) -> Result<Received, Rejection> {
    let envelope = Envelope::decode(&got.bytes)?;
    check_header(config, now, got.channel, &envelope)?;
    let message: Message = decode_whole(&envelope.body).ok_or(Rejection::Malformed)?;
    let from = envelope.src;
    let is_near = got.channel == config.hbsr;
    check_parts(config, from, is_near, &message)?;
    if let Some(formation) = &message.formation {
        check_formation(config, from, formation)?;
    }
    let size = config.camera.columns;
    let read = |mask: &super::message::Mask| mask.read(size).ok_or(Rejection::Mask { size });
    let safe = message.safe.as_ref().map(read).transpose()?;
    let offset_m = if is_near { Some(check_offset(got.offset_m)?) } else { None };
    let (incarnation, step) = (envelope.incarnation, envelope.step);
    Ok(Received { from, incarnation, step, message, safe, offset_m })
}

fn check_header(
    config: &AgentConfig,
    now: Step,
    on: ChannelId,
    envelope: &Envelope,
) -> Result<(), Rejection> {
    if envelope.run != config.run {
        return Err(Rejection::Run);
    }
    let (got, agents) = (envelope.src, config.agents());
    if got.0 >= agents || got == config.id {
        return Err(Rejection::Sender { got: got.0, agents });
    }
    let is_used = on == config.hbsr || on == config.lblr;
    if envelope.channel != on || !is_used {
        return Err(Rejection::Channel { got: envelope.channel, on });
    }
    // Another agent may already be in the step of this agent's next frame.
    if envelope.step > now.after(1) {
        return Err(Rejection::Future { got: envelope.step, now });
    }
    let age_s = f64::from(now.0.saturating_sub(envelope.step.0)) * config.period_s;
    let max_s = config.clearing.max_age_s;
    if age_s > max_s {
        return Err(Rejection::TooOld { age_s, max_s });
    }
    Ok(())
}

fn check_parts(
    config: &AgentConfig,
    from: AgentId,
    is_near: bool,
    message: &Message,
) -> Result<(), Rejection> {
    let Message { beat, formation, safe } = message;
    let has_parts = formation.is_some() || safe.is_some();
    let is_uav = from.0 < config.fleet.count;
    let is_leader_uav =
        beat.leader.is_none_or(|leader| leader.0 < config.fleet.count && leader != from);
    let can = is_uav
        && is_leader_uav
        && (!has_parts || is_near && beat.duty == Duty::Cleaner)
        && (!beat.has_frontier || beat.duty == Duty::Cleaner);
    if can { Ok(()) } else { Err(Rejection::Duty { from, duty: beat.duty }) }
}

fn check_formation(
    config: &AgentConfig,
    from: AgentId,
    formation: &Formation,
) -> Result<(), Rejection> {
    let Formation { heading, wings, tails, parent, requests } = formation;
    let count = usize::from(config.fleet.count);
    if tails.len() > count || requests.len() > count {
        return Err(Rejection::Formation);
    }
    let mut members: Vec<AgentId> = wings.iter().flatten().chain(tails).copied().collect();
    members.push(from);
    members.sort_unstable();
    let is_uav = |id: &AgentId| id.0 < config.fleet.count;
    let is_valid = members.windows(2).all(|pair| pair[0] != pair[1])
        && members.iter().chain(parent).all(is_uav)
        && heading.iter().all(|axis| (-1..=1).contains(axis))
        && requests.iter().all(|request| members.contains(&request.to) && request.to != from);
    if !is_valid {
        return Err(Rejection::Formation);
    }
    let size = config.camera.columns;
    for request in requests {
        let (rows, columns) = (request.rows, request.columns);
        let is_in = [rows, columns].iter().all(|[first, last]| first <= last && *last < size);
        if !is_in {
            return Err(Rejection::Request { rows, columns, size });
        }
    }
    Ok(())
}

fn check_offset(got: Option<[f64; 2]>) -> Result<[f64; 2], Rejection> {
    let is_valid = |offset: &[f64; 2]| offset.iter().all(|metres| metres.abs() <= MAX_OFFSET_M);
    got.filter(is_valid).ok_or(Rejection::Offset { got })
}

#[cfg(test)]
pub(crate) mod tests;
