//! The checks of a message before it is believed.

use csat_proto::envelope::{Envelope, EnvelopeError, decode_whole};
use csat_proto::ids::{AgentId, MAX_TARGETS, TargetId};
use csat_proto::message::{Digest, Fact, Known, Message, Relay};
use csat_proto::oem::OemPatch;
use csat_proto::raster::Raster;
use csat_proto::region::{Region, to_units, twice_signed_area};
use csat_proto::time::Step;

use super::crossing::{self, RingFault};
use super::version_vector::MAX_INCARNATIONS;
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;

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
    /// The sender has restarted since.
    #[error("incarnation {got}, but {known} was heard already")]
    Incarnation {
        /// The message's.
        got: u32,
        /// The newest one of that agent.
        known: u32,
    },
    /// The sender was proven to have said something false.
    #[error("agent {from} was proven to have said something false")]
    Liar {
        /// The sender's index.
        from: u16,
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
    /// In this mission, or as a station, the sender does not pass on the plans of others.
    #[error("plans of other UAVs, which this sender does not pass on in this mission")]
    Relay,
    /// The plans that it passes on are not by increasing UAV.
    #[error("passed-on plans are not by increasing UAV")]
    RelayOrder,
    /// The body does not decode, or bytes are left over.
    #[error("malformed body")]
    Malformed,
    /// Steps of header and body differ.
    #[error("header says step {header}, body step {body}")]
    Step {
        /// The header's.
        header: u32,
        /// The body's.
        body: u32,
    },
    /// What was known before a frame is of a later step than the frame.
    #[error("knowledge of step {known} before a frame of step {frame}")]
    KnownStep {
        /// The knowledge's.
        known: u32,
        /// The frame's.
        frame: u32,
    },
    /// More vertices than are accepted.
    #[error("{got} vertices, at most {max} are accepted")]
    TooManyVertices {
        /// Their number.
        got: usize,
        /// The limit.
        max: usize,
    },
    /// A set leaves the region of interest.
    #[error("a set leaves the region of interest")]
    Outside,
    /// An outer ring is not counter-clockwise or a hole not clockwise.
    #[error("a ring is wound the wrong way")]
    Winding,
    /// Two edges of a set cross.
    #[error("rings of a set cross each other or themselves")]
    Crossing,
    /// Edges of a set lie so close together that checking them would take too long.
    #[error("edges of a set are bundled too densely to be checked")]
    Bundle,
    /// Target indexes are not strictly increasing, or too large.
    #[error("targets are not listed once each by increasing index below {MAX_TARGETS}")]
    Targets,
    /// A raster on another grid.
    #[error("a raster is on another grid")]
    Grid,
    /// Cells outside the map.
    #[error("cells up to {got} of a map of {cells}")]
    Cell {
        /// One past the last.
        got: u64,
        /// Number of cells.
        cells: usize,
    },
    /// A digest of agents that do not exist, out of order, or of another map.
    #[error("a digest of {facts} lives and {blocks} blocks does not fit the fleet and its map")]
    Digest {
        /// Incarnations that it lists.
        facts: usize,
        /// Blocks that it lists.
        blocks: usize,
    },
    /// More messages wait than a fleet can have sent within `max_age_s`.
    #[error("{max} messages wait already")]
    Full {
        /// The limit.
        max: usize,
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
            Self::Liar { .. } => "liar",
            Self::Future { .. } => "future",
            Self::TooOld { .. } => "too-old",
            Self::Malformed => "malformed",
            Self::Relay => "relay",
            Self::RelayOrder => "relay-order",
            Self::Step { .. } => "step",
            Self::KnownStep { .. } => "known-step",
            Self::TooManyVertices { .. } => "vertices",
            Self::Outside => "outside",
            Self::Winding => "winding",
            Self::Crossing => "crossing",
            Self::Bundle => "bundle",
            Self::Digest { .. } => "digest",
            Self::Targets => "targets",
            Self::Grid => "grid",
            Self::Cell { .. } => "cell",
            Self::Full { .. } => "full",
        }
    }
}

/// Checks that a sender is another UAV or ground station of this mission.
///
/// # Errors
/// [`Rejection::Sender`] when it is not.
pub fn check_sender(config: &AgentConfig, src: AgentId) -> Result<(), Rejection> {
    let agents = config.agents();
    if src.0 >= agents || src == config.id {
        return Err(Rejection::Sender { got: src.0, agents });
    }
    Ok(())
}

/// Checks header and body against the configuration; `now` is the step of the receiver.
///
/// # Errors
/// The first check that fails.
pub fn check(config: &AgentConfig, now: Step, envelope: &Envelope) -> Result<Message, Rejection> {
    check_header(config, now, envelope)?;
    let message: Message = decode_whole(&envelope.body).ok_or(Rejection::Malformed)?;
    let body = match &message {
        Message::Fact(fact) => fact.step,
        Message::Snapshot(snapshot) => snapshot.fact.step,
        Message::Plan(plan) => plan.step,
        Message::Relay(relay) => relay.step,
    };
    if body != envelope.step {
        return Err(Rejection::Step { header: envelope.step.0, body: body.0 });
    }
    check_vertices(config.exchange.max_vertices, &message)?;
    match &message {
        Message::Fact(fact) => check_fact(config, fact)?,
        Message::Snapshot(snapshot) => {
            check_fact(config, &snapshot.fact)?;
            check_known(config, &snapshot.known, body)?;
        }
        // The scheduler of guidance checks plans: which plans are possible depends on the schedule.
        Message::Plan(_) => {}
        Message::Relay(relay) => check_relay(config, envelope.src, relay)?,
    }
    Ok(message)
}

/// Checks that a fact, and what was known before it, have at most `max` vertices each.
///
/// # Errors
/// [`Rejection::TooManyVertices`] when they have more.
pub fn check_vertices(max: u32, message: &Message) -> Result<(), Rejection> {
    let within = |sets: &mut dyn Iterator<Item = &Region>| {
        let (got, max) = (sets.map(Region::vertex_count).sum::<usize>(), max as usize);
        if got <= max { Ok(()) } else { Err(Rejection::TooManyVertices { got, max }) }
    };
    match message {
        Message::Fact(fact) => within(&mut sets_of_fact(fact)),
        Message::Snapshot(snapshot) => {
            within(&mut sets_of_fact(&snapshot.fact))?;
            within(&mut sets_of_known(&snapshot.known))
        }
        Message::Plan(_) | Message::Relay(_) => Ok(()),
    }
}

/// The scheduler checks the plans; a plan of this receiver itself says nothing new.
fn check_relay(config: &AgentConfig, src: AgentId, relay: &Relay) -> Result<(), Rejection> {
    if !config.relays_plans() || src.0 >= config.fleet.count {
        return Err(Rejection::Relay);
    }
    let is_ascending = relay.plans.windows(2).all(|pair| pair[0].uav < pair[1].uav);
    if is_ascending { Ok(()) } else { Err(Rejection::RelayOrder) }
}

fn sets_of_fact(fact: &Fact) -> impl Iterator<Item = &Region> {
    let of_targets = fact.targets.iter().flat_map(|t| [&t.location, &t.exclusion]);
    [&fact.clear_ground, &fact.obstacle_margin].into_iter().chain(of_targets)
}

fn sets_of_known(known: &Known) -> impl Iterator<Item = &Region> {
    let of_targets = known.targets.iter().map(|(_, set)| set);
    [&known.unexplored, &known.obstacle_margin].into_iter().chain(of_targets)
}

fn check_header(config: &AgentConfig, now: Step, envelope: &Envelope) -> Result<(), Rejection> {
    if envelope.run != config.run {
        return Err(Rejection::Run);
    }
    // Another agent may already be in the step of this agent's next frame.
    let ahead = config.steps(config.exchange.clock_skew_s).saturating_add(1);
    if envelope.step > now.after(ahead) {
        return Err(Rejection::Future { got: envelope.step.0, now: now.0 });
    }
    let age_s = f64::from(now.0.saturating_sub(envelope.step.0)) * config.period_s;
    let max_s = config.exchange.max_age_s;
    if age_s > max_s {
        return Err(Rejection::TooOld { age_s, max_s });
    }
    Ok(())
}

fn check_fact(config: &AgentConfig, fact: &Fact) -> Result<(), Rejection> {
    check_digest(config, &fact.held)?;
    check_targets(fact.targets.iter().map(|t| t.target))?;
    check_rasters(config, [&fact.hidden, &fact.seen])?;
    check_cells(config, &fact.oem)?;
    check_regions(config, sets_of_fact(fact))
}

/// `frame` is the step of the fact in the same snapshot.
fn check_known(config: &AgentConfig, known: &Known, frame: Step) -> Result<(), Rejection> {
    if known.step > frame {
        return Err(Rejection::KnownStep { known: known.step.0, frame: frame.0 });
    }
    check_targets(known.targets.iter().map(|(j, _)| *j))?;
    check_regions(config, sets_of_known(known))
}

fn check_digest(config: &AgentConfig, held: &Digest) -> Result<(), Rejection> {
    let (facts, blocks) = (held.facts.len(), held.oem.len());
    let agents = config.agents();
    let fits = facts <= usize::from(agents) * MAX_INCARNATIONS
        && held.facts.is_sorted_by_key(|f| (f.origin, f.incarnation))
        && held.facts.iter().all(|f| f.origin.0 < agents)
        && (blocks == 0 || blocks == Oem::blocks(&config.oem_grid()));
    if fits { Ok(()) } else { Err(Rejection::Digest { facts, blocks }) }
}

fn check_targets(targets: impl Iterator<Item = TargetId>) -> Result<(), Rejection> {
    let mut previous = None;
    for target in targets {
        if target.0 >= MAX_TARGETS || previous >= Some(target) {
            return Err(Rejection::Targets);
        }
        previous = Some(target);
    }
    Ok(())
}

fn check_regions<'a>(
    config: &AgentConfig,
    regions: impl Iterator<Item = &'a Region>,
) -> Result<(), Rejection> {
    // Exclusions may exceed the border of the region by their radius.
    let slack_m = config.targets.target_distance_m + 1.0;
    let limit = config.ground.size_m.map(|size| to_units(size / 2.0 + slack_m));
    for region in regions {
        let outside = |p: &csat_proto::region::GridPoint| {
            p.x.unsigned_abs() > limit[0] as u32 || p.y.unsigned_abs() > limit[1] as u32
        };
        if region.rings().flatten().any(outside) {
            return Err(Rejection::Outside);
        }
        crossing::check(region).map_err(|tangle| match tangle {
            RingFault::Crossing => Rejection::Crossing,
            RingFault::TooDense => Rejection::Bundle,
        })?;
        for shape in region.shapes() {
            let wound = |(i, ring): (usize, &Vec<_>)| (twice_signed_area(ring) > 0) == (i == 0);
            if !shape.iter().enumerate().all(wound) {
                return Err(Rejection::Winding);
            }
        }
    }
    Ok(())
}

fn check_rasters(config: &AgentConfig, rasters: [&Raster; 2]) -> Result<(), Rejection> {
    let grid = config.raster_grid();
    if rasters.iter().all(|raster| *raster.grid() == grid) { Ok(()) } else { Err(Rejection::Grid) }
}

fn check_cells(config: &AgentConfig, oem: &OemPatch) -> Result<(), Rejection> {
    let (got, cells) = (oem.end(), config.oem_grid().cells());
    if got <= cells as u64 { Ok(()) } else { Err(Rejection::Cell { got, cells }) }
}
