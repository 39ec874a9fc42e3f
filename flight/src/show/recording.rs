//! `recording.mcap`: a mission written down while it flies, for replays and for viewers of the
//! Foxglove family.

use std::collections::BTreeMap;
use std::path::Path;

use csat_proto::ids::Incarnation;
use csat_proto::time::Step;
use rayon::prelude::*;

use super::drawn::Drawn;
use super::seen::Seen;
use super::tape::Tape;
use super::{FILE, map, scene, truth};
use crate::flight::{Audience, Moment};
use crate::record::RecordError;
use crate::scenario::Loaded;
use csat_mission::documents::{AgentStep, Document, agent_documents};
use csat_mission::engine::LifeEvent;
use csat_mission::fleet::Flown;
use csat_mission::mission::{Detail, Mission, Whole};

/// The name of the metadata record that says what was recorded.
pub const METADATA: &str = "csat";

/// After how many recorded steps what was recorded is safe from a crash.
const STEPS_PER_CHUNK: u32 = 10;

/// Writes a recording into a run folder. Dropped without [`Self::finish`], it leaves a file under
/// its temporary name that can be read up to there.
pub struct Recording<M: Mission> {
    mission: M,
    tape: Tape,
    /// Every which step is recorded.
    every: u32,
    last: Step,
    lives: Vec<Incarnation>,
    /// Recorded steps since the last ones were safe.
    unsafe_steps: u32,
}

impl<M: Mission> Recording<M> {
    /// Starts the recording of a mission in the folder of its run, with a step every `period_s` of
    /// simulated time (never more often than there are steps) and the last one.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(
        folder: &Path,
        mission: M,
        loaded: &Loaded,
        period_s: f64,
    ) -> Result<Self, RecordError> {
        let Loaded { name, scenario, world, .. } = loaded;
        let every = (period_s / scenario.run.period_s).round().clamp(1.0, f64::from(u32::MAX));
        let mut tape = Tape::create(&folder.join(FILE), Whole::<M>::KIND)?;
        let facts = [
            ("name", name.clone()),
            ("seed", scenario.seed.to_string()),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("record_period_s", (every * scenario.run.period_s).to_string()),
        ];
        let facts = facts.map(|(key, value)| (key.to_owned(), value));
        tape.describe(METADATA, BTreeMap::from(facts))?;
        tape.attach("scenario.resolved.toml", "application/toml", &loaded.kept().to_toml())?;
        tape.document(truth::TOWN, 0, &truth::town(name, scenario, world))?;
        tape.document(truth::COLUMNS, 0, &truth::columns(&Whole::<M>::KIND))?;
        tape.document(truth::LAYERS, 0, &truth::layers(M::LAYERS))?;
        tape.message("/map/town", 0, &map::town(world))?;
        tape.message("/scene/town", 0, &scene::town(world))?;
        tape.flush()?;
        Ok(Self {
            mission,
            tape,
            every: every as u32,
            last: Step(scenario.steps()),
            lives: vec![Incarnation(0); world.poses().len()],
            unsafe_steps: 0,
        })
    }

    /// Closes the file, gives it its name and returns its length in bytes.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(self) -> Result<u64, RecordError> {
        self.tape.finish()
    }

    fn is_recorded(&self, step: Step) -> bool {
        step.0.is_multiple_of(self.every) || step == self.last
    }

    /// What people see of each agent that runs.
    fn look(&self, moment: &Moment<'_, M>) -> (Vec<Document>, Vec<Seen>) {
        // Not `self`: the file is nothing that threads may share.
        let (trace, mission, lives) = (moment.trace, &self.mission, &self.lives);
        let look = |flown: &Flown<M>| {
            let incarnation = lives[usize::from(flown.agent.0)];
            let step = AgentStep::of(flown, incarnation, trace.step, moment.time_s)?;
            let step = AgentStep { passages: &trace.passages, ..step };
            let layers = mission.picture(step.report);
            let documents = agent_documents(mission, &step, &layers);
            let footprint = truth::rounded(&mission.footprint(step.report));
            let layers = Drawn::of(M::LAYERS, &layers);
            Some((documents, Seen { agent: step.agent, footprint, layers, is_repeated: false }))
        };
        let (documents, mut seen): (Vec<Vec<Document>>, Vec<Seen>) =
            trace.flown.par_iter().filter_map(look).unzip();
        // Agents know much the same: side by side, it compresses to a fraction.
        let mut documents: Vec<Document> = documents.into_iter().flatten().collect();
        documents.sort_by(|a, b| name_of(a).cmp(name_of(b)));
        for index in 1..seen.len() {
            let (before, rest) = seen.split_at_mut(index);
            rest[0].is_repeated = before.iter().any(|other| other.layers == rest[0].layers);
        }
        for seen in seen.iter_mut().filter(|seen| !seen.is_repeated) {
            seen.layers.iter_mut().for_each(Drawn::thin);
        }
        (documents, seen)
    }

    fn record(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError> {
        let time_ns = nanoseconds(moment.time_s);
        let (documents, seen) = self.look(moment);
        for document in &documents {
            self.tape.document(&document.topic, time_ns, document)?;
        }
        let metrics = truth::metrics(moment);
        for document in [&truth::targets(moment), &metrics] {
            self.tape.document(&document.topic, time_ns, document)?;
        }
        self.tape.document("/metrics", time_ns, &metrics)?;
        let world = moment.world;
        self.tape.message("/map", time_ns, &map::step(world, &seen))?;
        self.tape.message("/scene", time_ns, &scene::step(time_ns, world, &seen))?;
        self.tape.message("/tf", time_ns, &scene::frames(time_ns, world))?;
        for index in 0..self.lives.len() {
            if let Some(fix) = map::fix(time_ns, world, index) {
                self.tape.message(&format!("/fix/{index}"), time_ns, &fix)?;
            }
        }
        self.unsafe_steps += 1;
        if self.unsafe_steps == STEPS_PER_CHUNK {
            self.unsafe_steps = 0;
            self.tape.flush()?;
        }
        Ok(())
    }
}

impl<M: Mission> Audience<M> for Recording<M> {
    fn wants(&mut self, step: Step) -> Detail {
        if self.is_recorded(step) { Detail::Full } else { Detail::Brief }
    }

    fn see(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError> {
        for (agent, event) in &moment.trace.lives {
            if let LifeEvent::Restarted { incarnation, .. } = event {
                self.lives[usize::from(agent.0)] = *incarnation;
            }
        }
        // Lives end at any step.
        for document in truth::lives(moment.trace, moment.time_s) {
            self.tape.document(&document.topic, nanoseconds(moment.time_s), &document)?;
        }
        if self.is_recorded(moment.trace.step) { self.record(moment) } else { Ok(()) }
    }
}

/// What a document of an agent is called, whosever it is.
fn name_of(document: &Document) -> &str {
    document.topic.rsplit('/').next().unwrap_or_default()
}

/// Simulated time as MCAP has it.
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

#[cfg(test)]
#[path = "recording_tests.rs"]
pub(in crate::show) mod tests;
