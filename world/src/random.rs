//! One random stream per (seed, purpose, index), so that the draws of one stream do not affect another.

use csat_netem::normal_quantile;
use csat_proto::ids::{AgentId, TargetId};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The purpose of a stream.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StreamPurpose {
    /// The streets of a generated town.
    Streets,
    /// The buildings of a generated town.
    Buildings,
    /// The streets of a desert suburb.
    Desert,
    /// The decisions of one car.
    Car(TargetId),
    /// The manner of one car that evades.
    Evader(TargetId),
    /// The place of one target off the roads.
    Place(TargetId),
    /// The random walk of one target.
    Walk(TargetId),
    /// The navigation errors of one UAV.
    Navigation(AgentId),
    /// The errors of the motion of one UAV.
    Motion(AgentId),
    /// The errors of the odometry of one UAV.
    Odometry(AgentId),
    /// The errors of the position fixes and of the dead reckoning of one UAV.
    Observer(AgentId),
}

/// The stream of `purpose` under the scenario's `seed`.
pub(crate) fn stream(seed: u64, purpose: StreamPurpose) -> ChaCha8Rng {
    // The upper half is the purpose (in ASCII, so that it is unlikely to equal a tag of another
    // module), the lower half the index of the car or the UAV.
    let (tag, index) = match purpose {
        StreamPurpose::Streets => (*b"road", 0),
        StreamPurpose::Buildings => (*b"town", 0),
        StreamPurpose::Desert => (*b"dsrt", 0),
        StreamPurpose::Car(id) => (*b"cars", u32::from(id.0)),
        StreamPurpose::Evader(id) => (*b"evad", u32::from(id.0)),
        StreamPurpose::Place(id) => (*b"spot", u32::from(id.0)),
        StreamPurpose::Walk(id) => (*b"walk", u32::from(id.0)),
        StreamPurpose::Navigation(id) => (*b"navi", u32::from(id.0)),
        StreamPurpose::Motion(id) => (*b"move", u32::from(id.0)),
        StreamPurpose::Odometry(id) => (*b"odom", u32::from(id.0)),
        StreamPurpose::Observer(id) => (*b"obsv", u32::from(id.0)),
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(u32::from_be_bytes(tag)) << 32 | u64::from(index));
    rng
}

/// A standard normal number, from one draw.
pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    const PART: f64 = 1.0 / (1u64 << 52) as f64;
    // The middle of one of 2⁵² equal parts of (0, 1): neither end has a finite quantile.
    normal_quantile(((rng.next_u64() >> 12) as f64 + 0.5) * PART)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_by_seed_purpose_and_car() {
        let first = |seed, purpose| stream(seed, purpose).next_u64();
        let mut draws = vec![
            first(1, StreamPurpose::Streets),
            first(2, StreamPurpose::Streets),
            first(1, StreamPurpose::Buildings),
            first(1, StreamPurpose::Car(TargetId(0))),
            first(1, StreamPurpose::Car(TargetId(1))),
            first(1, StreamPurpose::Evader(TargetId(1))),
            first(1, StreamPurpose::Place(TargetId(1))),
            first(1, StreamPurpose::Walk(TargetId(1))),
            first(1, StreamPurpose::Navigation(AgentId(0))),
            first(1, StreamPurpose::Navigation(AgentId(1))),
            first(1, StreamPurpose::Desert),
            first(1, StreamPurpose::Motion(AgentId(0))),
            first(1, StreamPurpose::Motion(AgentId(1))),
            first(1, StreamPurpose::Odometry(AgentId(0))),
            first(1, StreamPurpose::Odometry(AgentId(1))),
        ];
        assert_eq!(draws[0], first(1, StreamPurpose::Streets));
        draws.sort_unstable();
        draws.dedup();
        assert_eq!(draws.len(), 15);
    }
}
