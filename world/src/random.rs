//! One random stream per (seed, who, what for), so that no draw of one decides those of another.

use csat_proto::ids::TargetId;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Purpose {
    /// Laying out the streets of a generated town.
    Streets,
    /// The buildings of a generated town.
    Buildings,
    /// Everything one car decides.
    Car(TargetId),
    /// What one car wants when it evades.
    Evader(TargetId),
}

/// The stream of `purpose` under the scenario's `seed`.
pub(crate) fn stream(seed: u64, purpose: Purpose) -> ChaCha8Rng {
    // The upper half names the purpose (in ASCII, so that other modules' tags are unlikely to
    // meet it), the lower half who.
    let (tag, who) = match purpose {
        Purpose::Streets => (*b"road", 0),
        Purpose::Buildings => (*b"town", 0),
        Purpose::Car(id) => (*b"cars", u32::from(id.0)),
        Purpose::Evader(id) => (*b"evad", u32::from(id.0)),
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from(u32::from_be_bytes(tag)) << 32 | u64::from(who));
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
            first(1, Purpose::Streets),
            first(2, Purpose::Streets),
            first(1, Purpose::Buildings),
            first(1, Purpose::Car(TargetId(0))),
            first(1, Purpose::Car(TargetId(1))),
            first(1, Purpose::Evader(TargetId(1))),
        ];
        assert_eq!(draws[0], first(1, Purpose::Streets));
        draws.sort_unstable();
        draws.dedup();
        assert_eq!(draws.len(), 6);
    }
}
