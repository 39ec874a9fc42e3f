//! The documents of a recorded run.

use std::path::Path;

use super::document::Document;
use super::error::WatchError;
use crate::show::read;
use csat_peer::tell;

/// The documents of the run in a folder (or of a recording by its own name), by time. What is wrong
/// with a recording that can be read in part is told on stderr.
///
/// # Errors
/// When there is no recording, or nothing in it is whole.
pub fn load(dir: &Path) -> Result<Vec<Document>, WatchError> {
    let film = read::load(dir)?;
    if let Some(warning) = &film.warning {
        tell!("warning: {warning}");
    }
    let mut documents = Vec::with_capacity(film.documents.len());
    for recorded in film.documents {
        let (time_s, document) = (recorded.time_s(), recorded.document);
        let parsed = Document::parse(document.topic.as_str(), document.body.as_bytes());
        let topic = document.topic;
        let parsed = parsed.map_err(|reason| WatchError::Document { topic, time_s, reason })?;
        documents.push(Document { time_s, ..parsed });
    }
    if documents.is_empty() {
        return Err(WatchError::Empty(dir.to_owned()));
    }
    Ok(documents)
}
