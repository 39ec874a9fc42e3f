//! All agents in this process, in virtual time, as fast as it goes.

use std::convert::Infallible;
use std::sync::Arc;

use csat_netem::config::NetemConfig;
use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::{LinkId, Links};
use csat_netem::propagation::Obstruction;
use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;
use csat_world::camera::Renderer;
use rayon::prelude::*;

use super::{Brief, Fleet, Flown, Frames, renderers};
use crate::plug::Mission;
use crate::seat::{Said, Seat};

/// The agents of a mission in this process.
pub struct LocalFleet<M: Mission> {
    mission: M,
    seats: Vec<Seat<M>>,
    /// By index; `None` for agents without camera.
    renderers: Vec<Option<Renderer>>,
    /// By index, how many frames an agent was shown, or steps told of.
    shown: Vec<u64>,
}

impl<M: Mission> LocalFleet<M> {
    /// A fleet of `count` agents in their first lives, over links that follow `netem` with fates of
    /// `seed` among what may stand in the way.
    pub fn new(
        mission: M,
        count: usize,
        netem: &NetemConfig,
        seed: u64,
        obstruction: Option<Arc<dyn Obstruction>>,
    ) -> Self {
        let seat = |index: usize| {
            let links = Links::new(netem, seed, obstruction.clone());
            Seat::new(&mission, AgentId(index as u16), links)
        };
        Self {
            seats: (0..count).map(seat).collect(),
            renderers: renderers(&mission, count),
            shown: vec![0; count],
            mission,
        }
    }

    /// The agents, by index.
    pub fn seats(&self) -> &[Seat<M>] {
        &self.seats
    }

    /// What the links do from now on; what is under way stays under way.
    pub fn reconfigure_links(&mut self, netem: &NetemConfig) {
        for seat in &mut self.seats {
            seat.links_mut().reconfigure(netem);
        }
    }

    /// Renders every frame and hands it to its agent; those without camera are told of the step.
    fn look(&mut self, brief: &Brief) {
        for (shown, life) in self.shown.iter_mut().zip(&brief.lives) {
            *shown += u64::from(life.is_some());
        }
        let Self { mission, seats, renderers, .. } = self;
        let mission = &*mission;
        let each = seats.par_iter_mut().zip(renderers).zip(&brief.poses).zip(&brief.lives);
        each.enumerate().for_each(|(index, (((seat, renderer), pose), life))| {
            seat.begin(mission, *life, pose);
            match renderer {
                Some(renderer) => {
                    seat.look(brief.now, || brief.frame(renderer, AgentId(index as u16)));
                }
                None => seat.step(brief.now, brief.step),
            }
        });
    }

    /// Lets messages and timeouts take their turns until nothing is left before `next`.
    fn settle(&mut self, now: SimTime, next: SimTime) {
        let mut now = now;
        loop {
            self.talk(now);
            let Some(due) = self.seats.iter().filter_map(Seat::next_due).min() else { break };
            if due >= next {
                break;
            }
            now = now.max(due);
            self.seats.par_iter_mut().for_each(|seat| seat.run(now));
        }
    }

    /// Everybody hears what everybody has to say.
    fn talk(&mut self, now: SimTime) {
        let said: Vec<Said> = self.seats.iter_mut().flat_map(|seat| seat.say(now)).collect();
        self.seats.par_iter_mut().enumerate().for_each(|(dst, seat)| {
            let others = said.iter().filter(|said| usize::from(said.src.0) != dst);
            others.for_each(|said| seat.hear(said));
        });
    }
}

impl<M: Mission> Fleet<M> for LocalFleet<M> {
    type Error = Infallible;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        vec![Some(0); self.seats.len()]
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, Infallible> {
        self.look(brief);
        self.settle(brief.now, brief.next);
        let (mission, seats) = (&self.mission, self.seats.par_iter_mut());
        Ok(seats.map(|seat| seat.finish(mission, brief.detail)).collect())
    }

    fn show(&mut self) -> Vec<Option<M::Report>> {
        self.seats.iter_mut().map(|seat| Some(seat.show(&self.mission))).collect()
    }

    fn counters(&self) -> Counters {
        let mut all = Counters::default();
        self.seats.iter().for_each(|seat| all.add(seat.links().counters()));
        all
    }

    fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        let links = self.seats.iter().flat_map(|seat| seat.links().per_link());
        let mut links: Vec<_> = links.map(|(id, counters)| (id, counters.clone())).collect();
        links.sort_by_key(|(id, _)| *id);
        links
    }

    fn frames(&self) -> Vec<Frames> {
        // Here time waits for everybody.
        let frames = |&shown| Frames { shown, ..Frames::default() };
        self.shown.iter().map(frames).collect()
    }
}
