//! Forces of seats on the vertices of a surface that deforms. Seats are walls, and parts that stand
//! still.
//!
//! The force on a vertex at the depth `d` is `k d sum_f max(0, -a_f.n) n`: k is the stiffness for
//! each area, `a_f` a third of the area of a facet at the vertex times its normal, n the normal of
//! the seat. Over a patch that lies flat on a seat these areas add up to the patch's.

use crate::Vec3;
use crate::bodies::deformable_surface::{DeformableSurface, FacetLoad, area_vectors};
use crate::bodies::placed_parts::PlacedPart;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_grains_kit::space::wall_triangle::{Triangle, closest_point, distance};

/// The vertices of a surface that may touch a seat.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seat {
    /// Stiffness for each area [N/m³].
    stiffness: f64,
    /// `start[v]..start[v + 1]` are the shares of vertex v.
    start: Vec<u32>,
    /// Facets at a vertex, with a third of their area vectors.
    shares: Vec<(u32, Vec3)>,
    /// Vertices near planes, with the planes' numbers; how deep each is in its plane, and a zero.
    flat: Vec<(u32, u32)>,
    planes: Vec<SeatPlane>,
    depths: Vec<f64>,
    patches: Vec<Patch>,
    /// For each facet its patch, while patches of a plane are listed; else [`NONE`].
    patch_of: Vec<u32>,
    /// Vertices near what is not flat, and its triangles in the world.
    entries: Vec<Entry>,
    triangles: Vec<Triangle>,
    room: Vec<u32>,
    /// Energy at the last accepted shape [J].
    pub energy: f64,
}

/// A flat seat.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SeatPlane {
    normal: Vec3,
    offset: f64,
}

/// A facet on a flat seat.
#[derive(Clone, Copy, Debug)]
struct Patch {
    facet: u32,
    plane: u32,
    /// Places of its vertices among the depths; that of the zero where one is not near.
    vertices: [u32; 3],
    /// Stiffness of each of its vertices [N/m].
    stiffness: f64,
}

/// A vertex near a part's triangles.
#[derive(Clone, Copy, Debug)]
struct Entry {
    vertex: u32,
    first: u32,
    end: u32,
}

/// Of nothing.
const NONE: u32 = u32::MAX;

/// Everything that seats are made of.
#[derive(Clone, Copy)]
pub(crate) struct Seats<'a> {
    pub parts: &'a [PlacedPart],
    /// Walls, mirrors not among them.
    pub walls: &'a [Wall],
}

impl Seat {
    /// Seat contacts of a valid surface.
    pub fn new(surface: &DeformableSurface) -> Self {
        let mut count = vec![0u32; surface.vertices.len() + 1];
        for v in surface.triangles.iter().flatten() {
            count[*v as usize + 1] += 1;
        }
        for v in 1..count.len() {
            count[v] += count[v - 1];
        }
        let mut next = count.clone();
        let mut shares = vec![(0, Vec3::zeros()); 3 * surface.triangles.len()];
        let facets = (0..).zip(&surface.triangles).zip(area_vectors(surface));
        for ((facet, triangle), area) in facets {
            for &v in triangle {
                let place = &mut next[v as usize];
                shares[*place as usize] = (facet, area / 3.0);
                *place += 1;
            }
        }
        let patch_of = vec![NONE; surface.triangles.len()];
        Self {
            stiffness: surface.seat_stiffness,
            start: count,
            shares,
            patch_of,
            ..Self::default()
        }
    }

    /// Lists the vertices that are closer than `gap` to a seat, or in it.
    pub fn list(&mut self, vertices: &[[f64; 3]], gap: f64, seats: Seats<'_>) {
        self.entries.clear();
        self.triangles.clear();
        self.flat.clear();
        self.planes.clear();
        for (vertex, &x) in (0..).zip(vertices) {
            let x = Vec3::from(x);
            for wall in seats.walls {
                if x.dot(&wall.normal) - wall.offset < gap {
                    let Wall { normal, offset, .. } = *wall;
                    self.list_flat(vertex, SeatPlane { normal, offset });
                }
            }
            for part in
                seats.parts.iter().filter(|part| !part.moves() && part.shape.is_near(x, gap))
            {
                let clearance = part.clearance(x).0;
                if clearance >= gap {
                    continue;
                }
                let first = self.triangles.len() as u32;
                // Inside the solid the closest triangle may be as far away as the depth.
                let reach = gap + (-clearance).max(0.0);
                part.shape.triangles_near(part.shape.to_part(x), reach, &mut self.room);
                let placed = self.room.iter().map(|&triangle| part.shape.placed_triangle(triangle));
                let near = |triangle: &Triangle| distance(x, triangle.corners) < reach;
                self.triangles.extend(placed.filter(near));
                // One plane stands for triangles that all lie on it.
                if let Some(plane) = plane_of(&self.triangles[first as usize..]) {
                    self.triangles.truncate(first as usize);
                    self.list_flat(vertex, plane);
                } else {
                    self.entries.push(Entry { vertex, first, end: self.triangles.len() as u32 });
                }
            }
        }
        self.list_patches();
    }

    /// Lists a vertex near a plane, which may be known.
    fn list_flat(&mut self, vertex: u32, plane: SeatPlane) {
        let near = |known: &SeatPlane| {
            (known.normal - plane.normal).norm_squared() < FLAT * FLAT
                && (known.offset - plane.offset).abs() <= FLAT * plane.offset.abs()
        };
        let known = self.planes.iter().position(near).unwrap_or_else(|| {
            self.planes.push(plane);
            self.planes.len() - 1
        });
        self.flat.push((vertex, known as u32));
    }

    /// Lists the facets of the vertices near planes, as far as they face them.
    fn list_patches(&mut self) {
        let none = self.flat.len() as u32;
        self.depths.clear();
        // One entry more, which stays 0: the depth of corners that are not near the plane.
        self.depths.resize(self.flat.len() + 1, 0.0);
        self.patches.clear();
        for (number, plane) in (0..).zip(&self.planes) {
            let first = self.patches.len();
            let on_it = (0..).zip(&self.flat).filter(|(_, (_, plane))| *plane == number);
            for (place, &(vertex, _)) in on_it {
                let v = vertex as usize;
                let range = self.start[v] as usize..self.start[v + 1] as usize;
                for &(facet, area) in &self.shares[range] {
                    let facing = -area.dot(&plane.normal);
                    if facing <= 0.0 {
                        continue;
                    }
                    let known = &mut self.patch_of[facet as usize];
                    if *known == NONE {
                        *known = self.patches.len() as u32;
                        self.patches.push(Patch {
                            facet,
                            plane: number,
                            vertices: [none; 3],
                            stiffness: self.stiffness * facing,
                        });
                    }
                    let vertices = &mut self.patches[*known as usize].vertices;
                    if let Some(free) = vertices.iter_mut().find(|place| **place == none) {
                        *free = place;
                    }
                }
            }
            // A facet may have one patch with each plane.
            for patch in &self.patches[first..] {
                self.patch_of[patch.facet as usize] = NONE;
            }
        }
    }

    /// Adds the forces on facets; gives the energy [J].
    pub fn push(&mut self, vertices: &[[f64; 3]], out: &mut Vec<FacetLoad>) -> f64 {
        self.push_flat(vertices, out) + self.push_others(vertices, out)
    }

    /// Forces of planes: one for each facet and plane.
    fn push_flat(&mut self, vertices: &[[f64; 3]], out: &mut Vec<FacetLoad>) -> f64 {
        let mut energy = 0.0;
        for (depth, &(vertex, plane)) in self.depths.iter_mut().zip(&self.flat) {
            let SeatPlane { normal, offset } = self.planes[plane as usize];
            *depth = (offset - Vec3::from(vertices[vertex as usize]).dot(&normal)).max(0.0);
        }
        for patch in &self.patches {
            let depths = patch.vertices.map(|place| self.depths[place as usize]);
            let sum = depths[0] + depths[1] + depths[2];
            if sum <= 0.0 {
                continue;
            }
            let (mut point, mut touching) = (Vec3::zeros(), 0.0);
            for (&place, depth) in patch.vertices.iter().zip(depths) {
                if depth > 0.0 {
                    let vertex = self.flat[place as usize].0;
                    point += Vec3::from(vertices[vertex as usize]) * (depth / sum);
                    touching += 1.0;
                    energy += 0.5 * patch.stiffness * depth * depth;
                }
            }
            let force = self.planes[patch.plane as usize].normal * (patch.stiffness * sum);
            out.push(FacetLoad {
                facet: patch.facet,
                force: force.into(),
                point: point.into(),
                stiffness: patch.stiffness * touching,
            });
        }
        energy
    }

    /// Forces of seats that are not flat: one for each vertex of a facet.
    fn push_others(&self, vertices: &[[f64; 3]], out: &mut Vec<FacetLoad>) -> f64 {
        let mut energy = 0.0;
        for entry in &self.entries {
            let x = Vec3::from(vertices[entry.vertex as usize]);
            let near = &self.triangles[entry.first as usize..entry.end as usize];
            let Some((depth, n)) = depth(x, near).filter(|touch| touch.0 > 0.0) else { continue };
            let v = entry.vertex as usize;
            for &(facet, area) in &self.shares[self.start[v] as usize..self.start[v + 1] as usize] {
                let facing = -area.dot(&n);
                if facing > 0.0 {
                    let force = self.stiffness * facing * depth;
                    energy += 0.5 * force * depth;
                    let (force, point) = ((n * force).into(), x.into());
                    let stiffness = self.stiffness * facing;
                    out.push(FacetLoad { facet, force, point, stiffness });
                }
            }
        }
        energy
    }
}

/// The plane of triangles that lie in one; none if they do not. All of a closed surface that is
/// near a point is then that plane: it has no rim there.
fn plane_of(triangles: &[Triangle]) -> Option<SeatPlane> {
    let Triangle { corners: [origin, b, _], normal, .. } = *triangles.first()?;
    let flat = FLAT * (b - origin).norm_squared().sqrt();
    let is_on = |triangle: &Triangle| {
        let mut away = triangle.corners.iter().map(|corner| (corner - origin).dot(&normal).abs());
        triangle.normal.dot(&normal) > 0.0 && away.all(|away| away < flat)
    };
    triangles.iter().all(is_on).then(|| SeatPlane { normal, offset: origin.dot(&normal) })
}

/// Corners that are off a plane by less than this part of an edge's length are on it, and planes
/// that differ by less are one.
const FLAT: f64 = 1e-12;

/// Depth of a point behind the surface of the closest `triangles` [m], with the normal there, out
/// of the solid; `None` in front of the surface.
fn depth(x: Vec3, triangles: &[Triangle]) -> Option<(f64, Vec3)> {
    let (mut closest, mut square, mut outward) = (Vec3::zeros(), f64::INFINITY, Vec3::zeros());
    for triangle in triangles {
        let point = closest_point(x, triangle);
        let distance = (x - point).norm_squared();
        if distance < square * (1.0 - TIE) {
            (closest, square, outward) = (point, distance, triangle.normal);
        } else if distance <= square * (1.0 + TIE) {
            // An edge or a corner: the triangles at it tell together on which side the point is.
            outward += triangle.normal;
        }
    }
    let away = closest - x;
    if away.dot(&outward) <= 0.0 {
        return None;
    }
    let depth = square.sqrt();
    Some((depth, away / depth))
}

/// Squared distances that differ by less are of one point.
const TIE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_grains_kit::space::wall_triangle::Grooves;

    fn quad(a: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [Triangle; 2] {
        let (a, u, v) = (Vec3::from(a), Vec3::from(u), Vec3::from(v));
        let normal = u.cross(&v).normalize();
        let of = |corners| Triangle { corners, normal, grooves: Grooves::NONE };
        [of([a, a + u, a + u + v]), of([a, a + u + v, a + v])]
    }

    fn close(found: Option<(f64, Vec3)>, depth: f64, normal: [f64; 3]) {
        let (d, n) = found.unwrap();
        assert!((d - depth).abs() < 1e-14 && (n - Vec3::from(normal)).norm() < 1e-12, "{d} {n}");
    }

    #[test]
    fn what_is_flat_around_a_point_is_a_plane() {
        let floor = quad([-9.0, -9.0, 0.3], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        let SeatPlane { normal, offset } = plane_of(&floor).unwrap();
        assert!((normal - Vec3::new(0.0, 0.0, 1.0)).norm() < 1e-15 && (offset - 0.3).abs() < 1e-15);
        let wall = quad([-9.0, 9.0, 0.3], [18.0, 0.0, 0.0], [0.0, 0.0, 9.0]);
        assert!(plane_of(&[floor, wall].concat()).is_none());
        // As flat, but a step lower, and the other face of a thin plate.
        let lower = quad([9.0, -9.0, 0.2], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        assert!(plane_of(&[floor, lower].concat()).is_none());
        let back = quad([-9.0, -9.0, 0.3], [0.0, 18.0, 0.0], [18.0, 0.0, 0.0]);
        assert!(plane_of(&[floor, back].concat()).is_none() && plane_of(&[]).is_none());
    }

    #[test]
    fn depth_is_the_way_to_the_closest_point_on_faces_edges_and_corners() {
        let floor = quad([-9.0, -9.0, 0.0], [18.0, 0.0, 0.0], [0.0, 18.0, 0.0]);
        close(depth(Vec3::new(1.0, 1.0, -0.2), &floor), 0.2, [0.0, 0.0, 1.0]);
        assert_eq!(depth(Vec3::new(1.0, 1.0, 0.2), &floor), None);
        // A groove along y: the solid is everything but x > 0, z > 0.
        let groove = [
            quad([0.0, -9.0, 0.0], [9.0, 0.0, 0.0], [0.0, 18.0, 0.0]),
            quad([0.0, -9.0, 0.0], [0.0, 18.0, 0.0], [0.0, 0.0, 9.0]),
        ]
        .concat();
        let root = 0.5f64.sqrt();
        close(depth(Vec3::new(-0.3, 0.1, -0.3), &groove), 0.6 * root, [root, 0.0, root]);
        close(depth(Vec3::new(2.0, 0.1, -0.3), &groove), 0.3, [0.0, 0.0, 1.0]);
        assert_eq!(depth(Vec3::new(0.3, 0.1, 0.4), &groove), None);
        // A ridge: the solid is x < 0, z < 0.
        let ridge = [
            quad([-9.0, -9.0, 0.0], [9.0, 0.0, 0.0], [0.0, 18.0, 0.0]),
            quad([0.0, -9.0, -9.0], [0.0, 18.0, 0.0], [0.0, 0.0, 9.0]),
        ]
        .concat();
        assert_eq!(depth(Vec3::new(0.3, 0.1, 0.3), &ridge), None);
        close(depth(Vec3::new(-0.1, 0.1, -0.3), &ridge), 0.1, [1.0, 0.0, 0.0]);
    }
}
