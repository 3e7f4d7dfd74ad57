//! Descriptions of the protobuf messages, as MCAP wants them: a `FileDescriptorSet` for each
//! schema.

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto,
    FileDescriptorProto, FileDescriptorSet,
};

const TIMESTAMP: &str = ".google.protobuf.Timestamp";
const TIMESTAMP_FILE: &str = "google/protobuf/timestamp.proto";

/// A field: name, number, kind.
type Field<'a> = (&'a str, i32, Kind<'a>);

#[derive(Clone, Copy)]
enum Kind<'a> {
    One(Type),
    Many(Type),
    Sub(&'a str),
    Subs(&'a str),
    Choice(&'a str),
}

fn field((name, number, kind): &Field) -> FieldDescriptorProto {
    let (label, r#type, type_name) = match kind {
        Kind::One(t) => (Label::Optional, *t, None),
        Kind::Many(t) => (Label::Repeated, *t, None),
        Kind::Sub(name) => (Label::Optional, Type::Message, Some(*name)),
        Kind::Subs(name) => (Label::Repeated, Type::Message, Some(*name)),
        Kind::Choice(name) => (Label::Optional, Type::Enum, Some(*name)),
    };
    FieldDescriptorProto {
        name: Some((*name).into()),
        number: Some(*number),
        label: Some(label.into()),
        r#type: Some(r#type.into()),
        type_name: type_name.map(Into::into),
        ..Default::default()
    }
}

fn described(name: &str, fields: &[Field]) -> DescriptorProto {
    DescriptorProto {
        name: Some(name.into()),
        field: fields.iter().map(field).collect(),
        ..Default::default()
    }
}

fn choice(name: &str, values: &[(&str, i32)]) -> EnumDescriptorProto {
    let value = |(name, number): &(&str, i32)| EnumValueDescriptorProto {
        name: Some((*name).into()),
        number: Some(*number),
        ..Default::default()
    };
    EnumDescriptorProto {
        name: Some(name.into()),
        value: values.iter().map(value).collect(),
        ..Default::default()
    }
}

fn file(
    name: &str,
    package: &str,
    needs: &[&str],
    messages: Vec<DescriptorProto>,
) -> FileDescriptorProto {
    FileDescriptorProto {
        name: Some(name.into()),
        package: Some(package.into()),
        dependency: needs.iter().map(|name| (*name).into()).collect(),
        message_type: messages,
        syntax: Some("proto3".into()),
        ..Default::default()
    }
}

fn timestamp_file() -> FileDescriptorProto {
    let fields = [("seconds", 1, Kind::One(Type::Int64)), ("nanos", 2, Kind::One(Type::Int32))];
    file(TIMESTAMP_FILE, "google.protobuf", &[], vec![described("Timestamp", &fields)])
}

fn set(files: Vec<FileDescriptorProto>) -> Vec<u8> {
    FileDescriptorSet { file: files }.encode_to_vec()
}

fn doubles<'a>(names: &[&'a str]) -> Vec<Field<'a>> {
    names.iter().zip(1..).map(|(name, number)| (*name, number, Kind::One(Type::Double))).collect()
}

/// `foxglove.PointCloud`.
pub fn point_cloud() -> Vec<u8> {
    let mut packed = described(
        "PackedElementField",
        &[
            ("name", 1, Kind::One(Type::String)),
            ("offset", 2, Kind::One(Type::Fixed32)),
            ("type", 3, Kind::Choice(".foxglove.PackedElementField.NumericType")),
        ],
    );
    packed.enum_type.push(choice(
        "NumericType",
        &[
            ("UNKNOWN", 0),
            ("UINT8", 1),
            ("INT8", 2),
            ("UINT16", 3),
            ("INT16", 4),
            ("UINT32", 5),
            ("INT32", 6),
            ("FLOAT32", 7),
            ("FLOAT64", 8),
        ],
    ));
    let pose = described(
        "Pose",
        &[
            ("position", 1, Kind::Sub(".foxglove.Vector3")),
            ("orientation", 2, Kind::Sub(".foxglove.Quaternion")),
        ],
    );
    let cloud = described(
        "PointCloud",
        &[
            ("timestamp", 1, Kind::Sub(TIMESTAMP)),
            ("frame_id", 2, Kind::One(Type::String)),
            ("pose", 3, Kind::Sub(".foxglove.Pose")),
            ("point_stride", 4, Kind::One(Type::Fixed32)),
            ("fields", 5, Kind::Subs(".foxglove.PackedElementField")),
            ("data", 6, Kind::One(Type::Bytes)),
        ],
    );
    let messages = vec![
        described("Vector3", &doubles(&["x", "y", "z"])),
        described("Quaternion", &doubles(&["x", "y", "z", "w"])),
        pose,
        packed,
        cloud,
    ];
    set(vec![
        timestamp_file(),
        file("foxglove/PointCloud.proto", "foxglove", &[TIMESTAMP_FILE], messages),
    ])
}

/// `foxglove.Log`.
pub fn log() -> Vec<u8> {
    let mut log = described(
        "Log",
        &[
            ("timestamp", 1, Kind::Sub(TIMESTAMP)),
            ("level", 2, Kind::Choice(".foxglove.Log.Level")),
            ("message", 3, Kind::One(Type::String)),
            ("name", 4, Kind::One(Type::String)),
            ("file", 5, Kind::One(Type::String)),
            ("line", 6, Kind::One(Type::Fixed32)),
        ],
    );
    log.enum_type.push(choice(
        "Level",
        &[("UNKNOWN", 0), ("DEBUG", 1), ("INFO", 2), ("WARNING", 3), ("ERROR", 4), ("FATAL", 5)],
    ));
    set(vec![
        timestamp_file(),
        file("foxglove/Log.proto", "foxglove", &[TIMESTAMP_FILE], vec![log]),
    ])
}

/// `tremie.Frame`.
pub fn frame() -> Vec<u8> {
    let grid = described(
        "Grid",
        &[
            ("origin", 1, Kind::Many(Type::Double)),
            ("step_0", 2, Kind::Many(Type::Double)),
            ("step_1", 3, Kind::Many(Type::Double)),
            ("count", 4, Kind::Many(Type::Uint64)),
        ],
    );
    let frame = described(
        "Frame",
        &[
            ("timestamp", 1, Kind::Sub(TIMESTAMP)),
            ("topic", 2, Kind::One(Type::String)),
            ("window", 3, Kind::One(Type::Uint64)),
            ("ticks", 4, Kind::One(Type::Uint64)),
            ("events", 5, Kind::One(Type::Uint64)),
            ("substep", 6, Kind::One(Type::Uint32)),
            ("iteration", 7, Kind::One(Type::Uint32)),
            ("time", 8, Kind::One(Type::Double)),
            ("level", 9, Kind::One(Type::Uint64)),
            ("grid", 10, Kind::Sub(".tremie.Grid")),
        ],
    );
    set(vec![
        timestamp_file(),
        file("tremie/Frame.proto", "tremie", &[TIMESTAMP_FILE], vec![grid, frame]),
    ])
}

/// `tremie.Message`.
pub fn message() -> Vec<u8> {
    let fields = [
        ("timestamp", 1, Kind::Sub(TIMESTAMP)),
        ("type", 2, Kind::One(Type::String)),
        ("count", 3, Kind::One(Type::Uint64)),
        ("values", 4, Kind::One(Type::Bytes)),
    ];
    let whole = described("Message", &fields);
    set(vec![
        timestamp_file(),
        file("tremie/Message.proto", "tremie", &[TIMESTAMP_FILE], vec![whole]),
    ])
}

/// `tremie.hashes.<name>` with a list of windows, and one of hashes for each field, numbered from 3.
pub fn hashes(name: &str, fields: &[String]) -> Vec<u8> {
    let mut all: Vec<Field> =
        vec![("timestamp", 1, Kind::Sub(TIMESTAMP)), ("window", 2, Kind::Many(Type::Uint64))];
    all.extend(
        fields.iter().zip(3..).map(|(field, n)| (field.as_str(), n, Kind::Many(Type::Fixed64))),
    );
    let path = format!("tremie/hashes/{name}.proto");
    set(vec![
        timestamp_file(),
        file(&path, "tremie.hashes", &[TIMESTAMP_FILE], vec![described(name, &all)]),
    ])
}

/// `tremie.signals.<name>` with one double for each field, numbered from 2.
pub fn signals(name: &str, fields: &[String]) -> Vec<u8> {
    let mut all: Vec<Field> = vec![("timestamp", 1, Kind::Sub(TIMESTAMP))];
    all.extend(
        fields.iter().zip(2..).map(|(field, n)| (field.as_str(), n, Kind::One(Type::Double))),
    );
    let path = format!("tremie/signals/{name}.proto");
    set(vec![
        timestamp_file(),
        file(&path, "tremie.signals", &[TIMESTAMP_FILE], vec![described(name, &all)]),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::proto;
    use prost::encoding::{DecodeContext, WireType, decode_key, skip_field};

    /// Wire type of a field of this kind; lists of numbers are packed.
    fn wire_type(field: &FieldDescriptorProto) -> WireType {
        match field.r#type() {
            _ if field.label() == Label::Repeated => WireType::LengthDelimited,
            Type::Double | Type::Fixed64 => WireType::SixtyFourBit,
            Type::Float | Type::Fixed32 => WireType::ThirtyTwoBit,
            Type::String | Type::Bytes | Type::Message => WireType::LengthDelimited,
            _ => WireType::Varint,
        }
    }

    /// Expects that the schema of `name` in `set` describes every field of the encoded `message`.
    #[track_caller]
    fn describes(set: &[u8], name: &str, message: &impl Message) {
        let set = FileDescriptorSet::decode(set).unwrap();
        let mut known = set.file.iter().flat_map(|file| &file.message_type);
        let schema = known.find(|known| known.name() == name).unwrap();
        let (bytes, mut found) = (message.encode_to_vec(), 0);
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            let (number, wire) = decode_key(&mut rest).unwrap();
            let field = schema.field.iter().find(|field| field.number() == number as i32);
            let field = field.unwrap_or_else(|| panic!("{name} has no field {number}"));
            assert_eq!(wire, wire_type(field), "{name}.{}", field.name());
            skip_field(wire, number, &mut rest, DecodeContext::default()).unwrap();
            found += 1;
        }
        assert!(found > 0, "{name}: nothing was encoded");
    }

    #[test]
    fn schemas_describe_the_messages_as_they_are_written() {
        let (one, time) = (1.0, Some(proto::timestamp(1)));
        let vector = proto::Vector3 { x: one, y: one, z: one };
        let quaternion = proto::Quaternion { x: one, y: one, z: one, w: one };
        let pose =
            proto::Pose { position: Some(vector.clone()), orientation: Some(quaternion.clone()) };
        let field = proto::PackedElementField { name: "x".into(), offset: 8, r#type: 7 };
        let cloud = proto::PointCloud {
            timestamp: time,
            frame_id: "world".into(),
            pose: Some(pose.clone()),
            point_stride: 12,
            fields: vec![field.clone()],
            data: vec![1],
        };
        let grid = proto::Grid {
            origin: vec![one; 3],
            step_0: vec![one; 3],
            step_1: vec![one; 3],
            count: vec![2; 2],
        };
        let frame = proto::Frame {
            timestamp: time,
            topic: "/log".into(),
            window: 1,
            ticks: 1,
            events: 1,
            substep: 1,
            iteration: 1,
            time: one,
            level: 1,
            grid: Some(grid.clone()),
        };
        let whole = proto::WholeMessage {
            timestamp: time,
            r#type: "f64".into(),
            count: 1,
            values: vec![1],
        };
        let line = proto::Log { timestamp: time, level: 1, message: "a".into(), name: "b".into() };
        describes(&point_cloud(), "Vector3", &vector);
        describes(&point_cloud(), "Quaternion", &quaternion);
        describes(&point_cloud(), "Pose", &pose);
        describes(&point_cloud(), "PackedElementField", &field);
        describes(&point_cloud(), "PointCloud", &cloud);
        describes(&super::frame(), "Grid", &grid);
        describes(&super::frame(), "Frame", &frame);
        describes(&log(), "Log", &line);
        describes(&message(), "Message", &whole);
    }
}
