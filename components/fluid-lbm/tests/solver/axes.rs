//! The orientation of a scene does not matter: the lattice turns itself so that its rows are long,
//! and tells everything by the world's axes.

use crate::common::*;
use tremie_fluid_lbm::{FluidError, LbmFluid, Ledger, ReservoirPlace, ReservoirState, SliceNode};
use tremie_geometry::Turned;
use tremie_messages::scene::{
    Course, DeformableSurface, Diameters, Face, FacetKind, FluidMaterial, Gap, GapRegion, GapRule,
    GapSide, Geometry, Inlet, InletVelocity, Motion, OpenVelocity, Plane, Pose, Probe, ProbeShape,
    Profile, Reservoir, Ring, Scene, Section, SectionEdge,
};
use tremie_messages::{BodyState, FacetLoad, Load, PortState, SurfaceVertex};

/// The longest edge of the box, the one that lies along x in the first of the three lays.
const CELLS: [usize; 3] = [34, 14, 12];

/// Orientation of a scene: its first axis along this one of the world, the others after it.
#[derive(Clone, Copy)]
struct Lay(usize);

impl Lay {
    fn out<T: Copy>(self, v: [T; 3]) -> [T; 3] {
        std::array::from_fn(|a| v[(a + 3 - self.0) % 3])
    }

    fn back<T: Copy>(self, v: [T; 3]) -> [T; 3] {
        std::array::from_fn(|a| v[(a + self.0) % 3])
    }

    fn axis(self, axis: usize) -> usize {
        (axis + self.0) % 3
    }

    /// The orientation of a frame that is not turned in the first lay.
    fn orientation(self) -> [f64; 4] {
        [[0.0, 0.0, 0.0, 1.0], [0.5; 4], [-0.5, -0.5, -0.5, 0.5]][self.0]
    }

    fn pose(self, position: [f64; 3]) -> Pose {
        Pose { position: self.out(position), orientation: self.orientation() }
    }
}

/// Probes of all shapes but a profile.
fn probes(lay: Lay) -> Vec<Probe> {
    let (min, max) = (lay.out([18.0, 2.0, 3.0]), lay.out([24.0, 9.0, 8.0]));
    let shapes = [
        ProbeShape::Point(lay.out([21.3, 4.4, 5.2])),
        ProbeShape::Section { axis: lay.axis(0), position: 20.3, min, max },
        ProbeShape::Line { from: lay.out([3.0, 2.0, 9.0]), to: lay.out([30.0, 4.0, 3.0]) },
        ProbeShape::Region { min, max },
        ProbeShape::Ring(Ring {
            axis: lay.axis(1),
            through: lay.out([20.0, 3.0, 6.0]),
            radii: [1.0, 4.0],
            heights: [-1.0, 5.0],
        }),
    ];
    let named = |(k, shape)| Probe { name: format!("probe_{k}"), shape };
    shapes.into_iter().enumerate().map(named).collect()
}

/// A gap beneath the part that moves.
fn gap(lay: Lay) -> Gap {
    Gap {
        name: "beneath".into(),
        between: [GapSide::Part("mover".into()), GapSide::Face { axis: lay.axis(2), side: 0 }],
        open_at: 1.5,
        close_at: 0.5,
        pressure: GapRule::Nearest,
        slip_below: 0.0,
        region: Some(GapRegion::Ring {
            axis: lay.axis(2),
            through: lay.out([15.0, 7.0, 0.0]),
            radii: [0.0, 3.0],
        }),
    }
}

/// A channel with all that has a direction: a piston at one end, an outflow with a profile at the
/// other, a lid and mirrors, an obstacle and a plane, a part, a sphere and a seal that move, a gap,
/// an inlet, probes.
fn scene(lay: Lay) -> Scene {
    let mut case = Case::new(lay.out(CELLS), [WALL; 3], 0.6);
    case.gravity = lay.out([-1e-5, 2e-5, -4e-5]);
    let mut scene = case.scene();
    scene.fluid = Some(FluidMaterial {
        acceleration: lay.out([1e-6, 2e-6, -1e-6]),
        velocity: lay.out([0.01, 0.0, 0.0]),
        inside: vec![lay.out([20.2, 5.1, 6.3])],
        ..scene.fluid.unwrap()
    });
    let reservoir = Reservoir {
        course: Course::Points(vec![[0.0, 0.5], [9.0, 1.0]]),
        ..Reservoir::new(168.0, 5e3, 0.01)
    };
    let outflow = OpenVelocity {
        velocity: lay.out([0.01, 0.0, 0.0]),
        profile: Profile::Parabolic,
        course: Course::default(),
    };
    // At an edge of two walls the order of the world's axes decides; here none meet.
    let lid = Face::moving(lay.out([0.01, 0.004, 0.0]));
    for (axis, faces) in [
        (0, [Face::Reservoir(reservoir), Face::Velocity(outflow)]),
        (1, [SYMMETRY, SYMMETRY]),
        (2, [WALL, lid]),
    ] {
        scene.domain.faces[lay.axis(axis)] = faces;
    }
    let mut obstacle = part("obstacle", Geometry::Box { size: [3.1, 4.3, 2.7] }, [0.0; 3]);
    obstacle.pose = lay.pose([8.3, 9.2, 1.1]);
    let mut mover = part("mover", Geometry::Box { size: [3.3, 2.9, 4.1] }, [0.0; 3]);
    (mover.pose, mover.motion) = (lay.pose([15.2, 7.3, 2.9]), Motion::Prescribed(Vec::new()));
    let mut carrier = part("carrier", Geometry::Box { size: [1.0; 3] }, [0.0; 3]);
    (carrier.pose, carrier.motion) = (lay.pose([26.2, 6.8, 5.7]), mover.motion.clone());
    scene.parts = vec![obstacle, mover, carrier];
    let normal = lay.out([0.0, -0.6, -0.8]);
    scene.planes =
        vec![Plane { point: lay.out([0.0, 13.6, 10.9]), normal, material: "wall".into() }];
    let edge = |k| SectionEdge { points: [k, k + 1], kind: FacetKind::Exposed };
    scene.surfaces = vec![DeformableSurface {
        name: "seal".into(),
        carrier: "carrier".into(),
        table: String::new(),
        pose: Pose::IDENTITY,
        sectors: 17,
        material: "wall".into(),
        seat_stiffness: 1.0,
        start: Default::default(),
        section: Section { points: DISC.to_vec(), edges: (0..3).map(edge).collect() },
    }];
    scene.gaps = vec![gap(lay)];
    scene.inlets = vec![Inlet {
        name: "feed".into(),
        bodies: "grains".into(),
        min: [0.0; 3],
        max: [1.0; 3],
        fraction: 0.1,
        diameters: Diameters::Uniform { min: 1.0, max: 1.0 },
        every: None,
        velocity: InletVelocity::Face { axis: lay.axis(0), side: 1 },
        until: None,
        seed: 1,
        tries: 1,
    }];
    scene.probes = probes(lay);
    scene
}

/// Section of the seal.
const DISC: [[f64; 2]; 4] = [[0.0, -1.3], [3.2, -1.5], [2.9, 1.4], [0.0, 1.7]];

/// All that a fluid tells, by the axes of the first lay.
#[derive(Debug, Default)]
struct Told {
    loads: Vec<Load>,
    facets: Vec<FacetLoad>,
    on_parts: Vec<Load>,
    probes: Vec<f64>,
    ports: Vec<PortState>,
    reservoirs: Vec<ReservoirState>,
    ledger: Ledger,
    nodes: Vec<SliceNode>,
    slice: Vec<SliceNode>,
    populations: Vec<f64>,
}

fn run(lay: Lay, steps: usize) -> Told {
    let scene = scene(lay);
    let case = Case::new(lay.out(CELLS), [WALL; 3], 0.6);
    let mut fluid = case.fluid_of(&scene);
    fluid.apply_events(&[added(1, 2.3), added_part(2, 1), added_part(3, 2)]).unwrap();
    let turned = Turned::of(&scene.surfaces[0]);
    let places = turned.places(&DISC);
    let mut told =
        Told { facets: vec![FacetLoad::default(); turned.triangles.len()], ..Told::default() };
    let mut loads = vec![Load::default(); 3];
    for step in 0..=steps {
        let t = step as f64;
        let body = |id, [x, y, z]: [f64; 3], v: [f64; 3], w: [f64; 3]| BodyState {
            id,
            position: lay.out([x + t * v[0], y + t * v[1], z + t * v[2]]),
            orientation: lay.orientation(),
            velocity: lay.out(v),
            angular_velocity: lay.out(w),
        };
        let still = [0.0; 3];
        let bodies = [
            body(1, [19.7, 5.2, 6.4], [0.02, -0.01, 0.03], [1e-3, -2e-3, 3e-3]),
            body(2, [15.2, 7.3, 2.9], [0.0, 0.0, -0.01], still),
            body(3, [26.2, 6.8, 5.7], [-0.01, 0.0, 0.0], still),
        ];
        let squeeze = 1.0 - 1e-3 * t;
        let vertices: Vec<_> = places
            .iter()
            .map(|place| <[f64; 3]>::from(*place))
            .map(|[x, y, z]| SurfaceVertex {
                position: lay.out([26.2 - 0.01 * t + x, 6.8 + y, 5.7 + squeeze * z]),
                velocity: lay.out([-0.01, 0.0, -1e-3 * z]),
            })
            .collect();
        fluid.set_surfaces(&vertices).unwrap();
        if step == 0 {
            fluid.start(&bodies, &mut loads).unwrap();
        } else {
            fluid.step(&bodies, &mut loads).unwrap();
        }
    }
    closes(&fluid, 1e-10);
    tell(lay, &mut fluid, loads, &mut told);
    told
}

fn tell(lay: Lay, fluid: &mut LbmFluid, loads: Vec<Load>, told: &mut Told) {
    let load = |load: &Load| Load {
        id: load.id,
        force: lay.back(load.force),
        torque: lay.back(load.torque),
    };
    told.loads = loads.iter().map(load).collect();
    fluid.surface_loads(&mut told.facets);
    for facet in &mut told.facets {
        (facet.force, facet.point) = (lay.back(facet.force), lay.back(facet.point));
    }
    fluid.loads_on_parts(&mut told.on_parts);
    told.on_parts.iter_mut().for_each(|on_part| *on_part = load(on_part));
    fluid.probes(&mut told.probes);
    // Pressure, velocity and, of a volume, part that is solid; flow, pressure and mass through a
    // section.
    for first in [1, 8, 12, 17] {
        let velocity = lay.back([0, 1, 2].map(|a| told.probes[first + a]));
        told.probes[first..first + 3].copy_from_slice(&velocity);
    }
    told.ports = fluid.ports().to_vec();
    told.ports.iter_mut().for_each(|port| port.axis = (port.axis + 3 - lay.0 as u32) % 3);
    fluid.reservoirs(&mut told.reservoirs);
    for state in &mut told.reservoirs {
        if let ReservoirPlace::Face { axis, .. } = &mut state.place {
            *axis = (*axis + 3 - lay.0) % 3;
        }
    }
    let ledger = fluid.ledger();
    told.ledger = Ledger {
        momentum: lay.back(ledger.momentum),
        walls: lay.back(ledger.walls),
        open: lay.back(ledger.open),
        bodies: lay.back(ledger.bodies),
        buoyancy: lay.back(ledger.buoyancy),
        mass: ledger.mass,
        ..Ledger::default()
    };
    assert_eq!(fluid.cells(), lay.out(CELLS));
    let node = |node: SliceNode| SliceNode { velocity: lay.back(node.velocity), ..node };
    let [nx, ny, nz] = CELLS;
    for k in 0..nx * ny * nz {
        let at = [k % nx, k / nx % ny, k / (nx * ny)];
        let cell = lay.out(at);
        let centre = at.map(|k| k as f64 + 0.5);
        assert_eq!(lay.back(fluid.centre(cell)), centre);
        told.nodes.push(node(fluid.node(cell)));
        let populations = fluid.populations_at(cell);
        let along = |c: [i32; 3]| {
            let turned = lay.out(c);
            let i = tremie_fluid_lbm::d3q19::C.iter().position(|c| *c == turned).unwrap();
            populations[i]
        };
        told.populations.extend(tremie_fluid_lbm::d3q19::C.map(along));
    }
    // A cut along the second axis, cell by cell.
    let mut slice = Vec::new();
    let axis = lay.axis(1);
    let count = fluid.slice(axis, 5.5, &mut slice);
    let [fast, slow] = [[1, 2], [0, 2], [0, 1]][axis];
    assert_eq!(count, [fast, slow].map(|a| fluid.cells()[a]));
    for z in 0..nz {
        for x in 0..nx {
            let cell = lay.out([x, 5, z]);
            told.slice.push(node(slice[cell[fast] + count[0] * cell[slow]]));
        }
    }
}

/// Everything, to the last bit but for what poses of parts are turned by.
#[test]
fn what_a_fluid_tells_does_not_depend_on_how_the_scene_lies() {
    let first = run(Lay(0), 40);
    assert!(first.loads[0].force.iter().all(|f| f.abs() > 1e-6), "{:?}", first.loads);
    assert!(first.facets.iter().any(|facet| facet.force != [0.0; 3]));
    assert!(first.on_parts[0].torque.iter().all(|m| m.abs() > 1e-7), "{:?}", first.on_parts);
    assert_eq!((first.ports.len(), first.reservoirs.len(), first.probes.len()), (1, 1, 21));
    for lay in [Lay(1), Lay(2)] {
        let other = run(lay, 40);
        assert_eq!(first.loads, other.loads);
        assert_eq!(first.facets, other.facets);
        assert_eq!(first.on_parts, other.on_parts);
        assert_eq!(first.probes, other.probes);
        assert_eq!(first.ports, other.ports);
        assert_eq!(first.reservoirs, other.reservoirs);
        assert_eq!(first.ledger, other.ledger);
        assert_eq!(first.nodes, other.nodes);
        assert_eq!(first.slice, other.slice);
        assert_eq!(first.populations, other.populations);
    }
}

/// Errors are told by the world's axes.
#[test]
fn a_fault_is_where_the_world_has_it() {
    for lay in [0, 1, 2].map(Lay) {
        let mut fluid = Case::new(lay.out(CELLS), [WALL; 3], 0.6).fluid();
        let place = lay.out([20.5, 4.5, 7.5]);
        fluid.set_state(|x| (if x == place { [f64::NAN; 3] } else { [0.0; 3] }, 0.0));
        match fluid.check() {
            Err(FluidError::NonFinite { cell, position, .. }) => {
                assert_eq!((cell, position), (lay.out([20, 4, 7]), place));
            }
            other => panic!("{other:?}"),
        }
        let mut scene = Case::new(lay.out(CELLS), [WALL; 3], 0.6).scene();
        let reservoir = Reservoir::new(168.0, 168.0, 0.3);
        scene.domain.faces[lay.axis(2)][1] = Face::Reservoir(reservoir);
        let mut fluid = Case::new(lay.out(CELLS), [WALL; 3], 0.6).fluid_of(&scene);
        let error = (0..20).find_map(|_| fluid.step(&[], &mut []).err()).unwrap().to_string();
        let face = format!("{}_upper", ["x", "y", "z"][lay.axis(2)]);
        assert!(error.contains(&face), "{error}");
    }
}
