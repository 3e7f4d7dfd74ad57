//! Arrays for NumPy: files in its format (NEP 1, version 1.0) in an archive (NumPy's `savez`).

use crate::columns::{OF_TABLE, ProfileTable, axes};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;
use tremie_messages::frame::ProfileBin;
use tremie_messages::scene::GrainProfile;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Writes the tables of a profile; under its name the file is whole.
///
/// # Errors
/// If the disk refuses.
pub fn write(path: &Path, profile: &GrainProfile, tables: &[ProfileTable]) -> io::Result<()> {
    let begun = path.with_extension("part");
    let written = File::create(&begun)
        .and_then(|file| fill(ZipWriter::new(BufWriter::new(file)), profile, tables))
        .and_then(|()| std::fs::rename(&begun, path));
    if written.is_err() {
        // Half a file is of no use, and its room may be.
        let _ = std::fs::remove_file(&begun);
    }
    written
}

fn fill(
    mut archive: ZipWriter<BufWriter<File>>,
    profile: &GrainProfile,
    tables: &[ProfileTable],
) -> io::Result<()> {
    let values = |table: &ProfileTable| {
        let [begin, end] = table.times;
        [begin, end, table.samples as f64]
    };
    for (k, (name, _)) in OF_TABLE.into_iter().enumerate() {
        let column = tables.iter().map(|table| values(table)[k]);
        array(&mut archive, name, &[tables.len()], column)?;
    }
    for (name, &along) in axes(profile).zip(&profile.axes) {
        let middles = (0..along.bins).map(|bin| profile.middle(along, bin));
        array(&mut archive, name, &[along.bins], middles)?;
    }
    let counts = profile.axes.iter().map(|along| along.bins);
    let shape: Vec<usize> = std::iter::once(tables.len()).chain(counts).collect();
    for (k, (name, _)) in ProfileBin::COLUMNS.into_iter().enumerate() {
        let column = tables.iter().flat_map(|table| &table.bins).map(|bin| bin.values()[k]);
        array(&mut archive, name, &shape, column)?;
    }
    archive.finish()?.flush()
}

/// Adds an array, in C's order.
fn array(
    archive: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[usize],
    values: impl Iterator<Item = f64>,
) -> io::Result<()> {
    // The time of a file is the archive's first day, not that of the run.
    let bytes = 8 * shape.iter().product::<usize>() as u64;
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(zip::DateTime::default())
        .large_file(bytes >= u64::from(u32::MAX) / 2);
    archive.start_file(format!("{name}.npy"), options)?;
    archive.write_all(&header(shape))?;
    let mut piece = Vec::with_capacity(1 << 16);
    for value in values {
        piece.extend_from_slice(&value.to_le_bytes());
        if piece.len() + 8 > piece.capacity() {
            archive.write_all(&piece)?;
            piece.clear();
        }
    }
    archive.write_all(&piece)
}

/// NumPy's header of an array of little-endian `f64`: magic, version, length, and a literal of
/// Python that ends on a multiple of 64 bytes.
fn header(shape: &[usize]) -> Vec<u8> {
    // A comma after each length: a tuple of one needs it.
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let shape = lengths.trim_end();
    let literal = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({shape}), }}");
    let begun = 10 + literal.len() + 1;
    let padding = begun.next_multiple_of(64) - begun;
    let length = (literal.len() + padding + 1) as u16;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(literal.as_bytes());
    bytes.resize(bytes.len() + padding, b' ');
    bytes.push(b'\n');
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_numpys() {
        let of = |shape: &[usize]| {
            let bytes = header(shape);
            assert_eq!(bytes.len() % 64, 0);
            assert_eq!(usize::from(u16::from_le_bytes([bytes[8], bytes[9]])), bytes.len() - 10);
            String::from_utf8_lossy(&bytes[10..]).trim_end().to_string()
        };
        assert_eq!(of(&[3]), "{'descr': '<f8', 'fortran_order': False, 'shape': (3,), }");
        assert!(of(&[2, 16]).ends_with("'shape': (2, 16,), }"));
    }
}
