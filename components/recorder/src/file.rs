//! The MCAP file being written: channels as they are first needed, chunks at fixed amounts.

use crate::proto::Frame;
use crate::schema;
use crate::signals::{bytes, fields, identifier};
use crate::windows::Stream;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapResult, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use tremie_messages::start::Signal;

/// A chunk is closed when it holds this many bytes ..
const CHUNK_BYTES: usize = 4 << 20;
/// .. or this many windows: what a killed recorder loses at most. Never by the clock, which would
/// make files of identical runs differ.
const CHUNK_WINDOWS: u32 = 64;

/// Name of the program that wrote the file; fixed, as all of the file.
const LIBRARY: &str = concat!("tremie-recorder ", env!("CARGO_PKG_VERSION"));

/// Topic of the frames' stamps.
pub const FRAMES: &str = "/frames";
/// Topic of the log.
pub const LOG: &str = "/log";
/// Key of a signal channel's metadata that holds the signals, as JSON.
pub const SIGNALS: &str = "signals";

/// Topic of a stream.
pub fn topic(stream: &Stream) -> String {
    match stream {
        Stream::Bodies(from) => format!("/bodies/{from}"),
        Stream::Surfaces(from) => format!("/surfaces/{from}"),
        Stream::Cut(from, name) => format!("/cuts/{from}/{name}"),
        Stream::Signals(from) => format!("/signals/{from}"),
    }
}

/// A message of a topic, with the frame that announces it.
pub struct Entry {
    /// Stamp and topic.
    pub frame: Frame,
    /// Simulated time [ns].
    pub time: u64,
    /// The encoded message.
    pub data: Vec<u8>,
}

/// An MCAP file being written.
pub struct McapFile {
    writer: Writer<BufWriter<File>>,
    channels: BTreeMap<String, u16>,
    sequence: u32,
    bytes: usize,
    windows: u32,
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
        let mut writer = options.create(BufWriter::new(file))?;
        writer.write_metadata(&Metadata { name: crate::document::RUN.into(), metadata: run })?;
        let mut file =
            Self { writer, channels: BTreeMap::new(), sequence: 0, bytes: 0, windows: 0 };
        file.add_channel(FRAMES, "tremie.Frame", &schema::frame(), &BTreeMap::new())?;
        file.add_channel(LOG, "foxglove.Log", &schema::log(), &BTreeMap::new())?;
        file.writer.flush()?;
        Ok(file)
    }

    fn add_channel(
        &mut self,
        topic: &str,
        schema: &str,
        data: &[u8],
        metadata: &BTreeMap<String, String>,
    ) -> McapResult<()> {
        let schema = self.writer.add_schema(schema, "protobuf", data)?;
        let channel = self.writer.add_channel(schema, topic, "protobuf", metadata)?;
        self.channels.insert(topic.into(), channel);
        Ok(())
    }

    /// Makes sure that a stream's channel is there; `signals` of a signal stream.
    pub fn announce(&mut self, stream: &Stream, signals: &[Signal]) -> McapResult<()> {
        let topic = topic(stream);
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
                let list = serde_json::to_string(signals).map_err(std::io::Error::other)?;
                let metadata = BTreeMap::from([(SIGNALS.to_string(), list)]);
                let schema = schema::signals(&name, &fields(signals));
                self.add_channel(&topic, &format!("tremie.signals.{name}"), &schema, &metadata)
            }
        }
    }

    /// Writes a message after its frame.
    pub fn write(&mut self, entry: &Entry) -> McapResult<()> {
        self.put(FRAMES, entry.time, &bytes(&entry.frame))?;
        self.put(&entry.frame.topic, entry.time, &entry.data)?;
        self.sequence = self.sequence.wrapping_add(1);
        Ok(())
    }

    fn put(&mut self, topic: &str, time: u64, data: &[u8]) -> McapResult<()> {
        let Some(&channel_id) = self.channels.get(topic) else {
            return Ok(());
        };
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.bytes += data.len();
        self.writer.write_to_known_channel(&header, data)
    }

    /// A window was written: closes the chunk if it is full.
    pub fn end_window(&mut self) -> McapResult<()> {
        self.windows += 1;
        if self.bytes < CHUNK_BYTES && self.windows < CHUNK_WINDOWS {
            return Ok(());
        }
        (self.bytes, self.windows) = (0, 0);
        self.writer.flush()
    }

    /// Writes the last metadata record and the index.
    pub fn finish(mut self, last_common_window: u64) -> McapResult<()> {
        let metadata =
            BTreeMap::from([("last_common_window".to_string(), last_common_window.to_string())]);
        self.writer.write_metadata(&Metadata { name: crate::document::END.into(), metadata })?;
        self.writer.finish()?;
        self.writer.into_inner().flush()?;
        Ok(())
    }
}
