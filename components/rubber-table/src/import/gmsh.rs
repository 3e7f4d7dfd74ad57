//! Meshes from Gmsh: the text format MSH 2.2, which also meshio and most other programs write.
//!
//! Read are quadrilaterals of four nodes (type 3); lines of two nodes (type 1) name the outline by
//! the physical group that they belong to. x is the radius and y the height along the axis.
//! Gmsh writes such a file with `gmsh -2 -format msh22 FILE.geo`.

use crate::mesh::{Mesh, MeshError, Point};
use std::collections::BTreeMap;

/// Why a text is no mesh in MSH 2.2.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GmshError {
    /// Another version, or binary.
    #[error(
        "line {line}: found format \"{found}\", expected MSH 2.2 as text (\"2.2 0 8\"); write the file with: gmsh -2 -format msh22"
    )]
    Format {
        /// Line in the file.
        line: usize,
        /// Text or number found there.
        found: String,
    },
    /// A line that does not read as what it should be.
    #[error("line {line}: found \"{found}\", expected {expected}")]
    Line {
        /// Line in the file.
        line: usize,
        /// Text or number found there.
        found: String,
        /// Text expected there.
        expected: &'static str,
    },
    /// The file ends early, or a part of it is missing.
    #[error("the file ends without {0}")]
    Missing(&'static str),
    /// Elements that cannot be used.
    #[error(
        "line {line}: element {id} is {what}; the section must be of quadrilaterals with 4 nodes: set Mesh.RecombineAll = 1 and Mesh.ElementOrder = 1 in Gmsh"
    )]
    Element {
        /// Line in the file.
        line: usize,
        /// Its number in the file.
        id: usize,
        /// Its kind.
        what: String,
    },
    /// A node out of the plane.
    #[error(
        "line {line}: node {id} lies at z = {z}; the section must lie in the plane z = 0, with x the radius and y the height"
    )]
    OutOfPlane {
        /// Line in the file.
        line: usize,
        /// Its number in the file.
        id: usize,
        /// Its third coordinate, in the file's unit.
        z: f64,
    },
    /// An element names a node that the file does not hold.
    #[error("line {line}: there is no node {node}")]
    NoSuchNode {
        /// Line in the file.
        line: usize,
        /// Its number in the file.
        node: usize,
    },
    /// No section comes of it.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

/// Reads `text`; one unit of length in it is `unit` metres.
///
/// # Errors
/// If that is no section in MSH 2.2.
pub fn read(text: &str, unit: f64) -> Result<Mesh, GmshError> {
    let mut lines = Lines { lines: text.lines().enumerate() };
    let mut file = GmshFile::default();
    lines.until("$MeshFormat", "$MeshFormat")?;
    let (line, found) = lines.next("the format")?;
    if !(found.starts_with("2.2 0 ") || found.starts_with("2 0 ")) {
        return Err(GmshError::Format { line, found: found.to_string() });
    }
    while let Some((_, line)) = lines.lines.next() {
        match line.trim() {
            "$PhysicalNames" => file.read_names(&mut lines)?,
            "$Nodes" => file.read_nodes(&mut lines, unit)?,
            "$Elements" => file.read_elements(&mut lines)?,
            _ => {}
        }
    }
    file.mesh()
}

struct Lines<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
}

impl<'a> Lines<'a> {
    /// The next line and its number, from 1.
    fn next(&mut self, what: &'static str) -> Result<(usize, &'a str), GmshError> {
        let (line, text) = self.lines.next().ok_or(GmshError::Missing(what))?;
        Ok((line + 1, text.trim()))
    }

    fn until(&mut self, word: &str, what: &'static str) -> Result<(), GmshError> {
        while self.next(what)?.1 != word {}
        Ok(())
    }

    fn count(&mut self, what: &'static str) -> Result<usize, GmshError> {
        let (line, text) = self.next(what)?;
        text.parse().map_err(|_| GmshError::Line { line, found: text.into(), expected: what })
    }
}

#[derive(Default)]
struct GmshFile {
    names: BTreeMap<usize, String>,
    nodes: BTreeMap<usize, usize>,
    points: Vec<Point>,
    quads: Vec<[usize; 4]>,
    edges: BTreeMap<usize, Vec<[usize; 2]>>,
}

impl GmshFile {
    fn read_names(&mut self, lines: &mut Lines<'_>) -> Result<(), GmshError> {
        for _ in 0..lines.count("a number of names")? {
            let (line, text) = lines.next("a name")?;
            let expected = "dimension, number and \"name\" of a physical group";
            let wrong = || GmshError::Line { line, found: text.into(), expected };
            let mut words = text.splitn(3, char::is_whitespace);
            let mut number = || words.next().and_then(|word| word.parse::<usize>().ok());
            let (dimension, tag) = (number().ok_or_else(wrong)?, number().ok_or_else(wrong)?);
            let name = words.next().ok_or_else(wrong)?.trim().trim_matches('"');
            if dimension == 1 {
                self.names.insert(tag, name.to_string());
            }
        }
        Ok(())
    }

    fn read_nodes(&mut self, lines: &mut Lines<'_>, unit: f64) -> Result<(), GmshError> {
        for _ in 0..lines.count("a number of nodes")? {
            let (line, text) = lines.next("a node")?;
            let wrong = || GmshError::Line {
                line,
                found: text.into(),
                expected: "number, x, y and z of a node",
            };
            let words: Vec<&str> = text.split_whitespace().collect();
            let [id, x, y, z] = words[..] else { return Err(wrong()) };
            let id = id.parse().map_err(|_| wrong())?;
            let coordinate = |word: &str| word.parse::<f64>().map_err(|_| wrong());
            let (x, y, z) = (coordinate(x)?, coordinate(y)?, coordinate(z)?);
            if z.abs() > 1e-6 * (x.abs() + y.abs()) {
                return Err(GmshError::OutOfPlane { line, id, z });
            }
            self.nodes.insert(id, self.points.len());
            self.points.push([unit * x, unit * y]);
        }
        Ok(())
    }

    fn read_elements(&mut self, lines: &mut Lines<'_>) -> Result<(), GmshError> {
        for _ in 0..lines.count("a number of elements")? {
            let (line, text) = lines.next("an element")?;
            let wrong = || GmshError::Line {
                line,
                found: text.into(),
                expected: "number, type, tags and nodes of an element",
            };
            let numbers: Option<Vec<usize>> =
                text.split_whitespace().map(|word| word.parse().ok()).collect();
            let numbers =
                numbers.filter(|n| n.len() >= 3 && n.len() >= 3 + n[2]).ok_or_else(wrong)?;
            let (id, kind, tags) = (numbers[0], numbers[1], &numbers[3..3 + numbers[2]]);
            let ends = &numbers[3 + numbers[2]..];
            let nodes: Result<Vec<usize>, GmshError> = ends
                .iter()
                .map(|node| {
                    self.nodes.get(node).copied().ok_or(GmshError::NoSuchNode { line, node: *node })
                })
                .collect();
            match (kind, &nodes?[..]) {
                (1, &[a, b]) => {
                    self.edges.entry(tags.first().copied().unwrap_or(0)).or_default().push([a, b])
                }
                (3, &[a, b, c, d]) => self.quads.push([a, b, c, d]),
                (15, _) => {}
                (1 | 3, _) => return Err(wrong()),
                (kind, _) => return Err(GmshError::Element { line, id, what: describe(kind) }),
            }
        }
        Ok(())
    }

    fn mesh(self) -> Result<Mesh, GmshError> {
        if self.points.is_empty() {
            return Err(GmshError::Missing("$Nodes"));
        }
        let named = |(tag, edges)| Some((self.names.get(&tag)?.clone(), edges));
        let boundaries = self.edges.into_iter().filter_map(named).collect();
        Ok(Mesh::new(self.points, self.quads, boundaries)?)
    }
}

fn describe(kind: usize) -> String {
    match kind {
        2 => "a triangle".into(),
        8 => "a line of 3 nodes".into(),
        9 => "a triangle of 6 nodes".into(),
        10 | 16 => "a quadrilateral of 8 or 9 nodes".into(),
        kind => format!("of type {kind}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO_QUADS: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 5 \"glued face\"\n1 6 \"foot\"\n2 7 \"rubber\"\n$EndPhysicalNames
$Nodes\n7\n1 6 0 0\n2 8 0 0\n3 10 0 0\n11 6 3 0\n12 8 3 0\n13 10 3 0\n99 0 0 0\n$EndNodes
$Elements\n7\n1 15 2 0 1 1\n2 1 2 5 3 12 11\n3 1 2 5 3 13 12\n4 1 2 6 1 1 2\n5 1 2 6 1 2 3\n6 3 2 7 1 1 2 12 11\n7 3 2 7 1 12 13 3 2\n$EndElements\n";

    #[test]
    fn a_file_of_gmsh_is_read() {
        let mesh = read(TWO_QUADS, 1e-3).unwrap();
        assert_eq!(mesh.quads().len(), 2);
        assert_eq!(mesh.nodes().len(), 6, "the centre of an arc belongs to no element");
        assert_eq!(mesh.nodes()[5], [10e-3, 3e-3]);
        assert_eq!(mesh.names().collect::<Vec<_>>(), ["foot", "glued face"]);
        assert_eq!(mesh.boundary("foot"), Some(&[[0, 1], [1, 2]][..]));
        assert_eq!(mesh.boundary("glued face"), Some(&[[4, 3], [5, 4]][..]));
    }

    #[test]
    fn what_cannot_be_used_is_said_with_its_line() {
        let wrong = |from: &str, to: &str| {
            assert!(TWO_QUADS.contains(from));
            read(&TWO_QUADS.replace(from, to), 1e-3).unwrap_err().to_string()
        };
        assert!(wrong("2.2 0 8", "4.1 0 8").contains("line 2: found format \"4.1 0 8\""));
        assert!(wrong("2.2 0 8", "4.1 0 8").contains("msh22"));
        assert!(
            wrong("7 3 2 7 1 12 13 3 2", "7 2 2 7 1 12 13 3").contains("element 7 is a triangle")
        );
        assert!(wrong("13 10 3 0", "13 10 3 1").contains("node 13 lies at z = 1"));
        assert!(wrong("13 10 3 0", "13 10 three 0").contains("line 17"));
        assert!(wrong("12 13 3 2\n", "12 13 3 77\n").contains("no node 77"));
        assert!(wrong("$Elements\n7", "$Elements\n9").contains("expected number, type"));
        assert!(read("", 1.0).unwrap_err().to_string().contains("$MeshFormat"));
    }
}
