//! Thickness of a gap at a point.

use super::{Candidate, Declared, Wall, body_of};
use crate::bodies::body_list::Bodies;
use crate::boundary::boundaries::Boundaries;
use crate::lattice::d3q19::dot;
use crate::lattice::layout::Layout;
use tremie_fluid_kit::cells::centres::Centres;

/// Cosine of the angle between the ways to both sides at most.
const OPPOSITE_WAYS: f64 = -0.9;

impl Declared {
    /// Largest distance between a point and a side that counts [cells].
    pub(super) fn reach(&self) -> f64 {
        f64::from(self.open_at.max(self.slip_below))
    }

    /// Distance of a point [m] from the sides that stand still, and the way to the first of them
    /// [cells]; `None` where the gap is not.
    pub(super) fn still(
        &self,
        point: [f64; 3],
        layout: &Layout,
        surroundings: &Boundaries,
        centres: &Centres,
    ) -> Option<(f64, [f64; 3])> {
        if self.region.is_some_and(|region| !region.contains(point)) {
            return None;
        }
        let reach = self.reach();
        let (mut still, mut first) = (0.0, [0.0; 3]);
        for side in self.sides {
            let way = match side {
                Wall::Part(_) => continue,
                Wall::Face { axis, side } => {
                    let x = (point[axis] - centres.min[axis]) / centres.cell;
                    let mut way = [0.0; 3];
                    way[axis] = [-x, f64::from(layout.grid.n[axis]) - x][side];
                    way
                }
                Wall::Solid(number) => {
                    let solid = &surroundings.ground().solids[number];
                    solid.way_within(point, reach * centres.cell)?.map(|x| x / centres.cell)
                }
            };
            // Zero until a first side was measured.
            if still == 0.0 {
                first = way;
            } else if !are_opposite(first, way) {
                return None;
            }
            still += length(way);
        }
        (still < reach).then_some((still, first))
    }

    /// Thickness at a candidate, and the axis nearest to the direction across.
    pub(super) fn thickness(
        &self,
        layout: &Layout,
        bodies: &Bodies,
        candidate: &Candidate,
    ) -> (f32, u8) {
        let mut thickness = f64::from(candidate.still);
        let mut across = candidate.way.map(f64::from);
        for side in self.sides {
            let Wall::Part(index) = side else { continue };
            let at = layout.at(candidate.cell);
            let part = body_of(bodies, index).and_then(|body| body.part.as_ref());
            let way =
                part.and_then(|part| part.nearest(&layout.grid, at, self.reach() - thickness));
            let Some(way) = way.filter(|&way| thickness == 0.0 || are_opposite(across, way)) else {
                return (f32::INFINITY, 0);
            };
            thickness += length(way);
            across = way;
        }
        let larger = |best: usize, a: usize| {
            if across[a].abs() > across[best].abs() { a } else { best }
        };
        (thickness as f32, (1..3).fold(0, larger) as u8)
    }
}

/// True if the ways from a point to both sides of a gap are opposite.
fn are_opposite(a: [f64; 3], b: [f64; 3]) -> bool {
    dot(a, b) <= OPPOSITE_WAYS * length(a) * length(b)
}

fn length(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}
