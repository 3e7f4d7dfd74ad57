//! Thickness of parts in the fluid, in cells.
//!
//! At points of its surface that the fluid reaches, a part is measured three ways: inward along the
//! normal to where fluid is again, and, half-way in, the shortest way across that and the way
//! square to both. Sorted, these say what it is there: of a plate the first is small, of a rod the
//! first two, of a ball all three. A flow around it is that of its outline if the second is
//! resolved, as the diameter of a sphere has to be; a plate need only be seen. So an edge of a
//! plate, or a part that others stand flush to, is not mistaken for a thin one. Rare places of a
//! surface, a tip or a bevel, are not counted. A part that stands free has its own widths besides:
//! the faces of a tetrahedron are not opposite anywhere.

use crate::cells::vector::{cross, dot};
use crate::survey::solids::start_frame;
use crate::survey::static_geometry::StaticGeometry;
use serde::{Deserialize, Serialize};
use tremie_geometry::{Frame, Surface, principal};
use tremie_messages::scene::{Motion, PartBoundary, Scene};

/// Largest thickness that is measured [cells].
const REACH: f64 = 16.0;
/// Part of a surface in the fluid below which a place is rare.
const RARE: f64 = 0.05;
/// Points of all parts together, about: a file may have millions of triangles.
const POINTS: usize = 20_000;
/// Points on a side of a large triangle.
const SIDE: usize = 8;
/// Directions across the normal that are tried, over half a turn.
const AROUND: usize = 6;
/// Two faces that are turned away from being opposite by more than this cosine make a wedge or a
/// corner, not a wall. The sides of a pentagon are walls yet.
const OPPOSITE: f64 = 0.8;
/// Part of a surface in the fluid from which on a part stands free, and is no thicker than its own
/// widths.
const FREE: f64 = 0.95;

/// Thickness of a part in the fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartExtent {
    /// Its name.
    pub part: String,
    /// Its thickness where it is thinnest [cells].
    pub through: f64,
    /// Width across it where it is slimmest, a plate being as wide as it is long [cells]; none
    /// where that is more than 16.
    pub across: Option<f64>,
}

/// A part where it is at the start.
struct PlacedExtent<'a> {
    surface: &'a Surface,
    frame: Frame,
}

/// Of one point: its share of the surface, and the three ways, sorted; infinite where they are
/// longer than is looked at.
struct Sample {
    area: f64,
    ways: [f64; 3],
}

/// The parts that are thinner somewhere than is looked at, by their place in the scene. Cavities
/// have no thickness, and what lets fluid in or out no outline.
pub fn thin_parts(scene: &Scene, ground: &StaticGeometry) -> Vec<PartExtent> {
    let mut surfaces: Vec<(usize, &Surface)> = ground.part_surfaces().collect();
    surfaces.sort_by_key(|(index, _)| *index);
    let placed: Vec<(usize, PlacedExtent<'_>)> = surfaces
        .into_iter()
        .map(|(index, surface)| {
            let frame = start_frame(&scene.parts[index], surface);
            (index, PlacedExtent { surface, frame })
        })
        .collect();
    let each = (POINTS / placed.len().max(1)).max(100);
    let of = |k: usize| {
        let (index, own) = &placed[k];
        let part = &scene.parts[*index];
        let others = placed.iter().enumerate().filter(|(other, (index, _))| {
            *other != k && scene.parts[*index].motion != Motion::Fixed
        });
        let others: Vec<&PlacedExtent<'_>> = others.map(|(_, (_, other))| other).collect();
        let is_body = !part.cavity && part.boundary == PartBoundary::Wall;
        let (through, across) = is_body.then(|| own.measured(ground, &others, each)).flatten()?;
        Some(PartExtent { part: part.name.clone(), through, across })
    };
    (0..placed.len()).filter_map(of).collect()
}

impl PlacedExtent<'_> {
    /// Its thickness, and what it is across, in cells.
    fn measured(
        &self,
        ground: &StaticGeometry,
        others: &[&Self],
        most: usize,
    ) -> Option<(f64, Option<f64>)> {
        let (samples, whole) = self.samples(ground, others, most);
        let all: f64 = samples.iter().map(|sample| sample.area).sum();
        let stands_free = all > 0.0 && all >= FREE * whole;
        let widths =
            if stands_free { self.widths(ground.centres().cell) } else { [f64::INFINITY; 2] };
        let least = |k: usize| {
            let mut ways: Vec<(f64, f64)> =
                samples.iter().map(|sample| (sample.ways[k], sample.area)).collect();
            ways.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut seen = 0.0;
            let found = ways.into_iter().find(|(_, area)| {
                seen += area;
                seen >= RARE * all
            });
            let way = found.map_or(f64::INFINITY, |(way, _)| way).min(widths[k]);
            (way <= REACH).then(|| rounded(way))
        };
        Some((least(0)?, least(1)))
    }

    /// The least and the middle one of its widths, along the axes of its frame or of its inertia
    /// [cells].
    fn widths(&self, cell: f64) -> [f64; 2] {
        let own = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let (_, turned) = principal(&self.surface.mesh().moments().inertia);
        let sorted = [own, turned.map(<[f64; 3]>::from)].map(|axes| {
            let mut widths = axes.map(|axis| self.surface.width_along(axis) / cell);
            widths.sort_by(f64::total_cmp);
            widths
        });
        std::array::from_fn(|k| sorted[0][k].min(sorted[1][k]))
    }

    /// Samples at points of its surface in the fluid, and the area of all its surface that was
    /// looked at [m²].
    fn samples(
        &self,
        ground: &StaticGeometry,
        others: &[&Self],
        most: usize,
    ) -> (Vec<Sample>, f64) {
        let cell = ground.centres().cell;
        let mesh = self.surface.mesh();
        let count =
            (0..mesh.triangles.len()).take_while(|&t| self.surface.is_wall(t as u32)).count();
        let stride = count.div_ceil(most).max(1);
        let (mut samples, mut whole) = (Vec::new(), 0.0);
        for triangle in (0..count).step_by(stride) {
            let corners = mesh.corners(triangle).map(<[f64; 3]>::from);
            let [ab, ac] = [1, 2].map(|k| minus(corners[k], corners[0]));
            let area = 0.5 * length(cross(ab, ac));
            whole += area;
            let longest = length(ab).max(length(ac)).max(length(minus(ab, ac)));
            let fits = ((most / count.div_ceil(stride)) as f64).sqrt() as usize;
            let n = ((longest / (4.0 * cell)).ceil() as usize).clamp(1, SIDE.min(fits.max(1)));
            // The middles of n² triangles alike.
            for i in 0..n {
                for j in 0..2 * (n - i) - 1 {
                    let up = j % 2 == 0;
                    let third = if up { 1.0 / 3.0 } else { 2.0 / 3.0 };
                    let [s, t] = [i, j / 2].map(|k| (k as f64 + third) / n as f64);
                    let point = std::array::from_fn(|k| corners[0][k] + s * ab[k] + t * ac[k]);
                    let normal = self.surface.normal(triangle as u32);
                    let ways = self.ways(ground, others, point, normal.into());
                    let area = area / (n * n) as f64;
                    samples.extend(ways.map(|ways| Sample { area, ways }));
                }
            }
        }
        (samples, whole)
    }

    /// The three ways at a point of the surface, in its frame [cells], if there is fluid.
    fn ways(
        &self,
        ground: &StaticGeometry,
        others: &[&Self],
        point: [f64; 3],
        normal: [f64; 3],
    ) -> Option<[f64; 3]> {
        let cell = ground.centres().cell;
        let is_open = |at, out| self.is_open(ground, others, at, out);
        if length(normal) == 0.0 || !is_open(point, normal) {
            return None;
        }
        // A hair inward, not to meet the face itself.
        let hair = 1e-6 * cell;
        let start = along(point, normal, -hair);
        let inward = normal.map(|n| -n);
        let reach = REACH * cell;
        let far = [f64::INFINITY; 3];
        let Some((t, face)) = self.exit(start, inward, reach) else { return Some(far) };
        if dot(face, normal) > -OPPOSITE || !is_open(along(start, inward, t), inward) {
            return Some(far);
        }
        let middle = along(start, inward, 0.5 * t);
        let way = |direction: [f64; 3]| {
            let ends = [direction, direction.map(|x| -x)].map(|out| {
                let (t, face) = self.exit(middle, out, reach)?;
                is_open(along(middle, out, t), out).then_some((t, face))
            });
            let [Some((a, here)), Some((b, there))] = ends else { return f64::INFINITY };
            let opposite = dot(here, there) <= -OPPOSITE;
            if opposite && a + b <= reach { a + b } else { f64::INFINITY }
        };
        let (u, v) = across(normal);
        // Every 30 degrees.
        let high = 0.75f64.sqrt();
        let turns = [[1.0, 0.0], [high, 0.5], [0.5, high], [0.0, 1.0], [-0.5, high], [-high, 0.5]];
        let direction = |k: usize| {
            let [c, s] = turns[k];
            std::array::from_fn(|a| c * u[a] + s * v[a])
        };
        let found: Vec<f64> = (0..AROUND).map(|k| way(direction(k))).collect();
        let best = (0..AROUND).fold(0, |b, k| if found[k] < found[b] { k } else { b });
        let mut ways =
            [t + hair, found[best], found[(best + AROUND / 2) % AROUND]].map(|way| way / cell);
        ways.sort_by(f64::total_cmp);
        Some(ways)
    }

    /// Distance at which a way from inside leaves the part, within `reach`, and the normal there.
    fn exit(&self, from: [f64; 3], out: [f64; 3], reach: f64) -> Option<(f64, [f64; 3])> {
        let crossing = self.surface.first_crossing(from, along(from, out, reach))?;
        Some((crossing.fraction * reach, self.surface.normal(crossing.triangle).into()))
    }

    /// True if fluid is beyond a point of the surface, in its frame, half a cell or a whole one
    /// away.
    fn is_open(
        &self,
        ground: &StaticGeometry,
        others: &[&Self],
        at: [f64; 3],
        out: [f64; 3],
    ) -> bool {
        let cell = ground.centres().cell;
        [0.5, 1.0].into_iter().any(|step| {
            let place = self.frame.to_world(along(at, out, step * cell));
            let is_free = |other: &&Self| !other.surface.contains(other.frame.to_part(place));
            ground.is_fluid_at(place.into()) && others.iter().all(is_free)
        })
    }
}

/// A number of cells without the rounding of what it was found from: eight cells are not less than
/// eight.
pub fn rounded(cells: f64) -> f64 {
    (cells * 1e6).round() / 1e6
}

/// Two directions square to a unit vector and to each other.
fn across(n: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let least = (0..3).fold(0, |b, k| if n[k].abs() < n[b].abs() { k } else { b });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let u = cross(n, axis);
    let u = u.map(|x| x / length(u));
    (u, cross(n, u))
}

fn along(from: [f64; 3], direction: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|a| from[a] + by * direction[a])
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{Domain, Face, FluidMaterial, Geometry, Part, Pose};

    /// A box of 40 cells of 1 m between walls, along z periodic, with parts.
    fn found(parts: Vec<Part>) -> Vec<PartExtent> {
        let wall = || [Face::WALL, Face::WALL];
        let faces = [wall(), wall(), [Face::Periodic, Face::Periodic]];
        let fluid = FluidMaterial::at_rest(1.0, 0.1);
        let domain = Domain::new([0.0; 3], [40.0; 3], faces);
        let scene = Scene { fluid: Some(fluid), parts, ..Scene::empty(domain) };
        thin_parts(&scene, &StaticGeometry::in_unit_cells(&scene))
    }

    fn part(geometry: Geometry, position: [f64; 3]) -> Part {
        Part {
            name: "part".into(),
            geometry,
            pose: Pose { position, ..Pose::IDENTITY },
            cavity: false,
            material: "wall".into(),
            motion: Motion::Fixed,
            boundary: PartBoundary::Wall,
        }
    }

    fn cuboid(size: [f64; 3], position: [f64; 3]) -> Part {
        part(Geometry::Box { size }, position)
    }

    const MIDDLE: [f64; 3] = [20.2, 20.1, 20.3];

    #[test]
    fn a_plate_a_rod_and_a_ball_are_told_apart() {
        let only = |part: Part| {
            let all = found(vec![part]);
            assert_eq!(all.len(), 1, "{all:?}");
            (all[0].through, all[0].across)
        };
        let near = |found: Option<f64>, wanted: f64| {
            (found.unwrap_or(f64::INFINITY) / wanted - 1.0).abs() < 0.04
        };
        let (through, across) = only(cuboid([30.0, 1.5, 30.0], MIDDLE));
        assert!(near(Some(through), 1.5) && across.is_none(), "{through} {across:?}");
        // A rod, endless or not, square or round.
        for length in [20.0, 90.0] {
            let (through, across) = only(cuboid([0.8, 0.9, length], MIDDLE));
            assert!(near(Some(through), 0.8) && near(across, 0.9), "{through} {across:?}");
            let (through, across) = only(part(Geometry::Cylinder { radius: 2.0, length }, MIDDLE));
            assert!(near(Some(through), 4.0) && near(across, 4.0), "{through} {across:?}");
        }
        for radius in [0.4, 3.0] {
            let (through, across) = only(part(Geometry::Sphere { radius }, MIDDLE));
            assert!(near(Some(through), 2.0 * radius) && near(across, 2.0 * radius));
        }
        // A flat disc is as wide as its diameter. A chord whose ends are no more than 37 degrees
        // from opposite is a way across as well: no less than 0.948 of it.
        let (through, across) = only(part(Geometry::Cylinder { radius: 5.0, length: 1.0 }, MIDDLE));
        assert_eq!(through, 1.0);
        assert!(across.is_some_and(|across| (9.48..=10.0).contains(&across)), "{across:?}");
        // A tip has no faces that are opposite: 0.9 across its base, 0.9 high.
        let profile = vec![[0.0, 0.0], [0.45, 0.0], [0.0, 0.9]];
        let (through, across) = only(part(Geometry::Revolved { profile }, MIDDLE));
        assert!(through < 0.95 && near(across, 0.9), "{through} {across:?}");
        // A moving one alike.
        let mut moving = part(Geometry::Sphere { radius: 0.4 }, MIDDLE);
        moving.motion = Motion::Prescribed(Vec::new());
        assert!(near(only(moving).1, 0.8));
    }

    #[test]
    fn what_is_thick_with_others_or_thin_elsewhere_is_not_thin() {
        // A block.
        assert_eq!(found(vec![cuboid([20.0; 3], MIDDLE)]), []);
        // Slices that stand flush make one.
        let slice = |k: u32| cuboid([2.0, 20.0, 20.0], [11.0 + 2.0 * f64::from(k), 20.1, 20.3]);
        let slices = found((0..10).map(slice).collect());
        assert!(slices.iter().all(|slice| slice.through > 15.0), "{slices:?}");
        // A sheet on the floor: fluid is on one side only.
        assert_eq!(found(vec![cuboid([40.0, 0.8, 40.0], [20.0, 0.4, 20.0])]), []);
        // A slab outside of the domain, one that is half in a wall, and a rib that stands on it.
        assert_eq!(found(vec![cuboid([60.0, 0.8, 60.0], [20.0, -0.4, 20.0])]), []);
        assert_eq!(found(vec![cuboid([60.0, 0.8, 60.0], [20.0, 0.0, 20.0])]), []);
        let rib = found(vec![cuboid([30.0, 9.0, 30.0], [20.0, 0.0, 20.0])]);
        assert!(rib.iter().all(|part| part.through > 8.0), "{rib:?}");
        // A pin that is thick in the domain, and thin beyond its face.
        let profile =
            vec![[0.0, -30.0], [0.3, -30.0], [0.3, -11.0], [9.0, -11.0], [9.0, 5.0], [0.0, 5.0]];
        let mut pin = part(Geometry::Revolved { profile }, [9.5, 20.0, 20.0]);
        let half = 0.5f64.sqrt();
        pin.pose.orientation = [0.0, half, 0.0, half];
        assert_eq!(found(vec![pin]), []);
        // A wedge is thin at its edge only.
        let profile = vec![[0.0, -8.0], [9.0, 0.0], [0.0, 8.0]];
        let wedge = found(vec![part(Geometry::Revolved { profile }, MIDDLE)]);
        assert!(wedge.iter().all(|part| part.through > 4.0), "{wedge:?}");
        // The hollow of a cavity is no part.
        let mut tube = part(Geometry::Cylinder { radius: 1.0, length: 30.0 }, MIDDLE);
        tube.cavity = true;
        assert_eq!(found(vec![tube]), []);
    }
}
