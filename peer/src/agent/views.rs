//! What an agent's process shows to people (docs/topics.md, `view/{i}/…`).
//!
//! A thread of its own makes the documents, and only while a subscriber matches or a query asks for them.
//! The process drops a step that the thread has no time for, so that spectators never slow the agent.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::keys::Keys;
use csat_proto::time::Step;
use zenoh::Session;
use zenoh::query::Query;

use crate::view::{DocumentPublisher, MIN_PERIOD, reply};
use csat_mission::documents::{AgentStep, Document, agent_documents, names};
use csat_mission::fleet::Passage;
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;

/// How many jobs of the thread may wait.
const QUEUE: usize = 64;

/// An agent's step, to be shown.
#[derive(Debug)]
pub struct ShownStep<R> {
    /// Its life.
    pub incarnation: Incarnation,
    /// k.
    pub step: Step,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// What it knows, in full.
    pub report: R,
    /// The fates of messages to it.
    pub passages: Vec<Passage>,
    /// How many bytes it sent in this step.
    pub bytes_sent: u64,
}

enum Job<R> {
    Publish(Box<ShownStep<R>>),
    Answer(Box<ShownStep<R>>, Query),
}

/// Shows what an agent knows.
pub struct AgentViews<R> {
    jobs: SyncSender<Job<R>>,
    /// By document, whether any subscriber matches.
    matched: Vec<Arc<AtomicBool>>,
    /// Since the last step was published.
    since: Option<Stopwatch>,
}

impl<R: Send + 'static> AgentViews<R> {
    /// Declares the publishers of agent `id`.
    ///
    /// # Errors
    /// When Zenoh does not declare one.
    pub fn declare<M: Mission<Report = R>>(
        session: &Session,
        keys: Keys,
        id: AgentId,
        mission: M,
    ) -> zenoh::Result<Self> {
        let publishers =
            names::<M>().map(|name| DocumentPublisher::declare(session, keys.view(id, name)));
        let publishers = publishers.into_iter().collect::<zenoh::Result<Vec<_>>>()?;
        let matched = publishers.iter().map(DocumentPublisher::matched).collect();
        let (jobs, todo) = sync_channel(QUEUE);
        std::thread::spawn(move || work(&todo, &mission, keys, id, &publishers));
        Ok(Self { jobs, matched, since: None })
    }

    /// Whether a step is to be published now.
    pub fn is_due(&self) -> bool {
        let is_time = self.since.is_none_or(|since| since.left(MIN_PERIOD).is_zero());
        is_time && self.matched.iter().any(|matched| matched.load(Ordering::Relaxed))
    }

    /// Publishes a step.
    pub fn publish(&mut self, step: ShownStep<R>) {
        self.since = Some(Stopwatch::start());
        let _ = self.jobs.try_send(Job::Publish(Box::new(step)));
    }

    /// Answers a query for documents.
    pub fn answer(&self, step: ShownStep<R>, query: Query) {
        let _ = self.jobs.try_send(Job::Answer(Box::new(step), query));
    }
}

/// Makes documents until the [`AgentViews`] are gone.
fn work<M: Mission>(
    todo: &Receiver<Job<M::Report>>,
    mission: &M,
    keys: Keys,
    id: AgentId,
    publishers: &[DocumentPublisher],
) {
    while let Ok(job) = todo.recv() {
        match job {
            Job::Publish(step) => {
                let documents = documents(mission, id, &step);
                for (name, publisher) in names::<M>().zip(publishers) {
                    let topic = format!("view/{id}/{name}");
                    let named = documents.iter().filter(|document| document.topic == topic);
                    named.filter(|_| publisher.is_matched()).for_each(|d| publisher.put(d));
                }
            }
            Job::Answer(step, query) => {
                let documents = documents(mission, id, &step);
                documents.iter().for_each(|document| reply(&query, keys, document));
            }
        }
    }
}

fn documents<M: Mission>(
    mission: &M,
    agent: AgentId,
    step: &ShownStep<M::Report>,
) -> Vec<Document> {
    let ShownStep { incarnation, step, time_s, ref report, ref passages, bytes_sent } = *step;
    let step = AgentStep { agent, incarnation, step, time_s, report, passages, bytes_sent };
    agent_documents(mission, &step, &mission.picture(report))
}
