//! A step in real time: the world sends frames and asks for reports by the clock, and does not wait.

use std::time::Duration;

use csat_mission::fleet::Brief;
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;

use super::RemoteFleet;

/// The part of a period after which the world asks for reports.
const CLOSE_SHARE: f64 = 0.8;

/// A silence of a process that is shorter does not count, seconds of real time.
const SILENCE_S: f64 = 1.0;

impl<M: Mission> RemoteFleet<M> {
    pub(super) fn fly_realtime(&mut self, brief: &Brief, speed: f64) {
        let step = f64::from(brief.step.0);
        let period_s = brief.next.seconds_since(brief.now) / speed;
        self.pass_time(step * period_s);
        self.send_frames(brief);
        self.pass_time((step + CLOSE_SHARE) * period_s);
        self.request_reports(brief.detail);
        self.pass_time((step + 1.0) * period_s);
        self.note_silence(brief, SILENCE_S * speed);
    }

    /// Takes inputs until so many seconds after the first frame.
    fn pass_time(&mut self, until_s: f64) {
        let since_start = *self.since_start.get_or_insert_with(Stopwatch::start);
        let until = Duration::from_secs_f64(until_s.max(0.0));
        loop {
            let left = since_start.left(until);
            if left.is_zero() {
                return;
            }
            if let Some(input) = self.port.next(left) {
                self.take(input);
            }
        }
    }

    /// Notes which processes sent nothing in the step that is over, unless the scenario had the agent down;
    /// a silence of `least_s` simulated seconds or less does not count.
    pub(super) fn note_silence(&mut self, brief: &Brief, least_s: f64) {
        let span_s = (brief.now.seconds(), brief.next.seconds());
        let members = self.members.iter_mut().zip(&brief.is_down_by_schedule).enumerate();
        for (index, (member, is_down)) in members {
            let has_sent = std::mem::take(&mut member.has_sent) || *is_down;
            if member.silence.note(span_s, has_sent, least_s) {
                let since_s = span_s.1 - member.silence.lasts_s();
                tracing::warn!(agent = index, since_s, "nothing is heard of its process");
            }
        }
    }
}
