//! What happens to whatever a peer is too slow to take.

use csat_proto::control::Pace;
use zenoh::qos::CongestionControl;

/// In lockstep everybody waits for everybody. In real time nobody waits: one process that is stopped
/// must not stop the others, and what it missed is old by then.
pub fn congestion_control(pace: Pace) -> CongestionControl {
    match pace {
        Pace::Lockstep => CongestionControl::Block,
        Pace::Realtime(_) => CongestionControl::Drop,
    }
}
