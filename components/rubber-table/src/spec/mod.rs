//! The specification of a table: a TOML file that says what the seal is and how far it is pressed.
//!
//! ```toml
//! [section.rectangle]              # or o_ring, d_ring, mesh
//! inner_radius = "6.5 mm"
//! outer_radius = "11 mm"
//! height = "3 mm"
//! elements = [18, 12]              # along the radius, along the height
//!
//! [rubber]
//! shear_modulus = "0.3 MPa"
//! bulk_modulus = "8 MPa"
//!
//! [carrier]                        # steel that comes down; without this, "top" is bonded
//! bonded = ["top"]
//! guided = ["inner"]               # none by default: lies against the steel, upright, and slides along it
//!
//! [seat]                           # without this, flat
//! meridian = [["6 mm", "0 mm"], ["9 mm", "0 mm"], ["12 mm", "0.3 mm"]]
//! rounding = "0.1 mm"
//!
//! [table]
//! compression = "0.6 mm"
//! frames = 41
//! foot_at = "0.6 mm"               # what touches the seat in the nearest frame is the foot; without this, in the last
//! ```
//!
//! The other sections:
//!
//! ```toml
//! [section.o_ring]                 # boundaries lower, upper, inner, outer: quarters of the rim
//! diameter = "50 mm"               # of the circle through the middle of the section
//! thickness = "5 mm"
//! elements = 16                    # along each quarter of the rim
//!
//! [section.d_ring]                 # boundaries top (flat), round
//! diameter = "50 mm"
//! width = "5 mm"
//! elements = 16                    # along a quarter of the rim
//!
//! [section.mesh]                   # boundaries as its physical groups of lines are named
//! file = "seal.msh"                # Gmsh, MSH 2.2 as text: see import::gmsh
//! unit = "1 mm"
//! ```
//!
//! The seat may lie at any height: it is raised or lowered until it touches, and the compression
//! counts from there.
//!
//! Pressed further, a rim may leave the seat again. A table that ends there would have a narrower foot at every
//! compression: `foot_at` keeps the foot of a smaller one.

mod document;
mod problems;

pub use document::FEWEST_FRAMES;
pub use problems::{Located, SpecErrors};

use crate::fem::contact::Seat;
use crate::fem::element::Symmetry;
use crate::fem::material::NeoHookean;
use crate::fem::{Compression, Hold, Model};
use crate::import::gmsh;
use crate::mesh::{self, Mesh};
use document::{Section, SpecDocument};
use problems::Text;
use std::path::Path;
use tremie_messages::Problem;

/// Forces out of balance, over their size, at which an increment is done.
const TOLERANCE: f64 = 1e-9;

/// A specification that was read and found right.
#[derive(Clone, Debug)]
pub struct Spec {
    text: Text,
    /// The model to compress.
    pub model: Model,
    /// Its material.
    pub material: NeoHookean,
    /// Length and steps of a compression.
    pub compression: Compression,
    /// Compression at which what touches the seat is the foot [m].
    pub foot_at: f64,
}

impl Spec {
    /// Reads the specification at `path`. Files that it names are looked for beside it.
    ///
    /// # Errors
    /// The reason why it cannot be read, or all values that make no sense; each with its line.
    pub fn read(path: &Path) -> Result<Self, SpecErrors> {
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(path, text),
            Err(error) => Err(SpecErrors::unreadable(path, &error)),
        }
    }

    /// Reads a specification from `text`; `path` is what messages call it, and files that it names
    /// are looked for beside that.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(path: &Path, text: String) -> Result<Self, SpecErrors> {
        let text = Text::new(path, text);
        let document = text.read()?;
        let problems = document.problems();
        if !problems.is_empty() {
            return Err(text.errors(problems));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let material = NeoHookean {
            shear_modulus: document.rubber.shear_modulus.0,
            bulk_modulus: document.rubber.bulk_modulus.0,
        };
        let compression = Compression {
            largest: document.table.compression.0,
            frames: document.table.frames,
            tolerance: TOLERANCE,
        };
        let foot_at = document.table.foot_at.map_or(compression.largest, |length| length.0);
        match model(&document, folder, material) {
            Ok(model) => Ok(Self { text, model, material, compression, foot_at }),
            Err(problem) => Err(text.errors(vec![problem])),
        }
    }

    /// The text as read, to keep with what is made of it.
    pub fn text(&self) -> &str {
        self.text.text()
    }

    /// The file, as messages call it.
    pub fn file(&self) -> &str {
        self.text.file()
    }
}

fn model(document: &SpecDocument, folder: &Path, material: NeoHookean) -> Result<Model, Problem> {
    let mesh = mesh_of(&document.section, folder)?;
    let [low, high] = mesh.bounds();
    let (height, compression) = (high[1] - low[1], document.table.compression.0);
    if compression >= height {
        let found = format!(
            "found {} mm, expected less than the section's height, {} mm",
            1e3 * compression,
            1e3 * height
        );
        return Err(Problem::new("table.compression", found));
    }
    check_size(mesh.quads().len(), document.table.frames)?;
    let seat = seat_of(document)?;
    let carrier = document.carrier();
    let bonded = carrier.bonded.iter().map(|name| Hold::bonded(name));
    let sliding = carrier.sliding.iter().map(|name| Hold::sliding(name));
    let guided = carrier.guided.iter().map(|name| Hold::guided(name));
    let holds: Vec<Hold> = bonded.chain(sliding).chain(guided).collect();
    Model::new(mesh, Symmetry::Axisymmetric, material, &holds, Some(seat), document.seat.stiffness)
        .map_err(|error| Problem::new("carrier", error.to_string()))
}

/// Beyond these sizes memory runs out before anything is gained.
fn check_size(quads: usize, frames: usize) -> Result<(), Problem> {
    const MOST_QUADS: usize = 40_000;
    const MOST_VALUES: usize = 10_000_000;
    if quads > MOST_QUADS {
        let found = format!("found {quads} quadrilaterals, expected at most {MOST_QUADS}");
        return Err(
            Problem::new("section", found).help("a few thousand are within 0.1 % for most seals")
        );
    }
    if quads * frames > MOST_VALUES {
        let found = format!(
            "found {frames} frames of {quads} quadrilaterals, expected at most {}",
            MOST_VALUES / quads
        );
        return Err(Problem::new("table.frames", found).help("or mesh the section less finely"));
    }
    Ok(())
}

fn mesh_of(section: &Section, folder: &Path) -> Result<Mesh, Problem> {
    let wrong = |key: &str, error: String| Problem::new(format!("section.{key}"), error);
    match section {
        Section::Rectangle(r) => {
            let (inner, outer) = (r.inner_radius.0, r.outer_radius.0);
            mesh::rectangle(inner, outer, r.height.0, r.elements)
                .map_err(|e| wrong("rectangle", e.to_string()))
        }
        Section::ORing(o) => mesh::o_ring(0.5 * o.diameter.0, o.thickness.0, o.elements)
            .map_err(|e| wrong("o_ring", e.to_string())),
        Section::DRing(d) => mesh::d_ring(0.5 * d.diameter.0, d.width.0, d.elements)
            .map_err(|e| wrong("d_ring", e.to_string())),
        Section::Mesh(m) => {
            let file = folder.join(&m.file);
            let named = |error: &dyn std::fmt::Display| {
                wrong("mesh.file", format!("{}: {error}", file.display()))
            };
            let text = std::fs::read_to_string(&file).map_err(|e| named(&e))?;
            gmsh::read(&text, m.unit.0).map_err(|e| named(&e))
        }
    }
}

fn seat_of(document: &SpecDocument) -> Result<Seat, Problem> {
    let Some(meridian) = &document.seat.meridian else { return Ok(Seat::flat(0.0)) };
    let points = meridian.iter().map(|[r, z]| [r.0, z.0]).collect();
    Seat::along(points, document.seat.rounding.map_or(0.0, |length| length.0))
        .map_err(|error| Problem::new("seat.meridian", error.to_string()))
}
