//! Signals by which a run of grains of every kind is watched: the way of the fastest body in a step,
//! and the energy that the method made.

use serde::{Deserialize, Serialize};
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, Motion, Scene, Spring};
use tremie_messages::start::signal_row::SignalRow;
use tremie_messages::{Limit, WatchedQuantity};
use tremie_state::{StateError, StateExchange};

/// How sound the motion is at the end of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Soundness {
    /// Way of the fastest body in a step over the smallest radius.
    pub way: f64,
    /// Growth of the energy since the start over that at the start.
    pub energy_gain: f64,
}

/// Name of the signal with the way in a step.
pub const WAY: &str = "way_in_step";
const GAIN: &str = "energy_gain";

/// Signals of all bodies together.
pub const OF_SOUNDNESS: &[SignalRow<Soundness>] = &[
    (
        WAY,
        "1",
        "way of the fastest free body or slider in a step over the smallest radius; 0 where no steps are made",
        |s| s.way,
    ),
    (
        GAIN,
        "1",
        "growth since the start of the energies of motion, rotation, weight and springs together, over them at the start; 0 if they fell",
        |s| s.energy_gain,
    ),
];

/// The energy at the start, beside which later ones are seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EnergyAccount {
    gravity: [f64; 3],
    first: Option<f64>,
}

impl EnergyAccount {
    /// Of grains with this acceleration of gravity [m/s2].
    pub fn under(gravity: [f64; 3]) -> Self {
        Self { gravity, first: None }
    }

    /// Keeps the account, or puts it back. Where a run goes on under another gravity, the grains have
    /// another energy, and a new account begins.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let mut kept = *self;
        state.value("energy", &mut kept)?;
        if kept.gravity == self.gravity {
            *self = kept;
        }
        Ok(())
    }

    /// Growth of the energy since it was told first, over that; 0 if it fell, or was nothing.
    pub fn gain(&mut self, energy: f64) -> f64 {
        let first = *self.first.get_or_insert(energy);
        if first > 0.0 { (energy / first - 1.0).max(0.0) } else { 0.0 }
    }
}

/// Way of a speed in a step over a radius; 0 without a body.
pub fn way_in_step(speed: f64, step: f64, radius: f64) -> f64 {
    if radius > 0.0 && radius.is_finite() { speed * step / radius } else { 0.0 }
}

/// True if nothing but weight and contacts acts on the grains of a scene, so that their energy can
/// only fall: no fluid, nothing that moves as prescribed or on a spring, no grains that come or go,
/// no weight along a periodic axis, no adhesion.
pub fn keeps_energy(scene: &Scene) -> bool {
    let is_at_rest = |face: &Face| match face {
        Face::Wall { velocity, .. } => *velocity == [0.0; 3],
        _ => true,
    };
    let falls_around = |axis: usize| {
        scene.gravity[axis] != 0.0 && matches!(scene.domain.faces[axis][0], Face::Periodic)
    };
    let adheres = |spring: &Spring| matches!(spring, Spring::Jkr { .. });
    scene.fluid.is_none()
        && scene.surfaces.is_empty()
        && scene.inlets.is_empty()
        && scene.outlets.is_empty()
        && scene.parts.iter().all(|part| part.motion == Motion::Fixed)
        && scene.bodies.iter().all(|set| matches!(set.motion, Motion::Free | Motion::Fixed))
        && scene.domain.faces.iter().flatten().all(is_at_rest)
        && !(0..3).any(falls_around)
        && !scene.contacts.iter().any(|pair| adheres(&pair.law.spring))
}

/// Limit of the way in a step: doubtful, and wrong.
pub fn limit_of_way([doubtful, wrong]: [f64; 2], remedy: impl Into<String>) -> Limit {
    Limit {
        signal: WAY.into(),
        quantity: "way of the fastest body in a step over the smallest radius".into(),
        unit: "1".into(),
        doubtful,
        wrong: Some(wrong),
        why: format!(
            "beyond {} a step misses contacts that begin and end within it, and further on bodies pass through each other",
            short(doubtful)
        ),
        remedy: remedy.into(),
        watch: Some(WatchedQuantity::Speed),
    }
}

/// Growth of the energy that is doubtful, and wrong.
const GROWN: [f64; 2] = [0.1, 1.0];

/// Limit of the growth of the energy, in scenes in which it can only fall.
pub fn limit_of_energy(scene: &Scene, remedy: impl Into<String>) -> Option<Limit> {
    let [doubtful, wrong] = GROWN;
    keeps_energy(scene).then(|| Limit {
        signal: GAIN.into(),
        quantity: "growth of the grains' energy over that at the start".into(),
        unit: "1".into(),
        doubtful,
        wrong: Some(wrong),
        why: "contacts only take energy, and nothing else acts in this scene: what is more than at the start, the method made"
            .into(),
        remedy: remedy.into(),
        watch: Some(WatchedQuantity::Energy),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::Domain;
    use tremie_state::{KeepsState, SavedState};

    #[test]
    fn energy_counts_as_made_only_beyond_that_at_the_start() {
        let mut account = EnergyAccount::default();
        assert_eq!([2.0, 1.0, 3.0].map(|energy| account.gain(energy)), [0.0, 0.0, 0.5]);
        let mut nothing = EnergyAccount::default();
        assert_eq!([0.0, 1.0].map(|energy| nothing.gain(energy)), [0.0, 0.0]);
    }

    #[test]
    fn another_gravity_begins_another_account() {
        struct Kept(EnergyAccount);
        impl KeepsState for Kept {
            const STATE_VERSION: u32 = 1;
            fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
                self.0.exchange(state)
            }
        }
        let mut before = Kept(EnergyAccount::under([0.0, 0.0, -9.81]));
        before.0.gain(2.0);
        let saved = SavedState::of(&mut before).unwrap();
        for (gravity, gain) in [(-9.81, 2.0), (4.0, 0.0)] {
            let mut after = Kept(EnergyAccount::under([0.0, 0.0, gravity]));
            saved.restore(&mut after).unwrap();
            assert_eq!(after.0.gain(6.0), gain);
        }
    }

    #[test]
    fn energy_is_kept_where_nothing_moves_grains() {
        let still = Scene::empty(Domain::new([0.0; 3], [1.0; 3], Face::WALLS));
        assert!(keeps_energy(&still));
        let mut driven = still.clone();
        driven.domain.faces[0][1] = Face::moving([0.0, 1.0, 0.0]);
        assert!(!keeps_energy(&driven));
        let mut falling = still;
        falling.domain.faces[2] = [Face::Periodic, Face::Periodic];
        assert!(keeps_energy(&falling));
        falling.gravity = [0.0, 0.0, -9.81];
        assert!(!keeps_energy(&falling) && limit_of_energy(&falling, "").is_none());
    }

    #[test]
    fn a_way_needs_a_body() {
        assert_eq!(way_in_step(2.0, 0.5, 4.0), 0.25);
        assert_eq!(way_in_step(2.0, 0.5, f64::INFINITY), 0.0);
    }
}
