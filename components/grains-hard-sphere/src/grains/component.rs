//! The hard spheres as a component of a run.

use crate::grains::findings::{findings, limits};
use crate::grains::hard_spheres::HardSpheres;
use crate::grains::signals::{FACE, OF_ALL, PART};
use crate::setup::hard_resolution::HardResolution;
use crate::setup::parameters::Parameters;
use std::collections::BTreeMap;
use tremie_grains_kit::signals::body_signals::{FLUID, MOTION, PATH};
use tremie_grains_kit::signals::followed::{self, Followed};
use tremie_grains_kit::signals::shared_signals::{FEW, of_faces, of_followed, of_paths};
use tremie_grains_kit::signals::soundness::{
    EnergyAccount, OF_SOUNDNESS, Soundness, WAY, way_in_step,
};
use tremie_grains_kit::space::plane_walls;
use tremie_sdk::messages::scene::{Motion, Scene};
use tremie_sdk::messages::start::signal_row::{describe, push};
use tremie_sdk::messages::start::{Description, Signal};
use tremie_sdk::messages::{BodyEvent, BodyState, Load, Place, Problem};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsGrains, ControlPipe, Grains, Setup, SolverError};

/// Hard spheres behind the sdk's interface.
pub struct HardGrains {
    spheres: HardSpheres,
    /// Number of spheres whose paths are signals, because they are few.
    few: usize,
    /// Ids of the bodies whose motion is a signal.
    followed: Vec<usize>,
    has_fluid: bool,
    /// Parts that move, by their numbers.
    moves: Vec<bool>,
    /// Number of faces of the domain that hold grains.
    faces: usize,
    /// Length of a step [s]; 0 where bodies go from event to event.
    step: f64,
    smallest: f64,
    energy: EnergyAccount,
}

impl Grains for HardGrains {
    const PROGRAM: &'static str = concat!("grains-hard-sphere ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let scene = &setup.hello.scene;
        let resolution = parameters.resolve(scene)?;
        Ok(Description {
            step: resolution.time_step,
            step_limit: step_limit(&parameters, &resolution),
            bodies: resolution.bodies as u64,
            signals: signals(scene, resolution.spheres),
            work: "grain steps".into(),
            work_per_step: resolution.spheres as f64,
            limits: limits(scene, &resolution),
            memory: resolution.memory,
            notes: notes(&resolution),
            findings: findings(scene, &resolution),
            warnings: warnings(scene),
            state: Some(HardSpheres::STATE_VERSION),
            resolution: BTreeMap::from([
                ("bodies".to_string(), resolution.bodies as f64),
                ("solid fraction".to_string(), resolution.solid_fraction),
            ]),
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let (scene, step) = (&setup.hello.scene, setup.assigned()?.step);
        let threads = setup.hello.threads.max(1) as usize;
        let spheres = HardSpheres::new(scene, &parameters, step, threads)?;
        let few = if spheres.sphere_count() <= FEW { spheres.sphere_count() } else { 0 };
        Ok(Self {
            few,
            followed: followed_ids(scene, spheres.events()),
            has_fluid: scene.fluid.is_some(),
            moves: scene.parts.iter().map(|part| part.motion != Motion::Fixed).collect(),
            faces: plane_walls::faces(scene).count(),
            step: if spheres.is_by_events() { 0.0 } else { step },
            smallest: spheres.radii().fold(f64::INFINITY, f64::min),
            energy: EnergyAccount::under(scene.gravity),
            spheres,
        })
    }

    fn events(&self) -> &[BodyEvent] {
        self.spheres.events()
    }

    fn count(&self) -> usize {
        self.spheres.body_count()
    }

    fn state(&self, bodies: &mut [BodyState]) {
        self.spheres.write_state(bodies);
    }

    fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), SolverError> {
        self.spheres.advance(substeps, loads).map_err(SolverError::from_error)
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        self.spheres.exchange_state(state)?;
        self.energy.exchange(state)
    }

    fn place(&self, signal: &str) -> Option<Place> {
        if signal == WAY { self.spheres.fastest_place() } else { None }
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        let Self { spheres, few, followed, .. } = self;
        let all = spheres.diagnostics();
        push(OF_ALL, &all, values);
        let energy = all.kinetic_energy + all.rotational_energy + all.potential_energy;
        let soundness = Soundness {
            way: way_in_step(all.max_speed, self.step, self.smallest),
            energy_gain: self.energy.gain(energy),
        };
        push(OF_SOUNDNESS, &soundness, values);
        (0..*few).for_each(|id| push(PATH, &spheres.sphere(id), values));
        for &id in &*followed {
            push(MOTION, &spheres.sphere(id), values);
            if self.has_fluid {
                push(FLUID, &spheres.load(id), values);
            }
        }
        spheres.wall_forces()[..self.faces].iter().for_each(|force| push(FACE, force, values));
        for (part, load) in spheres.part_loads().iter().enumerate() {
            push(PART, load, values);
            if self.moves[part] {
                push(MOTION, &spheres.part(part), values);
            }
        }
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsGrains<HardGrains>>(line)
}

/// Ids of the bodies that a scene follows.
fn followed_ids(scene: &Scene, events: &[BodyEvent]) -> Vec<usize> {
    let id_of = |(_, followed): (String, Followed)| {
        let Followed::Body { set, place } = followed else { return None };
        let own = |e: &&BodyEvent| e.shape != BodyEvent::PART && e.set as usize == set;
        events.iter().filter(own).nth(place).map(|event| event.id as usize)
    };
    followed::of_scene(scene).into_iter().filter_map(id_of).collect()
}

fn signals(scene: &Scene, spheres: usize) -> Vec<Signal> {
    let mut all: Vec<_> = describe(OF_ALL, "").chain(describe(OF_SOUNDNESS, "")).collect();
    if spheres <= FEW {
        all.extend(of_paths(spheres));
    }
    all.extend(of_followed(scene));
    all.extend(of_faces(scene, FACE));
    for part in &scene.parts {
        let before = format!("{}.", part.name);
        all.extend(describe(PART, &before));
        if part.motion != Motion::Fixed {
            all.extend(describe(MOTION, &before));
        }
    }
    all
}

fn step_limit(parameters: &Parameters, resolution: &HardResolution) -> String {
    if parameters.time_step.is_some() {
        return "time_step".into();
    }
    let [smallest, _] = resolution.diameters;
    let speed = 0.5 * resolution.expected_speed;
    format!("a twentieth of the radius of a sphere of {smallest:.3e} m at {speed:.3} m/s")
}

fn notes(resolution: &HardResolution) -> Vec<String> {
    let HardResolution { spheres, diameters: [smallest, largest], .. } = resolution;
    let mut notes = vec![match (spheres, smallest == largest) {
        (0, _) => "no spheres".into(),
        (_, true) => format!("{spheres} hard spheres of {smallest:.4e} m"),
        (_, false) => format!("{spheres} hard spheres of {smallest:.4e} to {largest:.4e} m"),
    }];
    notes.push(match &resolution.because {
        None if resolution.by_events => "collisions are found from event to event".into(),
        None => "collisions are found from step to step, as the settings ask".into(),
        Some(what) => {
            format!("collisions are found from step to step, because {what} acts between them")
        }
    });
    notes.push(format!(
        "collisions are elastic within {:.2e} s of a body's last one, and below {:.2e} m/s",
        resolution.contact_time, resolution.elastic_speed
    ));
    notes
}

fn warnings(scene: &Scene) -> Vec<String> {
    let has_stiffness = !scene.contacts.is_empty();
    let sections = scene.probes.iter().any(|probe| {
        matches!(probe.shape, tremie_sdk::messages::scene::ProbeShape::Section { .. })
    });
    let text = "sections measure the fluid alone: hard spheres are not counted there";
    (has_stiffness && sections).then(|| text.into()).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_sdk::messages::scene::{
        BodySet, ContactLaw, Damping, Domain, Face, PairLaw, Placement, Sphere, Spring,
    };

    #[test]
    fn there_is_a_value_for_each_signal_and_the_floor_feels_the_weight() {
        let law = ContactLaw {
            spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 8e2 },
            friction: 0.3,
            rolling_friction: 0.0,
            damping: Damping::Restitution(0.5),
            tension: false,
        };
        let pair =
            |other: &str| PairLaw { between: ["stone".into(), other.into()], law: law.clone() };
        let sphere = Sphere {
            position: [5e-3, 5e-3, 1e-3],
            diameter: 2e-3,
            velocity: [0.0; 3],
            angular_velocity: [0.0; 3],
        };
        let scene = Scene {
            gravity: [0.0, 0.0, -9.81],
            contacts: vec![pair("stone"), pair("wall")],
            bodies: vec![BodySet {
                name: "stone".into(),
                density: 2500.0,
                material: "stone".into(),
                motion: Motion::Free,
                clump: None,
                placement: Placement::Listed(vec![sphere]),
            }],
            ..Scene::empty(Domain::new([0.0; 3], [10e-3; 3], Face::WALLS))
        };
        let spheres = HardSpheres::new(&scene, &Parameters::default(), 1e-3, 1).unwrap();
        let mut grains = HardGrains {
            few: 1,
            followed: followed_ids(&scene, spheres.events()),
            has_fluid: false,
            moves: Vec::new(),
            faces: plane_walls::faces(&scene).count(),
            spheres,
            step: 1e-3,
            smallest: 2e-3,
            energy: EnergyAccount::default(),
        };
        grains.advance(1000, &[]).unwrap();
        let (names, mut values) = (signals(&scene, 1), Vec::new());
        grains.signals(&mut values);
        assert_eq!(names.len(), values.len());
        let of = |name: &str| values[names.iter().position(|s| s.name == name).unwrap()];
        let weight = 2500.0 * std::f64::consts::PI / 6.0 * 8e-9 * 9.81;
        assert!((of("z_lower.wall_force_z") / -weight - 1.0).abs() < 1e-3);
        assert_eq!(of("x_upper.wall_force_x"), 0.0);
        assert_eq!(of("way_in_step"), of("max_speed") * 1e-3 / 2e-3);
        assert_eq!(grains.place("way_in_step").unwrap().bodies, [Some(0), None]);
        assert!((of("stone.z") - 1e-3).abs() < 1e-8 && of("wall_collisions") > 100.0);
    }
}
