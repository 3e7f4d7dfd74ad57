//! The solids of a scene as the solver takes them: parts, planes, polyhedra, spheres.

use crate::domain::parameters::ContactForces;
use crate::fluid::contact_prediction::LastingForce;
use crate::solids::half_spaces::HalfSpaces;
use crate::solids::rigid_body::{BodyShape, Freedom, RigidBody};
use crate::solids::section::Section;
use crate::solids::surface_solid::SurfaceSolid;
use nalgebra::Matrix3;
use std::sync::Arc;
use tremie_fluid_kit::bodies::body_registry::{BodyError, KnownBody};
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;
use tremie_geometry::{Convex, Frame, Surface, Vec3};
use tremie_messages::scene::{Motion, Part, Pose, Scene};
use tremie_messages::{BodyEvent, BodyState};

/// Strips of a face that a triangulated surface cuts: of parts at rest, and of those that move.
const STRIPS: [usize; 2] = [8, 2];

/// Shape of a part in its own frame.
#[derive(Clone, Debug)]
struct PartShape {
    surface: Arc<Surface>,
    /// The same as half spaces, if it is convex and has few faces.
    convex: Option<Arc<Convex>>,
    width: f64,
    volume: f64,
}

/// Shapes of all bodies that are no spheres.
#[derive(Clone, Debug)]
pub struct SceneSolids<const D: usize> {
    section: Section<D>,
    /// By index of the part; only those that move.
    parts: Vec<Option<PartShape>>,
    /// Shapes of polyhedra, of unit size.
    shapes: Vec<Option<UnitShape>>,
    /// Axis of the sliders among the parts.
    axes: Vec<Option<[f64; 3]>>,
    /// Depth of a plane's cells [m]; 1 in space.
    depth: f64,
}

/// A shape of polyhedra of unit size; in a plane scene of prisms across it.
#[derive(Clone, Debug)]
struct UnitShape {
    convex: Convex,
    /// Least width, of a prism that of its section.
    width: f64,
    volume: f64,
    /// Radius about the centroid that holds it, or the section of a prism.
    reach: f64,
    /// Inverse of its inertia for a mass of one; nothing where it has none.
    inverse_inertia: Matrix3<f64>,
}

impl UnitShape {
    fn of<const D: usize>(vertices: &[[f64; 3]], section: &Section<D>) -> Option<Self> {
        let convex = Convex::hull(vertices).ok()?.unit();
        let moments = convex.moments();
        let inverse = (moments.inertia / moments.volume).try_inverse();
        let seen = |v: &Vec3| section.along((*v).into()).iter().map(|x| x * x).sum::<f64>();
        Some(Self {
            width: if D == 2 {
                convex.least_width_across(section.across())
            } else {
                convex.least_width()
            },
            volume: moments.volume,
            reach: convex.vertices().iter().map(seen).fold(0.0, f64::max).sqrt(),
            inverse_inertia: inverse.unwrap_or_else(Matrix3::zeros),
            convex,
        })
    }
}

fn part_shape(surface: &Surface) -> PartShape {
    let convex = if surface.is_cavity() { None } else { Convex::of_mesh(surface.mesh()).ok() };
    PartShape {
        width: convex.as_ref().map_or(0.0, Convex::least_width),
        convex: convex.map(Arc::new),
        volume: surface.volume_and_centroid().0.abs(),
        surface: Arc::new(surface.clone()),
    }
}

impl PartShape {
    fn placed<const D: usize>(
        &self,
        frame: Frame,
        section: Section<D>,
        strips: usize,
    ) -> BodyShape<D> {
        let volume = if D == 2 {
            // Area of the section.
            let across = section.across();
            let along: [f64; 3] = std::array::from_fn(|a| if a == across { 1.0 } else { 0.0 });
            self.volume / self.surface.width_along(frame.turn_to_part(along).into())
        } else {
            self.volume
        };
        match &self.convex {
            Some(convex) => BodyShape::Convex {
                solid: Box::new(HalfSpaces::of(convex, 1.0, &frame, &section)),
                reach: self.surface.bounding_radius(),
                width: self.width,
                volume,
            },
            None => {
                let surface = Arc::clone(&self.surface);
                let solid = SurfaceSolid { surface, frame, section, strips };
                BodyShape::Surface { solid, volume }
            }
        }
    }
}

/// Solids that never move: fixed parts in their order, then planes.
pub fn solids_at_rest<const D: usize>(
    scene: &Scene,
    ground: &StaticGeometry,
    section: Section<D>,
) -> Vec<RigidBody<D>> {
    let fixed = |index: &usize| scene.parts[*index].motion == Motion::Fixed;
    let mut parts: Vec<(usize, &Surface)> =
        ground.part_surfaces().filter(|(index, _)| fixed(index)).collect();
    parts.sort_by_key(|(index, _)| *index);
    let mut all: Vec<RigidBody<D>> = parts
        .into_iter()
        .map(|(index, surface)| {
            let part: &Part = &scene.parts[index];
            let frame = tremie_fluid_kit::survey::solids::start_frame(part, surface);
            let shape = part_shape(surface).placed(frame, section, STRIPS[0]);
            RigidBody::at(section.along(frame.to_world([0.0; 3]).into()), shape)
        })
        .collect();
    all.extend(scene.planes.iter().map(|plane| {
        let shape = BodyShape::Convex {
            solid: Box::new(HalfSpaces::beyond(plane.point, plane.normal, &section)),
            reach: f64::INFINITY,
            width: f64::INFINITY,
            volume: 0.0,
        };
        RigidBody::at(section.along(plane.point), shape)
    }));
    all
}

impl<const D: usize> SceneSolids<D> {
    /// Of a scene.
    pub fn new(scene: &Scene, ground: &StaticGeometry, section: Section<D>, depth: f64) -> Self {
        let axis = |part: &Part| match &part.motion {
            Motion::Slider(slider) => {
                let length = slider.axis.iter().map(|x| x * x).sum::<f64>().sqrt();
                Some(slider.axis.map(|x| x / length))
            }
            _ => None,
        };
        Self {
            section,
            parts: ground.moving.iter().map(|s| s.as_deref().map(part_shape)).collect(),
            shapes: scene
                .shapes
                .iter()
                .map(|shape| UnitShape::of(&shape.vertices, &section))
                .collect(),
            axes: scene.parts.iter().map(axis).collect(),
            depth,
        }
    }

    /// A body in a state.
    ///
    /// # Errors
    /// Shapes that are not known.
    pub fn body(
        &self,
        known: &KnownBody<LastingForce>,
        state: &BodyState,
    ) -> Result<RigidBody<D>, BodyError> {
        let event = &known.event;
        let wrong = |why| BodyError::Body { id: event.id, why };
        let frame = Frame::of(&Pose { position: state.position, orientation: state.orientation });
        let table = usize::try_from(event.table).unwrap_or(usize::MAX);
        let shape = match event.shape {
            BodyEvent::SPHERE if D == 3 => BodyShape::Ball(event.size[0]),
            BodyEvent::CYLINDER if D == 2 => BodyShape::Ball(event.size[0]),
            BodyEvent::SPHERE => return Err(wrong("it is a sphere, and the scene is plane")),
            BodyEvent::CYLINDER => {
                return Err(wrong("it is a cylinder, and the scene is in space"));
            }
            BodyEvent::PART => {
                let part = self.parts.get(table).and_then(Option::as_ref);
                let part = part.ok_or_else(|| wrong("it is no part that moves"))?;
                part.placed(frame, self.section, STRIPS[1])
            }
            BodyEvent::POLYHEDRON => {
                let shape = self.shapes.get(table).and_then(Option::as_ref);
                let shape = shape.ok_or_else(|| wrong("its shape is unknown"))?;
                let size = event.size[1];
                BodyShape::Convex {
                    solid: Box::new(HalfSpaces::of(&shape.convex, size, &frame, &self.section)),
                    reach: size * shape.reach,
                    width: size * shape.width,
                    volume: size.powi(3) * shape.volume / self.depth,
                }
            }
            _ => return Err(wrong("its shape is unknown")),
        };
        let mut body = RigidBody::at(self.section.along(state.position), shape);
        body.id = event.id;
        body.velocity = self.section.along(state.velocity);
        body.spin = self.section.turn(state.angular_velocity);
        let mass = event.mass / self.depth;
        Ok(match event.motion {
            BodyEvent::FREE if body.is_round() => body.with_mass(mass),
            BodyEvent::FREE => {
                body.freedom =
                    Freedom::Free { mass, inverse_inertia: self.inverse_inertia(event, &frame) };
                body
            }
            BodyEvent::SLIDER => {
                let axis = self.axes.get(table).copied().flatten();
                let axis = axis.ok_or_else(|| wrong("it slides, but its part does not"))?;
                let seen = self.section.along(axis);
                let axis = std::array::from_fn(|a| if a < D { seen[a] } else { 0.0 });
                body.freedom = Freedom::Slider { axis, mass };
                body
            }
            _ => body,
        })
    }

    /// A body where a window ends and forces move it, of which `contacts` says what is expected.
    ///
    /// # Errors
    /// Shapes that are not known.
    pub fn body_at_end(
        &self,
        known: &KnownBody<LastingForce>,
        state: &BodyState,
        contacts: ContactForces,
    ) -> Result<RigidBody<D>, BodyError> {
        let mut body = self.body(known, state)?;
        if contacts == ContactForces::Lasting {
            let lasting = self.section.along(known.own.acceleration());
            let mass = body.mass().unwrap_or(0.0);
            body.force = lasting.map(|acceleration| mass * acceleration);
        }
        Ok(body)
    }

    /// Inverse inertia of a polyhedron in the world.
    fn inverse_inertia(&self, event: &BodyEvent, frame: &Frame) -> [[f64; 3]; 3] {
        let shape = self.shapes.get(event.table as usize).and_then(Option::as_ref);
        let own = shape.map_or_else(Matrix3::zeros, |shape| shape.inverse_inertia);
        let columns: [Vec3; 3] =
            [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| frame.turn_to_world(axis));
        let rotation = Matrix3::from_columns(&columns);
        let size = event.size[1];
        let world = rotation * own * rotation.transpose() / (event.mass * size * size);
        if D == 2 {
            // A prism turns about the axis across the plane alone; its mass is that of a metre of
            // depth.
            let across = self.section.across();
            let mut inverse = [[0.0; 3]; 3];
            inverse[2][2] = world[(across, across)] * self.depth;
            return inverse;
        }
        std::array::from_fn(|i| std::array::from_fn(|j| world[(i, j)]))
    }
}
