//! The MCAP file being written: channels as they are first needed, chunks at fixed amounts.

use crate::document::{END, RUN};
use crate::entry::{Entry, LOG, topic};
use crate::hashes::hash_fields;
use crate::schema;
use crate::signals::{fields, identifier};
use crate::windows::Stream;
use crate::write_behind::{Pieces, WriteBehind};
use mcap::read::ChunkReader;
use mcap::records::{Channel, MessageHeader, Metadata, Record};
use mcap::write::NoSeek;
use mcap::{Compression, McapError, McapResult, WriteOptions, Writer};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use tremie_messages::start::{SentChannel, Signal};

/// A chunk is closed when it holds this many bytes ..
const CHUNK_BYTES: usize = 4 << 20;
/// .. or this many windows: what a killed recorder loses at most, and what the disk was too slow for. Never by
/// the clock, which would make files of identical runs differ.
const CHUNK_WINDOWS: u32 = 64;

/// Name of the program that wrote the file; fixed, as all of the file.
const LIBRARY: &str = concat!("tremie-recorder ", env!("CARGO_PKG_VERSION"));

/// Topic of the frames' stamps.
pub const FRAMES: &str = "/frames";
/// Key of a signal channel's metadata that holds the signals, as JSON.
pub const SIGNALS: &str = "signals";
/// Key of the metadata of a channel of hashes that holds the channels whose messages they are of, as
/// JSON.
pub const CHANNELS: &str = "channels";

/// What a channel's schema and metadata say of its messages: signals, or hashed channels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Columns<'a> {
    /// Signals of a stream of signals.
    pub signals: &'a [Signal],
    /// Channels of a stream of hashes.
    pub channels: &'a [SentChannel],
}

/// How far a file was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Extent {
    /// Chunks that are closed.
    pub chunks: u64,
    /// Messages, with their frames, in these.
    pub entries: u64,
    /// Windows in the chunk that is open.
    pub windows: u32,
}

/// Schemas (name and content) and topics of a file that is copied, by its numbers.
#[derive(Default)]
pub struct Known {
    schemas: BTreeMap<u16, (String, Vec<u8>)>,
    topics: BTreeMap<u16, String>,
}

/// An MCAP file being written.
pub struct McapFile {
    writer: Writer<NoSeek<BufWriter<WriteBehind>>>,
    pieces: Pieces,
    channels: BTreeMap<String, u16>,
    extent: Extent,
    /// Bytes in the chunk that is open.
    bytes: usize,
    /// Messages in the chunk that is open: no reader finds them before it is closed.
    open: Vec<Entry>,
}

impl McapFile {
    /// Begins the file, with its first metadata record.
    pub fn create(file: File, level: u32, run: BTreeMap<String, String>) -> McapResult<Self> {
        let options = WriteOptions::new()
            .library(LIBRARY)
            .compression(Some(Compression::Zstd))
            .compression_level(level)
            .chunk_size(None)
            // A chunk then reaches the file in one piece, and a killed recorder leaves no half of
            // one.
            .disable_seeking(true);
        let file = WriteBehind::new(file)?;
        let pieces = file.pieces();
        let mut writer = options.create(NoSeek::new(BufWriter::new(file)))?;
        writer.write_metadata(&Metadata { name: RUN.into(), metadata: run })?;
        let mut file = Self {
            writer,
            pieces,
            channels: BTreeMap::new(),
            extent: Extent::default(),
            bytes: 0,
            open: Vec::new(),
        };
        file.add_channel(FRAMES, "tremie.Frame", &schema::frame(), &BTreeMap::new())?;
        file.add_channel(LOG, "foxglove.Log", &schema::log(), &BTreeMap::new())?;
        file.close_chunk()?;
        Ok(file)
    }

    /// Adds a channel, unless it is there.
    fn add_channel(
        &mut self,
        topic: &str,
        schema: &str,
        data: &[u8],
        metadata: &BTreeMap<String, String>,
    ) -> McapResult<()> {
        if self.channels.contains_key(topic) {
            return Ok(());
        }
        let schema = self.writer.add_schema(schema, "protobuf", data)?;
        let channel = self.writer.add_channel(schema, topic, "protobuf", metadata)?;
        self.channels.insert(topic.into(), channel);
        Ok(())
    }

    /// Makes sure that a stream's channel is there.
    fn announce(&mut self, stream: &Stream, columns: Columns<'_>) -> McapResult<()> {
        let topic = topic(Some(stream));
        if self.channels.contains_key(&topic) {
            return Ok(());
        }
        match stream {
            Stream::Bodies(_) | Stream::Surfaces(_) | Stream::Cut(..) => self.add_channel(
                &topic,
                "foxglove.PointCloud",
                &schema::point_cloud(),
                &BTreeMap::new(),
            ),
            Stream::Signals(from) => {
                let name = identifier(from);
                let list = serde_json::to_string(columns.signals).map_err(std::io::Error::other)?;
                let metadata = BTreeMap::from([(SIGNALS.to_string(), list)]);
                let schema = schema::signals(&name, &fields(columns.signals));
                self.add_channel(&topic, &format!("tremie.signals.{name}"), &schema, &metadata)
            }
            Stream::Hashes(from) => {
                let name = identifier(from);
                let list =
                    serde_json::to_string(columns.channels).map_err(std::io::Error::other)?;
                let metadata = BTreeMap::from([(CHANNELS.to_string(), list)]);
                let schema = schema::hashes(&name, &hash_fields(columns.channels));
                self.add_channel(&topic, &format!("tremie.hashes.{name}"), &schema, &metadata)
            }
            Stream::Messages(..) => {
                self.add_channel(&topic, "tremie.Message", &schema::message(), &BTreeMap::new())
            }
        }
    }

    /// Writes a message after its frame; `columns` of its stream.
    pub fn write(&mut self, entry: Entry, columns: Columns<'_>) -> McapResult<()> {
        if let Some(stream) = &entry.stream {
            self.announce(stream, columns)?;
        }
        // The sequence starts again from 0 after its last number.
        let sequence = (self.extent.entries + self.open.len() as u64) as u32;
        self.put(FRAMES, sequence, entry.time, &entry.frame)?;
        self.put(&topic(entry.stream.as_ref()), sequence, entry.time, &entry.data)?;
        self.open.push(entry);
        Ok(())
    }

    fn put(&mut self, topic: &str, sequence: u32, time: u64, data: &[u8]) -> McapResult<()> {
        let Some(&channel_id) = self.channels.get(topic) else {
            return Ok(());
        };
        let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
        self.bytes += data.len();
        self.writer.write_to_known_channel(&header, data)
    }

    /// A window was written: closes the chunk if it is full.
    pub fn end_window(&mut self) -> McapResult<()> {
        self.extent.windows += 1;
        if self.bytes < CHUNK_BYTES && self.extent.windows < CHUNK_WINDOWS {
            return Ok(());
        }
        self.close_chunk()
    }

    /// Closes the chunk, which is on its way to the file then.
    pub fn close_chunk(&mut self) -> McapResult<()> {
        self.extent.chunks += 1;
        self.extent.entries += self.open.len() as u64;
        self.extent.windows = 0;
        self.bytes = 0;
        self.open.clear();
        self.writer.flush()
    }

    /// What is on its way to the file.
    pub fn pieces(&self) -> Pieces {
        self.pieces.clone()
    }

    /// How far it was written.
    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Messages of the chunk that is open.
    pub fn open_entries(&self) -> &[Entry] {
        &self.open
    }

    /// Writes the records of a chunk of another file of this run again. `known` is what came in the
    /// chunks before it.
    pub fn copy_records(&mut self, chunk: ChunkReader<'_>, known: &mut Known) -> McapResult<()> {
        for record in chunk {
            match record? {
                Record::Schema { header, data } => {
                    known.schemas.insert(header.id, (header.name, data.into_owned()));
                }
                Record::Channel(Channel { id, schema_id, topic, metadata, .. }) => {
                    let schema = known.schemas.get(&schema_id);
                    let unknown = || McapError::UnknownSchema(topic.clone(), schema_id);
                    let (name, data) = schema.ok_or_else(unknown)?;
                    self.add_channel(&topic, name, data, &metadata)?;
                    known.topics.insert(id, topic);
                }
                Record::Message {
                    header: MessageHeader { channel_id, sequence, log_time, .. },
                    data,
                } => {
                    let unknown = || McapError::UnknownChannel(sequence, channel_id);
                    let topic = known.topics.get(&channel_id).ok_or_else(unknown)?;
                    self.put(topic, sequence, log_time, &data)?;
                    self.extent.entries += u64::from(topic == FRAMES);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Puts the messages of the chunk that was open into a file that was copied so far. `columns` has
    /// those of a stream.
    pub fn reopen_chunk<'a>(
        &mut self,
        windows: u32,
        entries: Vec<Entry>,
        columns: impl Fn(&Stream) -> Columns<'a>,
    ) -> McapResult<()> {
        for entry in entries {
            let columns = entry.stream.as_ref().map_or(Columns::default(), &columns);
            self.write(entry, columns)?;
        }
        self.extent.windows = windows;
        Ok(())
    }

    /// Writes the last metadata record and the index, and waits until the file has all.
    pub fn finish(mut self, last_common_window: u64) -> McapResult<()> {
        let metadata =
            BTreeMap::from([("last_common_window".to_string(), last_common_window.to_string())]);
        self.writer.write_metadata(&Metadata { name: END.into(), metadata })?;
        self.writer.finish()?;
        self.writer.into_inner().flush()?;
        Ok(self.pieces.settle()?)
    }
}
