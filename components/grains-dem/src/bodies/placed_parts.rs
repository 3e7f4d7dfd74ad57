//! Rigid parts: surfaces that grains meet, fixed, moved as the scene prescribes, or on an axis
//! under forces.

use crate::Vec3;
use crate::bodies::body_arrays::{Mobility, Twist, Wrench};
use crate::bodies::mirrors;
use crate::bodies::prescribed_motion::{Path, turn};
use crate::bodies::slider::Slider;
use crate::bodies::slider::{ROOM, across_mirrors};
use crate::bodies::wall_triangle::{Grooves, Triangle};
use crate::math::periodic::PeriodicBox;
use tremie_geometry::{Bounds, EdgeKind, Endless, Frame, Surface, motion_problem};
use tremie_messages::{
    Problem,
    body::BodyState,
    scene::{Motion, Part, Pose, Scene},
};

/// Motion of a part: fixed, prescribed or a slider.
enum Drive {
    Fixed,
    Path(Path),
    Slider(Box<Slider>),
}

/// A part where it is.
pub(crate) struct PlacedPart {
    surface: Surface,
    cavity: bool,
    /// By triangle.
    grooves: Vec<Grooves>,
    drive: Drive,
    /// Continuation of the part through periodic faces.
    endless: Endless,
    /// Axes across which symmetry planes cut it.
    mirrors: [bool; 3],
    pub pose: Pose,
    /// Frame of the surface: that of the pose, except along an axis on which the part is endless.
    frame: Frame,
    /// Velocities of its reference point, the origin of its frame.
    pub twist: Twist,
    /// Upper bound of the displacement of its points since neighbours were listed [m].
    pub moved: f64,
    /// Its place among all parts in space, by its box at the start: of parts that share a point of
    /// contact the first has it, in whatever order they are given.
    pub rank: u32,
}

/// A substep: from when to when [s], its length [s], and whether the substep before is to be
/// finished first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub from: f64,
    pub to: f64,
    pub dt: f64,
    pub finish: bool,
}

/// Loads the surfaces of all parts.
///
/// # Errors
/// Surfaces that cannot be had, and motions that are none of a part.
pub(crate) fn load(scene: &Scene) -> Result<Vec<PlacedPart>, Vec<Problem>> {
    let (mut parts, mut problems) = (Vec::new(), Vec::new());
    for (i, part) in scene.parts.iter().enumerate() {
        let key = format!("scene.parts[{i}]");
        if part.motion == Motion::Free {
            let message = "is free, but parts are moved by no force";
            let help = "fix the part, prescribe its motion, make it a slider, or make it a sphere";
            problems.push(Problem::new(format!("{key}.motion"), message).help(help));
        }
        match Surface::in_domain(part, &scene.domain) {
            Ok(surface) => {
                problems.extend(motion_problem(&key, part, &surface, &scene.domain));
                let placed = PlacedPart::new(part, surface, scene);
                problems.extend(placed.mirror_problem(&key, part, scene));
                parts.push(placed);
            }
            Err(error) => problems.extend(error.problems(&format!("{key}.geometry"))),
        }
    }
    give_ranks(&mut parts);
    if problems.is_empty() { Ok(parts) } else { Err(problems) }
}

/// Grooves of each triangle: the edges and corners that nowhere stick out towards the grains.
fn grooves_of(surface: &Surface, cavity: bool) -> Vec<Grooves> {
    let mesh = surface.mesh();
    let out = if cavity { EdgeKind::Concave } else { EdgeKind::Convex };
    // Of each corner, whether any edge there sticks out.
    let mut corners = vec![false; mesh.vertices.len()];
    let walls = |&(t, _): &(usize, &[u32; 3])| surface.is_wall(t as u32);
    for (t, names) in mesh.triangles.iter().enumerate().filter(walls) {
        for (i, kind) in surface.edge_kinds(t as u32).into_iter().enumerate() {
            corners[names[i] as usize] |= kind == out;
            corners[names[(i + 1) % 3] as usize] |= kind == out;
        }
    }
    let of_triangle = |(t, names): (usize, &[u32; 3])| {
        let kinds = surface.edge_kinds(t as u32);
        let bits = (0..3).map(|i| {
            let (edge, corner) = (kinds[i] != out, !corners[names[i] as usize]);
            (u8::from(edge) << i) | (u8::from(corner) << (3 + i))
        });
        Grooves(bits.fold(0, |all, bit| all | bit))
    };
    mesh.triangles.iter().enumerate().map(of_triangle).collect()
}

/// Ranks parts by their boxes.
fn give_ranks(parts: &mut [PlacedPart]) {
    let key = |part: &PlacedPart| {
        let Bounds { min, max } = part.surface.mesh().placed(&part.pose).bounds();
        [<[f64; 3]>::from(min), max.into()].concat()
    };
    let keys: Vec<Vec<f64>> = parts.iter().map(key).collect();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    let compare = |a: &f64, b: &f64| a.total_cmp(b);
    order.sort_by(|&a, &b| {
        let pairs = keys[a].iter().zip(&keys[b]).map(|(a, b)| compare(a, b));
        pairs.fold(core::cmp::Ordering::Equal, core::cmp::Ordering::then).then(a.cmp(&b))
    });
    for (rank, part) in (0..).zip(order) {
        parts[part].rank = rank;
    }
}

impl PlacedPart {
    /// Number of triangles of its surface.
    pub fn triangles(&self) -> u64 {
        self.surface.mesh().triangles.len() as u64
    }

    fn new(part: &Part, surface: Surface, scene: &Scene) -> Self {
        let position = part.pose.position;
        let mirrors = mirrors::of_part(&scene.domain, position);
        let drive = match &part.motion {
            Motion::Free | Motion::Fixed => Drive::Fixed,
            Motion::Prescribed(points) => Drive::Path(Path::new(points, Twist::zero())),
            Motion::Timed(timed) => Drive::Path(Path::timed(timed)),
            Motion::Slider(slider) => {
                let (gravity, whole) = (scene.gravity.into(), mirrors::whole(mirrors));
                Drive::Slider(Box::new(Slider::new(slider, position.into(), gravity, whole)))
            }
        };
        let twist = match &drive {
            Drive::Fixed => Twist::zero(),
            Drive::Path(path) => path.twist(0.0),
            Drive::Slider(slider) => slider.twist(),
        };
        let home = Pose { position: surface.endless().place(position).into(), ..part.pose };
        let frame = Frame::of(&home);
        Self {
            grooves: grooves_of(&surface, part.cavity),
            endless: surface.endless(),
            surface,
            cavity: part.cavity,
            drive,
            mirrors,
            pose: part.pose,
            frame,
            twist,
            moved: 0.0,
            rank: 0,
        }
    }

    /// Problem of a slider's placement relative to the symmetry planes, if any.
    fn mirror_problem(&self, key: &str, part: &Part, scene: &Scene) -> Option<Problem> {
        let Motion::Slider(slider) = &part.motion else { return None };
        let bounds = self.surface.mesh().placed(&self.pose).bounds();
        let (domain, room) = (&scene.domain, ROOM * self.bounding_radius());
        let across = |a: usize, side: usize| {
            let plane = [domain.min, domain.max][side][a];
            bounds.min[a] < plane - room && bounds.max[a] > plane + room
        };
        across_mirrors(key, slider, domain, self.mirrors, across)
    }

    /// True if the part moves, and so is a body of the run.
    pub fn moves(&self) -> bool {
        !matches!(self.drive, Drive::Fixed)
    }

    /// Its degree of freedom, if forces move it.
    pub fn slider(&self) -> Option<&Slider> {
        match &self.drive {
            Drive::Slider(slider) => Some(slider),
            _ => None,
        }
    }

    /// The slider, to be changed, if the part is one.
    pub fn slider_mut(&mut self) -> Option<&mut Slider> {
        match &mut self.drive {
            Drive::Slider(slider) => Some(slider),
            _ => None,
        }
    }

    /// Mobility of a slider along its axis; zero for other parts. Mirrored grains push at the same
    /// time: hence the factor `whole`.
    pub fn mobility(&self) -> Mobility {
        self.slider().map_or(Mobility::NONE, |slider| Mobility {
            inverse_mass: slider.whole / slider.mass,
            ..Mobility::NONE
        })
    }

    /// The load on the whole part, where symmetry planes cut it.
    pub fn whole(&self, load: &Wrench) -> Wrench {
        mirrors::with_images(self.mirrors, load)
    }

    /// Distances count from here on.
    pub fn begin_list(&mut self) {
        self.moved = 0.0;
        if let Some(slider) = self.slider_mut() {
            slider.begin_list();
        }
    }

    /// True if the space inside the surface is free and the space outside is solid.
    pub fn is_cavity(&self) -> bool {
        self.cavity
    }

    /// Radius about the reference point that holds it [m].
    pub fn bounding_radius(&self) -> f64 {
        self.surface.bounding_radius()
    }

    /// Moves it through a substep; `finish` as for spheres. True if its reference point crossed a
    /// periodic face.
    pub fn advance(&mut self, step: &Step, bounds: &PeriodicBox) -> bool {
        let position = match &mut self.drive {
            Drive::Fixed => return false,
            Drive::Path(path) => {
                let way = path.travelled(step.from, step.to);
                self.pose.orientation = turn(self.pose.orientation, way.w);
                self.twist = path.twist(step.to);
                let radius = self.surface.bounding_radius();
                // Along itself a straight one goes nowhere.
                let across =
                    Vec3::from_fn(|a, _| if self.endless.straight[a] { 0.0 } else { way.v[a] });
                self.moved += across.norm_squared().sqrt() + radius * way.w.norm_squared().sqrt();
                Vec3::from(self.pose.position) + way.v
            }
            Drive::Slider(slider) => {
                slider.first_half(step.dt, step.finish);
                self.twist = slider.twist();
                self.moved = slider.moved();
                slider.position()
            }
        };
        let wrapped = bounds.wrap(position);
        if wrapped != position
            && let Drive::Slider(slider) = &mut self.drive
        {
            slider.shift(wrapped - position);
        }
        self.pose.position = wrapped.into();
        let home = self.endless.place(self.pose.position);
        self.frame = Frame::of(&Pose { position: home.into(), ..self.pose });
        (0..3).any(|a| wrapped[a] != position[a] && !self.endless.straight[a])
    }

    /// True if bodies see the part through an image displaced by `shift`. An endless part needs no
    /// image along its endless axes.
    #[inline]
    pub fn is_seen(&self, shift: Vec3) -> bool {
        (0..3).all(|a| shift[a] == 0.0 || !self.endless.axes[a])
    }

    /// Ends a substep: the half kick of a slider.
    pub fn finish(&mut self, dt: f64) {
        if let Drive::Slider(slider) = &mut self.drive {
            slider.second_half(dt);
            self.twist = slider.twist();
        }
    }

    /// Area of its surface [m²].
    pub fn area(&self) -> f64 {
        self.surface.area()
    }

    /// Velocity of its point at `x` [m/s].
    #[inline(always)]
    pub fn velocity_at(&self, x: Vec3) -> Vec3 {
        self.twist.v + self.twist.w.cross(&(x - Vec3::from(self.pose.position)))
    }

    /// A point of the world in the part's frame.
    #[inline(always)]
    pub fn to_part(&self, x: Vec3) -> Vec3 {
        self.frame.to_part(x)
    }

    /// A direction of the part in the world.
    #[inline(always)]
    pub fn to_world(&self, direction: Vec3) -> Vec3 {
        self.frame.turn_to_world(direction)
    }

    /// A triangle, in the part's frame, its normal to the side of the grains.
    #[inline(always)]
    pub fn triangle(&self, index: u32) -> Triangle {
        let surface = &self.surface;
        let normal = surface.normal(index);
        Triangle {
            grooves: self.grooves[index as usize],
            corners: surface.mesh().corners(index as usize),
            normal: if self.cavity { -normal } else { normal },
        }
    }

    /// Puts into `out` the triangles near a sphere with its centre at `x`, in the part's frame.
    pub fn triangles_near(&self, x: Vec3, radius: f64, out: &mut Vec<u32>) {
        let bounds = Bounds { min: x, max: x }.grown(radius);
        if self.surface.bounds().meets(&bounds) {
            self.surface.triangles_near(&bounds, out);
        } else {
            out.clear();
        }
    }

    /// A triangle in the world, its corners anticlockwise seen from the grains.
    pub fn placed_triangle(&self, index: u32) -> Triangle {
        let Triangle { mut corners, normal, .. } = self.triangle(index);
        if self.cavity {
            corners.swap(1, 2);
        }
        let place = |corner: Vec3| self.frame.to_world(corner);
        let normal = self.to_world(normal);
        Triangle { corners: corners.map(place), normal, grooves: Grooves::NONE }
    }

    /// True if a point of the world may be closer to the solid than `gap` [m].
    pub fn is_near(&self, x: Vec3, gap: f64) -> bool {
        self.cavity || self.surface.bounds().grown(gap).contains(self.to_part(x))
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

    /// Distance of a point of the world from the surface [m], negative in the solid, and the unit
    /// vector along which it grows.
    pub fn clearance(&self, x: Vec3) -> (f64, Vec3) {
        let x = self.to_part(x);
        let closest = self.surface.closest(x);
        let sign = if self.cavity { -1.0 } else { 1.0 };
        let away = x - closest.point;
        let length = away.norm_squared().sqrt();
        // On the surface itself there is no line to the closest point.
        let direction = if length > 1e-9 * self.bounding_radius() {
            away * (closest.distance.signum() / length)
        } else {
            closest.normal
        };
        (sign * closest.distance, self.to_world(direction * sign))
    }
}
