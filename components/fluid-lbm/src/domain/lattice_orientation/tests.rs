//! Turns keep right hands right, and lead back.

use super::*;
use crate::domain::parameters::Parameters;
use crate::fluid::lbm_fluid::LbmFluid;
use crate::solver::lbm_solver::LbmSolver;
use tremie_geometry::Frame;
use tremie_messages::scene::{
    Course, Domain, Face, FluidMaterial, OpenVelocity, Pose, Profile, Scene,
};
use tremie_team::Variant;

const ALL: [LatticeOrientation; 3] = [
    LatticeOrientation { first: 0 },
    LatticeOrientation { first: 1 },
    LatticeOrientation { first: 2 },
];

#[test]
fn what_is_turned_is_turned_back() {
    for axes in ALL {
        assert_eq!(axes.to_world(&axes.to_lattice(&[4, 5, 6])), [4, 5, 6]);
        assert_eq!(axes.to_lattice(&[4, 5, 6])[0], [4, 5, 6][axes.first]);
        for axis in 0..3 {
            assert_eq!(axes.axis_to_world(axes.axis_to_lattice(axis)), axis);
        }
        for i in 0..Q {
            assert_eq!(C[axes.direction_to_lattice(i)], axes.to_lattice(&C[i]));
        }
    }
}

/// The quaternion does to a part what the order of the numbers does to a vector.
#[test]
fn poses_turn_as_vectors_do() {
    let length = (0.1_f64 * 0.1 + 0.3 * 0.3 + 0.2 * 0.2 + 0.9 * 0.9).sqrt();
    let orientation = [0.1, -0.3, 0.2, 0.9].map(|x| x / length);
    let pose = |orientation| Frame::of(&Pose { orientation, ..Pose::IDENTITY });
    for axes in ALL {
        let turned = pose(axes.turn(orientation));
        for point in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.3, -2.0, 5.0]] {
            let expected = axes.to_lattice(&pose(orientation).to_world(point).into());
            let found = turned.to_world(point);
            assert!((0..3).all(|a| (found[a] - expected[a]).abs() < 1e-14), "{axes:?} {found:?}");
        }
        // A pose that is not turned keeps its bits.
        let point = [0.1, -0.2, 1e-17];
        let upright = pose(axes.turn([0.0, 0.0, 0.0, 1.0]));
        assert_eq!(<[f64; 3]>::from(upright.to_world(point)), axes.to_lattice(&point));
    }
}

/// Rows lie along the longest way through the fluid, but where that gains little, or the ends of
/// shorter rows are those of lines.
#[test]
fn rows_are_long() {
    let of = |size: [f64; 3]| {
        let domain = Domain::new([0.0; 3], size, Face::WALLS);
        let fluid = Some(FluidMaterial::at_rest(1.0, 0.1));
        let scene = Scene { fluid, ..Scene::empty(domain) };
        let (_, ground) = Parameters::with_cell(1.0).survey(&scene).unwrap();
        LatticeOrientation::with_whole_lines(&ground, 16).first
    };
    assert_eq!(of([9.0, 9.0, 9.0]), 0);
    assert_eq!(of([10.0, 30.0, 11.0]), 1);
    assert_eq!(of([10.0, 11.0, 30.0]), 2);
    assert_eq!(of([30.0, 31.0, 8.0]), 0);
    assert_eq!(of([32.0, 40.0, 32.0]), 0);
    assert_eq!(of([32.0, 48.0, 32.0]), 0);
    assert_eq!(of([31.0, 48.0, 31.0]), 1);
}

/// Lines in pieces are those in which a row ends or begins, but not with the line.
#[test]
fn lines_in_pieces_are_counted() {
    let grid = Grid::walled([5, 4, 1], [false; 3]);
    // Fluid is 0: rows of 5, 2 and 2, 4 and 5 cells along x.
    let solid = [0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0];
    let of = |first: usize, line| LatticeOrientation { first }.lines(&grid, &solid, line);
    // They end at 5, 7, 9, 13 and 18.
    assert_eq!(of(0, 4), [5, 4]);
    assert_eq!(of(0, 18), [1, 1]);
    // Along y 4, 4, 1 and 2, 4, 2 and 1 cells: at 4, 8, 9, 11, 15, 17 and 18.
    assert_eq!(of(1, 4), [5, 3]);
}

/// Of two walls at an edge, or two open faces, the same one counts as by the world's axes: each
/// cell holds what it holds there, to rounding.
#[test]
fn edges_belong_to_the_same_faces() {
    let wall = |velocity| Face::moving(velocity);
    let open = |velocity| {
        Face::Velocity(OpenVelocity {
            velocity,
            profile: Profile::Uniform,
            course: Course::default(),
        })
    };
    let walls = [
        [wall([0.0, 0.02, 0.01]), wall([0.0, -0.01, 0.03])],
        [wall([0.01, 0.0, -0.02]), wall([0.03, 0.0, 0.02])],
        [wall([-0.02, 0.01, 0.0]), wall([0.01, 0.03, 0.0])],
    ];
    let mut pipe = walls.clone();
    pipe[0][0] = open([0.02, 0.0, 0.0]);
    pipe[1][1] = open([0.0, 0.03, 0.0]);
    pipe[2][0] = open([0.0, 0.0, 0.01]);
    for (faces, size) in
        [(walls.clone(), [7.0, 17.0, 9.0]), (walls, [7.0, 9.0, 17.0]), (pipe, [7.0, 17.0, 9.0])]
    {
        let scene = Scene {
            fluid: Some(FluidMaterial::at_rest(1.0, 0.1)),
            ..Scene::empty(Domain::new([0.0; 3], size, faces))
        };
        let parameters = Parameters::with_cell(1.0);
        let step = parameters.resolve(&scene).unwrap().time_step;
        let mut fluid = LbmFluid::new(&scene, &parameters, step, 1).unwrap();
        let mut plain =
            LbmSolver::<f64>::new(&scene, &parameters, step, 1, Variant::widest()).unwrap();
        let mut largest = 0.0_f64;
        for _ in 0..30 {
            fluid.step(&[], &mut []).unwrap();
            plain.step(&[], &mut []).unwrap();
        }
        let [nx, ny, nz] = fluid.cells();
        for k in 0..nx * ny * nz {
            let at = [k % nx, k / nx % ny, k / (nx * ny)];
            let (turned, own) = (fluid.populations_at(at), plain.lattice.populations_at(at));
            for i in 0..Q {
                assert!((turned[i] - own[i]).abs() < 1e-14, "{at:?} {i}: {} {}", turned[i], own[i]);
                largest = largest.max(own[i].abs());
            }
        }
        assert!(largest > 1e-3);
    }
}
