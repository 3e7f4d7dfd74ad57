//! Calls that rank 0 makes of its share of the fluid, and has all other ranks make.

use serde::{Deserialize, Serialize};

/// A call. What it is made with and is long stands behind it, as it lies in memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Call {
    /// Makes the share, of the setup and the deadline behind it as JSON.
    Create,
    /// The events behind it.
    Events,
    /// The start exchange with the bodies behind it.
    Start,
    /// A window with the bodies behind it.
    Advance {
        /// Steps in it.
        substeps: u32,
        /// The ranks tell their times.
        is_timed: bool,
    },
    /// The vertices of surfaces that deform behind it.
    Surface,
    /// The velocities at so many ports.
    Ports(u64),
    /// The values of probes.
    Sampled,
    /// A row of signals was kept.
    RowKept,
    /// The place of a signal.
    Place(String),
    /// The cut of a name, of so many nodes.
    Slice(String, u64),
    /// The volume whose grid stands behind it as JSON, of so many nodes.
    Volume(u64),
    /// Keeps a part of the state, beside the file whose place stands behind it as JSON.
    Keep,
    /// Puts the state back from there.
    PutBack,
    /// The end.
    Quit,
}

impl Call {
    /// Bytes of the call, before what stands behind it.
    pub fn head(&self) -> Vec<u8> {
        // It only fails without memory for a few bytes.
        let head = postcard::to_allocvec(self).unwrap_or_default();
        let length = (head.len() as u32).to_le_bytes();
        [&length[..], &head].concat()
    }

    /// The call of such bytes, and what stands behind it.
    pub fn read(bytes: &[u8]) -> Option<(Self, &[u8])> {
        let (length, rest) = bytes.split_first_chunk()?;
        let (head, behind) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        Some((postcard::from_bytes(head).ok()?, behind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_arrive_as_they_were_made() {
        let calls = [
            Call::Create,
            Call::Advance { substeps: 12, is_timed: true },
            Call::Slice("velocity".into(), 77),
            Call::Quit,
        ];
        for call in calls {
            let bytes = [call.head(), vec![1, 2, 3]].concat();
            assert_eq!(Call::read(&bytes), Some((call, &[1, 2, 3][..])));
            assert_eq!(Call::read(&bytes[..3]), None);
        }
    }
}
