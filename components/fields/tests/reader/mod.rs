//! Reads VTK's XML files with raw appended data, by VTK's documentation and not by the writer's
//! code. (No crate that reads VTK files reads raw appended data.)

use std::path::Path;

/// A file that was read.
pub struct VtkFile {
    text: String,
    data: Vec<u8>,
}

/// A type of numbers, as VTK calls it.
pub trait Number: Sized {
    const NAME: &'static str;
    fn all(bytes: &[u8]) -> Vec<Self>;
}

macro_rules! number {
    ($($type:ty, $name:literal;)+) => {$(
        impl Number for $type {
            const NAME: &'static str = $name;
            fn all(bytes: &[u8]) -> Vec<Self> {
                let chunks = bytes.chunks_exact(size_of::<Self>());
                assert!(chunks.remainder().is_empty());
                chunks.map(|chunk| Self::from_le_bytes(chunk.try_into().unwrap())).collect()
            }
        }
    )+};
}

number! {
    u8, "UInt8";
    u32, "UInt32";
    u64, "UInt64";
    i64, "Int64";
    f32, "Float32";
    f64, "Float64";
}

impl VtkFile {
    pub fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mark = b"<AppendedData encoding=\"raw\">";
        let at = bytes.windows(mark.len()).position(|window| window == mark).unwrap();
        let begin = at + bytes[at..].iter().position(|byte| *byte == b'_').unwrap() + 1;
        let end = b"\n  </AppendedData>\n</VTKFile>\n";
        assert!(bytes.ends_with(end), "{} is cut short", path.display());
        let text = String::from_utf8(bytes[..at].to_vec()).unwrap();
        assert!(text.contains("byte_order=\"LittleEndian\" header_type=\"UInt64\""), "{text}");
        Self { text, data: bytes[begin..bytes.len() - end.len()].to_vec() }
    }

    /// The tag that begins with this text, up to its end.
    fn tag(&self, begin: &str) -> &str {
        let at = self.text.find(begin).unwrap_or_else(|| panic!("no {begin} in {}", self.text));
        let tag = &self.text[at..];
        &tag[..tag.find('>').unwrap()]
    }

    /// An attribute of the first element of a kind.
    pub fn attribute(&self, element: &str, name: &str) -> &str {
        value(self.tag(&format!("<{element} ")), name)
    }

    /// An attribute that is a list of numbers.
    pub fn numbers(&self, element: &str, name: &str) -> Vec<f64> {
        let words = self.attribute(element, name).split_whitespace();
        words.map(|word| word.parse().unwrap()).collect()
    }

    /// The numbers of an array, which must be of this type, and how many make a tuple.
    pub fn array<T: Number>(&self, name: &str) -> (usize, Vec<T>) {
        let tag = self.tag(&format!("<DataArray type=\"{}\" Name=\"{name}\"", T::NAME));
        assert_eq!(value(tag, "format"), "appended");
        let offset: usize = value(tag, "offset").parse().unwrap();
        let components = value(tag, "NumberOfComponents").parse().unwrap();
        (components, T::all(&self.bytes(offset)))
    }

    fn bytes(&self, at: usize) -> Vec<u8> {
        let word = |k: usize| {
            let bytes = self.data[at + 8 * k..at + 8 * k + 8].try_into().unwrap();
            u64::from_le_bytes(bytes) as usize
        };
        if !self.text.contains("compressor=\"vtkLZ4DataCompressor\"") {
            return self.data[at + 8..at + 8 + word(0)].to_vec();
        }
        let (blocks, full, last) = (word(0), word(1), word(2));
        let mut begin = at + 8 * (3 + blocks);
        let mut bytes = Vec::new();
        for k in 0..blocks {
            let size = if k + 1 == blocks && last > 0 { last } else { full };
            let block = &self.data[begin..begin + word(3 + k)];
            bytes.extend(lz4_flex::block::decompress(block, size).unwrap());
            begin += block.len();
        }
        bytes
    }
}

fn value<'a>(tag: &'a str, name: &str) -> &'a str {
    let mark = format!(" {name}=\"");
    let at = tag.find(&mark).unwrap_or_else(|| panic!("no {name} in {tag}")) + mark.len();
    &tag[at..at + tag[at..].find('"').unwrap()]
}
