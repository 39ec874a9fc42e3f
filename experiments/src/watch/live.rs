//! Hears a fleet through Zenoh.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use tokio::sync::mpsc::{self, Receiver, Sender};
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::sample::{Sample, SampleKind};

use super::document::Document;
use super::error::WatchError;
use super::feed::Hub;
use crate::show::truth::{COLUMNS, LAYERS, TOWN};
use csat_mission::timing::Stopwatch;

/// Documents that were heard and are not read yet; one step of 64 agents is under 600.
const QUEUE: usize = 4096;
/// The liveliness token of a mission's world, which goes when the mission ends.
const WORLD: &str = "alive/world";
/// How long to wait before asking again for what is said once, and for an answer.
const ASKING: Duration = Duration::from_secs(1);
/// A mission that was not heard for so long gives way to another one, seconds.
const SILENCE_S: f64 = 5.0;

/// Something that was published, or the liveliness token of a world that came (put) or went (delete).
struct Heard {
    key: String,
    kind: SampleKind,
    payload: ZBytes,
}

/// Fills `hub` with what a fleet shows; with `run`, the mission of that seed only. Goes on until it
/// is dropped.
///
/// # Errors
/// When Zenoh refuses.
pub async fn follow(session: &Session, hub: &Arc<Hub>, run: Option<u64>) -> Result<(), WatchError> {
    let (sender, receiver) = mpsc::channel(QUEUE);
    let lost = Arc::new(AtomicU64::new(0));
    let runs = run.map_or_else(|| "*".to_owned(), |run| run.to_string());
    let mut subscribers = Vec::new();
    for part in ["view", "truth"] {
        let (sender, lost) = (sender.clone(), lost.clone());
        let subscriber = session
            .declare_subscriber(format!("csat/{runs}/{part}/**"))
            .callback(move |sample| hear(&sample, &sender, &lost))
            .await;
        subscribers.push(subscriber.map_err(refused)?);
    }
    let token = format!("csat/{runs}/{WORLD}");
    let (token_sender, token_lost) = (sender.clone(), lost.clone());
    let alive = session.liveliness().declare_subscriber(token);
    let alive = alive.callback(move |sample| queue(&sample, &token_sender, &token_lost)).await;
    let _alive = alive.map_err(refused)?;
    tokio::select! {
        result = ask_for_what_stays(session, hub, &runs, &sender) => result,
        () = read(receiver, hub, &lost, Choice::default()) => Ok(()),
    }
}

fn refused(error: zenoh::Error) -> WatchError {
    WatchError::Zenoh(error.to_string())
}

/// Queues what was published.
fn hear(sample: &Sample, sender: &Sender<Heard>, lost: &AtomicU64) {
    if sample.kind() == SampleKind::Put {
        queue(sample, sender, lost);
    }
}

/// Zenoh's own thread must not wait: what does not fit into the queue is counted as lost.
fn queue(sample: &Sample, sender: &Sender<Heard>, lost: &AtomicU64) {
    let (key, kind) = (sample.key_expr().to_string(), sample.kind());
    let heard = Heard { key, kind, payload: sample.payload().clone() };
    if sender.try_send(heard).is_err() {
        lost.fetch_add(1, Ordering::Relaxed);
    }
}

/// The town, the layers and the columns are published once, at the start: a page that comes later asks.
async fn ask_for_what_stays(
    session: &Session,
    hub: &Hub,
    runs: &str,
    sender: &Sender<Heard>,
) -> Result<(), WatchError> {
    loop {
        for topic in [TOWN, LAYERS, COLUMNS].into_iter().filter(|topic| !hub.has(topic)) {
            let key = format!("csat/{runs}/{topic}");
            let replies = session.get(key).timeout(ASKING).await.map_err(refused)?;
            while let Ok(reply) = replies.recv_async().await {
                // An error is that of a peer without documents.
                if let Ok(sample) = reply.result() {
                    hear(sample, sender, &AtomicU64::new(0));
                }
            }
        }
        tokio::time::sleep(ASKING).await;
    }
}

/// Which mission to show.
#[derive(Default)]
struct Choice {
    current: Option<(String, Stopwatch)>,
}

/// What to do with a document of a mission.
#[derive(Debug, PartialEq)]
enum Verdict {
    Show,
    /// It is the first of its mission.
    Begin,
    Ignore,
}

impl Choice {
    /// Whether it is the mission that is shown.
    fn is(&self, run: &str) -> bool {
        self.current.as_ref().is_some_and(|(current, _)| current == run)
    }

    /// The first one heard, until it falls silent and another one is heard.
    fn hears(&mut self, run: &str) -> Verdict {
        match &mut self.current {
            Some((current, silent)) if current == run => {
                *silent = Stopwatch::start();
                Verdict::Show
            }
            Some((_, silent)) if silent.elapsed_s() < SILENCE_S => Verdict::Ignore,
            _ => {
                self.current = Some((run.to_owned(), Stopwatch::start()));
                Verdict::Begin
            }
        }
    }
}

async fn read(mut receiver: Receiver<Heard>, hub: &Hub, lost: &AtomicU64, mut choice: Choice) {
    let mut heard = Vec::with_capacity(QUEUE);
    while receiver.recv_many(&mut heard, QUEUE).await > 0 {
        take(&mut heard, hub, &mut choice);
        let lost = lost.swap(0, Ordering::Relaxed);
        if lost > 0 {
            hub.lose(lost);
            tracing::warn!(lost, "documents came faster than they could be read");
        }
    }
}

/// Reads what is worth reading: of each topic the newest, of poses and metrics all, since paths and
/// curves are made of them.
fn take(heard: &mut Vec<Heard>, hub: &Hub, choice: &mut Choice) {
    let mut newest: BTreeMap<String, usize> = BTreeMap::new();
    for (index, Heard { key, .. }) in heard.iter().enumerate() {
        newest.insert(key.clone(), index);
    }
    let mut documents = Vec::new();
    let mut ended = None;
    for (index, Heard { key, kind, payload }) in heard.drain(..).enumerate() {
        let Some((run, topic)) = key.strip_prefix("csat/").and_then(|k| k.split_once('/')) else {
            continue;
        };
        if topic == WORLD {
            ended = choice.is(run).then_some(kind == SampleKind::Delete).or(ended);
            continue;
        }
        let is_series = topic == "truth/metrics" || topic.ends_with("/pose");
        if newest.get(&key) != Some(&index) && !is_series {
            continue;
        }
        match choice.hears(run) {
            Verdict::Ignore => continue,
            Verdict::Begin => {
                documents.clear();
                ended = None;
                hub.begin(run);
            }
            Verdict::Show => {}
        }
        match Document::parse(topic, &payload.to_bytes()) {
            Ok(document) => documents.push(document),
            Err(reason) => {
                tracing::warn!(key, reason, "not a document");
                hub.lose(1);
            }
        }
    }
    hub.publish(documents);
    if let Some(ended) = ended {
        hub.end(ended);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::feed::Cursor;

    fn heard(key: &str, body: &str) -> Heard {
        Heard { key: key.to_owned(), kind: SampleKind::Put, payload: ZBytes::from(body) }
    }

    fn shown(hub: &Hub) -> (String, u64, Vec<String>) {
        let batch = hub.since(&mut Cursor::default(), |_| true);
        let bodies = batch.documents.iter().map(|d| format!("{} {}", d.topic, d.body));
        (batch.run.clone(), batch.lost, bodies.collect())
    }

    #[test]
    fn the_first_mission_heard_is_shown_and_the_newest_of_each_topic_is_read() {
        let (hub, mut choice) = (Hub::default(), Choice::default());
        let mut queue = vec![
            heard("csat/7/view/0/oem", "old and never read"),
            heard("csat/8/view/0/pose", "{}"),
            heard("csat/7/view/0/oem", "{\"time_s\":2}"),
            heard("csat/7/view/0/stats", "nonsense"),
            heard("other/7/view/0/pose", "{}"),
        ];
        queue.insert(0, heard("csat/7/view/0/pose", "{\"time_s\":2,\"p_world\":[1,2,3]}"));
        take(&mut queue, &hub, &mut choice);
        let (run, lost, documents) = shown(&hub);
        assert_eq!((run.as_str(), lost), ("7", 1));
        assert_eq!(documents.len(), 2, "{documents:?}");
        assert!(documents[0].starts_with("view/0/oem {\"time_s\":2}"), "{documents:?}");
        assert!(hub.history_json().contains("[2,1.00,2.00]"));
    }

    #[test]
    fn a_mission_ends_with_its_own_world() {
        let (hub, mut choice) = (Hub::default(), Choice::default());
        let ended = || hub.since(&mut Cursor::default(), |_| true).ended;
        let gone = |run: &str| Heard {
            kind: SampleKind::Delete,
            ..heard(&format!("csat/{run}/alive/world"), "")
        };
        take(&mut vec![gone("7")], &hub, &mut choice);
        assert!(!ended(), "nothing is shown yet");
        take(&mut vec![heard("csat/7/view/0/pose", "{\"time_s\":2}")], &hub, &mut choice);
        take(&mut vec![gone("8")], &hub, &mut choice);
        assert!(!ended(), "another one's world");
        take(&mut vec![gone("7")], &hub, &mut choice);
        assert!(ended());
        // What agents still say after it is part of the mission that ended.
        take(&mut vec![heard("csat/7/view/0/pose", "{\"time_s\":3}")], &hub, &mut choice);
        assert!(ended());
        take(&mut vec![heard("csat/7/alive/world", "")], &hub, &mut choice);
        assert!(!ended(), "the same mission flies again");
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_fleet_is_heard_and_its_town_is_asked_for() {
        let mut config = zenoh::Config::default();
        for (key, value) in
            [("scouting/multicast/enabled", "false"), ("listen/endpoints", "[\"tcp/127.0.0.1:0\"]")]
        {
            config.insert_json5(key, value).unwrap();
        }
        // One session hears itself: what is tested is what is said and asked, not the transport.
        let session = zenoh::open(config).await.unwrap();
        let town = session
            .declare_queryable("csat/5/truth/town")
            .callback(|query| {
                zenoh::Wait::wait(query.reply("csat/5/truth/town", "{\"seed\":5}")).unwrap();
            })
            .await
            .unwrap();
        let hub = Arc::new(Hub::default());
        let publishing = async {
            for step in 0.. {
                let body = format!("{{\"time_s\":{step},\"p_world\":[{step},0,50]}}");
                session.put("csat/5/view/0/pose", body).await.unwrap();
                tokio::time::sleep(Duration::from_millis(20)).await;
                if hub.has("truth/town") && hub.has("view/0/pose") {
                    break;
                }
                assert!(step < 500, "{:?}", shown(&hub));
            }
        };
        tokio::select! {
            result = follow(&session, &hub, None) => panic!("{result:?}"),
            () = publishing => {}
        }
        let (run, lost, documents) = shown(&hub);
        assert_eq!((run.as_str(), lost), ("5", 0));
        assert_eq!(documents[0], "truth/town {\"seed\":5}");
        drop(town);
    }
}
