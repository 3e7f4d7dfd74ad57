//! Tables as files.

use crate::mesh::Point;
use crate::table::check::TableError;
use crate::table::contents::{Contents, Convergence, Facets, MaterialRecord};
use crate::table::interpolation::Table;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use tremie_state::write_whole;

const FORMAT: &str = "tremie-rubber-table";
const VERSION: u32 = 1;

/// Why a table could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file cannot be read or written.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the system.
        error: std::io::Error,
    },
    /// It is no JSON of this form.
    #[error("{}: {error}", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// The fault, with its line and column.
        error: serde_json::Error,
    },
    /// Another format or version.
    #[error("{}: found format \"{format}\", version {version}; expected \"{FORMAT}\", version {VERSION}: make the table anew with this program", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The format that it names.
        format: String,
        /// The version that it names.
        version: u64,
    },
    /// Its contents are no table.
    #[error("{}: {error}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// The fault.
        error: TableError,
    },
}

/// The keys that name the format, whatever else the file holds.
#[derive(Deserialize)]
struct Head {
    #[serde(default)]
    format: String,
    #[serde(default)]
    version: u64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TableDocument {
    format: String,
    version: u32,
    source: String,
    material: Option<MaterialRecord>,
    #[serde(rename = "compression_m")]
    compressions: Vec<f64>,
    #[serde(rename = "force_N")]
    forces: Vec<f64>,
    facets: Facets,
    #[serde(default)]
    quads: Vec<[usize; 4]>,
    #[serde(rename = "vertices_m")]
    vertices: Vec<Vec<Point>>,
    #[serde(default, rename = "mises_stress_Pa")]
    mises: Vec<Vec<f64>>,
    #[serde(default, rename = "energy_J")]
    energies: Vec<f64>,
    #[serde(default)]
    convergence: Vec<Convergence>,
}

impl Table {
    /// Reads the table at `path`.
    ///
    /// # Errors
    /// If it cannot be read, or is no table.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let here = || path.to_path_buf();
        let text =
            std::fs::read_to_string(path).map_err(|error| FileError::Io { path: here(), error })?;
        let wrong = |error| FileError::Json { path: here(), error };
        let Head { format, version } = serde_json::from_str(&text).map_err(wrong)?;
        if format != FORMAT || version != u64::from(VERSION) {
            return Err(FileError::Format { path: here(), format, version });
        }
        let document: TableDocument = serde_json::from_str(&text).map_err(wrong)?;
        Self::new(document.into()).map_err(|error| FileError::Table { path: here(), error })
    }

    /// Writes the table to `path`: whole, or not at all.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), FileError> {
        write_whole(path, |file| {
            serde_json::to_writer(&mut *file, &TableDocument::from(self.contents()))?;
            file.write_all(b"\n")
        })
        .map_err(|error| FileError::Io { path: path.into(), error })
    }
}

impl From<TableDocument> for Contents {
    fn from(document: TableDocument) -> Self {
        let TableDocument { source, material, compressions, forces, facets, quads, .. } = document;
        let TableDocument { vertices, mises, energies, convergence, .. } = document;
        Self {
            source,
            material,
            compressions,
            forces,
            vertices,
            facets,
            quads,
            mises,
            energies,
            convergence,
        }
    }
}

impl From<&Contents> for TableDocument {
    fn from(contents: &Contents) -> Self {
        let Contents { source, material, compressions, forces, facets, quads, .. } =
            contents.clone();
        let Contents { vertices, mises, energies, convergence, .. } = contents.clone();
        let (format, version) = (FORMAT.to_string(), VERSION);
        Self {
            format,
            version,
            source,
            material,
            compressions,
            forces,
            facets,
            quads,
            vertices,
            mises,
            energies,
            convergence,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::example;

    fn written(table: &Table) -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ring.json");
        table.write(&path).unwrap();
        (folder, path)
    }

    #[test]
    fn what_is_read_is_what_was_written() {
        let mut contents = example();
        contents.forces[1] = 0.1 + 0.2;
        contents.material = Some(MaterialRecord { shear_modulus: 3e5, bulk_modulus: 8e6 });
        contents.convergence = vec![
            Convergence {
                increments: 1,
                passes: 3,
                residual: 1.7e-12,
                least_volume_ratio: 0.93,
                stable: true
            };
            3
        ];
        let table = Table::new(contents).unwrap();
        let (folder, path) = written(&table);
        assert_eq!(Table::read(&path).unwrap(), table);
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "nothing is left beside it"
        );
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said_with_its_name() {
        let (_folder, path) = written(&Table::new(example()).unwrap());
        let text = std::fs::read_to_string(&path).unwrap();
        let error = |from: &str, to: &str| {
            assert!(text.contains(from), "{from}");
            std::fs::write(&path, text.replace(from, to)).unwrap();
            let error = Table::read(&path).unwrap_err().to_string();
            assert!(error.contains("ring.json"), "{error}");
            error
        };
        assert!(error("\"version\":1", "\"version\":2").contains("version 2; expected"));
        assert!(error("tremie-rubber-table", "something").contains("\"something\""));
        assert!(error("\"force_N\"", "\"force_kN\"").contains("force_kN"));
        assert!(error("[0.0,5.0,20.0]", "[0.0,5.0,4.0]").contains("must grow"));
        assert!(error("[0.0,5.0,20.0]", "[0.0,5.0").contains("line 1"));
        assert!(
            Table::read(Path::new("/no/such/ring.json"))
                .unwrap_err()
                .to_string()
                .contains("/no/such")
        );
        let unwritable = Table::new(example()).unwrap().write(Path::new("/no/such/ring.json"));
        assert!(matches!(unwritable, Err(FileError::Io { .. })));
    }
}
