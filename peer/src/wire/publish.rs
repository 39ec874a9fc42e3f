//! Publishing: JSON, congestion control, and errors that go to the log.

use csat_proto::control::Pace;
use serde::Serialize;
use zenoh::Wait;
use zenoh::bytes::Encoding;
use zenoh::pubsub::{Publisher, PublisherPutBuilder};
use zenoh::qos::CongestionControl;

/// What Zenoh does with a sample that its receiver is too slow to take. In lockstep all processes wait
/// for each other. In real time a stopped process must not stop the others, and a sample that waits
/// for it is out of date by then.
pub fn congestion_control(pace: Pace) -> CongestionControl {
    match pace {
        Pace::Lockstep => CongestionControl::Block,
        Pace::Realtime(_) => CongestionControl::Drop,
    }
}

/// A value of the protocol as JSON.
pub fn to_json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("the protocol's types have a JSON form")
}

/// Publishes a sample; an error goes to the log.
pub fn put(sample: PublisherPutBuilder<'_>) {
    if let Err(error) = sample.wait() {
        tracing::error!(%error, "cannot publish");
    }
}

/// Publishes a value of the protocol as JSON.
pub fn put_json(publisher: &Publisher<'_>, value: &impl Serialize) {
    put(publisher.put(to_json(value)).encoding(Encoding::APPLICATION_JSON));
}
