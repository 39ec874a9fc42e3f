//! Reads a recording again, as far as it is whole.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use csat_proto::ids::RunId;
use mcap::McapError;
use mcap::read::parse_record;
use mcap::records::{Metadata, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::FILE;
use super::recording::METADATA;
use super::tape::MEDIA_TYPE;
use csat_mission::documents::{Document, Encoding};

/// The longest record or chunk that is read, bytes: 100 times what is written for large fleets.
const MAX_RECORD_BYTES: usize = 1 << 28;

/// Why a recording could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// There is none.
    #[error("{}: not found; expected a run flown with --record", .0.display())]
    NotFound(PathBuf),
    /// The system refused.
    #[error("cannot read `{}`: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// It is something else.
    #[error("{}: {reason}; expected an MCAP file that `csat run --record` wrote", path.display())]
    NotOurs {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// A document and when it was made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recorded {
    /// Simulated time since the start, nanoseconds.
    pub time_ns: u64,
    /// What was shown.
    pub document: Document,
}

impl Recorded {
    /// Simulated time since the start, seconds.
    pub fn time_s(&self) -> f64 {
        self.time_ns as f64 / 1e9
    }
}

/// The documents of a mission.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Film {
    /// Which run: its seed.
    pub run: RunId,
    /// The name of its scenario.
    pub scenario: String,
    /// The documents, by time.
    pub documents: Vec<Recorded>,
    /// What is wrong with the recording, when its end is missing or damaged.
    pub warning: Option<String>,
}

/// Reads the recording in a run folder, or the file that `path` names. The file that a run leaves
/// behind when it dies will do, too; then the film says so.
///
/// # Errors
/// When there is no recording, or nothing in it is whole.
pub fn load(path: &Path) -> Result<Film, ReadError> {
    let file = find(path)?;
    let bytes =
        std::fs::read(&file).map_err(|error| ReadError::Io { path: file.clone(), error })?;
    let not_ours = |reason: String| ReadError::NotOurs { path: file.clone(), reason };
    let Contents { facts, mut documents, failure } = contents(&bytes);
    let Some(facts) = facts else {
        return Err(not_ours(match failure {
            Some(failure) => format!("broken before its first record: {failure}"),
            None => "it does not say which run it is of".to_owned(),
        }));
    };
    let seed = facts.get("seed").map_or("", String::as_str);
    let run = seed.parse().map_err(|_| not_ours(format!("its seed is `{seed}`")))?;
    // Sorting keeps the order of what was said at the same time.
    documents.sort_by_key(|recorded| recorded.time_ns);
    let until_s = documents.last().map_or(0.0, Recorded::time_s);
    let warning = failure.map(|failure| {
        format!("{}: {failure}; read up to {until_s} s, which is whole", file.display())
    });
    let scenario = facts.get("name").cloned().unwrap_or_default();
    Ok(Film { run: RunId(run), scenario, documents, warning })
}

fn find(path: &Path) -> Result<PathBuf, ReadError> {
    if path.is_file() {
        return Ok(path.to_owned());
    }
    let whole = path.join(FILE);
    let left_behind = path.join(format!("{FILE}.tmp"));
    let found = [&whole, &left_behind].into_iter().find(|file| file.is_file()).cloned();
    found.ok_or(ReadError::NotFound(whole))
}

/// What could be read of a file.
struct Contents {
    facts: Option<BTreeMap<String, String>>,
    documents: Vec<Recorded>,
    failure: Option<McapError>,
}

impl Contents {
    /// Takes in a record of the file; true when it is the last one that counts.
    fn add(
        &mut self,
        record: Record<'_>,
        channels: &mut BTreeMap<u16, (String, Encoding)>,
    ) -> bool {
        match record {
            Record::Metadata(Metadata { name, metadata }) if name == METADATA => {
                self.facts = Some(metadata);
            }
            Record::Channel(channel) => {
                let encoding = channel.metadata.get(MEDIA_TYPE);
                let encoding = encoding.and_then(|name| Encoding::of_media_type(name));
                // What is for viewers only, such as `/metrics`, is a copy.
                let is_ours = !channel.topic.starts_with('/');
                if let Some(encoding) = encoding.filter(|_| is_ours) {
                    channels.insert(channel.id, (channel.topic, encoding));
                }
            }
            Record::Message { header, data } => {
                if let Some((topic, encoding)) = channels.get(&header.channel_id)
                    && let Ok(body) = String::from_utf8(data.into_owned())
                {
                    let document = Document { topic: topic.clone(), encoding: *encoding, body };
                    self.documents.push(Recorded { time_ns: header.log_time, document });
                }
            }
            Record::DataEnd(_) => return true,
            _ => {}
        }
        false
    }
}

/// Reads until the end of the data, or to the first thing that is not whole.
fn contents(mut bytes: &[u8]) -> Contents {
    // A damaged length must not make the reader ask for more memory than there is.
    let options = LinearReaderOptions::default()
        .with_record_length_limit(MAX_RECORD_BYTES)
        .with_prevalidate_chunk_crcs(true);
    let mut reader = LinearReader::new_with_options(options);
    let mut channels = BTreeMap::new();
    let mut contents = Contents { facts: None, documents: Vec::new(), failure: None };
    while let Some(event) = reader.next_event() {
        let record = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let (now, later) = bytes.split_at(wanted.min(bytes.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                bytes = later;
                continue;
            }
            Ok(LinearReadEvent::Record { data, opcode }) => parse_record(opcode, data),
            Err(error) => Err(error),
        };
        match record.map(|record| contents.add(record, &mut channels)) {
            Ok(false) => {}
            Ok(true) => return contents,
            Err(error) => {
                contents.failure = Some(error);
                return contents;
            }
        }
    }
    contents.failure = Some(McapError::UnexpectedEof);
    contents
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
