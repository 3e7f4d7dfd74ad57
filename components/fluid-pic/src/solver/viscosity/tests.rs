//! Tests of the viscous step against exact flows.

use super::*;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::solids::half_spaces::HalfSpaces;
use crate::solids::open_fractions::OpenFractions;
use crate::solids::rigid_body::BodyShape;
use crate::solids::section::Section;
use crate::solver::pic_settings::BoxWall;
use std::f64::consts::PI;

const FLAT: Section<2> = Section { axes: [0, 1], through: [0.0; 3] };

/// A channel along x, open at its ends, of 4 by `n` cells, one high.
fn channel(n: usize, solids: Vec<RigidBody<2>>) -> (StaggeredGrid<2>, OpenFractions<2>) {
    let grid = StaggeredGrid::new([4, n], 1.0 / n as f64, [0.0; 2], [false; 2]);
    let fractions = OpenFractions::new(&grid, |axis, _| axis == 0, solids);
    (grid, fractions)
}

const STICK: [[BoxWall<2>; 2]; 2] =
    [[BoxWall::Slip; 2], [BoxWall::Stick([0.0; 2]), BoxWall::Stick([0.0; 2])]];

fn shear(
    grid: &StaggeredGrid<2>,
    fractions: &OpenFractions<2>,
    velocity: &mut [f64],
    (steps, number): (usize, f64),
) -> ShearLoads<2> {
    let mut team = Team::new("test", 1).unwrap();
    let mut viscosity = Viscosity::default();
    let carried = [vec![true; grid.stored], vec![false; grid.stored]];
    let mut both = [velocity.to_vec(), vec![0.0; grid.stored]];
    // Of unit density and viscosity.
    let dt = number * grid.spacing * grid.spacing;
    for _ in 0..steps {
        let step = ViscousStep {
            grid,
            fractions,
            bodies: &[],
            walls: &STICK,
            bodies_stick: true,
            density: 1.0,
            number,
            dt,
            gains: &[],
        };
        viscosity.shear(&mut team, Variant::widest(), &step, &carried, &mut both);
    }
    velocity.copy_from_slice(&both[0]);
    viscosity.loads
}

/// A sine between two walls fades as the exact solution does.
#[test]
fn a_sine_between_walls_fades() {
    let n = 32;
    let (grid, fractions) = channel(n, Vec::new());
    let mut velocity = vec![0.0; grid.stored];
    for cell in grid.all() {
        velocity[grid.place(cell)] = (PI * grid.face_centre(0, cell)[1]).sin();
    }
    let (steps, number) = (50, 0.5);
    shear(&grid, &fractions, &mut velocity, (steps, number));
    let time = steps as f64 * number / (n * n) as f64;
    let exact = (-PI * PI * time).exp();
    let middle = [2, n as isize / 2];
    let found = velocity[grid.place(middle)] / (PI * grid.face_centre(0, middle)[1]).sin();
    assert!((found / exact - 1.0).abs() < 5e-3, "{found} {exact}");
}

/// Between a plate that moves and a wall the velocity falls linearly, wherever among the cells the
/// plate's surface lies, and the plate feels the shear.
#[test]
fn a_plate_that_slides_drags_the_fluid_linearly() {
    for surface in [0.1, 0.117, 0.137, 0.149] {
        let solid = HalfSpaces::beyond([0.0, surface, 0.0], [0.0, 1.0, 0.0], &FLAT);
        let shape = BodyShape::Convex {
            solid: Box::new(solid),
            reach: f64::INFINITY,
            width: f64::INFINITY,
            volume: 0.0,
        };
        let mut plate = RigidBody::at([0.0; 2], shape);
        plate.velocity = [1.0, 0.0];
        let (grid, fractions) = channel(20, vec![plate]);
        let mut velocity = vec![0.0; grid.stored];
        let loads = shear(&grid, &fractions, &mut velocity, (400, 5.0));
        for j in 3..20 {
            let cell = [2, j];
            let height = grid.face_centre(0, cell)[1];
            let exact = (1.0 - height) / (1.0 - surface);
            let found = velocity[grid.place(cell)];
            assert!((found - exact).abs() < 1e-6, "{surface} {height}: {found} {exact}");
        }
        // Four cells long, of which the faces of the lower end are the box's.
        let exact = -0.2 / (1.0 - surface);
        assert!((loads.solids[0][0] / exact - 1.0).abs() < 1e-6, "{:?} {exact}", loads.solids);
        let wall = loads.walls[1][1][0];
        assert!((wall + loads.solids[0][0]).abs() < 1e-6, "{wall}");
    }
}
