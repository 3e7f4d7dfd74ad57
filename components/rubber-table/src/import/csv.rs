//! Tables from CSV files, so that any program's results can become one.
//!
//! A folder with three files, each with these headers, in SI units:
//!
//! ```text
//! frames.csv     compression_m,force_N       a row for each frame, the first 0,0
//! vertices.csv   frame,vertex,r_m,z_m        all vertices of all frames, both counted from 0
//! facets.csv     kind,from,to                edges of the outline, the rubber on their left;
//!                                            kind: seat, exposed, covered or bonded
//! ```
//!
//! Heights z point away from the seat and are seen from the carrier: bonded vertices stand still.

use crate::table::{Contents, Table, TableError};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Why a folder of CSV files is no table.
#[derive(Debug, thiserror::Error)]
pub enum CsvError {
    /// A file cannot be read, or a row is not what it should be.
    #[error("{}: {error}", file.display())]
    Row {
        /// The file.
        file: PathBuf,
        /// The fault, with its line.
        error: csv::Error,
    },
    /// A vertex out of order or missing.
    #[error("{}, line {line}: found vertex {vertex} of frame {frame}, expected {expected}", file.display())]
    Order {
        /// The file.
        file: PathBuf,
        /// The line in it.
        line: usize,
        /// The frame that it names.
        frame: usize,
        /// The vertex that it names.
        vertex: usize,
        /// Text expected there.
        expected: String,
    },
    /// The numbers are no table.
    #[error("{}: {error}", folder.display())]
    Table {
        /// The folder.
        folder: PathBuf,
        /// The fault.
        error: TableError,
    },
}

#[derive(Deserialize)]
struct FrameRow {
    #[serde(rename = "compression_m")]
    compression: f64,
    #[serde(rename = "force_N")]
    force: f64,
}

#[derive(Deserialize)]
struct VertexRow {
    frame: usize,
    vertex: usize,
    #[serde(rename = "r_m")]
    r: f64,
    #[serde(rename = "z_m")]
    z: f64,
}

#[derive(Deserialize)]
struct FacetRow {
    kind: Kind,
    from: usize,
    to: usize,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Seat,
    Exposed,
    Covered,
    Bonded,
}

/// Reads the table in `folder`.
///
/// # Errors
/// If a file cannot be read, or what they say is no table.
pub fn read(folder: &Path) -> Result<Table, CsvError> {
    let mut contents =
        Contents { source: format!("CSV files in {}", folder.display()), ..Contents::default() };
    for FrameRow { compression, force } in rows(&folder.join("frames.csv"))? {
        contents.compressions.push(compression);
        contents.forces.push(force);
    }
    read_vertices(&folder.join("vertices.csv"), &mut contents)?;
    for FacetRow { kind, from, to } in rows(&folder.join("facets.csv"))? {
        let list = match kind {
            Kind::Seat => &mut contents.facets.seat,
            Kind::Exposed => &mut contents.facets.exposed,
            Kind::Covered => &mut contents.facets.covered,
            Kind::Bonded => &mut contents.facets.bonded,
        };
        list.push([from, to]);
    }
    Table::new(contents).map_err(|error| CsvError::Table { folder: folder.into(), error })
}

fn rows<T: DeserializeOwned>(file: &Path) -> Result<Vec<T>, CsvError> {
    let wrong = |error| CsvError::Row { file: file.into(), error };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_path(file)
        .map_err(wrong)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(wrong)
}

/// Frames and vertices may come in any order as long as each frame's vertices count up.
fn read_vertices(file: &Path, contents: &mut Contents) -> Result<(), CsvError> {
    contents.vertices = vec![Vec::new(); contents.compressions.len()];
    for (row, VertexRow { frame, vertex, r, z }) in rows(file)?.into_iter().enumerate() {
        let frames = contents.vertices.len();
        let expected = match contents.vertices.get(frame) {
            None => format!("a frame below {frames}, as many as frames.csv has"),
            Some(so_far) if so_far.len() != vertex => format!("vertex {}", so_far.len()),
            Some(_) => {
                contents.vertices[frame].push([r, z]);
                continue;
            }
        };
        return Err(CsvError::Order { file: file.into(), line: row + 2, frame, vertex, expected });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::example;

    const FRAMES: &str = "compression_m,force_N\n0,0\n0.1,5\n0.3,20\n";
    const FACETS: &str = "kind,from,to\nseat,0,1\nexposed,1,2\nbonded,2,3\nexposed,3,0\n";

    fn vertices() -> String {
        let mut text = String::from("frame,vertex,r_m,z_m\n");
        for (frame, vertices) in example().vertices.iter().enumerate() {
            for (vertex, [r, z]) in vertices.iter().enumerate() {
                text += &format!("{frame}, {vertex}, {r}, {z}\n");
            }
        }
        text
    }

    fn read_texts(frames: &str, vertices: &str, facets: &str) -> Result<Table, CsvError> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [("frames", frames), ("vertices", vertices), ("facets", facets)] {
            std::fs::write(folder.path().join(name).with_extension("csv"), text).unwrap();
        }
        read(folder.path())
    }

    #[test]
    fn three_files_are_a_table() {
        let table = read_texts(FRAMES, &vertices(), FACETS).unwrap();
        let (found, expected) = (table.contents(), example());
        assert_eq!(found.compressions, expected.compressions);
        assert_eq!(found.forces, expected.forces);
        assert_eq!(found.vertices, expected.vertices);
        assert_eq!(found.facets, expected.facets);
    }

    #[test]
    fn what_is_wrong_is_said_with_file_and_line() {
        let error = |frames: &str, vertices: &str, facets: &str| {
            read_texts(frames, vertices, facets).unwrap_err().to_string()
        };
        let all = vertices();
        let text = error(&FRAMES.replace("0.1,5", "0.1,five"), &all, FACETS);
        assert!(text.contains("frames.csv") && text.contains("line: 3"), "{text}");
        let text = error(&FRAMES.replace("force_N", "force"), &all, FACETS);
        assert!(text.contains("force_N"), "{text}");
        let text = error(FRAMES, &all.replace("1, 2, ", "1, 3, "), FACETS);
        assert!(text.contains("line 8") && text.contains("expected vertex 2"), "{text}");
        let text = error(FRAMES, &all.replace("2, 3, ", "7, 3, "), FACETS);
        assert!(text.contains("a frame below 3"), "{text}");
        let text = error(FRAMES, &all, &FACETS.replace("bonded", "glued"));
        assert!(text.contains("facets.csv") && text.contains("glued"), "{text}");
        let text = error(&FRAMES.replace("20", "2"), &all, FACETS);
        assert!(text.contains("must grow"), "{text}");
    }
}
