//! Checks of `[[scene.shapes]]`, and of the polyhedra and prisms of a set.

use super::super::document::{BodiesTable, PolyhedronTable, PrismTable, SceneTable, ShapeTable};
use super::super::path;
use super::super::read::Findings;
use super::parts::orientation;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use tremie_geometry::{Convex, ConvexError, Mesh, SOLIDS, solid};
use tremie_messages::scene::{
    Domain, Geometry, Placement, Polyhedra, Polyhedron, PolyhedronPlacement, Pose, Shape,
};
use tremie_messages::units::Length;

/// The shapes that bodies may name: those of the scene, and the well-known ones.
pub(super) struct Shapes {
    known: BTreeMap<String, Convex>,
    /// Names of those that have an outline.
    prisms: Vec<String>,
    /// The axis across a plane scene.
    across: Option<usize>,
    /// Names of shapes that are there, but wrong.
    wrong: Vec<String>,
}

impl Shapes {
    /// Of a scene with this domain.
    pub fn of(table: &SceneTable, domain: Option<&Domain>, findings: &mut Findings) -> Self {
        let plane = domain.and_then(|domain| domain.across.zip(domain.depth()));
        let mut own = Self {
            known: BTreeMap::new(),
            prisms: Vec::new(),
            across: plane.map(|(across, _)| across),
            wrong: Vec::new(),
        };
        for (i, table) in table.shapes.iter().enumerate() {
            let at = path::item("scene.shapes", i);
            let Some(name) = findings.required(&table.name, &at, "name") else { continue };
            if own.known.contains_key(&name) || SOLIDS.contains(&name.as_str()) {
                let message = format!("a second shape with the name \"{name}\"");
                findings.problem(&path::join(&at, "name"), message);
                continue;
            }
            let found = match &table.outline {
                Some(outline) => prism(table, outline, plane, &at, findings),
                None => convex(table, &at, findings),
            };
            let Some(convex) = found else {
                own.wrong.push(name);
                continue;
            };
            if table.outline.is_some() {
                own.prisms.push(name.clone());
            }
            own.known.insert(name, convex);
        }
        for name in SOLIDS {
            let corners = solid(name).unwrap_or_default();
            own.known.extend(Convex::hull(&corners).ok().map(|convex| (name.into(), convex)));
        }
        own
    }

    /// Those that are used by sets that are right, as the scene has them.
    pub fn used<'a>(&self, sets: impl Iterator<Item = &'a Placement>) -> Vec<Shape> {
        let mut names = Vec::new();
        for placement in sets {
            if let Placement::Polyhedra(own) = placement
                && !names.contains(&own.shape)
            {
                names.push(own.shape.clone());
            }
        }
        let shape = |name: String| {
            let corners = self.known.get(&name)?.vertices();
            let vertices = corners.iter().map(|&corner| corner.into()).collect();
            Some(Shape { name, vertices })
        };
        names.into_iter().filter_map(shape).collect()
    }

    /// The shape that a set names.
    fn find(&self, name: &str, at: &str, findings: &mut Findings) -> Option<&Convex> {
        let found = self.known.get(name);
        if found.is_none() && !self.wrong.iter().any(|wrong| wrong == name) {
            let known: Vec<&str> = self.known.keys().map(String::as_str).collect();
            let message = format!("found \"{name}\", expected the name of a shape");
            let help = format!("one of {}, or a [[scene.shapes]] of its own", known.join(", "));
            findings.problem_with_help(&path::join(at, "shape"), message, help);
        }
        found
    }
}

/// A prism across a plane scene, of an axis and a depth [m].
fn prism(
    table: &ShapeTable,
    outline: &[[Length; 2]],
    plane: Option<(usize, f64)>,
    at: &str,
    findings: &mut Findings,
) -> Option<Convex> {
    let key = path::join(at, "outline");
    if table.vertices.is_some() || table.file.is_some() {
        let other = if table.file.is_some() { "a file" } else { "vertices" };
        let message = format!("found both an outline and {other}, expected one of them");
        findings.problem(&key, message);
        return None;
    }
    let Some((across, depth)) = plane else {
        let message = "found the outline of a prism, but this is no plane scene";
        let help = "write scene.domain.across = \"y\" for a plane of x and z, or give vertices";
        findings.problem_with_help(&key, message, help);
        return None;
    };
    let corners: Vec<[f64; 2]> = outline.iter().map(|corner| corner.map(|x| x.0)).collect();
    let message = match Convex::prism(&corners, across, depth) {
        Ok(convex) => return Some(convex),
        Err(ConvexError::TooMany { found, most }) => {
            format!("found {} corners, expected at most {}", found / 2, most / 2)
        }
        Err(ConvexError::Flat { .. }) => format!(
            "its {} corners enclose no area: expected three or more that do not lie in one line",
            outline.len()
        ),
        Err(error) => format!("makes no shape: {error}"),
    };
    findings.problem(&key, message);
    None
}

fn convex(table: &ShapeTable, at: &str, findings: &mut Findings) -> Option<Convex> {
    let (key, found) = match (&table.vertices, &table.file) {
        (Some(vertices), None) => {
            ("vertices", Convex::hull(vertices).map_err(|error| error.to_string()))
        }
        (None, Some(file)) => {
            // The unit does not matter: bodies of the shape have sizes of their own.
            let geometry = Geometry::File { path: file.clone(), unit: 1.0 };
            let mesh = Mesh::of(&geometry).map_err(|error| error.to_string());
            let convex =
                mesh.and_then(|mesh| Convex::of_mesh(&mesh).map_err(|error| error.to_string()));
            ("file", convex)
        }
        (None, None) => {
            let keys = ["vertices", "file", "outline"];
            if !keys.iter().any(|key| findings.is_unreadable(&path::join(at, key))) {
                findings.problem(at, "missing: its corners, as \"vertices\", a \"file\", or in a plane scene an \"outline\"");
            }
            return None;
        }
        (Some(_), Some(_)) => {
            let message = "found both vertices and a file, expected one of them";
            findings.problem(&path::join(at, "file"), message);
            return None;
        }
    };
    match found {
        Ok(convex) => Some(convex),
        Err(message) => {
            findings.problem(&path::join(at, key), format!("makes no shape: {message}"));
            None
        }
    }
}

/// The listed polyhedra of a set.
pub(super) fn listed(
    table: &BodiesTable,
    list: &[PolyhedronTable],
    shapes: &Shapes,
    at: &str,
    findings: &mut Findings,
) -> Option<Placement> {
    let name = findings.required(&table.shape, at, "shape")?;
    let convex = shapes.find(&name, at, findings)?;
    let at = path::join(at, "polyhedra");
    let of = |(i, table)| polyhedron(table, convex, &path::item(&at, i), findings);
    listed_as(name, list.iter().enumerate().map(of))
}

/// Listed bodies of a shape, if all are right: each is looked at, so that each problem is told.
fn listed_as(shape: String, bodies: impl Iterator<Item = Option<Polyhedron>>) -> Option<Placement> {
    let all: Vec<Option<Polyhedron>> = bodies.collect();
    let listed = all.into_iter().collect::<Option<_>>()?;
    Some(of_shape(shape, PolyhedronPlacement::Listed(listed)))
}

/// The prisms of a set.
pub(super) fn prisms(
    table: &BodiesTable,
    list: &[PrismTable],
    shapes: &Shapes,
    at: &str,
    findings: &mut Findings,
) -> Option<Placement> {
    let name = findings.required(&table.shape, at, "shape")?;
    let convex = shapes.find(&name, at, findings)?;
    if !shapes.prisms.contains(&name) {
        let message = format!("found \"{name}\", which has no outline, but the bodies are prisms");
        let help = "give the shape an outline = [[\"-2 cm\", \"-1 cm\"], ...] in place of vertices";
        findings.problem_with_help(&path::join(at, "shape"), message, help);
        return None;
    }
    // As large as it is drawn, in terms of the sphere of equal volume.
    let diameter = libm::cbrt(6.0 / PI * convex.moments().volume);
    let across = shapes.across?;
    let at = path::join(at, "prisms");
    let prism = |(i, table): (usize, &PrismTable)| {
        let position = findings.required(&table.position, &path::item(&at, i), "position")?;
        let (sine, cosine) = libm::sincos(0.5 * table.turn?.0);
        let mut orientation = [0.0, 0.0, 0.0, cosine];
        orientation[across] = sine;
        Some(Polyhedron {
            position: position.map(|x| x.0),
            orientation,
            diameter,
            velocity: table.velocity?.map(|v| v.0),
            angular_velocity: table.angular_velocity?.map(|w| w.0),
        })
    };
    listed_as(name, list.iter().enumerate().map(prism))
}

/// A packing of polyhedra.
pub(super) fn packed(
    name: &str,
    packing: tremie_messages::scene::Packing,
    shapes: &Shapes,
    at: &str,
    findings: &mut Findings,
) -> Option<Placement> {
    shapes.find(name, at, findings)?;
    Some(of_shape(name.into(), PolyhedronPlacement::Packed(packing)))
}

fn of_shape(shape: String, placement: PolyhedronPlacement) -> Placement {
    Placement::Polyhedra(Polyhedra { shape, placement })
}

fn polyhedron(
    table: &PolyhedronTable,
    convex: &Convex,
    at: &str,
    findings: &mut Findings,
) -> Option<Polyhedron> {
    let position = findings.required(&table.position, at, "position");
    let diameter = match (table.edge, table.diameter) {
        (Some(_), None) => findings.positive(&table.edge, at, "edge").map(|edge| {
            // Diameter of the sphere of equal volume. By `libm`, with the same bits on every
            // machine.
            let volume = convex.moments().volume;
            edge / convex.longest_edge() * libm::cbrt(6.0 / PI * volume)
        }),
        (None, Some(_)) => findings.positive(&table.diameter, at, "diameter"),
        (Some(_), Some(_)) => {
            let message = "found both an edge and a diameter, expected one of them";
            findings.problem(&path::join(at, "diameter"), message);
            None
        }
        (None, None) => {
            let keys = ["edge", "diameter"];
            if !keys.iter().any(|key| findings.is_unreadable(&path::join(at, key))) {
                findings.problem(at, "missing: its size, as \"edge\" or as \"diameter\"");
            }
            None
        }
    };
    let orientation = match &table.rotation {
        Some(rotation) => orientation(rotation, &path::join(at, "rotation"), findings),
        None => Some(Pose::IDENTITY.orientation),
    };
    Some(Polyhedron {
        position: position?.map(|x| x.0),
        orientation: orientation?,
        diameter: diameter?,
        velocity: table.velocity?.map(|v| v.0),
        angular_velocity: table.angular_velocity?.map(|w| w.0),
    })
}
