//! Bodies, clumps and parts whose motion and fluid loads are signals, in a run.

use crate::bodies::placed_parts::PlacedPart;
use crate::solver::dem_solver::GrainsDem;
use tremie_grains_kit::signals::body_signals::{FLUID, MOTION};
use tremie_grains_kit::signals::followed::{Followed, of_scene};
use tremie_messages::scene::{Motion, Scene};
use tremie_messages::start::signal_row::push;
use tremie_messages::{BodyEvent, BodyState, Load};

/// Bodies and clumps followed in a run, by id.
#[derive(Clone, Debug, Default)]
pub(crate) struct Follow {
    all: Vec<Target>,
    parts: Vec<bool>,
    has_fluid: bool,
}

#[derive(Clone, Copy, Debug)]
enum Target {
    Body(u64),
    Clump(usize),
}

impl Follow {
    /// Follows a scene whose bodies came with these events.
    pub fn new(scene: &Scene, events: &[BodyEvent]) -> Self {
        let id_of = |set: usize, place: usize| {
            let own =
                |event: &&BodyEvent| event.shape != BodyEvent::PART && event.set as usize == set;
            events.iter().filter(own).nth(place).map(|event| event.id)
        };
        let target = |(_, followed): (String, Followed)| match followed {
            // Nobody has the last id.
            Followed::Body { set, place } => Target::Body(id_of(set, place).unwrap_or(u64::MAX)),
            Followed::Clump(number) => Target::Clump(number),
        };
        Self {
            all: of_scene(scene).into_iter().map(target).collect(),
            parts: scene.parts.iter().map(|part| part.motion != Motion::Fixed).collect(),
            has_fluid: scene.fluid.is_some(),
        }
    }

    /// Pushes the values of bodies and clumps; no numbers of one that has left.
    pub fn push(&self, grains: &GrainsDem, values: &mut Vec<f64>) {
        for target in &self.all {
            let found = match *target {
                Target::Body(id) => grains.body(id),
                Target::Clump(number) => grains.clump(number),
            };
            let Some((state, load)) = found else {
                let count = MOTION.len() + if self.has_fluid { FLUID.len() } else { 0 };
                values.extend(std::iter::repeat_n(f64::NAN, count));
                continue;
            };
            push(MOTION, &state, values);
            if self.has_fluid {
                push(FLUID, &load, values);
            }
        }
    }

    /// True if a part moves, so that its motion is a signal.
    pub fn moves(&self, part: usize) -> bool {
        self.parts[part]
    }
}

impl GrainsDem {
    /// A sphere or polyhedron that lives, as it is at the end of the last substep, and the load of
    /// the fluid under which it went through the last window; no load in a dry run.
    pub fn body(&self, id: u64) -> Option<(BodyState, Load)> {
        let bodies = &self.population.bodies;
        let rank = bodies.ids.binary_search(&id).ok()?;
        let slot = bodies.slot[rank] as usize;
        let twist = &bodies.twists[slot];
        let state = BodyState {
            id,
            position: bodies.balls[slot].x.into(),
            orientation: bodies.orientation[slot],
            velocity: twist.v.into(),
            angular_velocity: twist.w.into(),
        };
        let mut load = Load { id, ..Load::default() };
        if self.fluid.loaded {
            let own = &bodies.load[slot];
            (load.force, load.torque) = (own.force.into(), own.torque.into());
        }
        Some((state, load))
    }

    /// State and load of a clump, by its number: of its centroid, and about it. Its orientation is
    /// that from the start.
    pub fn clump(&self, number: usize) -> Option<(BodyState, Load)> {
        let clump = self.population.clumps.all().get(number)?;
        let mut load = Load { id: number as u64, ..Load::default() };
        if self.fluid.loaded {
            let own = clump.load(&self.population.bodies);
            (load.force, load.torque) = (own.force.into(), own.torque.into());
        }
        let mut state = clump.state(&self.population.bodies);
        state.position = self.around.bounds.wrap(state.position.into()).into();
        Some((state, load))
    }

    /// A part of the scene as it is at the end of the last substep.
    pub fn part(&self, part: usize) -> Option<BodyState> {
        self.around.parts.get(part).map(|placed: &PlacedPart| placed.state(part as u64))
    }
}
