//! NumPy's format of arrays (NEP 1, version 1.0): a line of text before the numbers.

use zip::CompressionMethod;
use zip::write::SimpleFileOptions;

/// Options of an archive's entry of a length [bytes]: not compressed, and with the archive's first day
/// for its time, so that the same content is the same bytes whenever it is written.
pub fn stored(length: usize) -> SimpleFileOptions {
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(zip::DateTime::default())
        .large_file(length as u64 >= u64::from(u32::MAX) / 2)
}

/// NumPy's header of an array in C's order: magic, version, length, and a literal of Python that ends on a
/// multiple of 64 bytes. `name` is the type's, as `<f8`.
pub fn header(name: &str, shape: &[usize]) -> Vec<u8> {
    // A comma after each length: a tuple of one needs it.
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let shape = lengths.trim_end();
    let literal = format!("{{'descr': '{name}', 'fortran_order': False, 'shape': ({shape}), }}");
    let begun = START + literal.len() + 1;
    let padding = begun.next_multiple_of(64) - begun;
    let length = (literal.len() + padding + 1) as u16;
    let mut bytes = MAGIC.to_vec();
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(literal.as_bytes());
    bytes.resize(bytes.len() + padding, b' ');
    bytes.push(b'\n');
    bytes
}

/// Bytes before the literal.
pub const START: usize = 10;

const MAGIC: &[u8; 8] = b"\x93NUMPY\x01\x00";

/// Length of the literal of a header that begins with `start`; `None` if that is no header of version 1.0.
pub fn literal_length(start: &[u8; START]) -> Option<usize> {
    let [.., low, high] = *start;
    (start[..8] == *MAGIC).then_some(usize::from(u16::from_le_bytes([low, high])))
}

/// Type and lengths of the array that a literal describes; `None` if it is none of [`header`]'s.
pub fn parse(literal: &str) -> Option<(String, Vec<usize>)> {
    let rest = literal.strip_prefix("{'descr': '")?;
    let (name, rest) = rest.split_once("', 'fortran_order': False, 'shape': (")?;
    let (lengths, rest) = rest.split_once("), }")?;
    let of = |length: &str| length.trim().parse::<usize>().ok();
    let shape: Option<Vec<usize>> =
        lengths.split(',').filter(|length| !length.trim().is_empty()).map(of).collect();
    rest.trim().is_empty().then(|| Some((name.to_string(), shape?))).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_numpys() {
        let of = |shape: &[usize]| {
            let bytes = header("<f8", shape);
            assert_eq!(bytes.len() % 64, 0);
            let start: &[u8; START] = bytes.first_chunk().unwrap();
            assert_eq!(literal_length(start), Some(bytes.len() - START));
            let literal = String::from_utf8_lossy(&bytes[START..]).into_owned();
            assert_eq!(parse(&literal), Some(("<f8".to_string(), shape.to_vec())));
            literal.trim_end().to_string()
        };
        assert_eq!(of(&[3]), "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }");
        assert!(of(&[2, 16]).ends_with("'shape': (2, 16,), }"));
        assert!(of(&[]).ends_with("'shape': (), }"));
    }

    #[test]
    fn what_is_no_header_is_refused() {
        assert_eq!(literal_length(b"\x93NUMPY\x02\x00ab"), None);
        for literal in
            ["", "{'descr': '<f8', 'fortran_order': True, 'shape': (3,), }", "{'descr': '<f8'"]
        {
            assert_eq!(parse(literal), None, "{literal}");
        }
        assert_eq!(parse("{'descr': '<f8', 'fortran_order': False, 'shape': (3,-1), }"), None);
    }
}
