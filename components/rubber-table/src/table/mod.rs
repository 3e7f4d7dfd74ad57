//! The table: force and shape of a seal over its compression.
//!
//! # The file
//!
//! One JSON object, in SI units:
//!
//! | key | meaning |
//! | --- | --- |
//! | `format` | `"tremie-rubber-table"` |
//! | `version` | 1 |
//! | `source` | where the numbers come from, in words |
//! | `material` | `shear_modulus_Pa` and `bulk_modulus_Pa` of a neo-Hookean solid, or null |
//! | `compression_m` | compression of each frame; the first is 0, then growing |
//! | `force_N` | force of the seat on the whole ring in each frame, upwards; the first is 0, then growing |
//! | `vertices_m` | for each frame, radius and height [r, z] of each vertex, seen from the carrier: what is bonded to it stands still |
//! | `facets` | edges [a, b] of the section's outline, the rubber on their left, a and b numbers of vertices from 0: `seat` touches the seat in the last frame, or in an earlier one that its maker chose (surface A, the foot), `exposed` stays free (surface B), `covered` lies against steel along which it slides (may be left out), `bonded` is held by steel |
//! | `quads` | quadrilaterals of the section, four vertices each, counter-clockwise; may be empty |
//! | `mises_stress_Pa` | for each frame, of each quadrilateral; may be empty |
//! | `energy_J` | stored energy in each frame; may be empty |
//! | `convergence` | how each frame was found; may be empty |
//!
//! Heights point away from the seat, so that the seal's free end has the smallest. Numbers are
//! written with all their digits: what is read equals what was written, bit for bit.
//!
//! # Between frames
//!
//! Force and vertices are both linear in the compression between two frames, with the same weight:
//! so shape and force always belong together. Below 0 the seal is at rest and pushes nothing;
//! beyond the last frame nothing is known, and asking is an error.

mod check;
mod contents;
mod file;
mod interpolation;
mod strain;
mod surface;

pub use check::TableError;
#[cfg(test)]
pub(crate) use contents::tests::example;
pub use contents::{Contents, Convergence, Facets, MaterialRecord};
pub use file::FileError;
pub use interpolation::{BeyondTable, Bracket, Table};
pub use surface::{Outline, Surface};
pub use tremie_messages::scene::FacetKind;
