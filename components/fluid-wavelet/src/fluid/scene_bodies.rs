//! The solids of a scene as the gas meets them: parts, planes, polyhedra, round bodies.

use crate::bodies::gas_body::{GasBody, SurfaceHeat, ball_height, cross, half_space_height};
use crate::domain::world_axes::WorldAxes;
use std::f64::consts::PI;
use std::sync::Arc;
use tremie_fluid_kit::bodies::body_registry::BodyError;
use tremie_fluid_kit::survey::solids::{moving_surfaces, start_frame};
use tremie_geometry::{Convex, Frame, Surface};
use tremie_messages::scene::{Motion, Pose, Scene};
use tremie_messages::{BodyEvent, BodyState, Problem};

/// A body of a scene, along the grid's axes.
#[derive(Clone, Debug)]
pub struct SceneBody {
    shape: BodyShape,
    centre: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
    /// Lengths after which the domain repeats [m]; endless where it does not.
    period: [f64; 3],
    heat: SurfaceHeat,
    /// Volume that it displaces [m³].
    pub volume: f64,
}

#[derive(Clone, Debug)]
enum BodyShape {
    /// A disc or a sphere, by its radius [m].
    Ball(f64),
    /// Everything below a plane through the centre, by its normal.
    HalfSpace([f64; 3]),
    /// What a surface encloses.
    Solid(PlacedSurface),
}

/// A surface in the world, which the grid sees by its axes.
#[derive(Clone, Debug)]
struct PlacedSurface {
    surface: Arc<Surface>,
    frame: Frame,
    /// By how much it is larger than in its own frame.
    size: f64,
    axes: WorldAxes,
}

impl PlacedSurface {
    /// Distance of a point of the grid, and the normal there.
    fn height(&self, at: [f64; 3]) -> (f64, [f64; 3]) {
        let own = self.frame.to_part(self.axes.to_world(at)) / self.size;
        let closest = self.surface.closest(own);
        let away = own - closest.point;
        let length = away.norm();
        let normal = if length > 1e-12 * self.surface.bounding_radius() {
            away * (closest.distance.signum() / length)
        } else {
            closest.normal
        };
        let normal = self.axes.along(self.frame.turn_to_world(normal).into());
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        // A face of a part across the plane has no direction in it.
        let normal = if length > 0.0 { normal.map(|n| n / length) } else { [1.0, 0.0, 0.0] };
        (closest.distance * self.size, normal)
    }
}

impl SceneBody {
    /// The nearest image of a point to the centre.
    fn image(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            if self.period[a].is_finite() {
                let apart = at[a] - self.centre[a];
                at[a] - self.period[a] * (apart / self.period[a]).round()
            } else {
                at[a]
            }
        })
    }
}

impl GasBody for SceneBody {
    fn height(&self, at: [f64; 3]) -> (f64, [f64; 3]) {
        match &self.shape {
            BodyShape::Ball(radius) => ball_height(self.arm(at), *radius),
            BodyShape::HalfSpace(normal) => half_space_height(self.arm(at), *normal),
            BodyShape::Solid(solid) => solid.height(self.image(at)),
        }
    }

    fn velocity(&self, at: [f64; 3]) -> [f64; 3] {
        let turn = cross(self.spin, self.arm(at));
        std::array::from_fn(|a| self.velocity[a] + turn[a])
    }

    fn arm(&self, at: [f64; 3]) -> [f64; 3] {
        let at = self.image(at);
        std::array::from_fn(|a| at[a] - self.centre[a])
    }

    fn heat(&self) -> SurfaceHeat {
        self.heat
    }
}

/// A shape that bodies of the run have.
#[derive(Clone, Debug)]
struct Shape {
    surface: Arc<Surface>,
    /// Volume for a size of one [m³].
    volume: f64,
}

/// The shapes of all bodies of a scene.
#[derive(Clone, Debug)]
pub struct SceneBodies {
    axes: WorldAxes,
    period: [f64; 3],
    depth: Option<f64>,
    /// By index of the part; only those that move.
    parts: Vec<Option<Shape>>,
    /// Polyhedra of unit size.
    polyhedra: Vec<Option<Shape>>,
    /// What becomes of heat at the surfaces of each set of bodies, and of each part.
    heat_of_sets: Vec<SurfaceHeat>,
    heat_of_parts: Vec<SurfaceHeat>,
    /// Fixed parts in their order, then planes.
    at_rest: Vec<SceneBody>,
}

impl SceneBodies {
    /// Of a scene.
    ///
    /// # Errors
    /// Every part whose surface cannot be had.
    pub fn new(scene: &Scene, axes: WorldAxes) -> Result<Self, Vec<Problem>> {
        let mut problems = Vec::new();
        let moving = moving_surfaces(scene).unwrap_or_else(|more| {
            problems.extend(more);
            Vec::new()
        });
        let size = scene.domain.size();
        let heat = |material: &String| heat_at(scene, material);
        let mut own = Self {
            axes,
            period: std::array::from_fn(|a| {
                let axis = axes.order[a];
                let wraps = a < axes.dims && scene.domain.is_periodic(axis);
                if wraps { size[axis] } else { f64::INFINITY }
            }),
            depth: scene.domain.depth(),
            parts: Vec::new(),
            polyhedra: scene.shapes.iter().map(|shape| polyhedron(&shape.vertices)).collect(),
            heat_of_sets: scene.bodies.iter().map(|set| heat(&set.material)).collect(),
            heat_of_parts: scene.parts.iter().map(|part| heat(&part.material)).collect(),
            at_rest: Vec::new(),
        };
        own.parts = moving.into_iter().map(|surface| Some(part_shape(surface?))).collect();
        for (index, part) in scene.parts.iter().enumerate() {
            if part.motion != Motion::Fixed {
                continue;
            }
            match Surface::in_domain(part, &scene.domain) {
                Ok(surface) => {
                    let surface = if part.cavity { surface.inside_out() } else { surface };
                    let frame = start_frame(part, &surface);
                    let shape = part_shape(Arc::new(surface));
                    let centre = axes.along(frame.to_world([0.0; 3]).into());
                    let body = own.part(&shape, frame, centre);
                    own.at_rest.push(SceneBody { heat: own.heat_of_parts[index], ..body });
                }
                Err(error) => {
                    problems.extend(error.problems(&format!("scene.parts[{index}].geometry")));
                }
            }
        }
        for plane in &scene.planes {
            let shape = BodyShape::HalfSpace(axes.along(plane.normal));
            own.at_rest.push(SceneBody {
                period: [f64::INFINITY; 3],
                ..own.body_at(shape, axes.along(plane.point), 0.0)
            });
        }
        if problems.is_empty() { Ok(own) } else { Err(problems) }
    }

    /// Solids that never move: fixed parts in their order, then planes.
    pub fn at_rest(&self) -> &[SceneBody] {
        &self.at_rest
    }

    /// A part where it is. In a plane scene it displaces what the depth cuts out of it.
    fn part(&self, shape: &Shape, frame: Frame, centre: [f64; 3]) -> SceneBody {
        let mut body = self.solid(shape, frame, 1.0, centre);
        if let Some(depth) = self.depth {
            let across = self.axes.order[2];
            let along = std::array::from_fn(|a| if a == across { 1.0 } else { 0.0 });
            let own = frame.turn_to_part(along);
            body.volume *= depth / shape.surface.width_along(own.into());
        }
        body
    }

    fn body_at(&self, shape: BodyShape, centre: [f64; 3], volume: f64) -> SceneBody {
        let (velocity, spin, period) = ([0.0; 3], [0.0; 3], self.period);
        let heat = SurfaceHeat::Adiabatic;
        SceneBody { shape, centre, velocity, spin, period, heat, volume }
    }

    fn solid(&self, shape: &Shape, frame: Frame, size: f64, centre: [f64; 3]) -> SceneBody {
        let placed =
            PlacedSurface { surface: Arc::clone(&shape.surface), frame, size, axes: self.axes };
        self.body_at(BodyShape::Solid(placed), centre, size.powi(3) * shape.volume)
    }

    /// A body in a state.
    ///
    /// # Errors
    /// Shapes that are not known.
    pub fn body(&self, event: &BodyEvent, state: &BodyState) -> Result<SceneBody, BodyError> {
        let wrong = |why| BodyError::Body { id: event.id, why };
        let frame = Frame::of(&Pose { position: state.position, orientation: state.orientation });
        let table = usize::try_from(event.table).unwrap_or(usize::MAX);
        let centre = self.axes.along(state.position);
        let radius = event.size[0];
        let mut body = match (event.shape, self.depth) {
            (BodyEvent::SPHERE, None) => {
                self.body_at(BodyShape::Ball(radius), centre, 4.0 / 3.0 * PI * radius.powi(3))
            }
            (BodyEvent::CYLINDER, Some(depth)) => {
                self.body_at(BodyShape::Ball(radius), centre, PI * radius * radius * depth)
            }
            (BodyEvent::SPHERE, Some(_)) => {
                return Err(wrong("it is a sphere, and the scene is plane"));
            }
            (BodyEvent::CYLINDER, None) => {
                return Err(wrong("it is a cylinder, and the scene is in space"));
            }
            (BodyEvent::PART, _) => {
                let part = self.parts.get(table).and_then(Option::as_ref);
                let part = part.ok_or_else(|| wrong("it is no part that moves"))?;
                self.part(part, frame, centre)
            }
            (BodyEvent::POLYHEDRON, _) => {
                let shape = self.polyhedra.get(table).and_then(Option::as_ref);
                let shape = shape.ok_or_else(|| wrong("its shape is unknown"))?;
                self.solid(shape, frame, event.size[1], centre)
            }
            _ => return Err(wrong("its shape is unknown")),
        };
        let (heats, number) = match event.shape {
            BodyEvent::PART => (&self.heat_of_parts, table),
            _ => (&self.heat_of_sets, event.set as usize),
        };
        body.heat = heats.get(number).copied().unwrap_or(SurfaceHeat::Adiabatic);
        body.velocity = self.axes.along(state.velocity);
        body.spin = self.axes.turn(state.angular_velocity);
        Ok(body)
    }
}

/// What becomes of heat at surfaces of a material.
fn heat_at(scene: &Scene, material: &str) -> SurfaceHeat {
    let gas = scene.fluid.as_ref().and_then(|fluid| fluid.gas.as_ref());
    let temperature = gas.and_then(|gas| gas.surface_temperatures.get(material));
    temperature.map_or(SurfaceHeat::Adiabatic, |kelvin| SurfaceHeat::Isothermal(*kelvin))
}

/// A part in its own frame.
fn part_shape(surface: Arc<Surface>) -> Shape {
    let volume = surface.volume_and_centroid().0.abs();
    Shape { surface, volume }
}

/// A polyhedron of unit size.
fn polyhedron(vertices: &[[f64; 3]]) -> Option<Shape> {
    let convex = Convex::hull(vertices).ok()?.unit();
    let volume = convex.moments().volume;
    let surface = Surface::new(convex.mesh()).ok()?;
    Some(Shape { surface: Arc::new(surface), volume })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{
        BodySet, Domain, Face, FluidMaterial, GasMaterial, Geometry, Part, PartBoundary, Placement,
    };

    #[test]
    fn a_ball_near_a_periodic_face_is_seen_from_both_ends() {
        let mut domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
        domain.faces[0] = [Face::Periodic, Face::Periodic];
        domain.across = Some(1);
        let scene = Scene::empty(domain);
        let bodies = SceneBodies::new(&scene, WorldAxes::of(&scene)).expect("no parts");
        let event = BodyEvent {
            id: 1,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::CYLINDER,
            motion: BodyEvent::FREE,
            set: 0,
            mass: 1.0,
            size: [0.1, 1.0, 0.0],
            table: 0,
        };
        let state = BodyState::at_rest(1, [0.95, 0.5, 0.4]);
        let ball = bodies.body(&event, &state).expect("a cylinder");
        assert!((ball.height([0.1, 0.4, 0.0]).0 - 0.05).abs() < 1e-12);
        assert!((ball.arm([0.02, 0.4, 0.0])[0] - 0.07).abs() < 1e-12);
    }

    #[test]
    fn a_turned_part_displaces_what_the_depth_cuts_out_of_it() {
        let mut domain = Domain::new([0.0; 3], [1.0, 0.1, 1.0], Face::WALLS);
        domain.across = Some(1);
        let scene = Scene::empty(domain);
        let bodies = SceneBodies::new(&scene, WorldAxes::of(&scene)).expect("no parts");
        let block = Surface::of(&Geometry::Box { size: [0.1, 0.2, 0.3] }).expect("a box");
        let shape = part_shape(Arc::new(block));
        // A quarter of a turn about x: its own z lies across the plane.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        for (orientation, section) in [([0.0, 0.0, 0.0, 1.0], 0.03), ([half, 0.0, 0.0, half], 0.02)]
        {
            let frame = Frame::of(&Pose { position: [0.5, 0.05, 0.5], orientation });
            let part = bodies.part(&shape, frame, [0.5, 0.5, 0.05]);
            assert!((part.volume - section * 0.1).abs() < 1e-15, "{}", part.volume);
        }
    }

    #[test]
    fn surfaces_have_the_temperature_of_their_material() {
        let part = |name: &str, motion: Motion| Part {
            name: name.into(),
            geometry: Geometry::Box { size: [0.2, 0.2, 0.2] },
            pose: Pose { position: [0.5, 0.5, 0.5], ..Pose::IDENTITY },
            cavity: false,
            material: name.into(),
            motion,
            boundary: PartBoundary::Wall,
        };
        let given = Motion::Prescribed(Vec::new());
        let set = |material: &str| BodySet {
            name: material.into(),
            density: 1.0,
            material: material.into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed(Vec::new()),
        };
        let gas = GasMaterial {
            pressure: 1e5,
            temperature: 300.0,
            heat_ratio: 1.4,
            prandtl: 0.72,
            sutherland: 110.4,
            surface_temperatures: [("hot".into(), 350.0), ("cold".into(), 250.0)].into(),
            regions: Vec::new(),
            shock: None,
            vortex: None,
        };
        let scene = Scene {
            fluid: Some(FluidMaterial { gas: Some(gas), ..FluidMaterial::at_rest(1.2, 1.8e-5) }),
            bodies: vec![set("plain"), set("hot")],
            parts: vec![part("cold", Motion::Fixed), part("hot", given)],
            ..Scene::empty(Domain::new([0.0; 3], [1.0; 3], Face::WALLS))
        };
        let bodies = SceneBodies::new(&scene, WorldAxes::of(&scene)).expect("two boxes");
        assert_eq!(bodies.at_rest()[0].heat(), SurfaceHeat::Isothermal(250.0));
        let event = |shape: u32, set: u32, table: u64| BodyEvent {
            id: 1,
            kind: BodyEvent::ADDED,
            shape,
            motion: BodyEvent::FREE,
            set,
            mass: 1.0,
            size: [0.1, 1.0, 0.0],
            table,
        };
        let state = BodyState::at_rest(1, [0.5; 3]);
        for (shape, set, table, heat) in [
            (BodyEvent::SPHERE, 0, 0, SurfaceHeat::Adiabatic),
            (BodyEvent::SPHERE, 1, 0, SurfaceHeat::Isothermal(350.0)),
            (BodyEvent::PART, 0, 1, SurfaceHeat::Isothermal(350.0)),
        ] {
            let body = bodies.body(&event(shape, set, table), &state).expect("a body");
            assert_eq!(body.heat(), heat);
        }
    }
}
