//! States that follow each other from message to message of a link.

use crate::draw::{Block, Draws};

/// Chains begin anew at every multiple of this sequence number, with a state of their stationary
/// distribution.
///
/// It bounds what one message can cost, whatever number it carries (a peer could claim any). The
/// states are distributed the same all the same; only, the first one of each epoch does not
/// remember the last one of the epoch before.
pub const EPOCH: u64 = 1 << 16;

/// A chain of states, advanced by sequence number: the state of a number is a function of the
/// random numbers of its epoch up to it, in whatever order numbers are asked for. Numbers that are
/// never asked for advance it too.
#[derive(Debug, Clone)]
pub struct Chain<S> {
    latest: Option<(u64, S)>,
}

impl<S> Default for Chain<S> {
    fn default() -> Self {
        Self { latest: None }
    }
}

impl<S: Copy> Chain<S> {
    /// The state at `sequence`, where an epoch begins with `first` and goes on with `next`.
    pub fn at(
        &mut self,
        sequence: u64,
        draws: &mut Draws,
        first: impl Fn(&Block) -> S,
        next: impl Fn(S, &Block) -> S,
    ) -> S {
        let epoch = sequence - sequence % EPOCH;
        let (mut at, mut state) = match self.latest {
            Some((at, state)) if (epoch..=sequence).contains(&at) => (at, state),
            _ => (epoch, first(draws.block(epoch))),
        };
        while at < sequence {
            at += 1;
            state = next(state, draws.block(at));
        }
        self.latest = Some((at, state));
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Purpose;
    use crate::fate::tests::sent;

    /// A state that remembers everything before it.
    fn hash_at(chain: &mut Chain<u64>, draws: &mut Draws, sequence: u64) -> u64 {
        let next = |state: u64, block: &Block| {
            state.rotate_left(7).wrapping_mul(0x9E37_79B9) ^ block.bits(Purpose::Chain)
        };
        chain.at(sequence, draws, |block| block.bits(Purpose::Chain), next)
    }

    #[test]
    fn the_state_of_a_number_does_not_depend_on_the_order_of_questions() {
        let mut draws = Draws::of_messages(3, &sent(0));
        let mut forward = Chain::default();
        let numbers = [0, 1, 2, 7, 1000, EPOCH - 1, EPOCH, EPOCH + 1, EPOCH + 70];
        let states = numbers.map(|n| hash_at(&mut forward, &mut draws, n));
        let mut backward = Chain::default();
        for (&number, &state) in numbers.iter().zip(&states).rev() {
            assert_eq!(hash_at(&mut backward, &mut draws, number), state);
            assert_eq!(hash_at(&mut backward, &mut draws, number), state, "asked twice");
            assert_eq!(hash_at(&mut Chain::default(), &mut draws, number), state);
        }
        hash_at(&mut backward, &mut draws, u64::MAX);
        assert_eq!(hash_at(&mut backward, &mut draws, 7), states[3]);
    }
}
