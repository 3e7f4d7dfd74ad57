//! Tables from results of CalculiX (`.frd`), so that a user's own run can take the place of ours.
//!
//! The run must be axisymmetric (CAX elements, x the radius, y the axis), the rubber below what it
//! is bonded to, which comes down in the increments of one step, and ask for
//!
//! ```text
//! *NODE FILE, OUTPUT=2D
//! U, RF
//! ```
//!
//! The compression is how far the bonded nodes have come down, the force is minus the sum of their
//! reaction forces, which CalculiX gives for the whole ring. Bonded are nodes of the outline that
//! moved straight down as far as any; facets of the seat are those whose ends lie on it at last.
//! The format is that of cgx, "Result Format", blocks `2C`, `3C` and `100C` as text.

mod parse;

use crate::fem::contact::Seat;
use crate::mesh::Point;
use crate::table::{Contents, Facets, Table, TableError};
use parse::{Block, FrdFile};
use std::collections::{BTreeMap, BTreeSet};

/// Units and seat for reading a file of CalculiX.
#[derive(Clone, Debug)]
pub struct Options {
    /// Its unit of length [m].
    pub length: f64,
    /// Its unit of force [N].
    pub force: f64,
    /// The seat in metres, in its coordinates; `None`: flat, at the lowest point of the last
    /// increment.
    pub seat: Option<Seat>,
    /// Distance from the seat within which a node touches it [m]; `None`: a thousandth of the
    /// section's height.
    pub reach: Option<f64>,
}

/// Why a file of CalculiX is no table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FrdError {
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
    /// A part that is missing.
    #[error("the file holds no {0}; write it with: *NODE FILE, OUTPUT=2D and U, RF")]
    Missing(&'static str),
    /// Elements of another kind.
    #[error(
        "line {line}: element of type {kind}; expected triangles or quadrilaterals (types 7 to 10): use axisymmetric elements and OUTPUT=2D"
    )]
    Element {
        /// Line in the file.
        line: usize,
        /// Its type.
        kind: usize,
    },
    /// An increment without one of its parts.
    #[error(
        "increment {increment} (time {time}) has displacements or reaction forces, not both; ask for U and RF in the same *NODE FILE"
    )]
    Unpaired {
        /// Number of the increment, from 1.
        increment: usize,
        /// Its time.
        time: f64,
    },
    /// A value at a node that is not there.
    #[error("there are displacements of node {0}, which the file does not hold")]
    NoSuchNode(usize),
    /// Nothing that moves straight down.
    #[error(
        "no two nodes side by side on the outline came straight down as far as any; what the rubber is bonded to must move against a seat that stays"
    )]
    NothingBonded,
    /// The numbers are no table.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// Reads the `text` of a file.
///
/// # Errors
/// If it cannot be read, or is no compression of a seal.
pub fn read(text: &str, options: &Options) -> Result<Table, FrdError> {
    let file = FrdFile::read(text)?;
    let numbers: BTreeMap<usize, usize> =
        file.nodes.keys().enumerate().map(|(number, id)| (*id, number)).collect();
    let rest: Vec<Point> = file
        .nodes
        .values()
        .map(|[x, y]| [options.length * x.max(0.0), options.length * y])
        .collect();
    let outline = outline(&file.elements, &numbers, &rest)?;
    let increments = file.increments(&numbers, options)?;
    let last = increments.last().ok_or(FrdError::Missing("displacements (DISP)"))?;
    let bonded = bonded(&outline, &last.moved)?;
    let mut contents = Contents {
        source: "CalculiX".into(),
        compressions: vec![0.0],
        forces: vec![0.0],
        vertices: vec![rest.clone()],
        facets: facets(&outline, &bonded, &rest, &last.moved, options),
        quads: file.quads(&numbers),
        ..Contents::default()
    };
    for increment in &increments {
        let first = *bonded.first().ok_or(FrdError::NothingBonded)?;
        let compression = -increment.moved[first][1];
        contents.compressions.push(compression);
        contents.forces.push(-bonded.iter().map(|node| increment.forces[*node]).sum::<f64>());
        let place = |(rest, moved): (&Point, &Point)| {
            [(rest[0] + moved[0]).max(0.0), rest[1] + moved[1] + compression]
        };
        contents.vertices.push(rest.iter().zip(&increment.moved).map(place).collect());
    }
    Ok(Table::new(contents)?)
}

/// A state in SI units, by number of the node.
struct Increment {
    moved: Vec<Point>,
    /// Axial reaction.
    forces: Vec<f64>,
}

impl FrdFile {
    /// Pairs of displacements and reactions of the same time.
    fn increments(
        &self,
        numbers: &BTreeMap<usize, usize>,
        options: &Options,
    ) -> Result<Vec<Increment>, FrdError> {
        let of = |name: &'static str| -> Vec<&Block> {
            self.results.iter().filter(|block| block.name == name).collect()
        };
        let (moves, forces) = (of("DISP"), of("FORC"));
        if forces.is_empty() {
            return Err(FrdError::Missing("reaction forces (FORC)"));
        }
        let mut out = Vec::new();
        for at in 0..moves.len().max(forces.len()) {
            let time = moves.get(at).or(forces.get(at)).map_or(0.0, |block| block.time);
            let unpaired = FrdError::Unpaired { increment: at + 1, time };
            let (Some(moves), Some(forces)) = (moves.get(at), forces.get(at)) else {
                return Err(unpaired);
            };
            if moves.time != forces.time {
                return Err(unpaired);
            }
            let mut increment = Increment {
                moved: vec![[0.0; 2]; numbers.len()],
                forces: vec![0.0; numbers.len()],
            };
            for (id, [x, y]) in &moves.values {
                let node = *numbers.get(id).ok_or(FrdError::NoSuchNode(*id))?;
                increment.moved[node] = [options.length * x, options.length * y];
            }
            for (id, [_, y]) in &forces.values {
                let node = *numbers.get(id).ok_or(FrdError::NoSuchNode(*id))?;
                increment.forces[node] = options.force * y;
            }
            out.push(increment);
        }
        Ok(out)
    }

    /// The linear quadrilaterals; none if there are others too.
    fn quads(&self, numbers: &BTreeMap<usize, usize>) -> Vec<[usize; 4]> {
        let quad = |nodes: &Vec<usize>| <[usize; 4]>::try_from(nodes.as_slice()).ok();
        let quads: Option<Vec<[usize; 4]>> = self.elements.iter().map(quad).collect();
        quads.unwrap_or_default().into_iter().map(|quad| quad.map(|id| numbers[&id])).collect()
    }
}

/// Edges of one element only, the solid on their left.
fn outline(
    elements: &[Vec<usize>],
    numbers: &BTreeMap<usize, usize>,
    rest: &[Point],
) -> Result<Vec<[usize; 2]>, FrdError> {
    let mut edges = BTreeSet::new();
    for element in elements {
        let known = |id: &usize| numbers.get(id).copied().ok_or(FrdError::NoSuchNode(*id));
        let mut nodes: Vec<usize> = element.iter().map(known).collect::<Result<_, _>>()?;
        let next = |at: usize| (at + 1) % element.len();
        let twice_area = |at: usize| {
            let (a, b) = (rest[nodes[at]], rest[nodes[next(at)]]);
            a[0] * b[1] - b[0] * a[1]
        };
        if (0..nodes.len()).map(twice_area).sum::<f64>() < 0.0 {
            nodes.reverse();
        }
        edges.extend((0..nodes.len()).map(|at| [nodes[at], nodes[next(at)]]));
    }
    if edges.is_empty() {
        return Err(FrdError::Missing("elements"));
    }
    Ok(edges.iter().copied().filter(|[a, b]| !edges.contains(&[*b, *a])).collect())
}

/// Nodes of the outline that moved straight down as far as any.
fn bonded(outline: &[[usize; 2]], moved: &[Point]) -> Result<Vec<usize>, FrdError> {
    let down = moved.iter().fold(0.0f64, |down, moved| down.max(-moved[1]));
    let near = 1e-5 * down;
    let straight =
        |node: &usize| moved[*node][0].abs() <= near && (moved[*node][1] + down).abs() <= near;
    let nodes: BTreeSet<usize> = outline.iter().flatten().copied().filter(straight).collect();
    let edge = |edge: &&[usize; 2]| edge.iter().all(|node| nodes.contains(node));
    match down > 0.0 && outline.iter().any(|e| edge(&e)) {
        true => Ok(nodes.into_iter().collect()),
        false => Err(FrdError::NothingBonded),
    }
}

fn facets(
    outline: &[[usize; 2]],
    bonded: &[usize],
    rest: &[Point],
    moved: &[Point],
    options: &Options,
) -> Facets {
    let at = |node: usize| [rest[node][0] + moved[node][0], rest[node][1] + moved[node][1]];
    let heights = || rest.iter().map(|point| point[1]);
    let height =
        heights().fold(f64::NEG_INFINITY, f64::max) - heights().fold(f64::INFINITY, f64::min);
    let reach = options.reach.unwrap_or(1e-3 * height);
    let lowest = outline.iter().map(|edge| at(edge[0])[1]).fold(f64::INFINITY, f64::min);
    let seat = options.seat.clone().unwrap_or_else(|| Seat::flat(lowest));
    let touches = |node: &usize| at(*node)[1] - seat.surface(at(*node)[0])[0] <= reach;
    let mut facets = Facets::default();
    for edge in outline {
        if edge.iter().all(|node| rest[*node][0] == 0.0) {
            continue; // The axis is no surface.
        }
        let list = match edge {
            edge if edge.iter().all(|node| bonded.contains(node)) => &mut facets.bonded,
            edge if edge.iter().all(touches) => &mut facets.seat,
            _ => &mut facets.exposed,
        };
        list.push(*edge);
    }
    facets
}

#[cfg(test)]
mod tests {
    use super::parse::around;
    use super::*;

    const MM: Options = Options { length: 1e-3, force: 1.0, seat: None, reach: None };

    /// As in Fortran's E12.5: 6.00000E+00.
    fn e12(x: f64) -> String {
        let text = format!("{x:.5e}");
        let (digits, power) = text.split_once('e').unwrap();
        let power: i32 = power.parse().unwrap();
        format!(
            "{:>12}",
            format!("{digits}E{}{:02}", if power < 0 { '-' } else { '+' }, power.abs())
        )
    }

    /// Lines with node and values in the columns of the format.
    fn values(rows: &[(usize, [f64; 3])]) -> String {
        rows.iter().map(|(node, xyz)| format!(" -1{node:10}{}\n", xyz.map(e12).concat())).collect()
    }

    /// A ring of two quadrilaterals from radius 6 to 10 mm, 3 mm high, in two increments; written
    /// from the description of the format.
    fn file() -> String {
        let nodes = [
            (1, 6.0, 0.0),
            (2, 8.0, 0.0),
            (3, 10.0, 0.0),
            (11, 6.0, 3.0),
            (12, 8.0, 3.0),
            (13, 10.0, 3.0),
        ];
        let mut text = String::from(
            "    1C\n    1UUSER\n    2C                             6                                     1\n",
        );
        text += &values(&nodes.map(|(id, x, y)| (id, [x, y, 1e-16])));
        text += " -3\n    3C                             2                                     1\n";
        text += " -1         1    9    0    1\n -2         1         2        12        11\n";
        // The other way around.
        text += " -1         2    9    0    1\n -2        12        13         3         2\n -3\n";
        for (number, down, force) in [(1, 0.1, 2.0), (2, 0.25, 6.0)] {
            let head = format!(
                "  100CL  10{number}{:12.9}           6                     0    {number}           1\n",
                0.5 * number as f64
            );
            let moved = nodes.map(|(id, _, y)| {
                (id, if y > 0.0 { [0.0, -down, 0.0] } else { [0.1 * down, 0.0, 0.0] })
            });
            let reactions =
                nodes.map(|(id, _, y)| (id, [7.0, if y > 0.0 { -force } else { force }, 0.0]));
            text += &format!(
                "    1PSTEP                         1\n{head} -4  DISP        4    1\n -5  D1          1    2    1    0\n{} -3\n",
                values(&moved)
            );
            text += &format!(
                "    1PSTEP                         2\n{head} -4  FORC        4    1\n -5  F1          1    2    1    0\n{} -3\n",
                values(&reactions)
            );
            text += &format!(
                "{head} -4  STRESS      6    1\n -5  SXX         1    4    1    1\n{} -3\n",
                values(&moved)
            );
        }
        text + " 9999\n"
    }

    #[test]
    fn a_run_of_calculix_is_a_table() {
        let table = read(&file(), &MM).unwrap();
        let contents = table.contents();
        assert_eq!(contents.compressions, [0.0, 0.1e-3, 0.25e-3]);
        assert_eq!(contents.forces, [0.0, 6.0, 18.0], "three nodes are bonded");
        assert_eq!(contents.facets.bonded, [[4, 3], [5, 4]]);
        assert_eq!(contents.facets.seat, [[0, 1], [1, 2]]);
        assert_eq!(contents.facets.exposed, [[2, 5], [3, 0]]);
        assert_eq!(contents.quads, [[0, 1, 4, 3], [4, 5, 2, 1]]);
        let last = &contents.vertices[2];
        assert!((last[2][0] - 10.025e-3).abs() < 1e-9 && (last[2][1] - 0.25e-3).abs() < 1e-9);
        assert!((last[5][1] - 3e-3).abs() < 1e-9, "the carrier stands still");
    }

    #[test]
    fn quadratic_sides_become_two_facets() {
        assert_eq!(around(&[1, 2, 3, 4, 5, 6, 7, 8], 4), [1, 5, 2, 6, 3, 7, 4, 8]);
        assert_eq!(around(&[1, 2, 3], 3), [1, 2, 3]);
    }

    #[test]
    fn what_is_missing_or_wrong_is_said() {
        let error = |from: &str, to: &str| {
            assert!(file().contains(from), "{from}");
            read(&file().replace(from, to), &MM).unwrap_err()
        };
        assert_eq!(error("FORC", "OTHE"), FrdError::Missing("reaction forces (FORC)"));
        assert_eq!(error("DISP", "OTHE"), FrdError::Unpaired { increment: 1, time: 0.5 });
        assert!(matches!(error("1    9", "1    4"), FrdError::Element { kind: 4, .. }));
        assert!(matches!(
            error("  2        12        11", "  2        77        11"),
            FrdError::NoSuchNode(77)
        ));
        assert!(matches!(
            error(" -1        11 6.00000E+00", " -1        11 6,00000E+00"),
            FrdError::Line { .. }
        ));
        assert!(matches!(read("", &MM), Err(FrdError::Missing("elements"))));
        // What comes down is not straight.
        assert_eq!(
            error(" 0.00000E+00-2.50000E-01", " 9.00000E-01-2.50000E-01"),
            FrdError::NothingBonded
        );
    }
}
