//! `csat replay`: a recording as if it flew now.

use std::sync::atomic::Ordering;

use super::common;
use crate::cli::ReplayArguments;
use crate::progress;
use crate::show::read::{self, Film};
use crate::show::replay::play;
use crate::show::truth;
use crate::verdict::{BAD_INPUT, DONE, INTERRUPTED};
use csat_mission::documents::Document;
use csat_peer::tell;
use csat_peer::wire::session::{self, Role};
use csat_proto::keys::Keys;
use indicatif::ProgressBar;
use zenoh::bytes::Encoding;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::{Session, Wait};

/// `csat replay`.
pub fn replay(arguments: &ReplayArguments) -> anyhow::Result<u8> {
    let film = match read::load(&arguments.dir) {
        Ok(film) => film,
        Err(error) => {
            tell!("error: {error}");
            return Ok(BAD_INPUT);
        }
    };
    if let Some(warning) = &film.warning {
        tell!("warning: {warning}");
    }
    let interrupted = common::interrupted_by_the_user()?;
    // It stands in for the world: others connect to it.
    let wire = arguments.wire.with_ports();
    let session = match session::open(&wire, Role::World) {
        Ok(session) => session,
        Err(error) => {
            tell!("error: {error}");
            return Ok(BAD_INPUT);
        }
    };
    let endpoints = session::listened(&wire, Role::World);
    let has_ended =
        show(&film, arguments, &endpoints, &session, || !interrupted.load(Ordering::SeqCst));
    session::close(session);
    // A user who plays it for ever ends it with Ctrl-C.
    Ok(if has_ended? || arguments.repeat { DONE } else { INTERRUPTED })
}

/// Plays the film, again and again if asked to; false when it was ended early.
fn show(
    film: &Film,
    arguments: &ReplayArguments,
    endpoints: &[String],
    session: &Session,
    goes_on: impl Fn() -> bool,
) -> anyhow::Result<bool> {
    let keys = Keys(film.run);
    tell!(
        "playing {} with seed {} under {}{}",
        film.scenario,
        film.run,
        keys.of("view/** and truth/**"),
        endpoints.first().map_or_else(String::new, |endpoint| format!(
            " on {}; look on with `csat watch --connect {endpoint}`",
            endpoints.join(", ")
        ))
    );
    let once = [truth::TOWN, truth::LAYERS];
    let once = film.documents.iter().filter(|r| once.contains(&&*r.document.topic));
    let _answers =
        once.map(|r| answer(session, keys, &r.document)).collect::<Result<Vec<_>, _>>()?;
    let bar = bar(film, arguments.speed);
    loop {
        let at = |time_s: f64| bar.set_position(time_s as u64);
        let has_ended = play(film, arguments.speed, &goes_on, at, |recorded| {
            at(recorded.time_s());
            publish(session, keys, &recorded.document)
        })?;
        if !has_ended || !arguments.repeat {
            bar.finish_and_clear();
            return Ok(has_ended);
        }
    }
}

fn publish(session: &Session, keys: Keys, document: &Document) -> anyhow::Result<()> {
    session
        .put(keys.of(&document.topic), document.body.as_str())
        .encoding(Encoding::from(document.encoding.media_type()))
        .priority(Priority::DataLow)
        .congestion_control(CongestionControl::Drop)
        .wait()
        .map_err(|error| anyhow::anyhow!("cannot publish {}: {error}", document.topic))
}

/// Answers queries for a document, as long as the returned queryable lives.
fn answer(
    session: &Session,
    keys: Keys,
    document: &Document,
) -> anyhow::Result<zenoh::query::Queryable<()>> {
    let key = keys.of(&document.topic);
    let (body, encoding) = (document.body.clone(), document.encoding.media_type());
    session
        .declare_queryable(key.clone())
        .callback(move |query| {
            let reply = query.reply(key.clone(), body.as_str()).encoding(Encoding::from(encoding));
            if let Err(error) = reply.wait() {
                tracing::warn!(%error, "the answer did not arrive");
            }
        })
        .wait()
        .map_err(|error| anyhow::anyhow!("cannot answer for {}: {error}", document.topic))
}

/// A bar of simulated seconds on stderr; invisible when stderr is no terminal.
fn bar(film: &Film, speed: f64) -> ProgressBar {
    let last_s = film.documents.last().map_or(0.0, read::Recorded::time_s);
    let style = progress::style("{wide_bar} {pos} s of {len} s {msg}");
    let bar = progress::bar(last_s as u64, style, false);
    bar.set_message(format!("({speed}x)"));
    bar
}
