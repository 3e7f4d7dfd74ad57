//! Deformable surfaces of the scene in the fluid: their vertices come in, the loads on their facets go
//! out. What such a surface is to the lattice, see `shape`.

use crate::balance::mirrors_of_part;
use crate::error::FluidError;
use crate::gap_pressure::each_felt;
use crate::kernel::Collides;
use crate::lattice::{cross, dot};
use crate::ledger::add_scaled;
use crate::links::Exchange;
use crate::part_body::{PartBody, Rounding};
use crate::shape::Shape;
use crate::solver::Solver;
use crate::units::Units;
use std::ops::Range;
use tremie_geometry::{Frame, Mesh, Surface, Turned};
use tremie_messages::scene::Scene;
use tremie_messages::{FacetLoad, SurfaceVertex};
use tremie_team::Cut;

/// A deformable surface of the scene.
#[derive(Clone, Debug)]
pub struct Soft {
    name: String,
    /// Index of the part that carries it.
    carrier: usize,
    triangles: Vec<[u32; 3]>,
    /// First of its vertices among those of all surfaces, and how many.
    first_vertex: usize,
    count: usize,
    /// Origin of its section in the scene [m].
    reference: [f64; 3],
}

impl Soft {
    /// Those of a scene that was checked.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let mut first_vertex = 0;
        let of = |surface: &tremie_messages::scene::DeformableSurface| {
            let turned = Turned::of(surface);
            let carrier = scene.parts.iter().position(|part| part.name == surface.carrier);
            let carrier = carrier.unwrap_or_default();
            let frame = Frame::of(&scene.parts[carrier].pose);
            let soft = Self {
                name: surface.name.clone(),
                carrier,
                count: turned.vertex_count(),
                first_vertex,
                reference: frame.to_world(surface.pose.position),
                triangles: turned.triangles,
            };
            first_vertex += soft.count;
            soft
        };
        scene.surfaces.iter().map(of).collect()
    }

    /// Its vertices among those of all surfaces.
    pub fn vertices(&self) -> Range<usize> {
        self.first_vertex..self.first_vertex + self.count
    }

    /// It as a body, `index` being its number among parts and surfaces.
    fn body(
        &self,
        index: usize,
        vertices: &[SurfaceVertex],
        step: f64,
        units: &Units,
    ) -> Result<PartBody, FluidError> {
        let position = units.position_to_lattice(self.reference);
        let reference: [f64; 3] = std::array::from_fn(|a| units.min[a] + position[a] * units.cell);
        let place =
            |vertex: &SurfaceVertex| std::array::from_fn(|a| vertex.position[a] - reference[a]);
        let vertices = vertices[self.vertices()].iter().map(place).collect();
        let mesh = Mesh { vertices, triangles: self.triangles.clone() };
        let surface = Surface::new(mesh).map_err(|error| FluidError::Surface {
            name: self.name.clone(),
            reason: error.to_string(),
        })?;
        let rounding = Rounding { position, orientation: [0.0, 0.0, 0.0, 1.0], step };
        Ok(PartBody::deformable(index, surface, self.carrier, rounding, units.cell))
    }
}

impl<T: Collides> Solver<T> {
    /// See [`crate::FluidLbm::set_surfaces`].
    pub fn set_surfaces(&mut self, vertices: &[SurfaceVertex]) -> Result<(), FluidError> {
        let expected = self.soft_vertices;
        if vertices.len() != expected {
            return Err(FluidError::Vertices { expected, found: vertices.len() });
        }
        if let Some(vertex) = vertices.iter().position(|vertex| !vertex.is_finite()) {
            return Err(FluidError::NonFiniteVertex { vertex });
        }
        if !self.waiting.is_empty() {
            let step = self.pose_spacing;
            let mut parts = Vec::new();
            for (k, soft) in self.waiting.iter().enumerate() {
                parts.push(soft.body(self.parts + k, vertices, step, &self.units)?);
            }
            let softs = std::mem::take(&mut self.waiting);
            self.bodies.add_softs(softs, parts, &self.layout.grid);
            self.list_items();
        }
        self.bodies.vertices.clear();
        self.bodies.vertices.extend_from_slice(vertices);
        Ok(())
    }

    /// That vertices of deformable surfaces came, if the scene has some.
    pub(crate) fn check_surfaces(&self) -> Result<(), FluidError> {
        match self.waiting.is_empty() {
            true => Ok(()),
            false => Err(FluidError::Vertices { expected: self.soft_vertices, found: 0 }),
        }
    }

    /// Gives the facets of deformable surfaces their loads, from what they felt, and balances them.
    pub(crate) fn load_facets(&mut self) {
        for place in self.bodies.rigid()..self.bodies.living.len() {
            let mut exchange = Exchange::default();
            for item in self.items_of(place) {
                exchange.join(&item.exchange);
            }
            if self.slips {
                exchange.join(&self.slip.on_body(self.bodies.living[place].handle));
            }
            self.exchange.join(&exchange);
            let Some(mut shape) =
                self.bodies.living[place].part.as_mut().and_then(|part| part.shape.take())
            else {
                continue;
            };
            self.feel(place, &mut shape);
            self.finish_facets(place, &exchange, &mut shape);
            if let Some(part) = &mut self.bodies.living[place].part {
                part.shape = Some(shape);
            }
        }
    }

    /// Adds up what the facets of a surface felt of the fluid, of gaps, and of slipping. Each thread looks at all of it
    /// and takes what is of its own facets: so each facet's sum has the order of what it felt.
    fn feel(&mut self, place: usize, shape: &mut Shape) {
        let items = self.bodies.living[place].items.clone();
        let (in_gaps, felt) = (&self.in_gaps[items.clone()], &self.link_items[items]);
        let slip = &self.slip;
        let handle = self.bodies.living[place].handle;
        let length = shape.loads.len().div_ceil(self.team.threads()).max(1);
        let pieces = Cut::every(&mut shape.loads, length);
        self.team.for_pieces(pieces, |piece, loads: &mut [[[f64; 3]; 2]]| {
            loads.fill([[0.0; 3]; 2]);
            let first = piece * length;
            let mut give = |facet: usize, force: [f64; 3], at: [f64; 3]| {
                if let Some(load) = loads.get_mut(facet.wrapping_sub(first)) {
                    add_scaled(&mut load[0], force, 1.0);
                    add_scaled(&mut load[1], cross(at, force), 1.0);
                }
            };
            each_felt(felt, in_gaps, &mut give);
            for felt in slip.on_facets(handle) {
                give(felt.facet as usize, felt.force, felt.at);
            }
        });
    }

    /// Counts loads for the mirrored half too, averages them, and adds buoyancy.
    fn finish_facets(&mut self, place: usize, exchange: &Exchange, shape: &mut Shape) {
        let body = &self.bodies.living[place];
        let mirrors = mirrors_of_part(&self.layout.grid, body.position);
        let copies: f64 = mirrors.iter().map(|is_cut| if *is_cut { 2.0 } else { 1.0 }).product();
        let mut sum = [0.0; 3];
        for (load, carried) in shape.loads.iter_mut().zip(&mut shape.carried) {
            *load = load.map(|v| v.map(|x| x * copies));
            add_scaled(&mut sum, load[0], 1.0);
            if self.average_force {
                let half = load.map(|v| v.map(|x| 0.5 * x));
                for k in 0..2 {
                    load[k] = half[k];
                    add_scaled(&mut load[k], carried[k], 1.0);
                }
                *carried = half;
                add_scaled(&mut self.balance.carried, half[0], 1.0);
            }
            add_scaled(&mut self.balance.delivered, load[0], 1.0);
        }
        add_scaled(&mut self.balance.gaps, body.pressed[0], 1.0);
        add_scaled(&mut self.balance.images, sum, 1.0);
        add_scaled(&mut self.balance.images, exchange.force, -1.0);
        add_scaled(&mut self.balance.images, body.pressed[0], -1.0);
        add_scaled(&mut self.balance.images, exchange.image, 1.0);
        self.lift_facets(place, mirrors, copies, shape);
    }

    /// Adds the hydrostatic pressure and the mean pressure gradient, which the lattice does not carry:
    /// their pressure is linear, zero at the middle of the surface's volume, and exact on flat facets.
    fn lift_facets(&mut self, place: usize, mirrors: [bool; 3], copies: f64, shape: &mut Shape) {
        let (body, grid, cell) = (&self.bodies.living[place], &self.layout.grid, self.units.cell);
        if self.lift == [0.0; 3] {
            return;
        }
        let middle = body.middle();
        let from = body.position;
        for facet in 0..shape.loads.len() {
            let corners = shape.corners(facet).map(|corner| corner.map(|x| x / cell));
            let centre: [f64; 3] =
                std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0);
            let is_beyond = (0..3).any(|a| {
                let x = from[a] + centre[a];
                mirrors[a] && !(0.0..=f64::from(grid.n[a])).contains(&x)
            });
            if is_beyond {
                continue;
            }
            let edge = |k: usize| std::array::from_fn(|a| corners[k][a] - corners[0][a]);
            let area = cross(edge(1), edge(2));
            let above = std::array::from_fn(|a| centre[a] - middle[a]);
            let scale = 0.5 * copies * dot(self.lift, above);
            let force = area.map(|x| x * scale);
            add_scaled(&mut self.balance.buoyancy, force, 1.0);
            add_scaled(&mut shape.loads[facet][0], force, 1.0);
            add_scaled(&mut shape.loads[facet][1], cross(centre, force), 1.0);
        }
    }

    /// See [`crate::FluidLbm::surface_loads`].
    pub fn surface_loads(&self, loads: &mut [FacetLoad]) {
        let bodies = &self.bodies.living[self.bodies.rigid()..];
        let shapes = bodies.iter().filter_map(|body| {
            let part = body.part.as_ref()?;
            Some((part.shape.as_ref()?, part.reference()))
        });
        let facets = shapes.flat_map(|(shape, reference)| {
            (0..shape.loads.len()).map(move |facet| (shape, reference, facet))
        });
        for ((number, load), (shape, reference, facet)) in (0..).zip(loads).zip(facets) {
            let [force, torque] = shape.loads[facet];
            let corners = shape.corners(facet).map(|corner| corner.map(|x| x / self.units.cell));
            let point = acting_at(corners, force, torque);
            let world = |a: usize| self.units.min[a] + (reference[a] + point[a]) * self.units.cell;
            *load = FacetLoad {
                facet: number,
                force: force.map(|f| f * self.units.force()),
                point: std::array::from_fn(world),
                stiffness: 0.0,
            };
        }
    }
}

/// The point of a force's line of action that is nearest to the middle of a facet, no farther from it
/// than its corners are: a force that almost cancels acts far away.
fn acting_at(corners: [[f64; 3]; 3], force: [f64; 3], torque: [f64; 3]) -> [f64; 3] {
    let centre: [f64; 3] =
        std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0);
    let about = cross(centre, force);
    let about = std::array::from_fn(|a| torque[a] - about[a]);
    let square = dot(force, force);
    if square == 0.0 {
        return centre;
    }
    let away = cross(force, about).map(|x| x / square);
    let reach = corners.iter().map(|corner| {
        let to: [f64; 3] = std::array::from_fn(|a| corner[a] - centre[a]);
        dot(to, to)
    });
    let (reach, length) = (reach.fold(0.0, f64::max).sqrt(), dot(away, away).sqrt());
    let scale = if length > reach { reach / length } else { 1.0 };
    std::array::from_fn(|a| centre[a] + scale * away[a])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_acts_on_its_line_near_the_facet() {
        let corners = [[0.0, 0.0, 5.0], [3.0, 0.0, 5.0], [0.0, 3.0, 5.0]];
        let (force, at) = ([0.0, 0.0, -2.0], [1.5, 0.5, 5.0]);
        let point = acting_at(corners, force, cross(at, force));
        assert!((0..3).all(|a| (point[a] - at[a]).abs() < 1e-12), "{point:?}");
        // A pair of forces that leaves next to nothing.
        let far = acting_at(corners, [0.0, 0.0, 1e-9], [1.0, 0.0, 0.0]);
        assert!((0..3).all(|a| (far[a] - [1.0, 1.0, 5.0][a]).abs() < 2.3), "{far:?}");
        assert_eq!(acting_at(corners, [0.0; 3], [1.0; 3]), [1.0, 1.0, 5.0]);
    }
}
