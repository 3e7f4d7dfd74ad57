//! Arrays as VTK's XML files store them in their appended data.
//!
//! Format: VTK's documentation of XML file formats, "Appended data" and "Compressed data". Headers
//! are of type UInt64, numbers little-endian.

use crate::parameters::Compression;

/// Bytes of an array that are compressed at a time: large enough for its redundancy, small enough
/// for readers that take a part.
const BLOCK: usize = 1 << 17;

/// A number of an array.
pub trait Scalar: Copy {
    /// VTK's name of the type.
    const NAME: &'static str;
    /// Appends the number, little-endian.
    fn push(self, bytes: &mut Vec<u8>);
}

macro_rules! scalar {
    ($($type:ty, $name:literal;)+) => {$(
        impl Scalar for $type {
            const NAME: &'static str = $name;
            #[inline(always)]
            fn push(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        }
    )+};
}

scalar! {
    u8, "UInt8";
    u32, "UInt32";
    u64, "UInt64";
    i64, "Int64";
    f32, "Float32";
    f64, "Float64";
}

/// Numbers as bytes.
pub fn bytes<T: Scalar>(values: impl Iterator<Item = T>) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.size_hint().0 * size_of::<T>());
    values.for_each(|value| value.push(&mut bytes));
    bytes
}

/// Appends an array with its header.
pub fn append(data: &mut Vec<u8>, array: &[u8], compression: Compression) {
    match compression {
        Compression::None => {
            (array.len() as u64).push(data);
            data.extend_from_slice(array);
        }
        Compression::Lz4 => append_compressed(data, array),
    }
}

/// Number of blocks, size of a block, size of a last shorter one (0: none), sizes of all blocks
/// compressed; then the blocks.
fn append_compressed(data: &mut Vec<u8>, array: &[u8]) {
    let blocks = array.len().div_ceil(BLOCK);
    for number in [blocks, BLOCK, array.len() % BLOCK] {
        (number as u64).push(data);
    }
    let sizes = data.len();
    data.resize(sizes + 8 * blocks, 0);
    for (k, block) in array.chunks(BLOCK).enumerate() {
        let begin = data.len();
        data.resize(begin + lz4_flex::block::get_maximum_output_size(block.len()), 0);
        // Cannot fail: there is room for the worst case.
        let size = lz4_flex::block::compress_into(block, &mut data[begin..]).unwrap_or(0);
        data.truncate(begin + size);
        data[sizes + 8 * k..sizes + 8 * (k + 1)].copy_from_slice(&(size as u64).to_le_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn word(data: &[u8], k: usize) -> usize {
        u64::from_le_bytes(data[8 * k..8 * k + 8].try_into().unwrap()) as usize
    }

    #[test]
    fn blocks_decompress_to_what_was_stored() {
        for len in [0, 1, BLOCK - 1, BLOCK, 3 * BLOCK + 17] {
            let array: Vec<u8> = (0..len).map(|k| (k / 100 % 251) as u8).collect();
            let mut data = Vec::new();
            append(&mut data, &array, Compression::Lz4);
            let blocks = word(&data, 0);
            let last = word(&data, 2);
            let mut at = 8 * (3 + blocks);
            let mut found = Vec::new();
            for k in 0..blocks {
                let full = if k + 1 == blocks && last > 0 { last } else { word(&data, 1) };
                let block = &data[at..at + word(&data, 3 + k)];
                found.extend(lz4_flex::block::decompress(block, full).unwrap());
                at += block.len();
            }
            assert!(found == array, "{len}");
            assert_eq!(at, data.len());
            assert!(len < BLOCK || data.len() < len / 10, "{len} became {}", data.len());
        }
    }
}
