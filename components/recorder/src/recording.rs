//! Reads a recording, and plays it to any observer.

use crate::codec::{decode_bodies, decode_grid, decode_nodes, decode_vertices};
use crate::document::{END, RUN, RunNote};
use crate::entry::LOG;
use crate::file::{CHANNELS, FRAMES, SIGNALS};
use crate::hashes::decode_hashes;
use crate::item::Item;
use crate::proto::{Frame, Log, PointCloud, WholeMessage};
use crate::records::Records;
use crate::signals::decode;
use mcap::McapError;
use mcap::records::Record;
use prost::Message;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;
use tremie_messages::Stamp;
use tremie_messages::frame::{LogHeader, SliceHeader};
use tremie_messages::schedule::Content;
use tremie_messages::start::{Clock, FrameContent, SentChannel, Signal};
use tremie_sdk::{Moment, Observer, ObserverError, Setup};

/// Why a recording cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// It is no MCAP file, or a damaged one.
    #[error("not a readable MCAP file: {0}")]
    Mcap(#[from] McapError),
    /// It is an MCAP file of something else.
    #[error("not a recording of Tremie: {0}")]
    Foreign(String),
    /// A message is not what its topic says.
    #[error("damaged recording: the message of {topic} at window {window} cannot be read")]
    Damaged {
        /// Topic of the message.
        topic: String,
        /// Its window.
        window: u64,
    },
    /// The observer that it was played to failed.
    #[error(transparent)]
    Observer(#[from] ObserverError),
}

/// End of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// Last window that all components completed; of an incomplete file, the last one found in it.
    pub last_common_window: u64,
    /// Simulated time of the newest frame that was read [s].
    pub time: f64,
    /// True if the recorder came to its end; `false` if it was killed, or the file is damaged.
    pub complete: bool,
}

/// An opened recording.
pub struct Recording {
    run: RunNote,
    items: Items,
}

impl Recording {
    /// Opens a recording.
    ///
    /// # Errors
    /// If it cannot be read, or is not one of Tremie's.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let mut records = Records::of(File::open(path)?, false)?;
        if records.is_empty() {
            return Err(ReadError::Foreign(
                "it is empty; its run ended before the first frame".into(),
            ));
        }
        let foreign = |why: &str| ReadError::Foreign(why.into());
        while let Some(record) = records.next()? {
            if let Record::Metadata(metadata) = &record
                && metadata.name == RUN
            {
                let run = RunNote::from_map(&metadata.metadata).map_err(|error| {
                    foreign(&format!("its description does not fit this version: {error}"))
                })?;
                return Ok(Self { run, items: Items::new(records) });
            }
        }
        Err(foreign(
            "no description of a run is in it; if the file was cut off, that is lost with its beginning",
        ))
    }

    /// Setup that an observer named `component` would have got in the run. The run's id is 0.
    pub fn setup(
        &self,
        component: &str,
        output: &Path,
        parameters: serde_json::Map<String, serde_json::Value>,
    ) -> Setup {
        self.run.setup(component, &output.to_string_lossy(), parameters)
    }

    /// The frames, one after the other.
    pub fn items(self) -> Items {
        self.items
    }

    /// Those frames of whose topics `wanted` says so; the others are not decoded.
    pub fn items_of(self, wanted: impl Fn(&str) -> bool + 'static) -> Items {
        Items { wanted: Box::new(wanted), ..self.items }
    }

    /// Ticks and windows of the run.
    pub fn clock(&self) -> Clock {
        self.run.clock()
    }

    /// True if every message of a component is in it, as its beginning says.
    pub fn has_messages(&self, from: &str) -> bool {
        self.run.sends(from, |content| matches!(content, FrameContent::Messages(_)))
    }

    /// True if hashes of some component's messages are in it, as its beginning says.
    pub fn has_hashes(&self) -> bool {
        self.run.has(|content| matches!(content, FrameContent::Hashes(_)))
    }

    /// Plays all frames to an observer. Closing it is up to the caller.
    ///
    /// # Errors
    /// If a frame cannot be read, or the observer fails.
    pub fn replay<O: Observer>(self, observer: &mut O) -> Result<End, ReadError> {
        self.replay_while(observer, || true)
    }

    /// As [`Recording::replay`], as long as `wanted` says so before each frame. The end is that of
    /// the frames which were played.
    ///
    /// # Errors
    /// As [`Recording::replay`].
    pub fn replay_while<O: Observer>(
        mut self,
        observer: &mut O,
        wanted: impl Fn() -> bool,
    ) -> Result<End, ReadError> {
        while wanted() {
            let Some(item) = self.items.next() else { break };
            item?.tell(observer)?;
        }
        Ok(self.items.end())
    }
}

/// A topic, with what its metadata say of its messages.
struct Topic {
    name: String,
    signals: Vec<Signal>,
    channels: Vec<SentChannel>,
    is_wanted: bool,
}

impl Topic {
    /// Of a channel of the file.
    fn new(
        channel: mcap::records::Channel,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Self, ReadError> {
        let list = |key: &str| channel.metadata.get(key).map_or("[]", String::as_str);
        let unreadable =
            |_| ReadError::Foreign(format!("the columns of {} are unreadable", channel.topic));
        Ok(Self {
            signals: serde_json::from_str(list(SIGNALS)).map_err(unreadable)?,
            channels: serde_json::from_str(list(CHANNELS)).map_err(unreadable)?,
            is_wanted: channel.topic == FRAMES || wanted(&channel.topic),
            name: channel.topic,
        })
    }
}

/// Frames of a recording.
pub struct Items {
    records: Records,
    topics: BTreeMap<u16, Topic>,
    wanted: Box<dyn Fn(&str) -> bool>,
    frame: Option<Frame>,
    last: u64,
    time: f64,
    end: Option<u64>,
    /// The end of the file was reached.
    is_read: bool,
}

impl Items {
    fn new(records: Records) -> Self {
        Self {
            records,
            topics: BTreeMap::new(),
            wanted: Box::new(|_| true),
            frame: None,
            last: 0,
            time: 0.0,
            end: None,
            is_read: false,
        }
    }

    /// End of the recording; known once all items were taken.
    pub fn end(&self) -> End {
        End {
            last_common_window: self.end.unwrap_or(self.last),
            time: self.time,
            complete: self.end.is_some(),
        }
    }

    /// The same, if all items were taken.
    pub fn reached(&self) -> Option<End> {
        self.is_read.then(|| self.end())
    }

    fn advance(&mut self) -> Result<Option<Item>, ReadError> {
        while let Some(record) = self.records.next()? {
            match record {
                Record::Channel(channel) => {
                    self.topics.insert(channel.id, Topic::new(channel, &self.wanted)?);
                }
                Record::Metadata(metadata) if metadata.name == END => {
                    self.end = metadata
                        .metadata
                        .get("last_common_window")
                        .and_then(|text| text.parse().ok());
                }
                Record::Message { header, data } => {
                    if let Some(item) = self.message(header.channel_id, &data)? {
                        self.last = self.last.max(item.window());
                        self.time = self.time.max(item.time());
                        return Ok(Some(item));
                    }
                }
                _ => {}
            }
        }
        self.is_read = true;
        Ok(None)
    }

    /// A frame is kept until its message comes.
    fn message(&mut self, channel: u16, data: &[u8]) -> Result<Option<Item>, ReadError> {
        let Some(topic) = self.topics.get(&channel).filter(|topic| topic.is_wanted) else {
            return Ok(None);
        };
        if topic.name == FRAMES {
            let damaged = |_| ReadError::Damaged { topic: FRAMES.into(), window: self.last };
            self.frame = Some(Frame::decode(data).map_err(damaged)?);
            return Ok(None);
        }
        // Messages that another program added have no frame: they are not ours to read.
        let Some(frame) = self.frame.take_if(|frame| frame.topic == topic.name) else {
            return Ok(None);
        };
        let window = frame.window;
        let damaged = || ReadError::Damaged { topic: topic.name.clone(), window };
        item(frame, topic, data).map(Some).ok_or_else(damaged)
    }
}

impl Iterator for Items {
    type Item = Result<Item, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.advance().transpose()
    }
}

fn moment(frame: &Frame) -> Moment {
    let stamp = Stamp {
        run: 0,
        window: frame.window,
        ticks: frame.ticks,
        events: frame.events,
        substep: frame.substep,
        iteration: frame.iteration,
    };
    Moment { stamp, time: frame.time }
}

/// A frame and its message; `None` if the message is not what the topic says.
fn item(frame: Frame, topic: &Topic, data: &[u8]) -> Option<Item> {
    let at = moment(&frame);
    let cloud = || PointCloud::decode(data).ok();
    let mut parts = frame.topic.trim_start_matches('/').splitn(3, '/');
    let (kind, from, name) = (parts.next()?, parts.next().unwrap_or_default(), parts.next());
    Some(match kind {
        "bodies" => Item::Bodies { from: from.into(), at, bodies: decode_bodies(&cloud()?)? },
        "surfaces" => {
            Item::Surfaces { from: from.into(), at, samples: decode_vertices(&cloud()?)? }
        }
        "cuts" => Item::Slice {
            from: from.into(),
            name: name?.into(),
            at,
            header: SliceHeader { stamp: at.stamp, ..decode_grid(frame.grid?)? },
            nodes: decode_nodes(&cloud()?)?,
        },
        "signals" => Item::Signals {
            from: from.into(),
            at,
            names: topic.signals.clone(),
            values: decode(data, topic.signals.len()).ok()?,
        },
        "hashes" => Item::Hashes {
            from: from.into(),
            at,
            channels: topic.channels.clone(),
            rows: decode_hashes(data, topic.channels.len()).ok()?,
        },
        "messages" => {
            let (content, to) = name?.split_once('/')?;
            let (content, to) = (Content::named(content)?, to.to_string());
            let values = WholeMessage::decode(data).ok()?.values;
            let channel = SentChannel { content, to };
            Item::Message { from: from.into(), at, channel, values }
        }
        _ if frame.topic == LOG => Item::Log {
            at,
            header: LogHeader { stamp: at.stamp, level: frame.level },
            text: Log::decode(data).ok()?.message,
        },
        _ => return None,
    })
}
