//! The protobuf messages, as Rust types. Field numbers of `foxglove.*` are Foxglove's own
//! (<https://github.com/foxglove/foxglove-sdk/tree/main/schemas/proto/foxglove>).

use prost::Message;
use prost_types::Timestamp;

/// `foxglove.Vector3`.
#[derive(Clone, PartialEq, Message)]
pub struct Vector3 {
    #[prost(double, tag = "1")]
    pub x: f64,
    #[prost(double, tag = "2")]
    pub y: f64,
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// `foxglove.Quaternion`.
#[derive(Clone, PartialEq, Message)]
pub struct Quaternion {
    #[prost(double, tag = "1")]
    pub x: f64,
    #[prost(double, tag = "2")]
    pub y: f64,
    #[prost(double, tag = "3")]
    pub z: f64,
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// `foxglove.Pose`.
#[derive(Clone, PartialEq, Message)]
pub struct Pose {
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

/// `foxglove.PackedElementField`.
#[derive(Clone, PartialEq, Message)]
pub struct PackedElementField {
    #[prost(string, tag = "1")]
    pub name: String,
    #[prost(fixed32, tag = "2")]
    pub offset: u32,
    #[prost(enumeration = "NumericType", tag = "3")]
    pub r#type: i32,
}

/// `foxglove.PackedElementField.NumericType`; kinds that are not used here are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum NumericType {
    Unknown = 0,
    Uint32 = 5,
    Float32 = 7,
    Float64 = 8,
}

/// `foxglove.PointCloud`.
#[derive(Clone, PartialEq, Message)]
pub struct PointCloud {
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    #[prost(string, tag = "2")]
    pub frame_id: String,
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    #[prost(fixed32, tag = "4")]
    pub point_stride: u32,
    #[prost(message, repeated, tag = "5")]
    pub fields: Vec<PackedElementField>,
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// `foxglove.Log`.
#[derive(Clone, PartialEq, Message)]
pub struct Log {
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    #[prost(enumeration = "Level", tag = "2")]
    pub level: i32,
    #[prost(string, tag = "3")]
    pub message: String,
    #[prost(string, tag = "4")]
    pub name: String,
}

/// `foxglove.Log.Level`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
#[repr(i32)]
pub enum Level {
    Unknown = 0,
    Debug = 1,
    Info = 2,
    Warning = 3,
    Error = 4,
    Fatal = 5,
}

/// `tremie.Message`: a message between components, its values as they lie in memory.
#[derive(Clone, PartialEq, Message)]
pub struct WholeMessage {
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Type of its values.
    #[prost(string, tag = "2")]
    pub r#type: String,
    /// Number of its values.
    #[prost(uint64, tag = "3")]
    pub count: u64,
    #[prost(bytes = "vec", tag = "4")]
    pub values: Vec<u8>,
}

/// `tremie.Frame`: what the next message is.
#[derive(Clone, PartialEq, Message)]
pub struct Frame {
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Topic of the next message.
    #[prost(string, tag = "2")]
    pub topic: String,
    #[prost(uint64, tag = "3")]
    pub window: u64,
    #[prost(uint64, tag = "4")]
    pub ticks: u64,
    #[prost(uint64, tag = "5")]
    pub events: u64,
    #[prost(uint32, tag = "6")]
    pub substep: u32,
    #[prost(uint32, tag = "7")]
    pub iteration: u32,
    /// Simulated time [s].
    #[prost(double, tag = "8")]
    pub time: f64,
    /// Level of a line of the log.
    #[prost(uint64, tag = "9")]
    pub level: u64,
    /// Grid of a cut.
    #[prost(message, optional, tag = "10")]
    pub grid: Option<Grid>,
}

/// `tremie.Grid`: node `(i, j)` lies at `origin + i * step_0 + j * step_1`.
#[derive(Clone, PartialEq, Message)]
pub struct Grid {
    #[prost(double, repeated, tag = "1")]
    pub origin: Vec<f64>,
    #[prost(double, repeated, tag = "2")]
    pub step_0: Vec<f64>,
    #[prost(double, repeated, tag = "3")]
    pub step_1: Vec<f64>,
    #[prost(uint64, repeated, tag = "4")]
    pub count: Vec<u64>,
}

/// Simulated time as protobuf says it [ns].
pub fn timestamp(nanoseconds: u64) -> Timestamp {
    const SECOND: u64 = 1_000_000_000;
    Timestamp { seconds: (nanoseconds / SECOND) as i64, nanos: (nanoseconds % SECOND) as i32 }
}
