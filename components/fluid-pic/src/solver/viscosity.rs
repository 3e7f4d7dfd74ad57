//! Viscosity, implicit in time: `(1 - dt nu lap) u = u^n`.
//!
//! What a link ([`WallLink`]) takes from the fluid, its wall or body gets. Air does not shear the
//! fluid.
//!
//! Velocities of free bodies are unknowns as well: a small body in a viscous fluid follows it in much
//! less than a step. They are eliminated ([`DraggedBody`]).
//!
//! The links make the traction `mu du/dn`. That of the fluid is `mu (du/dn + grad u . n)`; on a rigid
//! surface the second term has no force, and the torque `-2 mu V omega` (`V` the body's volume, from
//! the divergence theorem), which is added.

use crate::pressure::body_coupling::{Wrench, dot6};
use crate::solids::open_fractions::NONE;
use crate::solids::rigid_body::RigidBody;
use crate::solver::dragged_body::DraggedBody;
use crate::solver::shear_equations::{ShearEquations, gather, solve};
use crate::solver::wall_links::{ViscousStep, WallLink};
use tremie_state::{StateError, StateExchange};
use tremie_team::{Team, Variant};

/// Forces of shear.
#[derive(Clone, Debug)]
pub struct ShearLoads<const D: usize> {
    /// On each solid, those at rest first; forces and torques about their centres.
    pub solids: Vec<Wrench>,
    /// On the walls of the box, lower and upper along each axis.
    pub walls: [[[f64; D]; 2]; D],
}

impl<const D: usize> ShearLoads<D> {
    /// Keeps the forces of the last step, or puts them back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.list("solids", &mut self.solids)?;
        state.array("walls", self.walls.as_flattened_mut())
    }
}

/// The viscous step, and room to work in.
pub struct Viscosity<const D: usize> {
    /// One for each component; none before the first step.
    equations: Vec<ShearEquations<D>>,
    links: Vec<WallLink>,
    dragged: Vec<DraggedBody>,
    /// Forces of the last step.
    pub loads: ShearLoads<D>,
}

impl<const D: usize> Default for Viscosity<D> {
    fn default() -> Self {
        Self {
            equations: Vec::new(),
            links: Vec::new(),
            dragged: Vec::new(),
            loads: ShearLoads { solids: Vec::new(), walls: [[[0.0; D]; 2]; D] },
        }
    }
}

impl<const D: usize> Viscosity<D> {
    /// Forgets the forces of the last step, with solids at rest and bodies to come.
    pub fn clear(&mut self, at_rest: usize, bodies: &[RigidBody<D>], full: f64) {
        self.loads.solids.clear();
        self.loads.solids.resize(at_rest + bodies.len(), [0.0; 6]);
        self.loads.walls = [[[0.0; D]; 2]; D];
        self.dragged.clear();
        let free = bodies.iter().filter(|body| body.is_free());
        self.dragged
            .extend(free.map(|body| DraggedBody::new(body.motion(), body.mobility_by_shear(full))));
    }

    /// Shears all components of the velocity, on the faces that `is_carried`.
    pub fn shear(
        &mut self,
        team: &mut Team,
        variant: Variant,
        step: &ViscousStep<D>,
        is_carried: &[Vec<bool>; D],
        velocity: &mut [Vec<f64>; D],
    ) {
        let full = step.density * step.grid.cell_volume();
        self.clear(step.fractions.at_rest.len(), step.bodies, full);
        for (dragged, gain) in self.dragged.iter_mut().zip(step.gains) {
            (0..6).for_each(|k| dragged.motion[k] += gain[k]);
        }
        if self.equations.is_empty() {
            self.equations.extend((0..D).map(|_| ShearEquations::new(step.grid)));
        }
        self.links.clear();
        for axis in 0..D {
            let (is_carried, velocity) = (&is_carried[axis], &velocity[axis]);
            self.equations[axis].assemble(step, axis, is_carried, velocity, &mut self.links);
        }
        self.prepare_bodies(step);
        let Self { equations, links, dragged, .. } = self;
        solve(team, variant, equations, (links, dragged), velocity);
        self.move_bodies(velocity);
        self.take_loads(step, velocity);
        self.take_rotation(step);
    }

    /// Torques that rigid surfaces feel by their rotation, beyond those of the links.
    fn take_rotation(&mut self, step: &ViscousStep<D>) {
        if !step.bodies_stick {
            return;
        }
        let at_rest = step.fractions.at_rest.len();
        let mut free = 0;
        for (number, body) in step.bodies.iter().enumerate() {
            let mut motion = body.motion();
            if body.is_free() {
                motion = self.dragged[free].motion;
                free += 1;
            }
            let unit = step.density * step.grid.cell_volume() / step.dt;
            let drag = unit * rotation_drag(step, body);
            let load = &mut self.loads.solids[at_rest + number];
            (3..6).for_each(|k| load[k] -= drag * motion[k]);
        }
    }

    /// Takes the links of the free bodies in, and what of the bodies' velocities enters the right
    /// side.
    fn prepare_bodies(&mut self, step: &ViscousStep<D>) {
        let Self { equations, links, dragged, .. } = self;
        let free = step.bodies.iter().filter(|body| body.is_free());
        for (dragged, body) in dragged.iter_mut().zip(free) {
            dragged.begin(if step.bodies_stick { rotation_drag(step, body) } else { 0.0 });
        }
        let free = |link: &&WallLink| link.free != NONE;
        for link in links.iter().filter(free) {
            dragged[link.free as usize].add_link(link.weight, &link.arm);
        }
        dragged.iter_mut().for_each(DraggedBody::eliminate);
        for link in links.iter().filter(free) {
            let own = dragged[link.free as usize].velocity_without_fluid(&link.arm);
            equations[usize::from(link.axis)].right[link.face as usize] += link.weight * own;
        }
    }

    /// Velocities of the free bodies, and those of their surfaces.
    fn move_bodies(&mut self, u: &[Vec<f64>; D]) {
        let Self { links, dragged, .. } = self;
        gather(links, dragged, u);
        dragged.iter_mut().for_each(DraggedBody::take_motion);
        for link in links.iter_mut().filter(|link| link.free != NONE) {
            link.velocity = dot6(&link.arm, &dragged[link.free as usize].motion);
        }
    }

    /// Gives what the links took from the fluid to bodies and walls: `mu h^(D-2) (u - u_wall) / theta`.
    fn take_loads(&mut self, step: &ViscousStep<D>, velocity: &[Vec<f64>; D]) {
        let unit = step.density * step.grid.cell_volume() / step.dt;
        for link in &self.links {
            let axis = usize::from(link.axis);
            let own = velocity[axis][link.face as usize];
            let force = unit * link.weight * (own - link.velocity);
            if link.solid == NONE {
                let (a, side) = link.wall;
                self.loads.walls[usize::from(a)][usize::from(side)][axis] += force;
                continue;
            }
            let load = &mut self.loads.solids[link.solid as usize];
            (0..6).for_each(|k| load[k] += force * link.arm[k]);
        }
    }
}

/// What the rotation of a rigid surface takes of its angular velocity in a step: `2 mu V dt`, over
/// the mass of a full cell.
fn rotation_drag<const D: usize>(step: &ViscousStep<D>, body: &RigidBody<D>) -> f64 {
    let edge = step.grid.spacing;
    2.0 * step.number * edge * edge * body.volume() / step.grid.cell_volume()
}

#[cfg(test)]
mod tests;
