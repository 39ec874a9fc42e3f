//! One random stream per (seed, purpose, index), so that the draws of one stream do not affect another.

use csat_proto::ids::TargetId;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The purpose of a stream.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StreamPurpose {
    /// The streets of a generated town.
    Streets,
    /// The buildings of a generated town.
    Buildings,
    /// The decisions of one car.
    Car(TargetId),
    /// The manner of one car that evades.
    Evader(TargetId),
}

/// The stream of `purpose` under the scenario's `seed`.
pub(crate) fn stream(seed: u64, purpose: StreamPurpose) -> ChaCha8Rng {
    // The upper half is the purpose (in ASCII, so that it is unlikely to equal a tag of another
    // module), the lower half the index of the car.
    let (tag, index) = match purpose {
        StreamPurpose::Streets => (*b"road", 0),
        StreamPurpose::Buildings => (*b"town", 0),
        StreamPurpose::Car(id) => (*b"cars", u32::from(id.0)),
        StreamPurpose::Evader(id) => (*b"evad", u32::from(id.0)),
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(u32::from_be_bytes(tag)) << 32 | u64::from(index));
    rng
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

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
        ];
        assert_eq!(draws[0], first(1, StreamPurpose::Streets));
        draws.sort_unstable();
        draws.dedup();
        assert_eq!(draws.len(), 6);
    }
}
