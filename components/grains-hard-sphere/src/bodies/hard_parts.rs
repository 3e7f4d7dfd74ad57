//! Triangulated parts that stand still or move as the scene prescribes.

use crate::Vec3;
use crate::bodies::hard_body::HardBody;
use crate::cells::body_cells::BodyCells;
use crate::impact::collision::{Collider, ImpactLaw};
use crate::impact::impact_laws::ImpactLaws;
use crate::impact::triangle_touch::{CentrePath, first_touch};
use tremie_geometry::{Frame, Surface, motion_problem};
use tremie_grains_kit::motion::prescribed_motion::{Path, turn};
use tremie_grains_kit::space::part_surface::PartSurface;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::rigid_body::Twist;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_messages::body::BodyState;
use tremie_messages::scene::{Motion, Pose, Scene};
use tremie_messages::{Load, Problem};
use tremie_state::{StateError, StateExchange};

/// A part where it is, on its way through a step.
pub struct HardPart {
    shape: PartSurface,
    path: Option<Path>,
    material: u16,
    /// Pose at the start of the step.
    pose: Pose,
    /// Displacement in the step [m], and turn [rad].
    way: Twist,
    /// Velocities now.
    twist: Twist,
    /// Frames of the surface at the start and at the end of the step.
    frames: [Frame; 2],
    /// Impulse [N·s] and its moment about the origin of the frame [N·m·s] since a window began.
    received: [Vec3; 2],
}

/// A triangle near a cell, seen through an image of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NearTriangle {
    part: u32,
    triangle: u32,
    shift: Vec3,
}

/// The parts of a run.
#[derive(Default)]
pub struct HardParts {
    parts: Vec<HardPart>,
    /// Images through which parts are seen [m].
    shifts: Vec<Vec3>,
    /// Triangles near cells: those of cell `k` are `start[k]..start[k + 1]`.
    near: Vec<NearTriangle>,
    start: Vec<u32>,
}

/// A touch of a body and a part in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartTouch {
    /// Moment in the step [s].
    pub moment: f64,
    /// Number of the part.
    pub part: u32,
    /// Number of its triangle.
    pub triangle: u32,
    /// Image through which it is seen.
    pub image: u32,
    /// Direction from the part to the body.
    pub n: Vec3,
}

impl SolidPart for HardPart {
    fn clearance(&self, x: Vec3) -> (f64, Vec3) {
        self.shape.clearance(x)
    }

    fn is_cavity(&self) -> bool {
        self.shape.is_cavity()
    }

    fn is_seen(&self, shift: Vec3) -> bool {
        self.shape.is_seen(shift)
    }
}

/// Loads the parts of a scene.
///
/// # Errors
/// Surfaces that cannot be had, and motions that are none of these grains.
pub fn load(scene: &Scene) -> Result<Vec<HardPart>, Vec<Problem>> {
    let (mut parts, mut problems) = (Vec::new(), Vec::new());
    for (i, part) in scene.parts.iter().enumerate() {
        let key = format!("scene.parts[{i}]");
        let path = match &part.motion {
            Motion::Prescribed(points) => Some(Path::new(points, Twist::zero())),
            Motion::Timed(timed) => Some(Path::timed(timed)),
            Motion::Fixed => None,
            Motion::Free | Motion::Slider(_) => {
                let message = "is moved by forces, but hard spheres move no part";
                let help =
                    "fix the part or prescribe its motion, or take grains-dem, which has sliders";
                problems.push(Problem::new(format!("{key}.motion"), message).help(help));
                None
            }
        };
        match Surface::in_domain(part, &scene.domain) {
            Ok(surface) => {
                problems.extend(motion_problem(&key, part, &surface, &scene.domain));
                let shape = PartSurface::new(surface, part.cavity, &part.pose);
                let twist = path.as_ref().map_or(Twist::zero(), |path| path.twist(0.0));
                let frames = [shape.frame_at(&part.pose); 2];
                parts.push(HardPart {
                    shape,
                    path,
                    material: 0,
                    pose: part.pose,
                    way: Twist::zero(),
                    twist,
                    frames,
                    received: [Vec3::zeros(); 2],
                });
            }
            Err(error) => problems.extend(error.problems(&format!("{key}.geometry"))),
        }
    }
    if problems.is_empty() { Ok(parts) } else { Err(problems) }
}

impl HardPart {
    /// True if the part moves, and so is a body of the run.
    pub fn moves(&self) -> bool {
        self.path.is_some()
    }

    /// Its surface.
    pub fn shape(&self) -> &PartSurface {
        &self.shape
    }

    /// Pose and velocity as those of the body `id`.
    pub fn state(&self, id: u64) -> BodyState {
        BodyState {
            id,
            position: self.pose.position,
            orientation: self.pose.orientation,
            velocity: self.twist.v.into(),
            angular_velocity: self.twist.w.into(),
        }
    }

    /// The pose at the part `done` of the step.
    fn pose_at(&self, done: f64) -> Pose {
        let position = Vec3::from(self.pose.position) + self.way.v * done;
        let orientation = if self.way.w == Vec3::zeros() {
            self.pose.orientation
        } else {
            turn(self.pose.orientation, self.way.w * done)
        };
        Pose { position: position.into(), orientation }
    }

    /// Its velocity at a place, at the part `done` of a step of a length [s].
    fn velocity_at(&self, x: Vec3, done: f64, step: f64) -> Vec3 {
        let origin = Vec3::from(self.pose_at(done).position);
        (self.way.v + self.way.w.cross(&(x - origin))) / step
    }
}

impl HardParts {
    /// The parts of a scene, with their materials.
    pub fn new(
        mut parts: Vec<HardPart>,
        scene: &Scene,
        laws: &ImpactLaws,
        bounds: &PeriodicBox,
    ) -> Self {
        for (placed, part) in parts.iter_mut().zip(&scene.parts) {
            placed.material = laws.material(&part.material);
        }
        Self { parts, shifts: bounds.images().collect(), near: Vec::new(), start: Vec::new() }
    }

    /// The parts.
    pub fn parts(&self) -> &[HardPart] {
        &self.parts
    }

    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Lists the triangles near each cell, for bodies up to a radius [m]; parts stand still.
    pub fn list(&mut self, cells: &BodyCells, radius: f64) {
        self.near.clear();
        self.start = vec![0];
        let half = cells.edge * 0.5;
        let reach = half.norm_squared().sqrt() + radius * (1.0 + 1e-6);
        let mut found = Vec::new();
        let [nx, ny, nz] = cells.count.map(|n| n as u16);
        let rows = (0..nz).flat_map(|z| (0..ny).map(move |y| (y, z)));
        let all = rows.flat_map(|(y, z)| (0..nx).map(move |x| [x, y, z]));
        for cell in all {
            if self.parts.is_empty() {
                break;
            }
            let centre = cells.corner(cell) + half;
            for (number, part) in (0..).zip(&self.parts) {
                for &shift in self.shifts.iter().filter(|shift| part.is_seen(**shift)) {
                    let x = part.shape.to_part(centre + shift);
                    part.shape.triangles_near(x, reach, &mut found);
                    let near = |&triangle| NearTriangle { part: number, triangle, shift };
                    self.near.extend(found.iter().map(near));
                }
            }
            self.start.push(self.near.len() as u32);
        }
    }

    /// Places in the list of the triangles near a cell.
    pub fn near_cell(&self, cell: usize) -> core::ops::Range<usize> {
        self.start[cell] as usize..self.start[cell + 1] as usize
    }

    /// When a body touches a listed triangle of a part that stands still, in so many seconds at
    /// most; and the direction from there to the body.
    pub fn touch_at_rest(&self, place: usize, body: &HardBody, until: f64) -> Option<(f64, Vec3)> {
        let NearTriangle { part, triangle, shift } = self.near[place];
        let part = &self.parts[part as usize];
        let frame = &part.frames[0];
        let path = CentrePath {
            x: frame.to_part(body.x + shift),
            v: frame.turn_to_part(body.v),
            a: frame.turn_to_part(body.a),
        };
        let (s, n) = first_touch(&path, body.radius, &part.shape.triangle(triangle), until)?;
        Some((s, frame.turn_to_world(n)))
    }

    /// The law between the part of a listed triangle and a material.
    pub fn law(&self, place: usize, material: u16, laws: &ImpactLaws) -> ImpactLaw {
        self.law_of(self.near[place].part, material, laws)
    }

    /// The law between a part and a material.
    pub fn law_of(&self, part: u32, material: u16, laws: &ImpactLaws) -> ImpactLaw {
        *laws.between(self.parts[part as usize].material, material)
    }

    /// A part that stands still receives an impulse [N·s] from a body; `n` points to the body.
    pub fn push(&mut self, place: usize, body: &HardBody, n: Vec3, impulse: Vec3) {
        let NearTriangle { part, shift, .. } = self.near[place];
        self.receive(part, body.x + shift - n * body.radius, 0.0, impulse);
    }

    /// A part receives an impulse [N·s] at a place, at the part `done` of a step.
    pub fn receive(&mut self, part: u32, at: Vec3, done: f64, impulse: Vec3) {
        let part = &mut self.parts[part as usize];
        let origin = Vec3::from(part.pose_at(done).position);
        part.received[0] += impulse;
        part.received[1] += (at - origin).cross(&impulse);
    }

    /// Begins a step from one time of the run to another [s].
    pub fn begin_step(&mut self, from: f64, to: f64) {
        for part in &mut self.parts {
            if let Some(path) = &part.path {
                part.way = path.travelled(from, to);
                part.frames = [0.0, 1.0].map(|done| part.shape.frame_at(&part.pose_at(done)));
            }
        }
    }

    /// Ends a step at a time of the run [s].
    pub fn end_step(&mut self, time: f64, bounds: &PeriodicBox) {
        for part in &mut self.parts {
            let end = part.pose_at(1.0);
            if let Some(path) = &part.path {
                part.twist = path.twist(time);
                part.pose = Pose { position: bounds.wrap(end.position.into()).into(), ..end };
                part.way = Twist::zero();
                part.shape.place(&part.pose);
                part.frames = [part.shape.frame_at(&part.pose); 2];
            }
        }
    }

    /// The earliest touch of a body and any part in the rest of a step of a length [s]: of parts
    /// that overlap the body at its end, which is at `end` then. `room` is room to work in.
    pub fn first_in_step(
        &self,
        body: &HardBody,
        end: Vec3,
        step: f64,
        room: &mut Vec<u32>,
    ) -> Option<PartTouch> {
        let mut best: Option<PartTouch> = None;
        for (number, part) in (0..).zip(&self.parts) {
            for (image, &shift) in (0..).zip(&self.shifts) {
                if !part.is_seen(shift) {
                    continue;
                }
                let last = part.frames[1].to_part(end + shift);
                if !part.shape.is_cavity()
                    && !part.shape.surface().bounds().grown(body.radius).contains(last)
                {
                    continue;
                }
                part.shape.triangles_near(last, body.radius, room);
                if room.is_empty() {
                    continue;
                }
                let (path, rest) = (part.path_of(body, shift, last, step), step - body.time);
                for &triangle in &*room {
                    let surface = part.shape.triangle(triangle);
                    let Some((s, n)) = first_touch(&path, body.radius, &surface, rest) else {
                        continue;
                    };
                    let moment = body.time + s;
                    if best.is_none_or(|best| moment < best.moment) {
                        let n = part.turned_out(n, moment / step);
                        best = Some(PartTouch { moment, part: number, triangle, image, n });
                    }
                }
            }
        }
        best
    }

    /// A part as a partner in a collision, at the place where it touches a body in a step of a
    /// length [s]; and that place, as the part sees it.
    pub fn collider(&self, touch: &PartTouch, body: &HardBody, step: f64) -> (Collider, Vec3) {
        let shift = self.shifts[touch.image as usize];
        let at = body.x + shift - touch.n * body.radius;
        let part = &self.parts[touch.part as usize];
        let v = part.velocity_at(at, touch.moment / step, step);
        (Collider { v, ..Collider::STILL }, at)
    }

    /// Keeps where the parts are at a window's end, or puts them back there.
    ///
    /// # Errors
    /// A state of other parts.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let parts = &mut self.parts;
        state.column("position", parts, |p| p.pose.position, |p, x| p.pose.position = x)?;
        state.column(
            "orientation",
            parts,
            |p| p.pose.orientation,
            |p, q| p.pose.orientation = q,
        )?;
        state.column(
            "velocity",
            parts,
            |p| p.twist.v.into(),
            |p, v: [f64; 3]| p.twist.v = v.into(),
        )?;
        state.column(
            "angular_velocity",
            parts,
            |p| p.twist.w.into(),
            |p, w: [f64; 3]| p.twist.w = w.into(),
        )?;
        if state.restores() {
            for part in parts {
                part.shape.place(&part.pose);
                part.frames = [part.shape.frame_at(&part.pose); 2];
            }
        }
        Ok(())
    }

    /// Forces and torques, the mean over a window of a length [s]; counting begins anew.
    pub fn take_loads(&mut self, window: f64, loads: &mut Vec<Load>) {
        loads.clear();
        for (id, part) in (0..).zip(&mut self.parts) {
            let [force, torque] = part.received.map(|sum| (sum / window).into());
            loads.push(Load { id, force, torque });
            part.received = [Vec3::zeros(); 2];
        }
    }
}

impl HardPart {
    /// The path of a body's centre in the part's frame, which may turn, through the rest of a step:
    /// right at both ends and in its first velocity.
    fn path_of(&self, body: &HardBody, shift: Vec3, last: Vec3, step: f64) -> CentrePath {
        let (done, rest) = (body.time / step, step - body.time);
        let frame =
            if self.moves() { self.shape.frame_at(&self.pose_at(done)) } else { self.frames[0] };
        let x = body.x + shift;
        let v = body.path_velocity();
        if !self.moves() {
            return CentrePath {
                x: frame.to_part(x),
                v: frame.turn_to_part(v),
                a: frame.turn_to_part(body.a),
            };
        }
        let (first, v) =
            (frame.to_part(x), frame.turn_to_part(v - self.velocity_at(x, done, step)));
        let a = if rest > 0.0 {
            (last - first - v * rest) * (2.0 / (rest * rest))
        } else {
            Vec3::zeros()
        };
        CentrePath { x: first, v, a }
    }

    /// A direction of the part in the world, at the part `done` of a step.
    fn turned_out(&self, n: Vec3, done: f64) -> Vec3 {
        if self.moves() {
            self.shape.frame_at(&self.pose_at(done)).turn_to_world(n)
        } else {
            self.frames[0].turn_to_world(n)
        }
    }
}

/// Bytes of a surface that so many triangles take.
pub fn memory(parts: &[HardPart]) -> u64 {
    parts.iter().map(|part| part.shape.triangles() * OF_TRIANGLE).sum()
}

/// Memory of a triangle of a part, with the structures to find it [bytes].
const OF_TRIANGLE: u64 = 360;
