//! Inlets and outlets: who comes and who goes at the end of a window.

mod filled;
mod inlet;

use crate::{
    AddedSphere, GrainsDem, GrainsError, Parameters, Vec3,
    bodies::Ball,
    packing::{self, Sizes},
    placement,
    surroundings::Surroundings,
};
use inlet::Feeder;
pub(crate) use inlet::region;
use tremie_messages::scene::{InletVelocity, Outlet, Scene};

/// What an inlet has done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InletState {
    /// Spheres that came since the start.
    pub inserted: u64,
    /// Volume that is still to come to reach the fraction [m³]: 0 where less than half a sphere lacks.
    pub deficit: f64,
    /// Mass that came since the start [kg].
    pub mass_inserted: f64,
}

/// What an outlet has done.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutletState {
    /// Spheres that went since the start.
    pub removed: u64,
    /// Mass that went since the start [kg].
    pub mass_removed: f64,
}

/// Inlets and outlets of a run.
pub(crate) struct Ports {
    feeders: Vec<Feeder>,
    outlets: Vec<(Outlet, OutletState)>,
    /// Most spheres that may live at once.
    pub capacity: usize,
    /// Ids of those that go.
    gone: Vec<u64>,
}

/// Densest random packing of spheres.
const DENSEST: f64 = 0.64;

/// Most spheres that may live at once, of `start` at the start.
pub(crate) fn capacity(scene: &Scene, parameters: &Parameters, start: usize) -> usize {
    if scene.inlets.is_empty() {
        return start;
    }
    if let Some(capacity) = parameters.capacity {
        return capacity as usize;
    }
    let size = scene.domain.size();
    let volume = size[0] * size[1] * size[2];
    let of = |inlet: &tremie_messages::scene::Inlet| {
        (2.0 * inlet.fraction).min(DENSEST) * volume / Sizes::new(&inlet.diameters).mean_volume()
    };
    start + scene.inlets.iter().map(of).fold(0.0, f64::max).ceil() as usize
}

impl Ports {
    /// Those of a scene that is right, for steps of `dt` [s].
    pub fn of_scene(
        scene: &Scene,
        around: &Surroundings,
        parameters: &Parameters,
        dt: f64,
        start: usize,
    ) -> Self {
        let feeders = (0..).zip(&scene.inlets);
        let feeders = feeders.filter_map(|(k, inlet)| Feeder::new(scene, inlet, k, around, dt));
        let outlets = scene.outlets.iter().map(|outlet| (outlet.clone(), OutletState::default()));
        Self {
            feeders: feeders.collect(),
            outlets: outlets.collect(),
            capacity: capacity(scene, parameters, start),
            gone: Vec::new(),
        }
    }
}

impl GrainsDem {
    /// What each inlet has done, in the order of the scene.
    pub fn inlets(&self) -> impl ExactSizeIterator<Item = InletState> + '_ {
        self.ports.feeders.iter().map(|feeder| feeder.state)
    }

    /// What each outlet has done, in the order of the scene.
    pub fn outlets(&self) -> impl ExactSizeIterator<Item = OutletState> + '_ {
        self.ports.outlets.iter().map(|(_, state)| *state)
    }

    /// Tells the mean velocities of the fluid at open faces, as `(axis, side, velocity [m/s])`, for the
    /// spheres that come from now on. Until a face is told its spheres come at rest.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub fn set_port_velocities(
        &mut self,
        velocities: impl IntoIterator<Item = (usize, usize, [f64; 3])>,
    ) -> Result<(), GrainsError> {
        for (axis, side, velocity) in velocities {
            if velocity.iter().any(|v| !v.is_finite()) {
                return Err(GrainsError::PortVelocity { axis, side });
            }
            for feeder in &mut self.ports.feeders {
                if feeder.from == (InletVelocity::Face { axis, side }) {
                    feeder.velocity = velocity;
                }
            }
        }
        Ok(())
    }

    /// Lets spheres go and come, at the end of a window.
    pub(crate) fn pass_ports(&mut self) -> Result<(), GrainsError> {
        self.find_gone();
        let (steps, time) = (self.steps, self.time());
        let due = self.ports.feeders.iter().any(|feeder| feeder.is_due(steps, time));
        let added = if due { self.feed()? } else { Vec::new() };
        if !self.ports.gone.is_empty() || !added.is_empty() {
            let gone = std::mem::take(&mut self.ports.gone);
            self.swap(&gone, &added);
            self.ports.gone = gone;
        }
        Ok(())
    }

    /// Notes who lies in an outlet, by ascending ids; the first outlet counts.
    fn find_gone(&mut self) {
        let Ports { outlets, gone, .. } = &mut self.ports;
        gone.clear();
        if outlets.is_empty() {
            return;
        }
        for (&id, &slot) in self.bodies.ids.iter().zip(&self.bodies.slot) {
            let slot = slot as usize;
            let x = self.bodies.balls[slot].x.into();
            let Some((_, state)) = outlets.iter_mut().find(|(outlet, _)| outlet.holds(x)) else {
                continue;
            };
            gone.push(id);
            state.removed += 1;
            let density = self.sets[self.bodies.set[slot] as usize].density;
            state.mass_removed += placement::mass(density, 2.0 * self.bodies.balls[slot].radius);
        }
    }

    /// The spheres that come, at the inlets in their order.
    fn feed(&mut self) -> Result<Vec<AddedSphere>, GrainsError> {
        let gone = &self.ports.gone;
        let stays = |id: &u64| gone.binary_search(id).is_err();
        let living = self.bodies.ids.iter().zip(&self.bodies.slot);
        let living = living.filter(|(id, _)| stays(id));
        let balls: Vec<Ball> = living.map(|(_, &slot)| self.bodies.balls[slot as usize]).collect();
        let mut around = packing::Surroundings {
            parts: &self.around.parts,
            bounds: self.around.bounds.clone(),
            planes: self.around.walls.clone(),
            balls,
        };
        let (steps, time) = (self.steps, self.time());
        let mut added: Vec<AddedSphere> = Vec::new();
        let capacity = self.ports.capacity;
        for feeder in &mut self.ports.feeders {
            if !feeder.is_due(steps, time) {
                continue;
            }
            let next = self.next_id + added.len() as u64;
            let came = feeder.feed(&around, steps, next);
            if around.balls.len() + came.len() > capacity {
                return Err(GrainsError::Capacity { inlet: feeder.name.clone(), capacity });
            }
            for &ball in &came {
                feeder.count(ball, self.sets[feeder.set].density);
                added.push(AddedSphere {
                    set: feeder.set,
                    position: ball.x.into(),
                    diameter: 2.0 * ball.radius,
                    velocity: feeder.velocity,
                });
            }
            around.balls.extend(came);
        }
        Ok(added)
    }
}

/// The side from which things come that move like this, along the axis along which they are fastest.
fn upstream(velocity: Vec3) -> Option<(usize, usize)> {
    let axis =
        (0..3).fold(0, |best, a| if velocity[a].abs() > velocity[best].abs() { a } else { best });
    (velocity[axis] != 0.0).then(|| (axis, usize::from(velocity[axis] < 0.0)))
}
