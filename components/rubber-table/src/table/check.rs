//! Conditions on contents of a table.

use crate::mesh::Point;
use crate::table::contents::Contents;
use std::collections::BTreeSet;

/// Why contents are no table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// Too few frames.
    #[error("the table has {0} frame(s), it needs at least 2: one at rest and one compressed")]
    TooFewFrames(usize),
    /// Lists of different length.
    #[error("{what} has {found} entries, expected {expected}, {why}")]
    Length {
        /// The list.
        what: String,
        /// Its length.
        found: usize,
        /// Its length as it should be.
        expected: usize,
        /// Why.
        why: &'static str,
    },
    /// The first frame is not at rest.
    #[error("the first frame has {what} {found}, expected 0: a table begins at rest")]
    NotAtRest {
        /// `compression` or `force`.
        what: &'static str,
        /// Text or number found there.
        found: f64,
    },
    /// Something that must grow does not.
    #[error("{what} falls or stays from frame {} ({before}) to frame {frame} ({found}); it must grow, or one force would have several shapes", frame - 1)]
    NotGrowing {
        /// `compression` or `force`.
        what: &'static str,
        /// The frame, from 0.
        frame: usize,
        /// The value before.
        before: f64,
        /// The value.
        found: f64,
    },
    /// A number that is none.
    #[error("{what} of frame {frame} is not finite")]
    NotFinite {
        /// The value's name.
        what: &'static str,
        /// The frame, from 0.
        frame: usize,
    },
    /// A vertex beyond the axis.
    #[error("vertex {vertex} of frame {frame} has radius {radius} m; radii must be 0 or more")]
    BeyondAxis {
        /// The frame, from 0.
        frame: usize,
        /// The vertex, from 0.
        vertex: usize,
        /// Its radius [m].
        radius: f64,
    },
    /// A vertex that leaves the axis.
    #[error(
        "vertex {vertex} lies on the axis at rest and has radius {radius} m in frame {frame}; what is on the axis stays there"
    )]
    LeavesAxis {
        /// The vertex, from 0.
        vertex: usize,
        /// The frame, from 0.
        frame: usize,
        /// Its radius [m].
        radius: f64,
    },
    /// A facet or quadrilateral that names a vertex which is not there.
    #[error("{what} name vertex {vertex}, but there are {count}, counted from 0")]
    NoSuchVertex {
        /// `facets` or `quads`.
        what: &'static str,
        /// The vertex.
        vertex: usize,
        /// Number of them.
        count: usize,
    },
    /// An outline that branches or doubles back.
    #[error(
        "two facets begin or end at vertex {0}; the outline must pass each vertex once, with the rubber on its left"
    )]
    Branches(usize),
    /// No surface of a kind that is needed.
    #[error(
        "no facets are \"{0}\"; a seal needs both, where it touches the seat and where it is held"
    )]
    NoFacets(&'static str),
    /// A bonded vertex that moves along the axis.
    #[error(
        "vertex {vertex}, bonded, is {by} m off its height in frame {frame}; vertices must be given as seen from the carrier, where it stands still"
    )]
    BondMoves {
        /// The vertex, from 0.
        vertex: usize,
        /// The frame, from 0.
        frame: usize,
        /// Its way [m].
        by: f64,
    },
}

pub(super) fn check(contents: &Contents) -> Result<(), TableError> {
    check_lengths(contents)?;
    check_growth("compression", &contents.compressions)?;
    check_growth("force", &contents.forces)?;
    for (frame, vertices) in contents.vertices.iter().enumerate() {
        check_vertices(frame, vertices)?;
    }
    check_axis(contents)?;
    check_outline(contents)?;
    check_bond(contents)?;
    check_extras(contents)
}

/// A surface turned about the axis has one vertex for a point on it, and many for any other.
fn check_axis(contents: &Contents) -> Result<(), TableError> {
    for (frame, vertices) in contents.vertices.iter().enumerate() {
        let left = (contents.vertices[0].iter().zip(vertices))
            .position(|(rest, now)| rest[0] == 0.0 && now[0] != 0.0);
        if let Some(vertex) = left {
            return Err(TableError::LeavesAxis { vertex, frame, radius: vertices[vertex][0] });
        }
    }
    Ok(())
}

fn check_lengths(contents: &Contents) -> Result<(), TableError> {
    let frames = contents.compressions.len();
    if frames < 2 {
        return Err(TableError::TooFewFrames(frames));
    }
    length("force", contents.forces.len(), frames, "one for each frame")?;
    length("vertices", contents.vertices.len(), frames, "one list for each frame")?;
    let count = contents.vertices[0].len();
    for (frame, vertices) in contents.vertices.iter().enumerate() {
        let what = format!("vertices of frame {frame}");
        length(&what, vertices.len(), count, "as many as in frame 0")?;
    }
    Ok(())
}

fn length(what: &str, found: usize, expected: usize, why: &'static str) -> Result<(), TableError> {
    match found == expected {
        true => Ok(()),
        false => Err(TableError::Length { what: what.into(), found, expected, why }),
    }
}

/// Checks optional lists: absent, or of the right length.
fn check_extras(contents: &Contents) -> Result<(), TableError> {
    let frames = contents.compressions.len();
    for (what, found) in [
        ("energy", contents.energies.len()),
        ("convergence", contents.convergence.len()),
        ("mises_stress", contents.mises.len()),
    ] {
        if found > 0 {
            length(what, found, frames, "one for each frame")?;
        }
    }
    for (frame, stresses) in contents.mises.iter().enumerate() {
        let what = format!("mises_stress of frame {frame}");
        length(&what, stresses.len(), contents.quads.len(), "one for each quadrilateral")?;
        finite("Mises stress", frame, stresses)?;
    }
    contents.energies.iter().enumerate().try_for_each(|(k, e)| finite("energy", k, &[*e]))
}

fn finite(what: &'static str, frame: usize, values: &[f64]) -> Result<(), TableError> {
    match values.iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(TableError::NotFinite { what, frame }),
    }
}

fn check_growth(what: &'static str, values: &[f64]) -> Result<(), TableError> {
    for (frame, value) in values.iter().enumerate() {
        finite(what, frame, &[*value])?;
    }
    if values[0] != 0.0 {
        return Err(TableError::NotAtRest { what, found: values[0] });
    }
    match values.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(at) => Err(TableError::NotGrowing {
            what,
            frame: at + 1,
            before: values[at],
            found: values[at + 1],
        }),
        None => Ok(()),
    }
}

fn check_vertices(frame: usize, vertices: &[Point]) -> Result<(), TableError> {
    finite("a vertex", frame, vertices.as_flattened())?;
    match vertices.iter().position(|vertex| vertex[0] < 0.0) {
        Some(vertex) => Err(TableError::BeyondAxis { frame, vertex, radius: vertices[vertex][0] }),
        None => Ok(()),
    }
}

fn check_outline(contents: &Contents) -> Result<(), TableError> {
    let (facets, count) = (&contents.facets, contents.vertices[0].len());
    for (name, edges) in [("seat", &facets.seat), ("bonded", &facets.bonded)] {
        if edges.is_empty() {
            return Err(TableError::NoFacets(name));
        }
    }
    let known = |what, vertex: &usize| match *vertex < count {
        true => Ok(()),
        false => Err(TableError::NoSuchVertex { what, vertex: *vertex, count }),
    };
    contents.quads.iter().flatten().try_for_each(|vertex| known("quads", vertex))?;
    let free = || facets.seat.iter().chain(&facets.exposed);
    let edges = || free().chain(&facets.covered).chain(&facets.bonded);
    edges().flatten().try_for_each(|vertex| known("facets", vertex))?;
    for end in 0..2 {
        let mut seen = BTreeSet::new();
        if let Some(edge) = edges().find(|edge| !seen.insert(edge[end])) {
            return Err(TableError::Branches(edge[end]));
        }
    }
    Ok(())
}

/// To a millionth of the section's height.
fn check_bond(contents: &Contents) -> Result<(), TableError> {
    let heights = || contents.vertices[0].iter().map(|vertex| vertex[1]);
    let (low, high) =
        (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
    for (frame, vertices) in contents.vertices.iter().enumerate() {
        for &vertex in contents.facets.bonded.iter().flatten() {
            let by = vertices[vertex][1] - contents.vertices[0][vertex][1];
            if by.abs() > 1e-6 * (high - low) {
                return Err(TableError::BondMoves { vertex, frame, by });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::example;

    #[test]
    fn each_thing_that_can_be_wrong_is_told_apart() {
        let found = |change: fn(&mut Contents)| {
            let mut contents = example();
            change(&mut contents);
            check(&contents).unwrap_err()
        };
        assert_eq!(check(&example()), Ok(()));
        assert_eq!(found(|c| c.compressions.truncate(1)), TableError::TooFewFrames(1));
        assert!(matches!(found(|c| c.forces.truncate(2)), TableError::Length { .. }));
        assert!(matches!(found(|c| c.vertices[2].truncate(3)), TableError::Length { .. }));
        assert!(matches!(found(|c| c.mises[1].clear()), TableError::Length { .. }));
        assert!(matches!(found(|c| c.energies.truncate(2)), TableError::Length { .. }));
        assert!(matches!(found(|c| c.forces[0] = 0.1), TableError::NotAtRest { .. }));
        assert!(matches!(found(|c| c.forces[2] = 5.0), TableError::NotGrowing { frame: 2, .. }));
        assert!(matches!(found(|c| c.compressions[1] = -0.1), TableError::NotGrowing { .. }));
        assert!(matches!(
            found(|c| c.forces[1] = f64::NAN),
            TableError::NotFinite { frame: 1, .. }
        ));
        assert!(matches!(found(|c| c.vertices[1][0][0] = -0.1), TableError::BeyondAxis { .. }));
        assert!(matches!(found(|c| c.quads[0][1] = 4), TableError::NoSuchVertex { .. }));
        assert!(matches!(found(|c| c.facets.seat[0][1] = 9), TableError::NoSuchVertex { .. }));
        assert!(matches!(found(|c| c.facets.exposed[0] = [0, 2]), TableError::Branches(0)));
        assert!(matches!(found(|c| c.facets.seat.clear()), TableError::NoFacets("seat")));
        let error = found(|c| c.vertices[2][3][1] = 0.7);
        assert!(matches!(error, TableError::BondMoves { vertex: 3, frame: 2, .. }));
        assert!(error.to_string().contains("carrier"));
    }
}
