//! Real time: frames and the end of a step come by the clock, and whoever is late is left out.

use std::time::Duration;

use csat_proto::control::Pace;

use super::{CLOSE_SHARE, RemoteFleet, SILENCE_S};
use csat_mission::fleet::Brief;
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;

impl<M: Mission> RemoteFleet<M> {
    /// Until that many periods of real time after the first frame.
    pub(super) fn pass_time(&mut self, periods: f64, period_s: f64, speed: f64) {
        let clock = *self.clock.get_or_insert_with(Stopwatch::start);
        let until = Duration::from_secs_f64((periods * period_s / speed).max(0.0));
        loop {
            let left = clock.left(until);
            if left.is_zero() {
                return;
            }
            if let Some(news) = self.port.next(left) {
                self.take(news);
            }
        }
    }

    pub(super) fn fly_realtime(&mut self, brief: &Brief, speed: f64) {
        let step = f64::from(brief.step.0);
        let period_s = brief.next.seconds_since(brief.now);
        self.pass_time(step + CLOSE_SHARE, period_s, speed);
        self.close(brief.detail);
        self.pass_time(step + 1.0, period_s, speed);
    }

    /// Keeps account of who said nothing in a step that is over.
    pub(super) fn note_silence(&mut self, brief: &Brief) {
        let least_s = match self.pace {
            Pace::Lockstep => 0.0,
            Pace::Realtime(speed) => SILENCE_S * speed,
        };
        let span_s = (brief.now.seconds(), brief.next.seconds());
        let members = self.members.iter_mut().zip(&brief.is_down_by_schedule).enumerate();
        for (index, (member, is_down)) in members {
            let is_heard = std::mem::take(&mut member.is_heard) || *is_down;
            if member.silence.note(span_s, is_heard, least_s) {
                let since_s = span_s.1 - member.silence.lasts_s();
                tracing::warn!(agent = index, since_s, "nothing is heard of its process");
            }
        }
    }
}
