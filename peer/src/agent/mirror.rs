//! Mirrors: what an agent shows to people (docs/topics.md, `view/{i}/…`).
//!
//! Documents are made by a thread of their own, and only while somebody listens or asks. A step that
//! comes while the last one is still being drawn is not shown, so that watching never slows an agent.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::keys::Keys;
use csat_proto::time::Step;
use zenoh::bytes::Encoding;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::Query;
use zenoh::{Session, Wait};

use csat_mission::documents::{AgentStep, Document, agent_documents, names};
use csat_mission::fleet::Passage;
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;

/// The least time between two steps that are shown, however fast a fleet flies.
pub const LEAST_PERIOD: Duration = Duration::from_millis(80);

/// How many may wait for an answer.
const QUEUE: usize = 64;

/// What an agent's process shows of a step.
#[derive(Debug)]
pub struct Picture<R> {
    /// Its life.
    pub incarnation: Incarnation,
    /// k.
    pub step: Step,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// What it knows, in full.
    pub report: R,
    /// What became of messages to it.
    pub passages: Vec<Passage>,
    /// Bytes it sent in this step.
    pub bytes_sent: u64,
}

enum Job<R> {
    Show(Box<Picture<R>>),
    Answer(Box<Picture<R>>, Query),
}

/// Shows what an agent knows.
pub struct Mirror<R> {
    jobs: SyncSender<Job<R>>,
    wanted: Vec<Arc<AtomicBool>>,
    shown: Option<Stopwatch>,
}

/// A publisher and whether anybody listens.
pub struct Watched {
    publisher: Publisher<'static>,
    wanted: Arc<AtomicBool>,
}

impl Watched {
    /// Publishes under `key` what may be lost and waits for nobody.
    ///
    /// # Errors
    /// What Zenoh says.
    pub fn declare(session: &Session, key: String) -> zenoh::Result<Self> {
        let publisher = session
            .declare_publisher(key)
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::DataLow)
            .wait()?;
        let wanted = Arc::new(AtomicBool::new(publisher.matching_status().wait()?.matching()));
        let flag = wanted.clone();
        publisher
            .matching_listener()
            .callback(move |status| flag.store(status.matching(), Ordering::Relaxed))
            .background()
            .wait()?;
        Ok(Self { publisher, wanted })
    }

    /// Whether anybody listens.
    pub fn is_wanted(&self) -> bool {
        self.wanted.load(Ordering::Relaxed)
    }

    /// Shows a document.
    pub fn put(&self, document: &Document) {
        let encoding = Encoding::from(document.encoding.media_type());
        if let Err(error) = self.publisher.put(&document.body).encoding(encoding).wait() {
            tracing::warn!(%error, "cannot show");
        }
    }
}

impl<R: Send + 'static> Mirror<R> {
    /// A mirror of agent `id`.
    ///
    /// # Errors
    /// What Zenoh says.
    pub fn declare<M: Mission<Report = R>>(
        session: &Session,
        keys: Keys,
        id: AgentId,
        mission: M,
    ) -> zenoh::Result<Self> {
        let watched = names::<M>().map(|name| Watched::declare(session, keys.view(id, name)));
        let watched = watched.collect::<zenoh::Result<Vec<_>>>()?;
        let wanted = watched.iter().map(|w| w.wanted.clone()).collect();
        let (jobs, todo) = sync_channel(QUEUE);
        std::thread::spawn(move || draw(&todo, &mission, keys, id, &watched));
        Ok(Self { jobs, wanted, shown: None })
    }

    /// Whether a picture is to be shown now.
    pub fn is_wanted(&self) -> bool {
        let is_due = self.shown.is_none_or(|shown| shown.left(LEAST_PERIOD).is_zero());
        is_due && self.wanted.iter().any(|wanted| wanted.load(Ordering::Relaxed))
    }

    /// Shows a step.
    pub fn show(&mut self, picture: Picture<R>) {
        self.shown = Some(Stopwatch::start());
        let _ = self.jobs.try_send(Job::Show(Box::new(picture)));
    }

    /// Answers somebody who asks for documents.
    pub fn answer(&self, picture: Picture<R>, query: Query) {
        let _ = self.jobs.try_send(Job::Answer(Box::new(picture), query));
    }
}

/// The thread that makes documents, until the mirror is gone.
fn draw<M: Mission>(
    todo: &Receiver<Job<M::Report>>,
    mission: &M,
    keys: Keys,
    id: AgentId,
    watched: &[Watched],
) {
    while let Ok(job) = todo.recv() {
        match job {
            Job::Show(picture) => {
                let documents = documents(mission, id, &picture);
                for (name, watched) in names::<M>().zip(watched).filter(|(_, w)| w.is_wanted()) {
                    let topic = format!("view/{id}/{name}");
                    documents.iter().filter(|d| d.topic == topic).for_each(|d| watched.put(d));
                }
            }
            Job::Answer(picture, query) => {
                for document in documents(mission, id, &picture) {
                    reply(&query, keys, &document);
                }
            }
        }
    }
}

fn documents<M: Mission>(
    mission: &M,
    agent: AgentId,
    picture: &Picture<M::Report>,
) -> Vec<Document> {
    let Picture { incarnation, step, time_s, ref report, ref passages, bytes_sent } = *picture;
    let step = AgentStep { agent, incarnation, step, time_s, report, passages, bytes_sent };
    agent_documents(mission, &step, &mission.picture(report))
}

/// Replies with a document if it is among what was asked for.
pub fn reply(query: &Query, keys: Keys, document: &Document) {
    let name = keys.of(&document.topic);
    // Whoever joins late asks for the map under this name.
    let state = document.topic.replacen("view/", "state/", 1);
    for key in [name, keys.of(&state)] {
        let is_asked = zenoh::key_expr::KeyExpr::try_from(key.as_str())
            .is_ok_and(|key| query.key_expr().intersects(&key));
        if is_asked {
            let encoding = Encoding::from(document.encoding.media_type());
            let replied = query.reply(key, &document.body).encoding(encoding).wait();
            if let Err(error) = replied {
                tracing::debug!(%error, "cannot answer a query");
            }
        }
    }
}
