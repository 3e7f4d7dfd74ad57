//! What pushes the vertices of a surface that deforms: walls, and parts that stand still.
//!
//! A vertex at the depth `d` feels the force `k d sum_f max(0, -a_f.n) n`: k is the stiffness for
//! each area, `a_f` a third of the area of a facet at the vertex times its normal, n the normal of the
//! seat. Over a patch that lies flat on a seat these areas add up to the patch's.

use crate::{
    Vec3,
    mesh_contact::{Triangle, closest_point, distance},
    parts::PlacedPart,
    surface::{DeformableSurface, FacetLoad, area_vectors},
    walls::Wall,
};

/// The vertices of a surface that may touch a seat.
#[derive(Clone, Debug, Default)]
pub(crate) struct Seat {
    /// Stiffness for each area [N/m³].
    stiffness: f64,
    /// `start[v]..start[v + 1]` are the shares of vertex v.
    start: Vec<u32>,
    /// Facets at a vertex, with a third of their area vectors.
    shares: Vec<(u32, Vec3)>,
    entries: Vec<Entry>,
    /// Triangles of parts near vertices, in the world.
    triangles: Vec<Triangle>,
    room: Vec<u32>,
    /// Energy at the last accepted shape [J].
    pub energy: f64,
}

/// A vertex near a wall or a part.
#[derive(Clone, Copy, Debug)]
struct Entry {
    vertex: u32,
    with: With,
}

#[derive(Clone, Copy, Debug)]
enum With {
    Plane { normal: Vec3, offset: f64 },
    Triangles { first: u32, end: u32 },
}

/// Everything that seats are made of.
#[derive(Clone, Copy)]
pub(crate) struct Seats<'a> {
    pub parts: &'a [PlacedPart],
    /// Walls, mirrors not among them.
    pub walls: &'a [Wall],
}

impl Seat {
    /// Of a surface that is right.
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
        Self { stiffness: surface.seat_stiffness, start: count, shares, ..Self::default() }
    }

    /// Lists the vertices that are closer than `gap` to a seat, or in it.
    pub fn list(&mut self, vertices: &[[f64; 3]], gap: f64, seats: Seats<'_>) {
        self.entries.clear();
        self.triangles.clear();
        for (vertex, &x) in (0..).zip(vertices) {
            let x = Vec3::from(x);
            for wall in seats.walls {
                if x.dot(&wall.normal) - wall.offset < gap {
                    let Wall { normal, offset, .. } = *wall;
                    self.entries.push(Entry { vertex, with: With::Plane { normal, offset } });
                }
            }
            for part in seats.parts.iter().filter(|part| !part.moves() && part.is_near(x, gap)) {
                let clearance = part.clearance(x).0;
                if clearance >= gap {
                    continue;
                }
                let first = self.triangles.len() as u32;
                let reach = gap + (-clearance).max(0.0);
                part.triangles_near(part.to_part(x), reach, &mut self.room);
                let placed = self.room.iter().map(|&triangle| part.placed_triangle(triangle));
                let near = |triangle: &Triangle| distance(x, triangle.corners) < reach;
                self.triangles.extend(placed.filter(near));
                let with = With::Triangles { first, end: self.triangles.len() as u32 };
                self.entries.push(Entry { vertex, with });
            }
        }
    }

    /// Adds the forces on facets; gives the energy [J].
    pub fn push(&self, vertices: &[[f64; 3]], out: &mut Vec<FacetLoad>) -> f64 {
        let mut energy = 0.0;
        for entry in &self.entries {
            let x = Vec3::from(vertices[entry.vertex as usize]);
            let touch = match entry.with {
                With::Plane { normal, offset } => Some((offset - x.dot(&normal), normal)),
                With::Triangles { first, end } => {
                    depth(x, &self.triangles[first as usize..end as usize])
                }
            };
            let Some((depth, n)) = touch.filter(|touch| touch.0 > 0.0) else { continue };
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

/// How deep a point lies behind a surface of which the closest triangles are given, and the normal there,
/// out of the solid; none in front of it.
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

    fn quad(a: [f64; 3], u: [f64; 3], v: [f64; 3]) -> [Triangle; 2] {
        let (a, u, v) = (Vec3::from(a), Vec3::from(u), Vec3::from(v));
        let normal = u.cross(&v).normalize();
        let of = |corners| Triangle { corners, normal };
        [of([a, a + u, a + u + v]), of([a, a + u + v, a + v])]
    }

    fn close(found: Option<(f64, Vec3)>, depth: f64, normal: [f64; 3]) {
        let (d, n) = found.unwrap();
        assert!((d - depth).abs() < 1e-14 && (n - Vec3::from(normal)).norm() < 1e-12, "{d} {n}");
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
