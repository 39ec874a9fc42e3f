//! Markov chains along the messages of a link.

use crate::draw::{Block, Draws};

/// Length of an epoch, sequence numbers. At the first number of each epoch a chain starts again, with a
/// state drawn from its stationary distribution.
///
/// Epochs bound the steps that one message can cost, since a message may carry any sequence number.
/// They do not change the distribution of the states; only the first state of an epoch is independent
/// of the last state of the epoch before.
pub const EPOCH: u64 = 1 << 16;

/// A Markov chain that advances by sequence number. The state at a number is a function of the random
/// numbers of its epoch up to that number, so the order of the queries does not matter. Numbers for
/// which no caller asks advance the chain too.
#[derive(Debug, Clone)]
pub struct MarkovChain<S> {
    latest: Option<(u64, S)>,
}

impl<S> Default for MarkovChain<S> {
    fn default() -> Self {
        Self { latest: None }
    }
}

impl<S: Copy> MarkovChain<S> {
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

    /// A state that depends on all states before it in its epoch.
    fn hash_at(chain: &mut MarkovChain<u64>, draws: &mut Draws, sequence: u64) -> u64 {
        let next = |state: u64, block: &Block| {
            state.rotate_left(7).wrapping_mul(0x9E37_79B9) ^ block.bits(Purpose::Chain)
        };
        chain.at(sequence, draws, |block| block.bits(Purpose::Chain), next)
    }

    #[test]
    fn the_state_of_a_number_does_not_depend_on_the_order_of_queries() {
        let mut draws = Draws::of_messages(3, &sent(0));
        let mut forward = MarkovChain::default();
        let numbers = [0, 1, 2, 7, 1000, EPOCH - 1, EPOCH, EPOCH + 1, EPOCH + 70];
        let states = numbers.map(|n| hash_at(&mut forward, &mut draws, n));
        let mut backward = MarkovChain::default();
        for (&number, &state) in numbers.iter().zip(&states).rev() {
            assert_eq!(hash_at(&mut backward, &mut draws, number), state);
            assert_eq!(hash_at(&mut backward, &mut draws, number), state, "asked twice");
            assert_eq!(hash_at(&mut MarkovChain::default(), &mut draws, number), state);
        }
        hash_at(&mut backward, &mut draws, u64::MAX);
        assert_eq!(hash_at(&mut backward, &mut draws, 7), states[3]);
    }
}
