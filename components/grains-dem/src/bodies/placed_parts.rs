//! Rigid parts: surfaces that grains meet, fixed, moved as the scene prescribes, or on an axis
//! under forces.

use crate::Vec3;
use crate::bodies::body_arrays::{Mobility, Twist, Wrench};
use crate::bodies::mirrors;
use crate::bodies::slider::Slider;
use crate::bodies::slider::{ROOM, across_mirrors};
use tremie_geometry::{Bounds, Surface, motion_problem};
use tremie_grains_kit::motion::prescribed_motion::{Path, turn};
use tremie_grains_kit::space::part_surface::PartSurface;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_messages::{
    Problem,
    body::BodyState,
    scene::{Motion, Part, Pose, Scene},
};
use tremie_state::{StateError, StateExchange};

/// Motion of a part: fixed, prescribed or a slider.
enum Drive {
    Fixed,
    Path(Path),
    Slider(Box<Slider>),
}

/// A part where it is.
pub(crate) struct PlacedPart {
    /// Its surface, where it is.
    pub shape: PartSurface,
    drive: Drive,
    /// Axes across which symmetry planes cut it.
    mirrors: [bool; 3],
    pub pose: Pose,
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

/// Ranks parts by their boxes.
fn give_ranks(parts: &mut [PlacedPart]) {
    let key = |part: &PlacedPart| {
        let Bounds { min, max } = part.shape.surface().mesh().placed(&part.pose).bounds();
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
        Self {
            shape: PartSurface::new(surface, part.cavity, &part.pose),
            drive,
            mirrors,
            pose: part.pose,
            twist,
            moved: 0.0,
            rank: 0,
        }
    }

    /// Problem of a slider's placement relative to the symmetry planes, if any.
    fn mirror_problem(&self, key: &str, part: &Part, scene: &Scene) -> Option<Problem> {
        let Motion::Slider(slider) = &part.motion else { return None };
        let bounds = self.shape.surface().mesh().placed(&self.pose).bounds();
        let (domain, room) = (&scene.domain, ROOM * self.shape.bounding_radius());
        let across = |a: usize, side: usize| {
            let plane = [domain.min, domain.max][side][a];
            bounds.min[a] < plane - room && bounds.max[a] > plane + room
        };
        across_mirrors(key, slider, domain, self.mirrors, across)
    }

    /// Keeps where the part is at a window's end, or puts it back there.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.array("position", &mut self.pose.position)?;
        state.array("orientation", &mut self.pose.orientation)?;
        state.value("twist", &mut self.twist)?;
        state.value("moved", &mut self.moved)?;
        if let Drive::Slider(slider) = &mut self.drive {
            state.within("slider", |state| slider.exchange(state))?;
        }
        if state.restores() {
            self.shape.place(&self.pose);
        }
        Ok(())
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

    /// Moves it through a substep; `finish` as for spheres. True if its reference point crossed a
    /// periodic face.
    pub fn advance(&mut self, step: &Step, bounds: &PeriodicBox) -> bool {
        let position = match &mut self.drive {
            Drive::Fixed => return false,
            Drive::Path(path) => {
                let way = path.travelled(step.from, step.to);
                self.pose.orientation = turn(self.pose.orientation, way.w);
                self.twist = path.twist(step.to);
                let radius = self.shape.bounding_radius();
                // Along itself a straight one goes nowhere.
                let across =
                    Vec3::from_fn(
                        |a, _| if self.shape.endless().straight[a] { 0.0 } else { way.v[a] },
                    );
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
        self.shape.place(&self.pose);
        (0..3).any(|a| wrapped[a] != position[a] && !self.shape.endless().straight[a])
    }

    /// Ends a substep: the half kick of a slider.
    pub fn finish(&mut self, dt: f64) {
        if let Drive::Slider(slider) = &mut self.drive {
            slider.second_half(dt);
            self.twist = slider.twist();
        }
    }

    /// Velocity of its point at `x` [m/s].
    #[inline(always)]
    pub fn velocity_at(&self, x: Vec3) -> Vec3 {
        self.twist.v + self.twist.w.cross(&(x - Vec3::from(self.pose.position)))
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
}

impl SolidPart for PlacedPart {
    fn clearance(&self, x: Vec3) -> (f64, Vec3) {
        self.shape.clearance(x)
    }

    fn is_cavity(&self) -> bool {
        self.shape.is_cavity()
    }

    #[inline]
    fn is_seen(&self, shift: Vec3) -> bool {
        self.shape.is_seen(shift)
    }
}
