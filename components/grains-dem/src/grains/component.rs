//! The discrete elements as a component of a run.

use crate::grains::findings::MAX_OVERLAP;
use crate::grains::findings::{findings, limits};
use crate::grains::followed::Follow;
use crate::grains::signals::{BODIES, DRAG_BAND, FACE, INLET, OF_ALL, OUTLET, PART, SLIDER};
use crate::grains::surface_messages::{Carried, check_start, in_scene, surfaces};
use crate::math::parameters::Parameters;
use crate::setup::check_profiles;
use crate::setup::resolution::Resolution;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::diagnostics::Diagnostics;
use crate::solver::probes::{PROBE_MEANINGS, probe_signals};
use std::collections::BTreeMap;
use tremie_grains_kit::signals::body_signals::{MOTION, PATH};
use tremie_grains_kit::signals::shared_signals::{FEW, of_faces, of_followed, of_paths};
use tremie_grains_kit::signals::soundness::{
    EnergyAccount, OF_SOUNDNESS, Soundness, WAY, way_in_step,
};
use tremie_grains_kit::space::plane_walls;
use tremie_sdk::messages::frame::{ProfileBin, ProfileHeader};
use tremie_sdk::messages::scene::{GrainProfile, Motion, Scene};
use tremie_sdk::messages::start::signal_row::{describe, push};
use tremie_sdk::messages::start::{Description, ProfileSpec, Signal};
use tremie_sdk::messages::{
    BodyEvent, BodyState, FacetLoad, Load, Place, PortState, Problem, SurfaceVertex,
};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{AsGrains, ControlPipe, Grains, Setup, SolverError};

/// Soft spheres behind the sdk's interface.
pub struct SoftSpheres {
    grains: GrainsDem,
    /// Room for the states of all bodies, where spheres are so few that their paths are signals.
    tracked: Vec<BodyState>,
    /// Number of these spheres.
    few: usize,
    carried: Carried,
    /// Bodies, clumps and parts whose motion are signals.
    follow: Follow,
    /// Axis and side of the faces of the domain that hold grains.
    faces: Vec<(usize, usize)>,
    /// Length of a step [s].
    step: f64,
    energy: EnergyAccount,
}

impl Grains for SoftSpheres {
    const PROGRAM: &'static str = concat!("grains-dem ", env!("CARGO_PKG_VERSION"));
    const TAKES_SURFACES: bool = true;
    const TAKES_PORTS: bool = true;

    fn takes_polyhedra() -> bool {
        true
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let resolution = parameters.resolve(&setup.hello.scene)?;
        let surfaces = surfaces(&setup.hello.scene)?;
        check_start(&setup.hello.scene, &surfaces)?;
        Ok(Description {
            step: resolution.time_step,
            step_limit: resolution.step_limit.clone(),
            bodies: resolution.bodies as u64,
            signals: signals(&setup.hello.scene, resolution.spheres),
            work: "grain steps".into(),
            work_per_step: resolution.spheres as f64,
            limits: limits(&setup.hello.scene),
            memory: resolution.memory,
            notes: notes(&setup.hello.scene, &resolution),
            findings: findings(&setup.hello.scene, &parameters, &resolution),
            warnings: warnings(&setup.hello.scene, &resolution),
            profiles: setup.hello.scene.profiles.iter().map(profile_spec).collect(),
            resolution: numbers(&resolution),
            state: Some(GrainsDem::STATE_VERSION),
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        let (scene, step) = (&setup.hello.scene, setup.assigned()?.step);
        let threads = setup.hello.threads.max(1) as usize;
        let surfaces = surfaces(scene)?;
        let mut grains = GrainsDem::with_surfaces(scene, &parameters, step, threads, &surfaces)
            .map_err(in_scene)?;
        grains.choose_threads();
        grains.measure_profiles(scene, setup.assigned()?.clock.window());
        let spheres = grains.radii().len();
        let few = if is_followed(scene, spheres) { spheres } else { 0 };
        // All states are asked for at once, those of parts too.
        let tracked =
            vec![BodyState::at_rest(0, [0.0; 3]); if few > 0 { grains.body_count() } else { 0 }];
        let follow = Follow::new(scene, grains.events());
        let (carried, faces) = (Carried::new(&surfaces), plane_walls::faces(scene).collect());
        let of_overlap = setup.assigned()?.watched.iter().find(|w| w.signal == MAX_OVERLAP);
        grains.watch_overlaps(of_overlap.map_or(f64::INFINITY, |watched| watched.limit));
        let energy = EnergyAccount::under(setup.hello.scene.gravity);
        Ok(Self { grains, tracked, few, carried, follow, faces, step, energy })
    }

    fn events(&self) -> &[BodyEvent] {
        self.grains.events()
    }

    fn count(&self) -> usize {
        self.grains.body_count()
    }

    fn state(&self, bodies: &mut [BodyState]) {
        self.grains.write_state(bodies);
    }

    fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), SolverError> {
        self.grains.advance(substeps, loads).map_err(SolverError::from_error)?;
        self.tell_threads();
        Ok(())
    }

    fn carriers(&self, carriers: &mut [BodyState]) -> Result<(), SolverError> {
        for (surface, out) in carriers.iter_mut().enumerate() {
            let state = self.grains.carrier_state(surface);
            *out = state.ok_or_else(|| SolverError(format!("there is no surface {surface}")))?;
        }
        Ok(())
    }

    fn begin_window(&mut self, substeps: u32, loads: &[Load]) -> Result<(), SolverError> {
        self.grains.begin_window(substeps, loads).map_err(SolverError::from_error)
    }

    fn begin_substep(&mut self) -> Result<(), SolverError> {
        self.grains.begin_substep().map_err(SolverError::from_error)
    }

    fn contacts(
        &mut self,
        vertices: &[SurfaceVertex],
        loads: &mut Vec<FacetLoad>,
    ) -> Result<(), SolverError> {
        let Self { carried, grains, .. } = self;
        carried.contacts(grains, vertices, loads).map_err(SolverError::from_error)
    }

    fn finish_substep(
        &mut self,
        vertices: &[SurfaceVertex],
        resultants: &[Load],
    ) -> Result<(), SolverError> {
        let Self { carried, grains, .. } = self;
        carried.finish(grains, vertices, resultants).map_err(SolverError::from_error)
    }

    fn end_window(&mut self) -> Result<(), SolverError> {
        self.grains.end_window().map_err(SolverError::from_error)?;
        self.tell_threads();
        Ok(())
    }

    fn ports(&mut self, ports: &[PortState]) -> Result<(), SolverError> {
        let velocity = |port: &PortState| (port.axis as usize, port.side as usize, port.vector());
        self.grains.set_port_velocities(ports.iter().map(velocity)).map_err(SolverError::from_error)
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        self.grains.exchange_state(state)?;
        self.energy.exchange(state)
    }

    fn take_bodies(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        self.grains.take_bodies(state)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        let all = self.grains.diagnostics();
        push(OF_ALL, &all, values);
        push(OF_SOUNDNESS, &self.soundness(&all), values);
        if !self.tracked.is_empty() {
            self.grains.write_state(&mut self.tracked);
        }
        self.tracked[..self.few].iter().for_each(|body| push(PATH, body, values));
        self.follow.push(&self.grains, values);
        let on_faces = self.grains.face_forces();
        self.faces.iter().for_each(|&(axis, side)| push(FACE, &on_faces[axis][side], values));
        let mut sliders = self.grains.sliders().peekable();
        for (part, loads) in self.grains.part_loads().enumerate() {
            push(PART, &loads, values);
            if let Some(state) = self.grains.part(part).filter(|_| self.follow.moves(part)) {
                push(MOTION, &state, values);
            }
            if let Some(slider) = sliders.next_if(|slider| slider.part == part) {
                push(SLIDER, &slider, values);
            }
        }
        drop(sliders);
        self.grains.inlets().for_each(|inlet| push(INLET, &inlet, values));
        self.grains.outlets().for_each(|outlet| push(OUTLET, &outlet, values));
        self.grains.drag_bands().for_each(|band| push(DRAG_BAND, &band, values));
        if self.grains.inlets().len() + self.grains.outlets().len() > 0 {
            push(BODIES, &self.grains.radii().len(), values);
        }
        self.grains.read_probes(values);
    }

    fn row_kept(&mut self) {
        self.grains.restart_means();
    }

    fn place(&self, signal: &str) -> Option<Place> {
        match signal {
            MAX_OVERLAP => self.grains.deepest_place(),
            WAY => self.grains.fastest_place(),
            _ => None,
        }
    }

    fn contact_forces(&self, forces: &mut [[f64; 3]]) -> bool {
        self.grains.write_contact_forces(forces)
    }

    fn has_profile(&self, name: &str, is_last: bool) -> bool {
        self.grains.has_profile(name, is_last)
    }

    fn profile(&mut self, name: &str, bins: &mut [ProfileBin]) -> ProfileHeader {
        self.grains.profile(name, bins)
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsGrains<SoftSpheres>>(line)
}

impl SoftSpheres {
    fn soundness(&mut self, all: &Diagnostics) -> Soundness {
        let energy =
            all.kinetic_energy + all.rotational_energy + all.potential_energy + all.elastic_energy;
        let smallest = self.grains.radii().fold(f64::INFINITY, f64::min);
        Soundness {
            way: way_in_step(all.max_speed, self.step, smallest),
            energy_gain: self.energy.gain(energy),
        }
    }

    /// Logs the number of threads of a substep, once it was found.
    fn tell_threads(&mut self) {
        if let Some(found) = self.grains.take_found() {
            tremie_sdk::log_line(format_args!("a substep {found}"));
        }
    }
}

/// True if the paths of spheres are signals: they are few, and none comes or goes.
fn is_followed(scene: &Scene, spheres: usize) -> bool {
    spheres <= FEW && scene.inlets.is_empty() && scene.outlets.is_empty()
}

fn signals(scene: &Scene, spheres: usize) -> Vec<Signal> {
    let mut all: Vec<_> = describe(OF_ALL, "").chain(describe(OF_SOUNDNESS, "")).collect();
    if is_followed(scene, spheres) {
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
        if matches!(part.motion, Motion::Slider(_)) {
            all.extend(describe(SLIDER, &before));
        }
    }
    scene.inlets.iter().for_each(|i| all.extend(describe(INLET, &format!("{}.", i.name))));
    scene.outlets.iter().for_each(|o| all.extend(describe(OUTLET, &format!("{}.", o.name))));
    scene.drag_bands.iter().for_each(|b| all.extend(describe(DRAG_BAND, &format!("{}.", b.name))));
    if !scene.inlets.is_empty() || !scene.outlets.is_empty() {
        all.extend(describe(BODIES, ""));
    }
    all.extend(probe_signals(scene).into_iter().map(|(name, unit)| {
        let is_mean = name.ends_with(".mass_flow_rate");
        let own = Signal::new(name, unit, PROBE_MEANINGS);
        if is_mean { own.sampled() } else { own }
    }));
    all
}

fn profile_spec(profile: &GrainProfile) -> ProfileSpec {
    ProfileSpec { name: profile.name.clone(), bins: profile.bins() as u64 }
}

fn warnings(scene: &Scene, resolution: &Resolution) -> Vec<String> {
    resolution.warnings.iter().cloned().chain(check_profiles::left_out(scene)).collect()
}

fn notes(scene: &Scene, resolution: &Resolution) -> Vec<String> {
    let what = if scene.has_polyhedra() { "bodies as large as spheres" } else { "spheres" };
    let Resolution { spheres, smallest_diameter, largest_diameter, .. } = resolution;
    let mut notes = vec![if *spheres == 0 {
        "no spheres".into()
    } else if smallest_diameter == largest_diameter {
        format!("{spheres} {what} of {smallest_diameter:.4e} m")
    } else {
        format!("{spheres} {what} of {smallest_diameter:.4e} to {largest_diameter:.4e} m")
    }];
    let sides = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    let held = |(axis, side): (usize, usize)| {
        scene.domain.faces[axis][side].is_open() && !scene.is_way_out(axis, side)
    };
    if sides.into_iter().any(held) && resolution.free_bodies > 0 {
        notes.push("open faces without an outlet are walls to grains: none goes there".into());
    }
    if resolution.time_step.is_some() && resolution.time_step == resolution.stable_time_step {
        notes.push(
            "stability in a dense packing, not the steps in a collision, sets the time step".into(),
        );
    }
    if resolution.hertz {
        notes.push(format!(
            "collisions under Hertz's law are resolved up to {:.3e} m/s",
            resolution.expected_speed
        ));
    }
    for pair in &resolution.pairs {
        notes.push(format!(
            "{}: restitution {:.3}, damping ratio {:.3}, collision of {:.3e} s",
            pair.pair, pair.restitution, pair.damping_ratio, pair.contact_time
        ));
    }
    notes
}

fn numbers(resolution: &Resolution) -> BTreeMap<String, f64> {
    let mut numbers = BTreeMap::from([("bodies".to_string(), resolution.bodies as f64)]);
    if let (Some(contact), Some(step)) = (resolution.contact_time, resolution.time_step) {
        numbers.insert("steps in the shortest collision".into(), contact / step);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_sdk::messages::scene::{
        BodySet, ContactLaw, Damping, Domain, Face, PairLaw, Placement, Sphere, Spring,
    };

    /// A sphere at rest on the floor, between periodic faces along y.
    fn resting() -> Scene {
        let spring = Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 8e2 };
        let law = ContactLaw {
            spring,
            friction: 0.3,
            rolling_friction: 0.0,
            damping: Damping::Restitution(0.2),
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
        let set = BodySet {
            name: "stones".into(),
            density: 2500.0,
            material: "stone".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed(vec![sphere]),
        };
        let faces =
            [Face::WALLS[0].clone(), [Face::Periodic, Face::Periodic], Face::WALLS[2].clone()];
        let domain = Domain::new([0.0; 3], [10e-3; 3], faces);
        Scene {
            gravity: [0.0, 0.0, -9.81],
            contacts: vec![pair("stone"), pair("wall")],
            bodies: vec![set],
            ..Scene::empty(domain)
        }
    }

    #[test]
    fn the_weight_on_the_floor_is_a_signal() {
        let scene = resting();
        let grains = GrainsDem::new(&scene, &Parameters::default(), 1e-5, 1).unwrap();
        let mut spheres = SoftSpheres {
            tracked: vec![BodyState::at_rest(0, [0.0; 3]); grains.body_count()],
            few: 1,
            carried: Carried::new(&[]),
            follow: Follow::new(&scene, grains.events()),
            faces: plane_walls::faces(&scene).collect(),
            grains,
            step: 1e-5,
            energy: EnergyAccount::default(),
        };
        spheres.advance(20_000, &[]).unwrap();
        let (names, mut values) = (signals(&scene, 1), Vec::new());
        spheres.signals(&mut values);
        assert_eq!(names.len(), values.len());
        let of = |name: &str| {
            let place = names.iter().position(|signal| signal.name == name);
            place.map(|k| (values[k], names[k].meaning.clone()))
        };
        let (force, meaning) = of("z_lower.wall_force_z").unwrap();
        let weight = 2500.0 * std::f64::consts::PI / 6.0 * 8e-9 * 9.81;
        assert!((force / -weight - 1.0).abs() < 1e-6, "{force} {weight}");
        assert!(meaning.contains("face of the domain"), "{meaning}");
        assert_eq!(of("x_upper.wall_force_x").map(|(force, _)| force), Some(0.0));
        assert_eq!(of("y_lower.wall_force_y"), None);
        let value = |name: &str| of(name).unwrap().0;
        let way = value("max_speed") * 1e-5 / 1e-3;
        assert_eq!((value("way_in_step"), value("energy_gain")), (way, 0.0));
        let deepest = spheres.place("max_overlap_ratio").unwrap();
        assert_eq!((deepest.bodies, spheres.place("mean_x")), ([Some(0), None], None));
        let [.., z] = deepest.position.unwrap();
        assert!((z - 1e-3 + value("max_overlap_ratio") * 1e-3).abs() < 1e-12, "{deepest:?}");
    }
}
