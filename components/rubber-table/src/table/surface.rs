//! The outline of the table's section, and the surface in space that it sweeps.

use crate::table::interpolation::Table;
use tremie_geometry::Turned;
use tremie_messages::scene::{FacetKind, Section, SectionEdge};

/// The surface of the ring in space, the axis along z. Which vertices a triangle has never changes;
/// where they are follows from the section's.
pub type Surface = Turned;

/// The outline without what lies inside, and where its points come from.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The outline at rest: what a scene says of the seal.
    pub section: Section,
    /// Vertex of the table behind each of its points.
    pub vertices: Vec<usize>,
}

impl Table {
    /// The outline, its points in the order in which the facets name them.
    pub fn outline(&self) -> Outline {
        let rest = &self.contents().vertices[0];
        let mut place = vec![None; rest.len()];
        let mut outline = Outline { section: Section::default(), vertices: Vec::new() };
        for (kind, [a, b]) in self.edges() {
            let mut point = |vertex: usize| {
                *place[vertex].get_or_insert_with(|| {
                    outline.section.points.push(rest[vertex]);
                    outline.vertices.push(vertex);
                    outline.vertices.len() as u32 - 1
                })
            };
            let points = [point(a), point(b)];
            outline.section.edges.push(SectionEdge { points, kind });
        }
        outline
    }

    /// Revolves the outline in `sectors` steps, at least 3. The points of its section are all the
    /// vertices of the table.
    pub fn surface(&self, sectors: usize) -> Surface {
        let points = self.contents().vertices[0].clone();
        let edge =
            |(kind, ends): (_, [usize; 2])| SectionEdge { points: ends.map(|v| v as u32), kind };
        Turned::new(&Section { points, edges: self.edges().map(edge).collect() }, sectors)
    }

    fn edges(&self) -> impl Iterator<Item = (FacetKind, [usize; 2])> {
        let facets = &self.contents().facets;
        [
            (FacetKind::Seat, &facets.seat),
            (FacetKind::Exposed, &facets.exposed),
            (FacetKind::Covered, &facets.covered),
            (FacetKind::Bonded, &facets.bonded),
        ]
        .into_iter()
        .flat_map(|(kind, edges)| edges.iter().map(move |edge| (kind, *edge)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::contents::Contents;
    use crate::table::example;

    #[test]
    fn the_outline_turns_into_the_same_surface_as_the_whole_section() {
        // A vertex inside, and one more in the middle of nothing.
        let mut contents = example();
        for frame in &mut contents.vertices {
            frame.insert(0, [1.5, 0.5]);
            frame.push([1.2, 0.6]);
        }
        for [a, b] in (contents.facets.seat.iter_mut())
            .chain(&mut contents.facets.exposed)
            .chain(&mut contents.facets.bonded)
        {
            (*a, *b) = (*a + 1, *b + 1);
        }
        contents.quads = vec![[1, 2, 3, 4]];
        let table = Table::new(contents).unwrap();
        let outline = table.outline();
        assert_eq!(outline.vertices, [1, 2, 3, 4]);
        let (whole, alone) = (table.surface(12), Turned::new(&outline.section, 12));
        assert_eq!((&whole.triangles, &whole.kinds), (&alone.triangles, &alone.kinds));
        let at = table.bracket(0.2).unwrap();
        let section = table.vertices(at);
        let points: Vec<_> = outline.vertices.iter().map(|vertex| section[*vertex]).collect();
        assert_eq!(whole.places(&section), alone.places(&points));
        assert!(alone.kinds.is_sorted());
    }

    #[test]
    fn what_is_on_the_axis_stays_there() {
        let frame = |c: f64| vec![[0.0, c], [2.0 + c, c], [2.0, 1.0], [0.0, 1.0]];
        let mut contents = Contents { vertices: [0.0, 0.1, 0.3].map(frame).to_vec(), ..example() };
        // The axis is no surface.
        contents.facets.exposed.pop();
        let surface = Table::new(contents.clone()).unwrap().surface(8);
        assert_eq!(surface.section.iter().filter(|vertex| **vertex == 0).count(), 1);
        contents.vertices[1][0][0] = 0.05;
        let error = Table::new(contents).unwrap_err().to_string();
        assert!(error.contains("vertex 0") && error.contains("axis"), "{error}");
    }
}
