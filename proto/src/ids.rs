//! Identifiers of agents, targets, incarnations, runs and radios.

use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident($inner:ty)) => {
        $(#[$doc])*
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
        )]
        #[serde(transparent)]
        pub struct $name(pub $inner);

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

id!(
    /// One agent, 0-based: the UAVs of the fleet first, the ground stations after them.
    AgentId(u16)
);
id!(
    /// One target, 0-based, below [`MAX_TARGETS`]. Agents learn indexes only from detections.
    TargetId(u16)
);

/// The greatest number of targets that is accepted: each known target takes time in every step.
pub const MAX_TARGETS: u16 = 1024;

id!(
    /// The number of restarts of an agent: 0 at the start of the run. A new incarnation begins without
    /// knowledge and with a new sequence.
    Incarnation(u32)
);
id!(
    /// The run a message belongs to; messages of other runs are dropped.
    RunId(u64)
);
id!(
    /// A named radio, by its position in the scenario.
    ChannelId(u8)
);
