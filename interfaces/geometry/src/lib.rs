//! Surfaces of rigid parts: what fluid, grains, viewer and orchestrator must agree on.
//!
//! [`load`] turns a part's [`Geometry`](tremie_messages::scene::Geometry) into a [`Mesh`]:
//! triangles from an STL or OBJ file, a box, cylinder or sphere, a profile turned about an axis, or an
//! outline drawn out along one, in metres, welded, closed, with all normals outward. [`Surface`] answers questions about such a
//! mesh, in the part's own frame; a [`Frame`] takes points there and back.
//!
//! The inside is decided exactly: by winding numbers from the adaptive predicates of Shewchuk,
//! *Discrete Comput. Geom.* 18 (1997) 305. So [`Surface::contains`], [`Surface::fill_row`] and
//! [`Surface::first_crossing`] never disagree, whatever line a question travels along: a lattice
//! link with exactly one end inside always has a crossing.
//!
//! ```
//! use tremie_geometry::{Frame, Row, RowScratch, Surface};
//! use tremie_messages::scene::{Geometry, Pose};
//!
//! let surface = Surface::of(&Geometry::Box { size: [2e-3, 1e-3, 1e-3] })?;
//! let frame = Frame::of(&Pose { position: [5e-3, 0.0, 0.0], ..Pose::IDENTITY });
//! // A lattice link of the world, from a fluid cell to one in the solid.
//! let (from, to) = (frame.to_part([3.75e-3, 0.0, 0.0]), frame.to_part([4.25e-3, 0.0, 0.0]));
//! assert!(!surface.contains(from) && surface.contains(to));
//! let crossing = surface.first_crossing(from, to).expect("exactly one end is inside");
//! assert!((crossing.fraction - 0.5).abs() < 1e-12);
//! // All cells of a row at once.
//! let row = Row { start: frame.to_part([3.75e-3, 0.0, 0.0]), step: frame.turn_to_part([5e-4, 0.0, 0.0]) };
//! let mut solid = [false; 6];
//! surface.fill_row(&row, &mut solid, &mut RowScratch::default());
//! assert_eq!(solid, [false, true, true, true, true, false]);
//! # Ok::<(), tremie_geometry::GeometryError>(())
//! ```
//!
//! [`Convex`] is the shape of a grain: a convex polyhedron from its corners, with faces, moments
//! and [`principal`] axes. [`shares`] says what convex pieces that overlap are together.
//!
//! Lengths are in metres, vectors in the part's frame unless it says otherwise. Equal input gives
//! equal bits on every machine with IEEE arithmetic: no function of the system's mathematics
//! library is used, nothing is fused, and every tie is broken by index.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod bounds;
mod caps;
mod closest;
mod clump;
mod convex;
mod crossing;
mod edges;
mod endless;
mod error;
mod exact;
mod extrude;
mod features;
mod frame;
mod inside;
mod intersections;
mod junctions;
mod mend;
mod mesh;
mod moments;
mod nesting;
mod orient;
mod read;
mod revolve;
mod row;
mod shapes;
mod solids;
mod stray;
mod surface;
mod tree;
mod turned;
mod union;
mod vector;
mod weld;
mod write;

pub use bounds::Bounds;
pub use closest::{Closest, Feature};
pub use clump::{ClumpPiece, clump};
pub use convex::{Convex, ConvexError, ConvexFace, principal};
pub use crossing::Crossing;
pub use endless::{Endless, EndlessFault, motion_problem};
pub use error::{Fault, GeometryError};
pub use features::{EdgeKind, FLAT_ANGLE, VertexKind};
pub use frame::Frame;
pub use intersections::Intersections;
pub use mend::{Repairs, mend};
pub use mesh::{Loaded, Mesh, load};
pub use moments::Moments;
pub use read::triangulate;
pub use row::{Row, RowScratch};
pub use shapes::{CYLINDER_SEGMENTS, SPHERE_LEVELS};
pub use solids::{SOLIDS, solid};
pub use surface::Surface;
pub use turned::Turned;
pub use union::{Piece, Share, TOLERANCE as UNION_TOLERANCE, shares};

/// A point or vector, in the frame that its user names.
pub type Vec3 = nalgebra::Vector3<f64>;
