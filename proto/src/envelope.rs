//! The wire format of messages: magic and version, checksum, header (sender, time, pose) and body.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::agent::MAX_MESSAGE_BYTES;
use crate::grid_pose::GridPose;
use crate::ids::{AgentId, ChannelId, Incarnation, RunId};
use crate::time::{SimTime, Step};

/// The first bytes of every message: "csat" and the version of the format.
const MAGIC: [u8; 5] = *b"csat\x02";

/// The header and the body of a message. The body is the encoded message of the mission.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Envelope {
    /// The run.
    pub run: RunId,
    /// The sender.
    pub src: AgentId,
    /// The sender's incarnation.
    pub incarnation: Incarnation,
    /// The radio.
    pub channel: ChannelId,
    /// Number of the message among those of this sender, incarnation and channel, from 0.
    pub sequence: u64,
    /// The sender's step.
    pub step: Step,
    /// The sender's simulated time.
    pub time: SimTime,
    /// Where the sender was.
    pub pose: GridPose,
    /// The encoded body.
    pub body: Vec<u8>,
}

/// Why bytes are not a valid envelope.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum EnvelopeError {
    /// Longer than any valid message.
    #[error("message of {got} bytes, at most {max} are accepted")]
    TooLong {
        /// Its length.
        got: usize,
        /// The limit.
        max: usize,
    },
    /// It does not begin with the magic and version of this format.
    #[error("not a csat message of version {}", MAGIC[4])]
    Magic,
    /// The checksum does not match: the message was damaged.
    #[error("checksum mismatch")]
    Checksum,
    /// The header does not decode, or something follows the body.
    #[error("malformed header or end")]
    Malformed,
}

/// The checksum that an encoded envelope states; 0 for bytes that do not begin like an envelope.
pub fn checksum(bytes: &[u8]) -> u32 {
    let stated = bytes.strip_prefix(&MAGIC).and_then(<[u8]>::first_chunk::<4>);
    stated.map_or(0, |checksum| u32::from_le_bytes(*checksum))
}

/// Decodes `bytes`; `None` if they are malformed or bytes are left over.
pub fn decode_whole<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    let (value, rest) = postcard::take_from_bytes(bytes).ok()?;
    rest.is_empty().then_some(value)
}

impl Envelope {
    /// An upper bound on the size of an envelope without its body, bytes.
    pub const HEADER_BYTES_MAX: usize = 88;

    /// Magic, checksum of the rest, postcard of the rest.
    pub fn encode(&self) -> Vec<u8> {
        let content = postcard::to_stdvec(self).expect("an envelope always serialises");
        let mut bytes = Vec::with_capacity(MAGIC.len() + 4 + content.len());
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&crc32fast::hash(&content).to_le_bytes());
        bytes.extend_from_slice(&content);
        bytes
    }

    /// The inverse of [`Self::encode`] for untrusted bytes.
    ///
    /// # Errors
    /// When they are longer than [`MAX_MESSAGE_BYTES`], are not an envelope from first to last byte, or
    /// do not match the checksum that they state.
    pub fn decode(bytes: &[u8]) -> Result<Self, EnvelopeError> {
        if bytes.len() > MAX_MESSAGE_BYTES {
            return Err(EnvelopeError::TooLong { got: bytes.len(), max: MAX_MESSAGE_BYTES });
        }
        let rest = bytes.strip_prefix(&MAGIC).ok_or(EnvelopeError::Magic)?;
        let (checksum, content) = rest.split_first_chunk::<4>().ok_or(EnvelopeError::Malformed)?;
        if crc32fast::hash(content) != u32::from_le_bytes(*checksum) {
            return Err(EnvelopeError::Checksum);
        }
        decode_whole(content).ok_or(EnvelopeError::Malformed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Pose;

    fn envelope() -> Envelope {
        Envelope {
            run: RunId(7),
            src: AgentId(2),
            incarnation: Incarnation(1),
            channel: ChannelId(0),
            sequence: 99,
            step: Step(12),
            time: SimTime::from_seconds(6.0),
            pose: Pose::level([1.0, 2.0, 52.0], 0.3).into(),
            body: vec![1, 2, 3],
        }
    }

    #[test]
    fn decode_inverts_encode() {
        let bytes = envelope().encode();
        assert!(bytes.len() <= Envelope::HEADER_BYTES_MAX + 3);
        assert_eq!(Envelope::decode(&bytes), Ok(envelope()));
    }

    #[test]
    fn a_header_is_as_long_as_is_said() {
        let far = Pose { yaw_rad: 3.0, pitch_rad: 3.0, roll_rad: 3.0, p_world: [-1e300; 3] };
        let longest = Envelope {
            run: RunId(u64::MAX),
            src: AgentId(u16::MAX),
            incarnation: Incarnation(u32::MAX),
            channel: ChannelId(u8::MAX),
            sequence: u64::MAX,
            step: Step(u32::MAX),
            time: SimTime(u64::MAX),
            pose: far.into(),
            body: vec![0; 1 << 21],
        };
        let bytes = longest.encode().len() - longest.body.len();
        assert!(bytes <= Envelope::HEADER_BYTES_MAX, "{bytes}");
        assert!(envelope().encode().len() < 48, "{}", envelope().encode().len());
    }

    #[test]
    fn every_single_byte_of_damage_is_noticed() {
        let bytes = envelope().encode();
        for position in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[position] ^= 0x40;
            assert!(Envelope::decode(&damaged).is_err(), "byte {position}");
        }
        assert_eq!(Envelope::decode(&bytes[..3]), Err(EnvelopeError::Magic));
        assert_eq!(Envelope::decode(&bytes[..7]), Err(EnvelopeError::Malformed));
        let long = vec![0; MAX_MESSAGE_BYTES + 1];
        assert!(matches!(Envelope::decode(&long), Err(EnvelopeError::TooLong { .. })));
    }

    #[test]
    fn nothing_follows_the_body() {
        let mut content = postcard::to_stdvec(&envelope()).unwrap();
        content.push(0);
        let checksum = crc32fast::hash(&content).to_le_bytes();
        let bytes = [&MAGIC[..], &checksum, &content].concat();
        assert_eq!(Envelope::decode(&bytes), Err(EnvelopeError::Malformed));
    }
}
