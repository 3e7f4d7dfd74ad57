//! Faults of a part's surface.

use crate::{Bounds, EndlessFault, Vec3};
use std::fmt::Display;
use tremie_messages::Problem;

/// No usable surface could be made of a part's geometry.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// The file could not be read.
    #[error("cannot read {path}: {why}")]
    Read {
        /// The file.
        path: String,
        /// The system's reason.
        why: String,
    },
    /// The file is not what its name says.
    #[error("{path} is no {format} file: {why}")]
    Format {
        /// The file.
        path: String,
        /// The expected format.
        format: &'static str,
        /// The text or number found.
        why: String,
    },
    /// The file could not be written.
    #[error("cannot write the surface: {why}")]
    Write {
        /// The reason.
        why: String,
    },
    /// A length that should be finite and greater than zero is not.
    #[error("{what} is {found}, but must be a finite length greater than zero")]
    Length {
        /// The length's name.
        what: &'static str,
        /// Its value [m].
        found: f64,
    },
    /// A profile that cannot be turned about its axis.
    #[error("the profile makes no solid: {why}")]
    Profile {
        /// The reason.
        why: String,
    },
    /// An outline that is no section of a prism.
    #[error("the outline makes no solid: {why}")]
    Outline {
        /// The reason.
        why: String,
    },
    /// A corner has a coordinate that is infinite or no number.
    #[error("triangle {triangle} has a corner at {found:?}, which is no point")]
    NotFinite {
        /// Number of the triangle, from zero.
        triangle: usize,
        /// The corner [m].
        found: Vec3,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {found}, but there are only {vertices}")]
    Index {
        /// Number of the triangle, from zero.
        triangle: usize,
        /// The vertex.
        found: u32,
        /// Number of them.
        vertices: usize,
    },
    /// There are more triangles or vertices than 32-bit numbers can tell apart.
    #[error("the surface has {found} triangles; at most {limit} can be used")]
    TooMany {
        /// Number found.
        found: usize,
        /// Number possible.
        limit: usize,
    },
    /// A corner is so far from all others that it is a damaged number.
    #[error(
        "triangle {triangle} has a corner at ({}, {}, {}) in the file's unit; {others} of its corners lie within {} of each other: that number is damaged",
        exact(found[0]), exact(found[1]), exact(found[2]), six_digits(*within)
    )]
    Stray {
        /// Number of the triangle, from one.
        triangle: usize,
        /// The corner, in the unit of the file.
        found: Vec3,
        /// Number of corners that are near each other.
        others: usize,
        /// Their distance, in the unit of the file.
        within: f64,
    },
    /// A corner is farther away than anything is.
    #[error(
        "triangle {triangle} has a corner at ({}, {}, {}) in the file's unit, which is {away:e} m away: a damaged number, or another unit",
        exact(found[0]), exact(found[1]), exact(found[2])
    )]
    Far {
        /// Number of the triangle, from one.
        triangle: usize,
        /// The corner, in the unit of the file.
        found: Vec3,
        /// Its greatest coordinate [m].
        away: f64,
    },
    /// There is no triangle with an area.
    #[error("the surface has no triangle with an area (of {found} triangles)")]
    Empty {
        /// Triangles before those without area were dropped.
        found: usize,
    },
    /// The triangles do not make a closed surface.
    #[error("{}", sentences(.0))]
    Faults(Vec<Fault>),
    /// The part cannot go on through periodic faces.
    #[error(transparent)]
    Endless(#[from] EndlessFault),
}

/// One way in which triangles fail to make a closed surface with an inside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// Edges with a triangle on one side only: holes.
    Open {
        /// Number of edges.
        edges: usize,
        /// Number of holes that they make.
        holes: usize,
        /// Ends of the first edge [m].
        first: [Vec3; 2],
        /// The box around the first edge's hole [m].
        hole: Bounds,
    },
    /// Corners of triangles that lie on the edges of others: T-junctions.
    Junction {
        /// Number of corners.
        corners: usize,
        /// The first [m].
        first: Vec3,
        /// Ends of the edge on which it lies [m].
        edge: [Vec3; 2],
    },
    /// Edges with more than two triangles.
    Crowded {
        /// Number of edges.
        edges: usize,
        /// Number of triangles that share the first.
        triangles: usize,
        /// Ends of the first edge [m].
        first: [Vec3; 2],
    },
    /// A surface with one side only, such as a Moebius strip or a Klein bottle.
    OneSided {
        /// Ends of an edge across which the sides disagree [m].
        at: [Vec3; 2],
    },
    /// Triangles wind in opposite ways. [`mend`](crate::mend) repairs this.
    Winding {
        /// Number of edges whose neighbours disagree.
        edges: usize,
        /// Ends of the first edge [m].
        first: [Vec3; 2],
    },
    /// A closed surface whose normals point inward. [`mend`](crate::mend) repairs this.
    Inward {
        /// Its number of triangles.
        triangles: usize,
        /// The box around it [m].
        bounds: Bounds,
    },
    /// A closed shell without volume.
    Flat {
        /// Its number of triangles.
        triangles: usize,
        /// The box around it [m].
        bounds: Bounds,
    },
}

impl GeometryError {
    /// The problems of the manifest's key `key` that this error means, one for each fault.
    pub fn problems(&self, key: &str) -> Vec<Problem> {
        match self {
            Self::Faults(faults) => faults
                .iter()
                .map(|fault| Problem::new(key, fault.to_string()).help(fault.help()))
                .collect(),
            Self::Endless(fault) => vec![Problem::new(key, fault.to_string()).help(fault.help())],
            other => vec![Problem::new(key, other.to_string())],
        }
    }
}

fn sentences(faults: &[Fault]) -> String {
    faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

impl Fault {
    /// The remedy.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Open { .. } => {
                "export the part as one closed solid; most mesh editors have a command that fills holes"
            }
            Self::Junction { .. } => {
                "let the mesher give both sides of the seam the same corners (\"remove T-junctions\", \"stitch\"), and export again"
            }
            Self::Crowded { .. } => {
                "unite solids that touch along an edge or face, or remove doubled triangles, and export again"
            }
            Self::OneSided { .. } => "give the surface a thickness, so that it has an inside",
            Self::Winding { .. } | Self::Inward { .. } => {
                "let the surface be mended, which turns triangles round"
            }
            Self::Flat { .. } => "remove the sheet, or give it a thickness",
        }
    }
}

impl Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Open { edges, holes, first, hole } => write!(
                f,
                "the surface is not closed: {} in {}; the first is {}, in a hole within {}",
                counted(*edges, "open edge"),
                counted(*holes, "hole"),
                Edge(first),
                Box(hole)
            ),
            Self::Junction { corners, first, edge } => write!(
                f,
                "the surface is not closed: {} (a corner on the edge of a triangle that does not have it); the first is at {}, on the edge {}",
                counted(*corners, "T-junction"),
                Place(first),
                Edge(edge)
            ),
            Self::Crowded { edges, triangles, first } => write!(
                f,
                "{} shared by more than two triangles; the first is {}, shared by {triangles}",
                if *edges == 1 { "1 edge is".to_string() } else { format!("{edges} edges are") },
                Edge(first)
            ),
            Self::OneSided { at } => {
                write!(
                    f,
                    "the surface has one side only; its sides disagree at the edge {}",
                    Edge(at)
                )
            }
            Self::Winding { edges, first } => write!(
                f,
                "triangles wind in opposite ways across {}; the first is {}",
                counted(*edges, "edge"),
                Edge(first)
            ),
            Self::Inward { triangles, bounds } => write!(
                f,
                "the normals of a surface of {} point inward; it lies within {}",
                counted(*triangles, "triangle"),
                Box(bounds)
            ),
            Self::Flat { triangles, bounds } => write!(
                f,
                "a shell of {} has no volume; it lies within {}",
                counted(*triangles, "triangle"),
                Box(bounds)
            ),
        }
    }
}

fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

struct Edge<'a>(&'a [Vec3; 2]);

impl Display for Edge<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b] = self.0;
        write!(f, "from {} to {}", Place(a), Place(b))
    }
}

struct Box<'a>(&'a Bounds);

impl Display for Box<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} .. {}", Place(&self.0.min), Place(&self.0.max))
    }
}

struct Place<'a>(&'a Vec3);

impl Display for Place<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.0.map(six_digits).into();
        write!(f, "({x}, {y}, {z}) m")
    }
}

/// A number as a file may have it: in single precision, if that is all of it.
fn exact(x: f64) -> String {
    let single = x as f32;
    match (f64::from(single) == x, x != 0.0 && !(1e-4..1e7).contains(&x.abs())) {
        (true, true) => format!("{single:e}"),
        (true, false) => format!("{single}"),
        (false, true) => format!("{x:e}"),
        (false, false) => format!("{x}"),
    }
}

/// As many digits as a person needs to find the place.
pub(crate) fn six_digits(x: f64) -> String {
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if rounded != 0.0 && !(1e-4..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}
