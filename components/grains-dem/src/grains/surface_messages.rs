//! The deformable surfaces of a scene, between messages and solver.

use crate::Vec3;
use crate::bodies::deformable_surface::mean_edge;
use crate::bodies::deformable_surface::{DeformableSurface, FacetLoad, SurfaceState};
use crate::bodies::placed_parts;
use crate::math::error::GrainsError;
use crate::solver::dem_solver::GrainsDem;
use core::ops::Range;
use tremie_geometry::{Frame, Turned};
use tremie_grains_kit::space::plane_walls;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_sdk::messages::scene::{self, Motion, Scene};
use tremie_sdk::messages::{self, Load, Problem, SurfaceVertex};

/// The surfaces of a run, with room for messages.
#[derive(Clone, Debug, Default)]
pub(crate) struct Carried {
    /// Vertices of each surface among all, and the number of its first facet.
    ranges: Vec<(Range<usize>, u64)>,
    vertices: Vec<[f64; 3]>,
    velocities: Vec<[f64; 3]>,
    loads: Vec<FacetLoad>,
}

/// The surfaces of a scene as the solver takes them.
///
/// # Errors
/// A surface whose carrier is no slider.
pub(crate) fn surfaces(scene: &Scene) -> Result<Vec<DeformableSurface>, Vec<Problem>> {
    let (mut surfaces, mut problems) = (Vec::new(), Vec::new());
    for (i, surface) in scene.surfaces.iter().enumerate() {
        match deformable(scene, surface) {
            Some(surface) => surfaces.push(surface),
            None => {
                let message =
                    format!("the part \"{}\" does not slide, found in its motion", surface.carrier);
                let help = "give the part motion = { slider = { .. } }: these grains hand what acts on a surface to sliders alone";
                let key = format!("scene.surfaces[{i}].carrier");
                problems.push(Problem::new(key, message).help(help));
            }
        }
    }
    if problems.is_empty() { Ok(surfaces) } else { Err(problems) }
}

fn deformable(scene: &Scene, surface: &scene::DeformableSurface) -> Option<DeformableSurface> {
    let carrier = scene.parts.iter().position(|part| part.name == surface.carrier)?;
    let part = &scene.parts[carrier];
    let Motion::Slider(_) = part.motion else { return None };
    let turned = Turned::of(surface);
    let (outer, inner) = (Frame::of(&part.pose), Frame::of(&surface.pose));
    let place = |x| outer.to_world(inner.to_world(x)).into();
    Some(DeformableSurface {
        vertices: turned.places(surface.start_points()).into_iter().map(place).collect(),
        triangles: turned.triangles,
        carrier,
        material: surface.material.clone(),
        seat_stiffness: surface.seat_stiffness,
    })
}

/// Checks that no surface begins deep in its seat: walls, and parts that stand still.
///
/// # Errors
/// A problem for each that does, and parts that cannot be had.
pub(crate) fn check_start(
    scene: &Scene,
    surfaces: &[DeformableSurface],
) -> Result<(), Vec<Problem>> {
    if surfaces.is_empty() {
        return Ok(());
    }
    let (parts, walls) = (placed_parts::load(scene)?, plane_walls::without_mirrors(scene));
    let depth = |&x: &[f64; 3]| {
        let x = Vec3::from(x);
        let walls = walls.iter().map(|wall| wall.offset - x.dot(&wall.normal));
        let near = parts.iter().filter(|part| !part.moves() && part.shape.is_near(x, 0.0));
        walls.chain(near.map(|part| -part.clearance(x).0)).fold(0.0, f64::max)
    };
    let problem = |(k, surface): (usize, &DeformableSurface)| {
        let deepest = surface.vertices.iter().map(depth).fold(0.0, f64::max);
        let most = DEEP * mean_edge(surface);
        let message = format!(
            "begins {deepest:.3e} m deep in its seat, expected at most {most:.1e} m, a tenth of its mean edge"
        );
        let help = "let it begin as compressed as it is on its seat (start), or lift its carrier";
        let key = format!("scene.surfaces[{k}].start");
        (deepest > most).then(|| Problem::new(key, message).help(help))
    };
    let problems: Vec<_> = surfaces.iter().enumerate().filter_map(problem).collect();
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// A vertex in its seat by more than this part of the mean edge is there by mistake.
const DEEP: f64 = 0.1;

/// The solver numbers surfaces in a list of its own; a manifest has them in the scene.
pub(crate) fn in_scene(problems: Vec<Problem>) -> Vec<Problem> {
    let of_scene = |mut problem: Problem| {
        if problem.key.starts_with("surfaces") {
            problem.key.insert_str(0, "scene.");
        }
        problem
    };
    problems.into_iter().map(of_scene).collect()
}

impl Carried {
    /// Of the solver's surfaces.
    pub fn new(surfaces: &[DeformableSurface]) -> Self {
        let (mut vertex, mut facet) = (0, 0);
        let range = |surface: &DeformableSurface| {
            let first = (vertex, facet);
            vertex += surface.vertices.len();
            facet += surface.triangles.len() as u64;
            (first.0..vertex, first.1)
        };
        let ranges = surfaces.iter().map(range).collect();
        let room = vec![[0.0; 3]; vertex];
        Self { ranges, vertices: room.clone(), velocities: room, loads: Vec::new() }
    }

    /// Contacts on a trial of all surfaces.
    pub fn contacts(
        &mut self,
        grains: &mut GrainsDem,
        vertices: &[SurfaceVertex],
        out: &mut Vec<messages::FacetLoad>,
    ) -> Result<(), GrainsError> {
        self.take(vertices);
        for (surface, (range, first)) in self.ranges.iter().enumerate() {
            let (x, v) = (&self.vertices[range.clone()], &self.velocities[range.clone()]);
            grains.contact_on_surface(surface, x, v, &mut self.loads)?;
            out.extend(self.loads.iter().map(|load| messages::FacetLoad {
                facet: first + u64::from(load.facet),
                force: load.force,
                point: load.point,
                stiffness: load.stiffness,
            }));
        }
        Ok(())
    }

    /// Ends a substep with the accepted surfaces.
    pub fn finish(
        &mut self,
        grains: &mut GrainsDem,
        vertices: &[SurfaceVertex],
        resultants: &[Load],
    ) -> Result<(), GrainsError> {
        self.take(vertices);
        let state = |(range, load): (&Range<usize>, &Load)| SurfaceState {
            vertices: &self.vertices[range.clone()],
            velocities: &self.velocities[range.clone()],
            carrier_force: load.force,
        };
        match (&self.ranges[..], resultants) {
            // The usual case, without a list.
            ([(range, _)], [load]) => grains.finish_substep(&[state((range, load))]),
            (ranges, _) => {
                let ranges = ranges.iter().map(|(range, _)| range);
                let states: Vec<_> = ranges.zip(resultants).map(state).collect();
                grains.finish_substep(&states)
            }
        }
    }

    fn take(&mut self, vertices: &[SurfaceVertex]) {
        let room = self.vertices.iter_mut().zip(&mut self.velocities);
        for ((position, velocity), vertex) in room.zip(vertices) {
            (*position, *velocity) = (vertex.position, vertex.velocity);
        }
    }
}
