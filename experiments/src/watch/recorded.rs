//! Reads a recording: an MCAP file of documents.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::WatchError;
use super::feed::Document;

/// The recording in a run folder.
pub const RECORDING: &str = "recording.mcap";

/// The documents of the run in a folder (or of a recording by its own name), by time.
///
/// # Errors
/// When there is no recording, or it is damaged.
pub fn load(dir: &Path) -> Result<Vec<Document>, WatchError> {
    let path = if dir.is_file() { dir.to_owned() } else { dir.join(RECORDING) };
    let bytes = std::fs::read(&path).map_err(|error| match error.kind() {
        ErrorKind::NotFound | ErrorKind::NotADirectory => WatchError::NotFound(path.clone()),
        _ => WatchError::Read { path: path.clone(), error },
    })?;
    let mut documents = read(&path, &bytes)?;
    if documents.is_empty() {
        return Err(WatchError::Empty(path));
    }
    documents.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    Ok(documents)
}

fn read(path: &Path, bytes: &[u8]) -> Result<Vec<Document>, WatchError> {
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(WatchError::NotMcap { path: path.to_owned(), length: bytes.len() });
    }
    let mut documents: Vec<Document> = Vec::new();
    let damaged = |documents: &[Document], error| WatchError::Damaged {
        path: PathBuf::from(path),
        messages: documents.len(),
        time_s: documents.last().map_or(0.0, |d| d.time_s),
        error,
    };
    let messages = mcap::MessageStream::new(bytes).map_err(|error| damaged(&[], error))?;
    for message in messages {
        let message = message.map_err(|error| damaged(&documents, error))?;
        if message.channel.message_encoding != "json" {
            continue;
        }
        let time_s = message.log_time as f64 / 1e9;
        let topic = &message.channel.topic;
        let document = Document::parse(topic, &message.data).map_err(|reason| {
            WatchError::Document { path: path.to_owned(), topic: topic.clone(), time_s, reason }
        })?;
        documents.push(Document { time_s, ..document });
    }
    Ok(documents)
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::collections::BTreeMap;
    use std::sync::Arc;

    use super::*;

    fn recording(bodies: &[(&str, f64, &str)]) -> Vec<u8> {
        let mut file = std::io::Cursor::new(Vec::new());
        let mut writer = mcap::WriteOptions::new().compression(None).create(&mut file).unwrap();
        for (sequence, (topic, time_s, body)) in bodies.iter().enumerate() {
            let channel = mcap::Channel {
                id: 1 + sequence as u16,
                topic: (*topic).to_owned(),
                schema: None,
                message_encoding: if topic.starts_with("link") { "postcard" } else { "json" }
                    .into(),
                metadata: BTreeMap::new(),
            };
            let log_time = (time_s * 1e9) as u64;
            let (channel, data) = (Arc::new(channel), Cow::Borrowed(body.as_bytes()));
            let message = mcap::Message { channel, sequence: 0, log_time, publish_time: 0, data };
            writer.write(&message).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        file.into_inner()
    }

    fn refusal(name: &str, bytes: &[u8]) -> String {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
        load(folder.path()).unwrap_err().to_string()
    }

    #[test]
    fn documents_come_by_time_and_other_messages_are_skipped() {
        let bytes = recording(&[
            ("view/0/pose", 1.5, "{\"time_s\":1.5}"),
            ("link/0", 0.7, "\u{1}"),
            ("truth/town", 0.0, "{}"),
        ]);
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(RECORDING);
        std::fs::write(&file, bytes).unwrap();
        let documents = load(folder.path()).unwrap();
        let found: Vec<_> = documents.iter().map(|d| (d.topic.as_str(), d.time_s)).collect();
        assert_eq!(found, [("truth/town", 0.0), ("view/0/pose", 1.5)]);
        assert_eq!(load(&file).unwrap(), documents);
    }

    #[test]
    fn refusals_say_what_was_found_and_expected() {
        let error = load(Path::new("/no/such/run")).unwrap_err().to_string();
        assert_eq!(
            error,
            "`/no/such/run/recording.mcap`: not found; expected a run recorded with --record"
        );
        let error = refusal("other.txt", b"");
        assert!(error.contains("recording.mcap`: not found"), "{error}");
        let error = refusal(RECORDING, b"time_s,agent\n");
        assert!(error.contains("not an MCAP file (13 bytes)"), "{error}");
        let error = refusal(RECORDING, &recording(&[("link/0", 0.0, "x")]));
        assert!(error.contains("got no document in JSON"), "{error}");
        let error = refusal(RECORDING, &recording(&[("view/0/pose", 2.5, "{\"agent\":}")]));
        assert!(error.contains("`view/0/pose` at 2.5 s: expected value"), "{error}");
    }

    #[test]
    fn a_recording_that_is_cut_off_anywhere_is_refused() {
        let whole = recording(&[("view/0/pose", 1.0, "{}"), ("view/0/pose", 2.0, "{}")]);
        for length in mcap::MAGIC.len()..whole.len() {
            let error = refusal(RECORDING, &whole[..length]);
            assert!(error.contains("damaged after"), "{length}: {error}");
        }
    }
}
