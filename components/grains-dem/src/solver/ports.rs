//! Inlets and outlets: spheres that come and go at the end of a window.

mod filled;
mod inlet;

use crate::Vec3;
use crate::bodies::body_arrays::BoundingSphere;
use crate::bodies::placed_parts::PlacedPart;
use crate::math::error::GrainsError;
use crate::math::parameters::Parameters;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::exchange::AddedSphere;
use crate::solver::interaction_context::InteractionContext;
use crate::solver::placement;
use inlet::Feeder;
pub(crate) use inlet::region;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::packing::random_packing::{self, Feeding, Sizes};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls::Wall;
use tremie_messages::scene::{Diameters, Domain, InletVelocity, Outlet, Packing, Scene};
use tremie_state::{StateError, StateExchange};

/// Totals of an inlet since the start, and its deficit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InletState {
    /// Spheres that came since the start.
    pub inserted: u64,
    /// Volume that is still to come to reach the fraction [m³]: 0 where less than half a sphere
    /// lacks.
    pub deficit: f64,
    /// Mass that came since the start [kg].
    pub mass_inserted: f64,
}

/// Totals of an outlet since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    /// Ids of spheres that leave.
    gone: Vec<u64>,
}

/// Densest random packing of spheres that are alike.
const DENSEST: f64 = 0.64;

/// Part by which there is more room than fits.
const SPARE: f64 = 0.05;

/// Most spheres that there is room for where nobody says: a GB of memory, and some 100 MB of shared
/// memory.
const MOST: f64 = 5e5;

/// Room for spheres: the most that may live at once, and the number that fits into the domain.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Room {
    /// Most spheres that may live at once.
    pub capacity: usize,
    /// Spheres that fit, those at the start among them, if inlets fill what parts leave of the
    /// domain.
    pub fits: f64,
    /// Volume of grains over that of the space that they fill.
    pub fraction: f64,
}

/// Room in a scene with inlets and `start` spheres at the start; without inlets exactly for these.
pub(crate) fn room(
    scene: &Scene,
    parameters: &Parameters,
    start: usize,
    parts: &[PlacedPart],
) -> Room {
    let none = Room { capacity: start, fits: start as f64, fraction: 0.0 };
    if scene.inlets.is_empty() {
        return none;
    }
    let fraction = densest(scene);
    let there: f64 = scene.bodies.iter().map(|set| set.placement.sizes().volume()).sum();
    let left = (fraction * free_volume(scene, parts) - there).max(0.0);
    let smallest = scene.inlets.iter().map(|inlet| Sizes::new(&inlet.diameters).mean_volume());
    let fits = start as f64 + left / smallest.fold(f64::INFINITY, f64::min);
    let spare = (fits * (1.0 + SPARE)).ceil().min(MOST).max(start as f64);
    let capacity = parameters.capacity.map_or(spare as usize, |capacity| capacity as usize);
    Room { capacity, fits, fraction }
}

/// The densest random packing of what inlets bring: small grains fit into the gaps between large
/// ones, the better the smaller they are, up to a tenth (Furnas, 1931).
fn densest(scene: &Scene) -> f64 {
    let [small, large] = scene.inlets.iter().fold([f64::INFINITY, 0.0f64], |[low, high], inlet| {
        let [small, large] = inlet.diameters.extremes();
        [low.min(small), high.max(large)]
    });
    let ratio = libm::log10((large / small).clamp(1.0, 10.0));
    1.0 - libm::pow(1.0 - DENSEST, 1.0 + ratio)
}

/// Volume of the domain outside parts and planes [m³], from points between them.
fn free_volume(scene: &Scene, parts: &[PlacedPart]) -> f64 {
    let (Domain { min, max, .. }, size) = (&scene.domain, scene.domain.size());
    let whole: f64 = size.into_iter().product();
    if parts.is_empty() && scene.planes.is_empty() {
        return whole;
    }
    let around = random_packing::PackingSurroundings {
        parts,
        bounds: PeriodicBox::new(&scene.domain),
        planes: scene
            .planes
            .iter()
            .map(|plane| Wall::through(plane.point.into(), plane.normal.into()))
            .collect(),
        balls: Vec::new(),
    };
    let region = Packing {
        min: *min,
        max: *max,
        fraction: 0.0,
        diameters: Diameters::Listed(Vec::new()),
        seed: 0,
    };
    // No sphere is put there: their size is of no account.
    let coarse = size.into_iter().fold(f64::INFINITY, f64::min);
    Feeding::new(&region, &around, 0.1 * coarse).free_volume()
}

impl Ports {
    /// Keeps the accounts of inlets and outlets, or puts them back.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        for (k, feeder) in self.feeders.iter_mut().enumerate() {
            state.within(&format!("inlet{k}"), |state| feeder.exchange(state))?;
        }
        for (k, (_, totals)) in self.outlets.iter_mut().enumerate() {
            state.value(&format!("outlet{k}"), totals)?;
        }
        Ok(())
    }

    /// Inlets and outlets of a valid scene, for steps of `dt` [s].
    pub fn of_scene(
        scene: &Scene,
        around: &InteractionContext,
        parameters: &Parameters,
        dt: f64,
        start: usize,
    ) -> Self {
        let room = room(scene, parameters, start, &around.parts);
        let feeders = (0..).zip(&scene.inlets);
        let feeders = feeders.filter_map(|(k, inlet)| Feeder::new(scene, inlet, k, around, dt));
        let outlets = scene.outlets.iter().map(|outlet| (outlet.clone(), OutletState::default()));
        Self {
            feeders: feeders.collect(),
            outlets: outlets.collect(),
            capacity: room.capacity,
            gone: Vec::new(),
        }
    }
}

impl GrainsDem {
    /// State of each inlet, in the order of the scene.
    pub fn inlets(&self) -> impl ExactSizeIterator<Item = InletState> + '_ {
        self.ports.feeders.iter().map(|feeder| feeder.state)
    }

    /// State of each outlet, in the order of the scene.
    pub fn outlets(&self) -> impl ExactSizeIterator<Item = OutletState> + '_ {
        self.ports.outlets.iter().map(|(_, state)| *state)
    }

    /// Tells the mean velocities of the fluid at open faces, as `(axis, side, velocity [m/s])`, for
    /// the spheres that come from now on. Until a face is told its spheres come at rest.
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
        let (steps, time) = (self.stepping.steps, self.time());
        let due = self.ports.feeders.iter().any(|feeder| feeder.is_due(steps, time));
        let added = if due { self.feed()? } else { Vec::new() };
        if !self.ports.gone.is_empty() || !added.is_empty() {
            let gone = std::mem::take(&mut self.ports.gone);
            self.swap(&gone, &added);
            self.ports.gone = gone;
        }
        Ok(())
    }

    /// Notes the spheres in an outlet, by ascending ids; the first outlet counts.
    fn find_gone(&mut self) {
        let Ports { outlets, gone, .. } = &mut self.ports;
        gone.clear();
        if outlets.is_empty() {
            return;
        }
        for (&id, &slot) in self.population.bodies.ids.iter().zip(&self.population.bodies.slot) {
            let slot = slot as usize;
            let x = self.population.bodies.balls[slot].x.into();
            let Some((_, state)) = outlets.iter_mut().find(|(outlet, _)| outlet.holds(x)) else {
                continue;
            };
            gone.push(id);
            state.removed += 1;
            let density = self.population.sets[self.population.bodies.set[slot] as usize].density;
            state.mass_removed +=
                placement::mass(density, 2.0 * self.population.bodies.balls[slot].radius);
        }
    }

    /// The spheres that come, at the inlets in their order.
    fn feed(&mut self) -> Result<Vec<AddedSphere>, GrainsError> {
        let gone = &self.ports.gone;
        let stays = |id: &u64| gone.binary_search(id).is_err();
        let living = self.population.bodies.ids.iter().zip(&self.population.bodies.slot);
        let living = living.filter(|(id, _)| stays(id));
        let balls: Vec<BoundingSphere> =
            living.map(|(_, &slot)| self.population.bodies.balls[slot as usize]).collect();
        let mut around = random_packing::PackingSurroundings {
            parts: &self.around.parts,
            bounds: self.around.bounds.clone(),
            planes: self.around.walls.clone(),
            balls,
        };
        let (steps, time) = (self.stepping.steps, self.time());
        let mut added: Vec<AddedSphere> = Vec::new();
        let capacity = self.ports.capacity;
        for feeder in &mut self.ports.feeders {
            if !feeder.is_due(steps, time) {
                continue;
            }
            let next = self.population.next_id + added.len() as u64;
            let came = feeder.feed(&around, steps, next);
            if around.balls.len() + came.len() > capacity {
                return Err(GrainsError::Capacity { inlet: feeder.name.clone(), capacity });
            }
            for &ball in &came {
                feeder.count(ball, self.population.sets[feeder.set].density);
                added.push(AddedSphere {
                    set: feeder.set,
                    position: ball.x.into(),
                    diameter: 2.0 * ball.radius,
                    velocity: feeder.velocity,
                });
            }
            // Later inlets keep clear of these.
            around.balls.extend(came);
        }
        Ok(added)
    }
}

/// The side from which things come that move like this, along the axis along which they are
/// fastest.
fn upstream(velocity: Vec3) -> Option<(usize, usize)> {
    let axis =
        (0..3).fold(0, |best, a| if velocity[a].abs() > velocity[best].abs() { a } else { best });
    (velocity[axis] != 0.0).then(|| (axis, usize::from(velocity[axis] < 0.0)))
}
