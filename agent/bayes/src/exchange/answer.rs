//! What an agent tells one that joins late.

use csat_proto::agent::MAX_MESSAGE_BYTES;
use csat_proto::envelope::Envelope;
use csat_proto::time::Step;

use super::factor_set::FactorSet;
use super::held::Held;
use super::message::{Message, size_of};
use super::protocol::LENGTHS_BYTES;
use super::validate::{self, MAX_FACTORS};
use crate::config::{AgentConfig, ExchangeMode};
use crate::factor::Factor;
use crate::tiles::Tiles;

/// The most bytes that a message tells of the factors held. Only false factors can make it more.
const MAX_HELD_BYTES: usize = 1 << 16;

/// The factors held up to a step, or in mode `snapshot` the belief; `None` if there is nothing to tell.
pub fn message(
    config: &AgentConfig,
    step: Step,
    set: &FactorSet,
    belief: Option<Tiles>,
) -> Option<Message> {
    match config.exchange.mode {
        ExchangeMode::None => None,
        ExchangeMode::Snapshot => Some(Message { belief: Some(belief?), ..Message::default() }),
        ExchangeMode::Facts | ExchangeMode::FactsRepair => {
            let factors = newest(config, step, set);
            let message = Message { held: told(set), factors, ..Message::default() };
            (!message.factors.is_empty()).then_some(message)
        }
    }
}

/// What is told of the factors held; `None` if it is too long.
pub fn told(set: &FactorSet) -> Option<Held> {
    let held = set.held();
    (size_of(&held) <= MAX_HELD_BYTES).then_some(held)
}

/// The newest factors up to a step that fit a message, by step.
fn newest(config: &AgentConfig, step: Step, set: &FactorSet) -> Vec<Factor> {
    let mut room = MAX_MESSAGE_BYTES - Envelope::HEADER_BYTES_MAX - MAX_HELD_BYTES - LENGTHS_BYTES;
    let is_valid = |factor: &&Factor| validate::check_factor(config, step, factor).is_ok();
    let fits = |factor: &&Factor| match room.checked_sub(size_of(*factor)) {
        Some(left) => {
            room = left;
            true
        }
        None => false,
    };
    let newest = set.since(Step(0)).rev().filter(is_valid).take(MAX_FACTORS).take_while(fits);
    let mut factors: Vec<Factor> = newest.copied().collect();
    factors.reverse();
    factors
}
