//! The facets of a turned section in its present shape: all sectors are turned from the first.

use crate::mesh::Point;
use crate::runtime::force::{Facet, Sums};
use crate::table::{FacetKind, Surface};
use std::f64::consts::PI;
use tremie_geometry::Vec3;
use tremie_messages::scene::Section;

/// Facets by sector.
#[derive(Clone, Debug)]
pub(super) struct SectorFacets {
    sectors: f64,
    /// Numbers and kinds of those in the first sector, and what they are now.
    first: Vec<usize>,
    kinds: Vec<FacetKind>,
    now: Vec<Facet>,
    /// For each facet of the surface the one that it is turned from, and the turn.
    turned: Vec<Turned>,
    /// Areas of all now.
    areas: Sums,
}

/// A facet of any sector.
#[derive(Clone, Copy, Debug)]
struct Turned {
    /// Its place among those of the first sector.
    from: u32,
    cos: f64,
    sin: f64,
}

impl SectorFacets {
    /// Of a `section` turned into a `surface`, now with these `points`; each edge has as many
    /// facets in each sector as it has ends off the axis.
    pub fn new(section: &Section, sectors: u32, surface: &Surface, points: &[Point]) -> Self {
        let sectors = sectors.max(3);
        let step = 2.0 * PI / f64::from(sectors);
        let (mut first, mut turned) = (Vec::new(), Vec::new());
        for edge in &section.edges {
            let ends = edge.points.iter().filter(|p| !section.is_on_axis(**p)).count();
            let from = first.len();
            first.extend(turned.len()..turned.len() + ends);
            for sector in 0..sectors {
                let (sin, cos) = libm::sincos(step * f64::from(sector));
                let of_end = |end| Turned { from: (from + end) as u32, cos, sin };
                turned.extend((0..ends).map(of_end));
            }
        }
        let kinds = first.iter().map(|&facet| surface.kinds[facet]).collect();
        let now = Vec::with_capacity(first.len());
        let sectors = f64::from(sectors);
        let mut own = Self { sectors, first, kinds, now, turned, areas: Sums::default() };
        own.shape(surface, points);
        own
    }

    /// Takes them to a shape.
    pub fn shape(&mut self, surface: &Surface, points: &[Point]) {
        let corners = |facet: usize| {
            surface.triangles[facet].map(|vertex| surface.place(points, vertex as usize))
        };
        self.now.clear();
        self.now.extend(self.first.iter().map(|&facet| Facet::new(corners(facet))));
        self.areas = Sums::default();
        for (kind, facet) in self.kinds.iter().zip(&self.now) {
            self.areas.add_area(*kind, facet, self.sectors);
        }
    }

    /// Areas of all, without loads.
    pub fn areas(&self) -> Sums {
        self.areas
    }

    /// Kind of a facet.
    pub fn kind(&self, facet: usize) -> FacetKind {
        self.kinds[self.turned[facet].from as usize]
    }

    /// Area of a facet [m²].
    pub fn area(&self, facet: usize) -> f64 {
        self.now[self.turned[facet].from as usize].area
    }

    /// The part of a load [N], in the section's frame, that presses on a facet.
    pub fn inward(&self, facet: usize, load: Vec3) -> f64 {
        let Turned { from, cos, sin } = self.turned[facet];
        let [x, y, z] = load.into();
        self.now[from as usize].inward(Vec3::new(cos * x + sin * y, cos * y - sin * x, z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::Table;
    use crate::table::example;

    /// Facets that were turned are those of the surface, also at its end on the axis.
    #[test]
    fn every_facet_is_that_of_the_surface() {
        let table = Table::new(example()).unwrap();
        for sectors in [3, 7] {
            let section = table.outline().section;
            let points = section.points.clone();
            let surface = Surface::new(&section, sectors as usize);
            let facets = SectorFacets::new(&section, sectors, &surface, &points);
            assert_eq!(facets.turned.len(), surface.triangles.len());
            let load = Vec3::new(0.3, -0.7, 1.9);
            for (number, triangle) in surface.triangles.iter().enumerate() {
                let corners = triangle.map(|vertex| surface.place(&points, vertex as usize));
                let facet = Facet::new(corners);
                assert_eq!(facets.kind(number), surface.kinds[number]);
                assert!((facets.area(number) / facet.area - 1.0).abs() < 1e-12);
                assert!((facets.inward(number, load) - facet.inward(load)).abs() < 1e-12);
            }
        }
    }
}
