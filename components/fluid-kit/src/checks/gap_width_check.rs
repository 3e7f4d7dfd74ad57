//! The narrowest gaps of a scene as it starts: between parts, walls, and listed bodies.

use crate::cells::centres::Centres;
use crate::cells::vector::cross;
use crate::survey::solids::start_frame;
use crate::survey::static_geometry::StaticGeometry;
use serde::{Deserialize, Serialize};
use tremie_geometry::{Bounds, Frame, Surface};
use tremie_messages::scene::{Face, Motion, Placement, Scene};

/// Cells that a gap is looked for across.
const REACH: f64 = 8.0;
/// Surfaces nearer than this part of a cell are in contact: no gap.
const CONTACT: f64 = 1e-3;
/// Points along the edge of a triangle at most.
const MOST: usize = 256;

/// A gap between two things.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Narrow {
    /// Its width [cells].
    pub cells: f64,
    /// Its middle [m].
    pub place: [f64; 3],
    /// Names of the two things.
    pub between: [String; 2],
}

/// The surface of a part where it is at the start.
struct PlacedSurface<'a> {
    name: &'a str,
    surface: &'a Surface,
    frame: Frame,
    bounds: Bounds,
}

/// A sphere that the scene lists.
struct ListedSurface<'a> {
    set: &'a str,
    position: [f64; 3],
    radius: f64,
}

/// The narrowest gap found so far [m], of those within reach.
struct Search {
    cell: f64,
    width: f64,
    found: Option<Narrow>,
}

impl Search {
    fn new(cell: f64) -> Self {
        Self { cell, width: REACH * cell, found: None }
    }

    /// Takes a gap over if it is one, and narrower.
    fn offer(&mut self, ends: [[f64; 3]; 2], between: [&str; 2]) {
        let width = length(minus(ends[1], ends[0]));
        if width > CONTACT * self.cell && width < self.width {
            self.width = width;
            self.found = Some(Narrow {
                cells: width / self.cell,
                place: std::array::from_fn(|a| 0.5 * (ends[0][a] + ends[1][a])),
                between: between.map(Into::into),
            });
        }
    }
}

/// The narrowest gap between parts and walls of the domain, and that between listed bodies and
/// anything, if there are any within 8 cells. Surfaces that touch or overlap have no gap.
pub fn narrowest(scene: &Scene, ground: &StaticGeometry) -> [Option<Narrow>; 2] {
    let Centres { cell, .. } = ground.centres();
    let (parts, walls) = (placed(scene, ground), walls(scene));
    let domain = Bounds::of([scene.domain.min, scene.domain.max]);
    let mut fixed = Search::new(cell);
    for (k, part) in parts.iter().enumerate() {
        for other in &parts[k + 1..] {
            let reached = |place| is_reached(ground, place);
            if let Some(ends) = between_parts(part, other, &domain, &reached, fixed.width, cell) {
                fixed.offer(ends, [part.name, other.name]);
            }
        }
        // The space outside a cavity is no fluid.
        for wall in walls.iter().filter(|_| !part.surface.is_cavity()) {
            let vertices = part.surface.mesh().vertices.iter();
            let vertices = vertices.map(|&v| <[f64; 3]>::from(part.frame.to_world(v)));
            let lowest = vertices.min_by(|a, b| wall.height(*a).total_cmp(&wall.height(*b)));
            let ends = lowest.filter(|&v| wall.height(v) > 0.0).map(|v| [v, wall.closest(v)]);
            if let Some(ends) = ends.filter(|&ends| is_reached(ground, middle(ends))) {
                fixed.offer(ends, [part.name, wall.name]);
            }
        }
    }
    let mut of_bodies = Search::new(cell);
    let mut spheres = listed(scene);
    spheres.sort_by(|a, b| (a.position[0] - a.radius).total_cmp(&(b.position[0] - b.radius)));
    for (k, sphere) in spheres.iter().enumerate() {
        let until = sphere.position[0] + sphere.radius;
        let near = spheres[k + 1..]
            .iter()
            .take_while(|other| other.position[0] - other.radius < until + REACH * cell);
        for other in near {
            of_bodies.offer_from(sphere, other.position, other.radius, [sphere.set, other.set]);
        }
        for wall in walls.iter().filter(|wall| wall.height(sphere.position) > 0.0) {
            let to = wall.closest(sphere.position);
            of_bodies.offer_from(sphere, to, 0.0, [sphere.set, wall.name]);
        }
        for part in &parts {
            let reach = sphere.radius + of_bodies.width;
            let centre = part.frame.to_part(sphere.position);
            if let Some(closest) = part.surface.closest_within(centre, reach)
                && closest.distance > 0.0
            {
                let point = part.frame.to_world(closest.point);
                of_bodies.offer_from(sphere, point.into(), 0.0, [sphere.set, part.name]);
            }
        }
    }
    [fixed.found, of_bodies.found]
}

impl Search {
    /// Takes over the gap between a sphere and another, or a point.
    fn offer_from(
        &mut self,
        sphere: &ListedSurface,
        to: [f64; 3],
        radius: f64,
        between: [&str; 2],
    ) {
        let d = minus(to, sphere.position);
        let distance = length(d);
        if distance > sphere.radius + radius {
            let at =
                |along: f64| std::array::from_fn(|a| sphere.position[a] + along / distance * d[a]);
            self.offer([at(sphere.radius), at(distance - radius)], between);
        }
    }
}

/// The parts where they are at the start.
fn placed<'a>(scene: &'a Scene, ground: &'a StaticGeometry) -> Vec<PlacedSurface<'a>> {
    let of = |(index, surface): (usize, &'a Surface)| {
        let part = &scene.parts[index];
        let frame = start_frame(part, surface);
        let bounds = Bounds::of(surface.mesh().vertices.iter().map(|&v| frame.to_world(v)));
        PlacedSurface { name: &part.name, surface, frame, bounds }
    };
    ground.part_surfaces().map(of).collect()
}

/// The spheres that the scene lists.
fn listed(scene: &Scene) -> Vec<ListedSurface<'_>> {
    let sets = scene.bodies.iter().filter(|set| set.motion != Motion::Fixed);
    sets.flat_map(|set| {
        let spheres = match &set.placement {
            Placement::Listed(spheres) => spheres.as_slice(),
            Placement::Packed(_) | Placement::Polyhedra(_) => &[],
        };
        spheres.iter().map(|sphere| ListedSurface {
            set: &set.name,
            position: sphere.position,
            radius: 0.5 * sphere.diameter,
        })
    })
    .collect()
}

/// A wall of the domain.
struct CheckedWall {
    axis: usize,
    side: usize,
    /// Coordinate of the face along the axis [m].
    at: f64,
    name: &'static str,
}

impl CheckedWall {
    /// Distance of a point inside of it [m].
    fn height(&self, point: [f64; 3]) -> f64 {
        [1.0, -1.0][self.side] * (point[self.axis] - self.at)
    }

    /// The point closest to another.
    fn closest(&self, mut point: [f64; 3]) -> [f64; 3] {
        point[self.axis] = self.at;
        point
    }
}

/// The walls of the domain.
fn walls(scene: &Scene) -> Vec<CheckedWall> {
    const NAMES: [[&str; 2]; 3] = [
        ["the lower x face", "the upper x face"],
        ["the lower y face", "the upper y face"],
        ["the lower z face", "the upper z face"],
    ];
    let domain = &scene.domain;
    let all = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    all.filter(|&(axis, side)| matches!(domain.faces[axis][side], Face::Wall { .. }))
        .map(|(axis, side)| CheckedWall {
            axis,
            side,
            at: [domain.min, domain.max][side][axis],
            name: NAMES[axis][side],
        })
        .collect()
}

fn middle([a, b]: [[f64; 3]; 2]) -> [f64; 3] {
    std::array::from_fn(|k| 0.5 * (a[k] + b[k]))
}

/// Cells around a gap among which one must be fluid for the fluid to reach the gap.
const NEAR: i32 = 2;

/// True if there is fluid at a place, or within two cells of it: a narrow gap holds no cell itself.
fn is_reached(ground: &StaticGeometry, place: [f64; 3]) -> bool {
    let Centres { cell, min } = ground.centres();
    let at: [i32; 3] = std::array::from_fn(|a| ((place[a] - min[a]) / cell).floor() as i32);
    let around = || -NEAR..=NEAR;
    around().any(|z| {
        around().any(|y| {
            around().any(|x| {
                let at = [at[0] + x, at[1] + y, at[2] + z];
                ground.grid.contains(at) && ground.voxels.is_fluid(&ground.grid, at)
            })
        })
    })
}

/// The two ends of the narrowest place between two parts, if it is narrower than `width`. `None` if
/// they touch.
///
/// Points of one surface two cells apart and less, and from those that may come closest on by going
/// to the closest point of the other surface and back; within the domain, outside of which parts
/// may meet, and where `reached` says that there is fluid.
fn between_parts(
    a: &PlacedSurface,
    b: &PlacedSurface,
    domain: &Bounds,
    reached: &dyn Fn([f64; 3]) -> bool,
    width: f64,
    cell: f64,
) -> Option<[[f64; 3]; 2]> {
    if !a.bounds.grown(width).meets(&b.bounds) {
        return None;
    }
    let spacing = 2.0 * cell;
    // From points farther than `slack` beyond the best, others lead to the same place.
    let (mut best, mut ends, slack) = (width, None, 0.25 * spacing);
    let mesh = a.surface.mesh();
    for triangle in 0..mesh.triangles.len() {
        let corners = mesh.corners(triangle).map(|corner| a.frame.to_world(corner).into());
        if !Bounds::of(corners).grown(best + spacing).meets(&b.bounds) {
            continue;
        }
        for point in points(corners, spacing).filter(|&point| domain.contains(point)) {
            let near = b.surface.closest_within(b.frame.to_part(point), best + slack);
            let Some(near) = near else { continue };
            if near.distance <= CONTACT * cell {
                return None;
            }
            let (from, to) = settle(a, b, b.frame.to_world(near.point).into());
            let found = length(minus(to, from));
            if found <= CONTACT * cell {
                return None;
            }
            let is_inside = domain.contains(from) && domain.contains(to);
            if found < best && is_inside && reached(middle([from, to])) {
                (best, ends) = (found, Some([from, to]));
            }
        }
    }
    ends
}

/// From a point of `b` to the closest of `a` and back, until that hardly changes.
fn settle(a: &PlacedSurface, b: &PlacedSurface, mut to: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    let closest = |part: &PlacedSurface, point: [f64; 3]| {
        part.frame.to_world(part.surface.closest(part.frame.to_part(point)).point).into()
    };
    let mut from = closest(a, to);
    let mut width = length(minus(to, from));
    for _ in 0..20 {
        to = closest(b, from);
        from = closest(a, to);
        let next = length(minus(to, from));
        if next > 0.9999 * width {
            break;
        }
        width = next;
    }
    (from, to)
}

/// Points of a triangle at most `spacing` apart, its corners among them: rows along its longest
/// edge.
fn points(corners: [[f64; 3]; 3], spacing: f64) -> impl Iterator<Item = [f64; 3]> {
    let edge = |k: usize| minus(corners[(k + 1) % 3], corners[k]);
    let longest = (0..3).max_by(|&a, &b| length(edge(a)).total_cmp(&length(edge(b)))).unwrap_or(0);
    let [p, q, r] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    let base = length(minus(q, p));
    let height = length(cross(minus(q, p), minus(r, p))) / base.max(f64::MIN_POSITIVE);
    let steps = move |x: f64| ((x / spacing).ceil() as usize).clamp(1, MOST);
    let rows = steps(height);
    (0..=rows).flat_map(move |j| {
        let t = j as f64 / rows as f64;
        let along = if j == rows { 0 } else { steps((1.0 - t) * base) };
        (0..=along).map(move |i| {
            let s = (1.0 - t) * i as f64 / along.max(1) as f64;
            std::array::from_fn(|a| p[a] + s * (q[a] - p[a]) + t * (r[a] - p[a]))
        })
    })
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn length(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{
        BodySet, Domain, FluidMaterial, Geometry, Part, PartBoundary, Pose, Sphere,
    };

    fn part(name: &str, geometry: Geometry, position: [f64; 3]) -> Part {
        Part {
            name: name.into(),
            geometry,
            pose: Pose { position, ..Pose::IDENTITY },
            cavity: false,
            material: "steel".into(),
            motion: Motion::Fixed,
            boundary: PartBoundary::Wall,
        }
    }

    fn gaps(parts: Vec<Part>, spheres: &[([f64; 3], f64)]) -> [Option<Narrow>; 2] {
        let spheres = spheres.iter().map(|&(position, diameter)| Sphere {
            position,
            diameter,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        });
        let scene = Scene {
            fluid: Some(FluidMaterial::at_rest(1000.0, 1e-3)),
            parts,
            bodies: vec![BodySet {
                name: "balls".into(),
                density: 2000.0,
                material: "steel".into(),
                motion: Motion::Free,
                clump: None,
                placement: Placement::Listed(spheres.collect()),
            }],
            ..Scene::empty(Domain::new([0.0; 3], [40.0; 3], Face::WALLS))
        };
        narrowest(&scene, &StaticGeometry::in_unit_cells(&scene))
    }

    /// Two crossed bars, edge above edge, 1.7 apart; what touches or is far away counts for
    /// nothing.
    #[test]
    fn the_narrowest_gap_is_found() {
        let bar = Geometry::Box { size: [30.0, 4.0, 4.0] };
        let mut across = part("across", bar.clone(), [20.0, 20.0, 20.0]);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        across.pose.orientation = [0.0, 0.0, half, half];
        let along = part("along", bar, [20.0, 20.0, 25.7]);
        let foot = part("foot", Geometry::Box { size: [4.0, 4.0, 4.0] }, [3.0, 3.0, 2.0]);
        let [gap, none] = gaps(vec![across, along, foot], &[]);
        let gap = gap.unwrap();
        assert!(none.is_none());
        assert!((gap.cells - 1.0).abs() < 1e-9, "{gap:?}");
        assert_eq!(gap.between, ["foot", "the lower x face"].map(String::from));
    }

    /// A shaft in a bore, off its middle: facets make the gap 0.5 % of the radius uncertain.
    #[test]
    fn a_shaft_in_a_bore() {
        let cylinder = |radius, length| Geometry::Cylinder { radius, length };
        let mut bore = part("bore", cylinder(12.0, 100.0), [20.0, 20.0, 20.0]);
        bore.cavity = true;
        let shaft = part("shaft", cylinder(9.0, 120.0), [18.5, 20.0, 20.0]);
        let [gap, _] = gaps(vec![bore, shaft], &[]);
        let gap = gap.unwrap();
        assert!((gap.cells - 1.5).abs() < 0.06, "{gap:?}");
        assert!((gap.place[0] - 8.75).abs() < 0.2, "{gap:?}");
    }

    /// Two boxes 0.5 apart, in a hollow that no way leads to from the fluid, and the same with it.
    #[test]
    fn a_gap_that_no_fluid_reaches_counts_for_nothing() {
        let cube =
            |name: &str, edge: f64, at: [f64; 3]| part(name, Geometry::Box { size: [edge; 3] }, at);
        let wall = |name: &str, z: f64| {
            part(name, Geometry::Box { size: [60.0, 60.0, 4.0] }, [20.0, 20.0, z])
        };
        let pair = [cube("one", 6.0, [12.0, 20.0, 30.0]), cube("other", 6.0, [18.5, 20.0, 30.0])];
        let found = |inside: [f64; 3]| {
            let scene = Scene {
                fluid: Some(FluidMaterial {
                    inside: vec![inside],
                    ..FluidMaterial::at_rest(1000.0, 1e-3)
                }),
                parts: [&[wall("shelf", 16.0)][..], &pair].concat(),
                ..Scene::empty(Domain::new([0.0; 3], [40.0; 3], Face::WALLS))
            };
            let [gap, _] = narrowest(&scene, &StaticGeometry::in_unit_cells(&scene));
            gap
        };
        assert!((found([2.0, 2.0, 30.0]).unwrap().cells - 0.5).abs() < 1e-9);
        assert_eq!(found([2.0, 2.0, 5.0]), None);
    }

    #[test]
    fn bodies_near_anything() {
        let table = part("table", Geometry::Box { size: [9.0, 9.0, 3.0] }, [20.0; 3]);
        let ball = |x: f64, z: f64| ([x, 20.0, z], 5.0);
        let [_, gap] = gaps(vec![table.clone()], &[ball(20.0, 24.4), ball(8.0, 30.0)]);
        let gap = gap.unwrap();
        assert!((gap.cells - 0.4).abs() < 1e-9 && gap.between[1] == "table", "{gap:?}");
        let [_, gap] = gaps(vec![table], &[ball(7.0, 30.0), ball(12.5, 30.0)]);
        let gap = gap.unwrap();
        assert!((gap.cells - 0.5).abs() < 1e-9, "{gap:?}");
        assert!((gap.place[0] - 9.75).abs() < 1e-9, "{gap:?}");
        // Two that touch each other and the floor.
        let [_, gap] = gaps(vec![], &[ball(20.0, 2.5), ball(25.0, 2.5)]);
        assert_eq!(gap, None);
    }
}
