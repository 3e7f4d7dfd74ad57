//! The faces of a scene's domain as the solver takes them.

use crate::domain::initial_gas::InitialGas;
use crate::domain::parameters::Parameters;
use crate::domain::world_axes::WorldAxes;
use crate::gas::gas_law::GasState;
use crate::solver::domain_faces::{DomainFace, DomainFaces};
use crate::solver::sponge::Sponge;
use tremie_messages::scene::{Domain, Face, OpenVelocity, Outflow, Scene};

/// Faces of a scene, and their courses over time.
#[derive(Clone, Debug)]
pub struct SceneFaces {
    axes: WorldAxes,
    domain: Domain,
    initial: InitialGas,
}

impl SceneFaces {
    /// Of a scene that was checked.
    pub fn new(scene: &Scene, axes: WorldAxes, initial: &InitialGas) -> Self {
        Self { axes, domain: scene.domain.clone(), initial: initial.clone() }
    }

    /// True if no gas comes or goes.
    pub fn are_closed(&self) -> bool {
        !self.domain.faces.iter().flatten().any(Face::is_open)
    }

    /// The faces at a time [s].
    pub fn at(&self, time: f64) -> DomainFaces {
        let mut faces = [[DomainFace::Periodic; 2]; 3];
        for a in 0..self.axes.dims {
            for side in 0..2 {
                faces[a][side] = self.face(self.axes.order[a], side, time);
            }
        }
        faces
    }

    fn face(&self, axis: usize, side: usize, time: f64) -> DomainFace {
        let law = &self.initial.law;
        match &self.domain.faces[axis][side] {
            Face::Periodic => DomainFace::Periodic,
            Face::Wall { velocity, course } if law.viscosity > 0.0 => {
                let factor = course.at(time);
                DomainFace::Wall(self.axes.along(*velocity).map(|u| u * factor))
            }
            Face::Wall { .. } | Face::Symmetry => DomainFace::Mirror,
            Face::Velocity(OpenVelocity { velocity, course, .. }) => {
                let factor = course.at(time);
                let start = self.initial.at(self.middle(axis, side));
                let velocity = self.axes.along(velocity.map(|u| u * factor));
                DomainFace::Given(law.fields(self.axes.dims, GasState { velocity, ..start }))
            }
            Face::Pressure { pressure, course, outflow: Outflow::Fixed } => {
                let pressure = self.initial.rest.pressure + pressure * course.at(time);
                DomainFace::Pressure(pressure / (law.heat_ratio - 1.0))
            }
            Face::Pressure { .. } | Face::Reservoir(_) => DomainFace::Open,
        }
    }

    /// The middle of a face [m].
    fn middle(&self, axis: usize, side: usize) -> [f64; 3] {
        let Domain { min, max, .. } = &self.domain;
        let mut middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (min[a] + max[a]));
        middle[axis] = [min[axis], max[axis]][side];
        middle
    }

    /// The layer at open faces, if the parameters ask for one.
    pub fn sponge(&self, parameters: &Parameters) -> Option<Sponge> {
        let table = parameters.sponge?;
        let mut faces = [[false; 2]; 3];
        for a in 0..self.axes.dims {
            faces[a] = self.domain.faces[self.axes.order[a]].each_ref().map(Face::is_open);
        }
        let rest = self.initial.rest;
        let velocity = self.axes.along(rest.velocity);
        Some(Sponge {
            faces,
            width: table.width.0,
            rate: table.strength * self.initial.sound_speed() / table.width.0,
            state: self.initial.law.fields(self.axes.dims, GasState { velocity, ..rest }),
        })
    }
}
