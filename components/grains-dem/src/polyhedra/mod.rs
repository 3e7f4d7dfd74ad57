//! Convex polyhedra among the bodies.
//!
//! A polyhedron is a body like others: its ball is the sphere around it, by which neighbours are
//! found, and its centroid moves as a sphere's centre does. What is its own stands here: shape,
//! size, angular momentum, and where its corners and faces are in this substep.

mod contact_geometry;
mod contact_list;
mod contact_pair;
mod energy;
mod free_rotation;
mod hidden;
mod overlap;
mod overlap_integrals;
mod overlap_response;
mod shape;
mod surfaces;

pub(crate) use contact_list::{OF_PAIR, PolyContacts, SolidSearch};
pub(crate) use free_rotation::Inertia;
pub(crate) use overlap::{of_bodies, with_part};
pub(crate) use overlap_integrals::OverlapRoom;
pub(crate) use shape::{Shape, to_world, turned_axes};

use crate::Vec3;
use crate::bodies::body_arrays::PlacedSolid;
use crate::bodies::body_arrays::{Bodies, PlacedSphere, Wrench};
use serde::{Deserialize, Serialize};
use shape::Solid;
use tremie_messages::scene::Scene;
use tremie_state::{StateError, StateExchange};
use tremie_team::{Cut, Team};

/// Memory of a polyhedron besides that of a body, with the corners and faces of a dodecahedron
/// [bytes].
pub(crate) const OF_BODY: usize =
    size_of::<Grain>() + size_of::<PlacedSolid>() + 32 * size_of::<Vec3>();

/// Polyhedra that are one item of work.
const TOGETHER: usize = 16;

/// A polyhedron of the run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Grain {
    pub id: u64,
    /// Place of the body in memory.
    pub slot: u32,
    shape: u32,
    size: f64,
    /// Inertia, of a body that forces move by itself.
    inertia: Option<Inertia>,
    orientation: [f64; 4],
    /// Angular momentum: of the full step between substeps, of the half step within one [kg·m²/s].
    momentum: Vec3,
    /// Torque of contacts at the last evaluation [N·m].
    torque: Vec3,
    spin: Vec3,
    predicted: Vec3,
    first_vertex: u32,
    first_normal: u32,
}

/// The polyhedra of a run, by ascending id.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polyhedra {
    shapes: Vec<Shape>,
    grains: Vec<Grain>,
    /// Corners and face normals of all, from the centroids.
    vertices: Vec<Vec3>,
    normals: Vec<Vec3>,
    /// The axis across a plane scene: polyhedra are prisms along it, and stay in the plane.
    across: Option<usize>,
    /// Bounds of each item of work in the vertices and in the normals.
    vertex_bounds: Vec<u32>,
    normal_bounds: Vec<u32>,
}

impl Polyhedra {
    /// Polyhedra of a scene, whose shapes are valid; `placed` by ids, which are their places too.
    pub fn new(scene: &Scene, placed: &[PlacedSphere], team: &mut Team) -> Self {
        let shapes: Vec<Shape> = scene.shapes.iter().filter_map(|s| Shape::of(s).ok()).collect();
        let mut own = Self { shapes, across: scene.domain.across, ..Self::default() };
        for (id, body) in (0..).zip(placed) {
            let Some(solid) = body.solid else { continue };
            let shape = &own.shapes[solid.shape as usize];
            let mobility = body.mobility();
            // A body of given motion or of a clump does not turn by itself.
            let inertia = (mobility.is_free() && !mobility.is_joined())
                .then(|| shape.inertia_of(body.mass, solid.size));
            let q = solid.orientation;
            let momentum =
                inertia.map_or(Vec3::zeros(), |inertia| inertia.momentum(q, body.twist.w));
            if own.grains.len().is_multiple_of(TOGETHER) {
                own.vertex_bounds.push(own.vertices.len() as u32);
                own.normal_bounds.push(own.normals.len() as u32);
            }
            own.grains.push(Grain {
                id,
                slot: id as u32,
                shape: solid.shape,
                size: solid.size,
                inertia,
                orientation: q,
                momentum,
                torque: Vec3::zeros(),
                spin: body.twist.w,
                predicted: body.twist.w,
                first_vertex: own.vertices.len() as u32,
                first_normal: own.normals.len() as u32,
            });
            own.vertices.resize(own.vertices.len() + shape.vertices.len(), Vec3::zeros());
            own.normals.resize(own.normals.len() + shape.normals.len(), Vec3::zeros());
        }
        own.vertex_bounds.push(own.vertices.len() as u32);
        own.normal_bounds.push(own.normals.len() as u32);
        own.each(team, |_| ());
        own
    }

    /// Keeps where they are and how they turn, or puts it back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("grains", &mut self.grains)?;
        state.value("vertices", &mut self.vertices)?;
        state.value("normals", &mut self.normals)
    }

    pub fn is_empty(&self) -> bool {
        self.grains.is_empty()
    }

    /// Number of polyhedra.
    pub fn len(&self) -> usize {
        self.grains.len()
    }

    /// All of them, by ascending id.
    pub fn grains(&self) -> &[Grain] {
        &self.grains
    }

    /// The shape of one.
    pub fn shape_of(&self, grain: usize) -> &Shape {
        &self.shapes[self.grains[grain].shape as usize]
    }

    /// One where it is.
    #[inline(always)]
    pub fn solid(&self, grain: usize) -> Solid<'_> {
        let own = &self.grains[grain];
        let shape = &self.shapes[own.shape as usize];
        let (v, n) = (own.first_vertex as usize, own.first_normal as usize);
        Solid {
            shape,
            size: own.size,
            vertices: &self.vertices[v..v + shape.vertices.len()],
            normals: &self.normals[n..n + shape.normals.len()],
        }
    }

    /// Finds where in memory the bodies stand, after these were put in another order.
    pub fn find_slots(&mut self, bodies: &Bodies) {
        for grain in &mut self.grains {
            if let Ok(rank) = bodies.ids.binary_search(&grain.id) {
                grain.slot = bodies.slot[rank];
            }
        }
    }

    /// Turns them through a substep, once their centroids have moved: half kick, drift and
    /// prediction; with `finish` the half kick that ends the substep before comes first.
    pub fn first_half(
        &mut self,
        team: &mut Team,
        bodies: &mut Bodies,
        loaded: bool,
        (dt, finish): (f64, bool),
    ) {
        if self.is_empty() {
            return;
        }
        let (orientation, load, across) = (&bodies.orientation, &bodies.load, self.across);
        self.each(team, |grain| {
            let slot = grain.slot as usize;
            let Some(inertia) = grain.inertia else {
                grain.orientation = orientation[slot];
                return;
            };
            let mut torque = grain.torque;
            if loaded {
                torque += load[slot].torque;
            }
            // Two half kicks and not one whole: the same bits as where a window ends between them.
            if finish {
                grain.momentum += torque * (0.5 * dt);
            }
            grain.momentum += torque * (0.5 * dt);
            grain.orientation = inertia.drift(grain.orientation, grain.momentum, dt);
            if let Some(across) = across {
                grain.orientation = turned_about(across, grain.orientation);
            }
            grain.spin = inertia.spin(grain.orientation, grain.momentum);
            let predicted = grain.momentum + torque * (0.5 * dt);
            grain.predicted = inertia.spin(grain.orientation, predicted);
        });
        // By one thread: the slots of neighbouring grains lie anywhere in memory.
        for grain in self.grains.iter().filter(|grain| grain.inertia.is_some()) {
            let slot = grain.slot as usize;
            bodies.orientation[slot] = grain.orientation;
            bodies.twists[slot].w = grain.spin;
            bodies.predicted[slot].w = grain.predicted;
        }
    }

    /// Half kick that ends a substep.
    pub fn second_half(&mut self, bodies: &mut Bodies, loaded: bool, dt: f64) {
        for grain in &mut self.grains {
            let Some(inertia) = grain.inertia else { continue };
            let slot = grain.slot as usize;
            let mut torque = grain.torque;
            if loaded {
                torque += bodies.load[slot].torque;
            }
            grain.momentum += torque * (0.5 * dt);
            bodies.twists[slot].w = inertia.spin(grain.orientation, grain.momentum);
        }
    }

    /// Changes each, and finds its corners and faces.
    fn each(&mut self, team: &mut Team, change: impl Fn(&mut Grain) + Sync) {
        let pieces = (
            Cut::every(&mut self.grains, TOGETHER),
            Cut::at(&mut self.vertices, &self.vertex_bounds),
            Cut::at(&mut self.normals, &self.normal_bounds),
        );
        let shapes = &self.shapes;
        type Arrays<'a> = (&'a mut [Grain], &'a mut [Vec3], &'a mut [Vec3]);
        team.for_pieces(pieces, |_, (grains, mut vertices, mut normals): Arrays<'_>| {
            for grain in grains {
                change(grain);
                let shape = &shapes[grain.shape as usize];
                let axes = turned_axes(grain.orientation);
                let (own, rest) = vertices.split_at_mut(shape.vertices.len());
                vertices = rest;
                for (to, v) in own.iter_mut().zip(&shape.vertices) {
                    *to = to_world(&axes, *v * grain.size);
                }
                let (own, rest) = normals.split_at_mut(shape.normals.len());
                normals = rest;
                for (to, n) in own.iter_mut().zip(&shape.normals) {
                    *to = to_world(&axes, *n);
                }
            }
        });
    }

    /// A load as a body of the scene feels it: in a plane scene without what leads out of it, which
    /// is rounding.
    fn felt(&self, load: Wrench) -> Wrench {
        let Some(across) = self.across else { return load };
        let mut felt = Wrench { force: load.force, torque: Vec3::zeros() };
        felt.force[across] = 0.0;
        felt.torque[across] = load.torque[across];
        felt
    }

    /// Energy of rotation [J].
    pub fn rotational_energy(&self, bodies: &Bodies) -> f64 {
        let of = |grain: &Grain| {
            let spin = bodies.twists[grain.slot as usize].w;
            grain.inertia.map_or(0.0, |i| 0.5 * spin.dot(&i.momentum(grain.orientation, spin)))
        };
        self.grains.iter().map(of).sum()
    }
}

/// The turn about one axis that is next to an orientation.
fn turned_about(axis: usize, q: [f64; 4]) -> [f64; 4] {
    let length = (q[axis] * q[axis] + q[3] * q[3]).sqrt();
    let mut turned = [0.0, 0.0, 0.0, q[3] / length];
    turned[axis] = q[axis] / length;
    turned
}
