//! Signals as a protobuf message with one `double` field for each, made for the component at hand.

use crate::proto::timestamp;
use prost::Message;
use prost::encoding::{DecodeContext, WireType, decode_key, encode_key, skip_field};
use std::collections::BTreeSet;
use tremie_messages::start::Signal;

/// A name that protobuf accepts: letters, digits and underscores, not beginning with a digit.
pub fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("n_{name}") }
}

/// Field names of these signals, each once.
pub fn fields(signals: &[Signal]) -> Vec<String> {
    let mut taken = BTreeSet::from(["timestamp".to_string()]);
    let mut free = |name: String| {
        let mut unique = name.clone();
        for k in 2.. {
            if taken.insert(unique.clone()) {
                break;
            }
            unique = format!("{name}_{k}");
        }
        unique
    };
    signals.iter().map(|signal| free(identifier(&signal.name))).collect()
}

/// Encodes values; every one is written, also zeros, so that their signs survive.
pub fn encode(nanoseconds: u64, values: &[f64]) -> Vec<u8> {
    let mut out = Vec::with_capacity(16 + 10 * values.len());
    prost::encoding::message::encode(1, &timestamp(nanoseconds), &mut out);
    for (value, number) in values.iter().zip(2..) {
        encode_key(number, WireType::SixtyFourBit, &mut out);
        out.extend(value.to_le_bytes());
    }
    out
}

/// The values of a message of `count` signals.
///
/// # Errors
/// If it is no such message.
pub fn decode(mut data: &[u8], count: usize) -> Result<Vec<f64>, prost::DecodeError> {
    let mut values = vec![0.0; count];
    while !data.is_empty() {
        let (number, kind) = decode_key(&mut data)?;
        match (number as usize).checked_sub(2).and_then(|k| values.get_mut(k)) {
            Some(value) if kind == WireType::SixtyFourBit => {
                prost::encoding::double::merge(kind, value, &mut data, DecodeContext::default())?;
            }
            _ => skip_field(kind, number, &mut data, DecodeContext::default())?,
        }
    }
    Ok(values)
}

/// Bytes of any other message.
pub fn bytes(message: &impl Message) -> Vec<u8> {
    message.encode_to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_bit_for_bit() {
        let values = [0.0, -0.0, 0.1, f64::MIN_POSITIVE / 4.0, f64::INFINITY, f64::NAN, -1e300];
        let back = decode(&encode(1_500_000_000, &values), values.len()).unwrap();
        let bits = |all: &[f64]| all.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&values));
    }

    #[test]
    fn names_become_fields() {
        let signal = |name: &str| Signal::new(name, "1", &[]);
        let names = fields(&[
            signal("speed"),
            signal("max speed"),
            signal("max-speed"),
            signal("2nd"),
            signal("timestamp"),
        ]);
        assert_eq!(names, ["speed", "max_speed", "max_speed_2", "n_2nd", "timestamp_2"]);
    }
}
