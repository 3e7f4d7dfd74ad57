//! Scenes that the tests share, in lattice units (1 m cells, 1 s steps, density 1 kg/m³), so that
//! numbers read as in papers.
#![allow(dead_code)]

use tremie_fluid_lbm::{
    Collision, GapPressure, LbmFluid, OpenFaces, Parameters, Precision, Refill, ReservoirState,
    Variant, Walls,
};
use tremie_messages::scene::{
    Course, DeformableSurface, Domain, Face, FacetKind, FluidMaterial, Geometry, Motion, Part,
    PartBoundary, Pose, Scene, Section, SectionEdge,
};
use tremie_messages::units::Time;
use tremie_messages::{BodyEvent, BodyState, Load};

pub const PERIODIC: Face = Face::Periodic;
pub const WALL: Face = Face::WALL;
pub const SYMMETRY: Face = Face::Symmetry;

/// A fluid to be made.
#[derive(Clone, Debug)]
pub struct Case {
    pub cells: [usize; 3],
    pub faces: [Face; 3],
    pub tau: f64,
    pub collision: Collision,
    pub bulk: Option<f64>,
    pub precision: Precision,
    pub average_force: bool,
    pub acceleration: [f64; 3],
    pub gravity: [f64; 3],
    pub velocity: [f64; 3],
    pub threads: usize,
    pub variant: Variant,
    /// Velocity of the upper face of an axis, if that is a wall.
    pub lid: (usize, [f64; 3]),
    pub smagorinsky: f64,
    pub open_faces: OpenFaces,
    pub walls: Walls,
    pub refill: Refill,
    pub gap_pressure: GapPressure,
}

impl Case {
    pub fn new(cells: [usize; 3], faces: [Face; 3], tau: f64) -> Self {
        Self {
            cells,
            faces,
            tau,
            collision: Collision::Trt,
            bulk: None,
            precision: Precision::F64,
            average_force: false,
            acceleration: [0.0; 3],
            gravity: [0.0; 3],
            velocity: [0.0; 3],
            threads: 1,
            variant: Variant::widest(),
            lid: (2, [0.0; 3]),
            smagorinsky: 0.0,
            open_faces: OpenFaces::Nee,
            walls: Walls::Bouzidi,
            refill: Refill::Eqneq,
            gap_pressure: GapPressure::Nearest,
        }
    }

    pub fn viscosity(&self) -> f64 {
        (self.tau - 0.5) / 3.0
    }

    pub fn scene(&self) -> Scene {
        let mut faces = self.faces.clone().map(|face| [face.clone(), face]);
        let (axis, velocity) = self.lid;
        if let Face::Wall { velocity: lid, .. } = &mut faces[axis][1] {
            *lid = velocity;
        }
        Scene {
            gravity: self.gravity,
            fluid: Some(FluidMaterial {
                acceleration: self.acceleration,
                velocity: self.velocity,
                ..FluidMaterial::at_rest(1.0, self.viscosity())
            }),
            ..Scene::empty(Domain::new([0.0; 3], self.cells.map(|n| n as f64), faces))
        }
    }

    pub fn fluid(&self) -> LbmFluid {
        self.fluid_of(&self.scene())
    }

    /// Parameters that the tests choose.
    pub fn parameters(&self) -> Parameters {
        Parameters {
            time_step: Some(Time(1.0)),
            collision: self.collision,
            bulk_relaxation_time: self.bulk,
            precision: self.precision,
            average_force: self.average_force,
            smagorinsky: self.smagorinsky,
            open_faces: self.open_faces,
            walls: self.walls,
            refill: self.refill,
            gap_pressure: self.gap_pressure,
            ..Parameters::with_cell(1.0)
        }
    }

    /// The fluid in a scene made from [`Case::scene`].
    pub fn fluid_of(&self, scene: &Scene) -> LbmFluid {
        let parameters = self.parameters();
        LbmFluid::with_variant(scene, &parameters, 1.0, self.threads, self.variant).unwrap()
    }
}

/// A sphere of the given radius appears.
pub fn added(id: u64, radius: f64) -> BodyEvent {
    BodyEvent {
        id,
        kind: BodyEvent::ADDED,
        shape: BodyEvent::SPHERE,
        motion: BodyEvent::FREE,
        set: 0,
        mass: 1.0,
        size: [radius, 0.0, 0.0],
        table: 0,
    }
}

/// A part that stands still at a position.
pub fn part(name: &str, geometry: Geometry, position: [f64; 3]) -> Part {
    Part {
        name: name.into(),
        geometry,
        pose: Pose { position, ..Pose::IDENTITY },
        cavity: false,
        material: "wall".into(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }
}

/// A part of the scene that moves appears as a body.
pub fn added_part(id: u64, part: u64) -> BodyEvent {
    BodyEvent {
        shape: BodyEvent::PART,
        motion: BodyEvent::PRESCRIBED,
        table: part,
        ..added(id, 0.0)
    }
}

/// Checks that the balance of momentum and mass of the last step closes.
pub fn closes(fluid: &LbmFluid, tolerance: f64) {
    let ledger = fluid.ledger();
    let terms = ledger.momentum_terms();
    for a in 0..3 {
        let gap = ledger.momentum_change[a] - terms[a];
        assert!(gap.abs() < tolerance, "axis {a}: {gap} {ledger:?}");
    }
    let gap = ledger.mass_change - ledger.mass_terms();
    assert!(gap.abs() < 10.0 * tolerance, "mass: {gap} {ledger:?}");
}

/// A body disappears.
pub fn removed(id: u64) -> BodyEvent {
    BodyEvent { kind: BodyEvent::REMOVED, ..added(id, 0.0) }
}

/// Room for the loads on bodies.
pub fn loads_of(bodies: &[BodyState]) -> Vec<Load> {
    vec![Load::default(); bodies.len()]
}

/// Moves bodies by one second.
pub fn advance(bodies: &mut [BodyState]) {
    for body in bodies {
        for a in 0..3 {
            body.position[a] += body.velocity[a];
        }
    }
}

/// Load on a body that is held in a steady flow.
pub struct SteadyDrag {
    /// Force along the acceleration, x.
    pub force: f64,
    /// Mean velocity over the whole box, what the body fills included.
    pub superficial: f64,
}

/// Drag on a body held at a position in a periodic box, whose fluid is accelerated along x, when
/// the flow changes by less than 1e-4 in 100 steps.
pub fn steady_drag(case: &Case, scene: &Scene, event: BodyEvent, position: [f64; 3]) -> SteadyDrag {
    let mut fluid = case.fluid_of(scene);
    let body = [BodyState::at_rest(event.id, position)];
    fluid.apply_events(&[event]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    let volume = case.cells.iter().product::<usize>() as f64;
    let mut before = 0.0;
    loop {
        for _ in 0..100 {
            fluid.step(&body, &mut loads).unwrap();
        }
        let superficial = fluid.ledger().momentum[0] / volume + 0.5 * case.acceleration[0];
        if (superficial - before).abs() < 1e-4 * superficial {
            return SteadyDrag { force: loads[0].force[0], superficial };
        }
        before = superficial;
    }
}

/// The state of the fluid's only reservoir.
pub fn only_reservoir(fluid: &LbmFluid) -> ReservoirState {
    let mut states = Vec::new();
    fluid.reservoirs(&mut states);
    assert_eq!(states.len(), 1);
    states[0]
}

/// From nothing to all in so many steps.
pub fn ramp(steps: f64) -> Course {
    Course::Points(vec![[0.0, 0.0], [steps, 1.0]])
}

/// Every cell of a fluid.
pub fn cells(fluid: &LbmFluid) -> impl Iterator<Item = [usize; 3]> + use<> {
    let [nx, ny, nz] = fluid.cells();
    (0..nx * ny * nz).map(move |k| [k % nx, k / nx % ny, k / (nx * ny)])
}

pub fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

/// Numbers that look random, from 0 to 1, the same everywhere.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as f64) / (1_u64 << 31) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }
}

/// A ring of rubber with a section of four points, in 30 sectors, on a part named carrier.
pub fn seal(points: &[[f64; 2]]) -> DeformableSurface {
    let edge = |k: u32| SectionEdge { points: [k, (k + 1) % 4], kind: FacetKind::Exposed };
    DeformableSurface {
        name: "seal".into(),
        carrier: "carrier".into(),
        table: "seal.json".into(),
        pose: Pose::IDENTITY,
        sectors: 30,
        material: "wall".into(),
        seat_stiffness: 1.0,
        start: Default::default(),
        section: Section { points: points.to_vec(), edges: (0..4).map(edge).collect() },
    }
}
