//! Which messages are lost at random.

use serde::{Deserialize, Serialize};

/// `loss` of a channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LossConfig {
    /// Each message with the same probability, independently.
    Iid {
        /// The probability.
        p: f64,
    },
    /// Two states, good and bad. Loss rate μ = [r(1-k) + p(1-h)] / (p + r).
    GilbertElliott {
        /// Probability, per message, of going from good to bad.
        p: f64,
        /// Probability, per message, of going from bad to good.
        r: f64,
        /// Probability of *delivery* in the bad state.
        #[serde(default)]
        h: f64,
        /// Probability of *delivery* in the good state.
        #[serde(default = "one")]
        k: f64,
    },
    /// The four states of Linux netem: 1 received in a gap, 2 received within a burst, 3 lost within
    /// a burst, 4 lost alone in a gap (from 4 always back to 1). With a = p13/p31 the loss rate is
    /// (a + p14) / (1 + p14 + a(1 + p32/p23)).
    Markov4 {
        /// From gap to burst.
        p13: f64,
        /// From burst to gap.
        p31: f64,
        /// From lost to received within a burst.
        #[serde(default)]
        p32: f64,
        /// From received to lost within a burst.
        #[serde(default = "one")]
        p23: f64,
        /// A loss alone in a gap.
        #[serde(default)]
        p14: f64,
    },
    /// A recording, repeated without end; each link starts at an offset of its own.
    Trace {
        /// A text file in the form of `lost`; the loader of the scenario reads it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        file: Option<String>,
        /// `1` for a message that is lost and `0` for one that is not; white space and comments after
        /// `#` are skipped.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        lost: Option<String>,
    },
}

fn one() -> f64 {
    1.0
}
