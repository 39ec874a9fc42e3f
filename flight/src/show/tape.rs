//! `recording.mcap`, channel by channel: an MCAP file (<https://mcap.dev>) that is whole or not
//! there, and readable up to the last chunk while it grows.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use foxglove::Encode;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer};

use super::schema;
use crate::record::RecordError;
use crate::run_folder::{FolderError, PartialFile};
use csat_mission::documents::Document;
use csat_mission::mission::Kind;

/// The key under which a channel of documents says which kind of JSON they are.
pub const MEDIA_TYPE: &str = "media_type";

/// The lowest level of LZ4 that looks for long matches: a quarter smaller than the fastest, and just
/// as fast to read.
const LZ4_LEVEL: u32 = 3;

/// An MCAP file being written.
///
/// It never seeks back: what is on the disk are whole chunks, and a reader of a file that was left
/// behind loses at most the chunk in the making. Dropped, it writes its index under its temporary
/// name.
pub struct Tape {
    writer: Writer<NoSeek<Counted>>,
    path: PathBuf,
    /// What schemas of numbers follow from.
    kind: Kind,
    /// The channel of each topic and how many messages it has.
    channels: BTreeMap<String, (u16, u32)>,
}

/// A file and how long it is.
struct Counted {
    file: PartialFile,
    bytes: u64,
}

impl Write for Counted {
    fn write(&mut self, buffer: &[u8]) -> std::io::Result<usize> {
        let written = self.file.write(buffer)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Tape {
    /// Starts the file that will be at `path`, of a mission of this kind.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path, kind: Kind) -> Result<Self, RecordError> {
        let file = Counted { file: PartialFile::create(path.to_owned())?, bytes: 0 };
        let writer = WriteOptions::new()
            .compression(Some(Compression::Lz4))
            .compression_level(LZ4_LEVEL)
            .library(concat!("csat ", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true)
            .create(NoSeek::new(file))
            .map_err(|error| mcap_error(path, error))?;
        Ok(Self { writer, path: path.to_owned(), kind, channels: BTreeMap::new() })
    }

    /// Adds a file.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn attach(&mut self, name: &str, media_type: &str, text: &str) -> Result<(), RecordError> {
        let attachment = Attachment {
            log_time: 0,
            create_time: 0,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: text.as_bytes().into(),
        };
        self.writer.attach(&attachment).map_err(|error| mcap_error(&self.path, error))
    }

    /// Adds a record of names and values.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn describe(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        let metadata = Metadata { name: name.to_owned(), metadata };
        self.writer.write_metadata(&metadata).map_err(|error| mcap_error(&self.path, error))
    }

    /// Adds a document under a topic.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn document(
        &mut self,
        topic: &str,
        time_ns: u64,
        document: &Document,
    ) -> Result<(), RecordError> {
        if !self.channels.contains_key(topic) {
            let (name, text) = schema::of_topic(&self.kind, &document.topic, document.encoding);
            let media_type = document.encoding.media_type().to_owned();
            let metadata = BTreeMap::from([(MEDIA_TYPE.to_owned(), media_type)]);
            self.open(topic, "json", (&name, "jsonschema", text.as_bytes()), &metadata)?;
        }
        self.write(topic, time_ns, document.body.as_bytes())
    }

    /// Adds a message of a schema that viewers know.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn message<T: Encode>(
        &mut self,
        topic: &str,
        time_ns: u64,
        message: &T,
    ) -> Result<(), RecordError> {
        if !self.channels.contains_key(topic)
            && let Some(schema) = T::get_schema()
        {
            let known = (schema.name.as_str(), schema.encoding.as_str(), &*schema.data);
            self.open(topic, &T::get_message_encoding(), known, &BTreeMap::new())?;
        }
        let mut bytes = Vec::with_capacity(message.encoded_len().unwrap_or_default());
        message.encode(&mut bytes).map_err(|error| {
            mcap_error(&self.path, McapError::Io(std::io::Error::other(error.to_string())))
        })?;
        self.write(topic, time_ns, &bytes)
    }

    /// Lets readers have everything up to here, whatever happens next.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.writer.flush().map_err(|error| mcap_error(&self.path, error))
    }

    /// Writes the index, gives the file its name and returns its length in bytes.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn finish(mut self) -> Result<u64, RecordError> {
        self.writer.finish().map_err(|error| mcap_error(&self.path, error))?;
        let Counted { file, bytes } = self.writer.into_inner().into_inner();
        file.finish()?;
        Ok(bytes)
    }

    fn open(
        &mut self,
        topic: &str,
        encoding: &str,
        schema: (&str, &str, &[u8]),
        metadata: &BTreeMap<String, String>,
    ) -> Result<(), RecordError> {
        let (name, of, data) = schema;
        let channel = self
            .writer
            .add_schema(name, of, data)
            .and_then(|schema| self.writer.add_channel(schema, topic, encoding, metadata))
            .map_err(|error| mcap_error(&self.path, error))?;
        self.channels.insert(topic.to_owned(), (channel, 0));
        Ok(())
    }

    fn write(&mut self, topic: &str, time_ns: u64, bytes: &[u8]) -> Result<(), RecordError> {
        let Some((channel, count)) = self.channels.get_mut(topic) else { return Ok(()) };
        let header = MessageHeader {
            channel_id: *channel,
            sequence: *count,
            log_time: time_ns,
            publish_time: time_ns,
        };
        *count += 1;
        self.writer
            .write_to_known_channel(&header, bytes)
            .map_err(|error| mcap_error(&self.path, error))
    }
}

/// What the mcap crate said, in the words of a file that could not be written.
fn mcap_error(path: &Path, error: McapError) -> RecordError {
    let error = match error {
        McapError::Io(error) => error,
        other => std::io::Error::other(other),
    };
    RecordError::Folder(FolderError::Io { what: "write", path: path.to_owned(), error })
}
