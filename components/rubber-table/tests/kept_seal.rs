//! A seal that goes on from the file of a state ends with the bits of one that was never interrupted.

mod common;

use tremie_messages::scene::{DeformableSurface, FacetKind, Pose, SurfaceStart};
use tremie_messages::{BodyState, FacetLoad, SurfaceVertex};
use tremie_rubber_table::runtime::{Form, Law, Seal, Water};
use tremie_rubber_table::table::Surface;
use tremie_state::SavedState;
use tremie_test_support::through_a_file;

const SLOPE: f64 = 1.194e5;
const WINDOW: f64 = 4.8e-7;
const SUBSTEPS: u32 = 4;

fn scene(compression: f64) -> DeformableSurface {
    let table = common::linear(SLOPE);
    let section = table.vertices(table.bracket(compression).unwrap());
    let outline = table.outline();
    DeformableSurface {
        name: "ring".into(),
        carrier: "disc".into(),
        table: "ring.json".into(),
        pose: Pose { position: [0.0, 0.0, -3e-3 - compression], ..Pose::IDENTITY },
        sectors: 12,
        material: "rubber".into(),
        seat_stiffness: 1e10,
        start: SurfaceStart {
            compression,
            points: outline.vertices.iter().map(|vertex| section[*vertex]).collect(),
        },
        section: outline.section,
    }
}

fn begin(compression: f64) -> Seal {
    let water = Water { density: 1e3, sound_speed: 1250.0, added_mass: None, exchange: WINDOW };
    let (table, law) = (common::linear(SLOPE), Law::default());
    let dt = WINDOW / f64::from(SUBSTEPS);
    Seal::new(&scene(compression), table, law, Form::Axial, Some(water), dt).unwrap()
}

/// The carrier comes down and turns about the ring's axis.
fn carrier(time: f64) -> BodyState {
    let half = 10.0 * time;
    BodyState {
        orientation: [0.0, 0.0, half.sin(), half.cos()],
        velocity: [0.0, 0.0, -0.2],
        angular_velocity: [0.0, 0.0, 20.0],
        ..BodyState::at_rest(0, [1e-3, 2e-3, 3e-3 - 0.2 * time])
    }
}

/// What a seal tells.
fn report(seal: &Seal) -> Vec<u64> {
    let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
    let mut strains = vec![0.0; seal.vertex_count()];
    seal.write(&mut vertices);
    seal.write_strains(&mut strains);
    let resultant = seal.resultant();
    let of_vertex = |vertex: &SurfaceVertex| [vertex.position, vertex.velocity];
    let vectors = vertices.iter().flat_map(of_vertex).chain([resultant.force, resultant.torque]);
    let values = vectors.flatten().chain(strains).map(f64::to_bits);
    values.chain(format!("{:?}", seal.readings()).bytes().map(u64::from)).collect()
}

/// Goes through windows in which a fluid answers the rate of before, and springs are the seat.
fn go(seal: &mut Seal, windows: std::ops::Range<u32>) -> Vec<Vec<u64>> {
    let surface = Surface::of(&scene(0.0));
    let mut vertices = vec![SurfaceVertex::default(); seal.vertex_count()];
    let mut told = Vec::new();
    for window in windows {
        let push = -20.0 * seal.readings().rate + f64::from(window % 7);
        let of_fluid = FacetLoad {
            facet: 30,
            force: [0.1, 0.2 * push, push],
            point: [0.01, 0.0, 0.0],
            stiffness: 0.0,
        };
        seal.begin_window([of_fluid].into_iter());
        for substep in 1..=SUBSTEPS {
            let part = f64::from(substep) / f64::from(SUBSTEPS);
            seal.begin_substep(&carrier((f64::from(window) + part) * WINDOW));
            loop {
                seal.write(&mut vertices);
                let springs = (0..12).map(|sector| {
                    let facet = 2 * sector;
                    assert_eq!(surface.kinds[facet], FacetKind::Seat);
                    let point = vertices[surface.triangles[facet][0] as usize].position;
                    let force = [0.0, 0.0, 1e6 * (-point[2]).max(0.0)];
                    FacetLoad { facet: facet as u64, force, point, stiffness: 1e6 }
                });
                let springs: Vec<_> = springs.filter(|load| load.force[2] > 0.0).collect();
                if seal.pass(springs.into_iter()).unwrap() {
                    break;
                }
            }
        }
        told.push(report(seal));
    }
    told
}

#[test]
fn a_seal_comes_down_on_its_seat() {
    for compression in [0.0, 0.2e-3] {
        let mut whole = begin(compression);
        whole.follow(&carrier(0.0));
        let expected = go(&mut whole, 0..60);
        assert!(whole.readings().seat_pressure > 0.0 && whole.readings().rate != 0.0);
        let ended = SavedState::of(&mut whole).unwrap();
        for stop in [0, 1, 31] {
            let mut first = begin(compression);
            first.follow(&carrier(0.0));
            go(&mut first, 0..stop);
            let mut second = begin(compression);
            through_a_file(&mut first, &mut second);
            assert!(report(&second) == report(&first), "at window {stop}");
            let told = go(&mut second, stop..60);
            assert!(told == expected[stop as usize..], "from window {stop}");
            let now = SavedState::of(&mut second).unwrap();
            assert_eq!(now.first_difference(&ended), None, "from window {stop}");
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let mut seal = begin(0.0);
    seal.begin_window(std::iter::empty());
    seal.begin_substep(&carrier(0.0));
    assert!(SavedState::of(&mut seal).is_err());
    let state = SavedState::of(&mut begin(0.5e-3)).unwrap();
    let contents = common::linear(SLOPE).contents().clone();
    let shorter = tremie_rubber_table::table::Contents {
        compressions: vec![0.0, 0.1e-3, 0.3e-3],
        ..contents
    };
    let table = tremie_rubber_table::table::Table::new(shorter).unwrap();
    let law = Law::default();
    let mut other = Seal::new(&scene(0.0), table, law, Form::Axial, None, 1e-7).unwrap();
    assert!(state.restore(&mut other).unwrap_err().to_string().contains("the state of a seal"));
}
