//! The faces of a scene's domain as the solver takes them.

use crate::solids::section::Section;
use crate::solver::open_faces::{FaceFlow, OpenFace};
use crate::solver::pic_settings::BoxWall;
use tremie_messages::scene::{Course, Face, OpenVelocity, Outflow, Profile, Scene};

/// A wall's velocity [m/s] and its factor over time, where the wall holds the fluid back.
type MovingWall<const D: usize> = Option<([f64; D], Course)>;

/// Faces of a scene, and the courses of their velocities and pressures.
#[derive(Clone, Debug)]
pub struct SceneFaces<const D: usize> {
    /// The open faces.
    pub open: Vec<OpenFace<D>>,
    courses: Vec<Course>,
    walls: [[MovingWall<D>; 2]; D],
}

impl<const D: usize> SceneFaces<D> {
    /// Of a scene that was checked. `sticks` says if walls hold the fluid back.
    pub fn new(scene: &Scene, section: &Section<D>, sticks: bool) -> Self {
        let (mut open, mut courses) = (Vec::new(), Vec::new());
        for (a, &axis) in section.axes.iter().enumerate() {
            for side in 0..2 {
                let (flow, course) = match &scene.domain.faces[axis][side] {
                    Face::Velocity(OpenVelocity { velocity, profile, course }) => {
                        let velocity = section.along(*velocity);
                        let is_parabolic = *profile == Profile::Parabolic;
                        (FaceFlow::Velocity { velocity, is_parabolic }, course)
                    }
                    Face::Pressure { pressure, course, outflow } => {
                        let absorbs = *outflow == Outflow::Absorbing;
                        (FaceFlow::Pressure { pressure: *pressure, absorbs }, course)
                    }
                    _ => continue,
                };
                let level = scene.domain.levels[axis][side];
                open.push(OpenFace { axis: a, side, flow, level });
                courses.push(course.clone());
            }
        }
        let walls = std::array::from_fn(|a| {
            [0, 1].map(|side| match &scene.domain.faces[section.axes[a]][side] {
                Face::Wall { velocity, course } if sticks => {
                    Some((section.along(*velocity), course.clone()))
                }
                _ => None,
            })
        });
        Self { open, courses, walls }
    }

    /// Factors of velocities and pressures at a time [s].
    pub fn factors(&self, time: f64) -> impl Iterator<Item = f64> + '_ {
        self.courses.iter().map(move |course| course.at(time))
    }

    /// Walls of the box at a time [s], as the fluid's shear feels them.
    pub fn walls(&self, time: f64) -> [[BoxWall<D>; 2]; D] {
        self.walls.each_ref().map(|sides| {
            sides.each_ref().map(|wall| match wall {
                Some((velocity, course)) => BoxWall::Stick(velocity.map(|u| u * course.at(time))),
                None => BoxWall::Slip,
            })
        })
    }
}
