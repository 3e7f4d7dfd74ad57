//! Hashes of messages as a protobuf message: a list of windows, and a list of hashes for each channel.

use crate::proto::timestamp;
use crate::signals::identifier;
use prost::encoding::{DecodeContext, decode_key, fixed64, skip_field, uint64};
use tremie_messages::start::SentChannel;

/// Number of the field that lists the windows; those of the channels follow.
const WINDOWS: u32 = 2;

/// Field names of the channels: `state_to_fluid`.
pub fn hash_fields(channels: &[SentChannel]) -> Vec<String> {
    let name = |channel: &SentChannel| format!("{}_to_{}", channel.content.name(), channel.to);
    channels.iter().map(|channel| identifier(&name(channel))).collect()
}

/// Encodes rows of a window and a hash for each of so many channels.
pub fn encode_hashes(nanoseconds: u64, channels: usize, rows: &[u64]) -> Vec<u8> {
    let column =
        |k: usize| -> Vec<u64> { rows.chunks_exact(1 + channels).map(|row| row[k]).collect() };
    let mut out = Vec::with_capacity(32 + 9 * rows.len());
    prost::encoding::message::encode(1, &timestamp(nanoseconds), &mut out);
    uint64::encode_packed(WINDOWS, &column(0), &mut out);
    for k in 1..=channels {
        fixed64::encode_packed(WINDOWS + k as u32, &column(k), &mut out);
    }
    out
}

/// The rows of a message of so many channels.
///
/// # Errors
/// If it is no such message.
pub fn decode_hashes(mut data: &[u8], channels: usize) -> Result<Vec<u64>, prost::DecodeError> {
    let mut columns = vec![Vec::new(); 1 + channels];
    while !data.is_empty() {
        let (number, kind) = decode_key(&mut data)?;
        let context = DecodeContext::default();
        match number.checked_sub(WINDOWS).map(|k| k as usize).filter(|k| *k <= channels) {
            Some(0) => uint64::merge_repeated(kind, &mut columns[0], &mut data, context)?,
            Some(k) => fixed64::merge_repeated(kind, &mut columns[k], &mut data, context)?,
            None => skip_field(kind, number, &mut data, context)?,
        }
    }
    // A column that is shorter than the others is damaged: its rows do not count.
    let rows = columns.iter().map(Vec::len).min().unwrap_or(0);
    let row = |k: usize| columns.iter().map(move |column| column[k]);
    Ok((0..rows).flat_map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::schedule::Content;

    #[test]
    fn rows_come_back() {
        let rows = [7, 0, u64::MAX, 8, 1, 2, 9, 1 << 63, 3];
        assert_eq!(decode_hashes(&encode_hashes(1_500_000_000, 2, &rows), 2).unwrap(), rows);
        assert!(decode_hashes(&encode_hashes(0, 2, &[]), 2).unwrap().is_empty());
    }

    #[test]
    fn channels_have_names_of_their_own() {
        let channel = |content| SentChannel { content, to: "my-fluid".into() };
        let fields = hash_fields(&[channel(Content::State), channel(Content::Events)]);
        assert_eq!(fields, ["state_to_my_fluid", "events_to_my_fluid"]);
    }
}
