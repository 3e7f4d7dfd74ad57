//! Surfaces of rigid parts: what fluid, grains, viewer and orchestrator must agree on.
//!
//! [`load`] turns a part's [`Geometry`](tremie_messages::scene::Geometry) into a [`Mesh`]: triangles
//! from an STL or OBJ file or from a box, cylinder or sphere, in metres, welded, closed, with all
//! normals outward. [`Surface`] answers questions about such a mesh, in the part's own frame; a
//! [`Frame`] takes points there and back.
//!
//! What is inside is decided exactly: by winding numbers from the adaptive predicates of Shewchuk,
//! *Discrete Comput. Geom.* 18 (1997) 305. So [`Surface::contains`], [`Surface::fill_row`] and
//! [`Surface::first_crossing`] never disagree, whatever line a question travels along: a lattice
//! link with exactly one end inside always has a crossing.
//!
//! Lengths are in metres, vectors in the part's frame unless it says otherwise. Equal input gives
//! equal bits on every machine with IEEE arithmetic: no function of the system's mathematics
//! library is used, nothing is fused, and every tie is broken by index.

mod bounds;
mod caps;
mod closest;
mod crossing;
mod edges;
mod error;
mod exact;
mod features;
mod frame;
mod inside;
mod intersections;
mod mend;
mod mesh;
mod moments;
mod nesting;
mod orient;
mod read;
mod row;
mod shapes;
mod surface;
mod tree;
mod vector;
mod weld;
mod write;

pub use bounds::Bounds;
pub use closest::{Closest, Feature};
pub use crossing::Crossing;
pub use error::{Fault, GeometryError};
pub use features::{EdgeKind, FLAT_ANGLE, VertexKind};
pub use frame::Frame;
pub use intersections::Intersections;
pub use mend::{Repairs, mend};
pub use mesh::{Loaded, Mesh, load};
pub use moments::Moments;
pub use row::{Row, RowScratch};
pub use shapes::{CYLINDER_SEGMENTS, SPHERE_LEVELS};
pub use surface::Surface;

/// A point or vector, in the frame that its user names.
pub type Vec3 = [f64; 3];
