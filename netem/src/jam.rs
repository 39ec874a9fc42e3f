//! Rule 5: discs in which receivers lose messages, from one time to another.

use csat_proto::ids::ChannelId;

use crate::config::NetemConfig;
use crate::draw::Purpose;
use crate::fate::{Reason, Sent};
use crate::outage::TimeSpan;
use crate::rule::{Case, Rule};

/// All jammers of a channel.
pub struct Jamming(Vec<Jammer>);

struct Jammer {
    p_m: [f64; 2],
    radius_m: f64,
    span: TimeSpan,
    loss: f64,
}

impl Jamming {
    /// `None` when no jammer jams the channel.
    pub fn new(config: &NetemConfig, channel: ChannelId) -> Option<Self> {
        let on_channel = config.jammer.iter().filter(|jammer| {
            let named = jammer.channel.as_ref();
            named.is_none_or(|name| config.channel_id(name) == Some(channel))
        });
        let jammers: Vec<Jammer> = on_channel
            .map(|jammer| Jammer {
                p_m: jammer.p_m,
                radius_m: jammer.radius_m,
                span: TimeSpan::new(jammer.from_s, jammer.until_s),
                loss: jammer.loss,
            })
            .collect();
        (!jammers.is_empty()).then_some(Self(jammers))
    }
}

impl Jammer {
    fn reaches(&self, sent: &Sent) -> bool {
        let [x, y, _] = sent.dst_p_world;
        let (dx, dy) = (x - self.p_m[0], y - self.p_m[1]);
        (dx * dx + dy * dy).sqrt() <= self.radius_m && self.span.contains(sent.time)
    }
}

impl Jamming {
    /// The probability that a message is heard.
    fn heard(&self, sent: &Sent) -> f64 {
        // Jammers that overlap jam independently.
        let reaching = self.0.iter().filter(|jammer| jammer.reaches(sent));
        reaching.map(|jammer| 1.0 - jammer.loss).product()
    }
}

impl Rule for Jamming {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        let heard = self.heard(case.sent);
        if case.block.uniform(Purpose::Jamming) < heard { Ok(()) } else { Err(Reason::Jamming) }
    }

    fn cuts(&self, probe: &Sent, _: u64) -> bool {
        self.heard(probe) < 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{ChannelConfig, JammerConfig};
    use crate::fate::tests::sent;
    use crate::rule::tests::{judge_alone, loss_share};
    use csat_proto::time::SimTime;

    /// The receiver of `sent` is 50 m from the origin.
    fn jammer(radius_m: f64, loss: f64, channel: Option<&str>) -> JammerConfig {
        let channel = channel.map(str::to_owned);
        JammerConfig { p_m: [0.0, 0.0], radius_m, from_s: 1.0, until_s: 2.0, loss, channel }
    }

    fn config(jammer: Vec<JammerConfig>) -> NetemConfig {
        let channels = [("far".to_owned(), ChannelConfig::default())].into();
        NetemConfig { jammer, channels, ..Default::default() }
    }

    #[test]
    fn the_receiver_is_jammed_within_the_disc_and_the_time() {
        let within = Jamming::new(&config(vec![jammer(50.0, 1.0, None)]), ChannelId(0)).unwrap();
        assert_eq!(judge_alone(&within, &sent(0)), Err(Reason::Jamming));
        let later = Sent { time: SimTime::from_seconds(2.0), ..sent(0) };
        assert!(judge_alone(&within, &later).is_ok());
        let src_inside = Sent { dst_p_world: [500.0, 0.0, 0.0], ..sent(0) };
        assert!(judge_alone(&within, &src_inside).is_ok());
        let beyond = Jamming::new(&config(vec![jammer(49.9, 1.0, None)]), ChannelId(0)).unwrap();
        assert!(judge_alone(&beyond, &sent(0)).is_ok());
    }

    #[test]
    fn a_jammer_may_be_of_one_channel() {
        let config = config(vec![jammer(50.0, 1.0, Some("far"))]);
        assert!(Jamming::new(&config, ChannelId(0)).is_none());
        assert!(Jamming::new(&config, ChannelId(1)).is_some());
    }

    #[test]
    fn jammers_jam_independently() {
        let both = vec![jammer(60.0, 0.5, None), jammer(70.0, 0.4, None), jammer(1.0, 1.0, None)];
        let rule = Jamming::new(&config(both), ChannelId(0)).unwrap();
        let share = loss_share(&rule, 40_000, sent);
        let sigma = (0.7f64 * 0.3 / 40_000.0).sqrt();
        assert!((share - 0.7).abs() < 4.0 * sigma, "{share}");
    }
}
