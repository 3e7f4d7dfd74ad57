//! Writes whole fields, bodies, parts and rubber of a run as VTK files, for ParaView and everything
//! else that is built on VTK.
//!
//! [`Fields`] is an observer; `outputs.fields = "10 ms"` in a manifest starts it. It fills
//! `OUT/fields`:
//!
//! | file | data set | what it holds |
//! | --- | --- | --- |
//! | `<volume>_<window>.vti` | ImageData | nodes of a component's lattice |
//! | `bodies_<window>.vtp` | PolyData | one point for each sphere |
//! | `polyhedra_<window>.vtp` | PolyData | triangles of the polyhedra, if there are any |
//! | `parts_<window>.vtp` | PolyData | triangles of the scene's parts, where they are |
//! | `rubber_<window>.vtp` | PolyData | triangles of the deformable surfaces, if there are any |
//! | `<volume>.pvd`, `bodies.pvd`, `polyhedra.pvd`, `parts.pvd`, `rubber.pvd` | collection | the files of a series by time: open these |
//! | `about.txt` | text | arrays, units, names of sets, shapes and parts |
//!
//! The volume of the lattice-Boltzmann fluid is called `lattice`. `<window>` is the coupling window
//! at whose end the data hold. Each file bears its time too (field data `TimeValue` [s], and
//! `window`).
//!
//! # Arrays
//!
//! World frame, SI units; each array of a quantity bears its unit as VTK's `UNITS_LABEL`.
//!
//! | data set | array | type | unit | meaning |
//! | --- | --- | --- | --- | --- |
//! | lattice | `velocity` | 3 Float32 | m/s | fluid velocity; zero in solids |
//! | | `pressure` | Float32 | Pa | gauge pressure without its hydrostatic part; zero in solids |
//! | | `fill` | Float32 | | share that the fluid fills: at a free surface a half, in a solid 0 |
//! | | `solid` | UInt8 | | 1 in a solid, else 0 |
//! | bodies | points | 3 Float64 | m | centres |
//! | | `id` | UInt64 | | id of the body |
//! | | `set` | UInt32 | | index of its set in the scene |
//! | | `motion` | UInt32 | | 0 free, 1 fixed, 2 prescribed, 3 slider |
//! | | `radius` | Float64 | m | |
//! | | `mass` | Float64 | kg | |
//! | | `velocity` | 3 Float64 | m/s | |
//! | | `angular_velocity` | 3 Float64 | rad/s | |
//! | | `orientation` | 4 Float64 | | unit quaternion (x, y, z, w) from body to world |
//! | polyhedra | `velocity` (points) | 3 Float64 | m/s | |
//! | | `id` (cells) | UInt64 | | id of the body |
//! | | `set`, `shape` (cells) | UInt32 | | indices of its set and its shape in the scene |
//! | parts | `velocity` (points) | 3 Float64 | m/s | |
//! | | `part` (cells) | UInt32 | | index of the part in the scene |
//! | rubber | `velocity` (points) | 3 Float64 | m/s | |
//! | | `strain` (points) | Float64 | | equivalent shear strain ([`tremie_messages::frame::SurfaceSample::strain`]) |
//! | | `surface` (cells) | UInt32 | | index of the surface in the scene |
//! | | `kind` (cells) | UInt8 | | 0 touches the seat, 2 is bonded, 1 is neither |
//!
//! In ParaView, bodies become spheres by `Glyph` with scale array `radius` and factor 2.
//!
//! # Ends
//!
//! A file appears under its name when it is whole, and in its series after that: what a killed run
//! leaves can be opened. The end of a run removes what lies beyond its last common window. No file
//! depends on the wall clock or the run's id: identical runs give identical bytes.
//!
//! # Checkpoints
//!
//! The state lists the moments of each series. A run that goes on from it needs their files, removes
//! later ones, and writes the collections anew: it ends with the files of a run without interruption.
//!
//! # Size
//!
//! 17 bytes a node and 144 a body, less what compression saves (LZ4, which VTK reads since version
//! 8); `tremie check` says how much a run will write before compression.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod about;
mod document;
mod encode;
mod parameters;
mod parts;
mod resumption;
mod rubber;
mod series;
mod solids;
mod tables;
mod writer;

pub use parameters::{Compression, Parameters, Region};
pub use writer::{Fields, run};
