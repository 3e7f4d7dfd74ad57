//! Arrays for NumPy: files in its format in an archive (NumPy's `savez`).

use crate::columns::{OF_TABLE, ProfileTable, axes};
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;
use tremie_messages::frame::ProfileBin;
use tremie_messages::scene::GrainProfile;
use tremie_state::{numpy, write_whole};
use zip::ZipWriter;

/// Writes the tables of a profile; under its name the file is whole.
///
/// # Errors
/// If the disk refuses.
pub fn write(path: &Path, profile: &GrainProfile, tables: &[ProfileTable]) -> io::Result<()> {
    write_whole(path, |file| fill(ZipWriter::new(file), profile, tables))
}

fn fill(
    mut archive: ZipWriter<&mut BufWriter<File>>,
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
    archive.finish()?;
    Ok(())
}

/// Adds an array, in C's order.
fn array(
    archive: &mut ZipWriter<impl Write + Seek>,
    name: &str,
    shape: &[usize],
    values: impl Iterator<Item = f64>,
) -> io::Result<()> {
    let bytes = 8 * shape.iter().product::<usize>();
    archive.start_file(format!("{name}.npy"), numpy::stored(bytes))?;
    archive.write_all(&numpy::header("<f8", shape))?;
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
