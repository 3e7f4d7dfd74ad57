//! Loads of the gas on bodies, by stress at their surfaces.
//!
//! `F = int sigma N dS` is taken over the points near a surface with smoothed delta functions of the
//! distance. Pressure goes on inside a body as it falls outside: it is taken on both sides, and
//! counts from that of the gas at rest, which has no resultant. Shear inside is that of the surface
//! and does not fall on: it is taken outside, at two heights, and extrapolated to the surface. So
//! both are of second order. Where another surface or a face of the domain is nearer than four and
//! a half points, part of these heights is missing, and shear is a guess.

use crate::bodies::body_mask::{BAND, BEYOND_GHOSTS, BlockPlaces};
use crate::bodies::gas_body::{BodyLoad, GasBody};
use crate::gas::block_rates::GasRoom;
use crate::gas::gas_law::Gas;
use crate::gas::viscous_flux::at_point;
use crate::grid::block_shape::GHOSTS;
use crate::grid::block_tree::BlockAddress;

/// Half of the width of the delta function of pressure, in points.
const PRESSURE_REACH: f64 = 2.0;
/// That of shear; it stands at this height above the surface, and at twice that.
const SHEAR_REACH: f64 = 1.5;

const _: () = assert!(BAND >= 3.0 * SHEAR_REACH);
const _: () = assert!(GHOSTS as f64 + BEYOND_GHOSTS >= 3.0 * SHEAR_REACH);

/// A smoothed delta function: of a distance and half of its width [m], in 1/m.
fn delta(distance: f64, reach: f64) -> f64 {
    let relative = distance / reach;
    if relative.abs() >= 1.0 {
        return 0.0;
    }
    (1.0 + (std::f64::consts::PI * relative).cos()) / (2.0 * reach)
}

/// Adds the loads on the bodies that come near a block of its points, whose state the room holds.
/// `marks` tell which of these are inside bodies; those in other bodies have no gas to press.
pub fn add_surface_loads(
    (places, gas): (&BlockPlaces, &Gas),
    block: BlockAddress,
    rest: f64,
    (bodies, near): (&[impl GasBody], &[u16]),
    marks: &[u16],
    room: &GasRoom,
    loads: &mut [BodyLoad],
) {
    let shape = &places.shape;
    let spacing = places.spacing(block.level);
    let volume = spacing.powi(shape.dims as i32);
    let (lift, depth) = (SHEAR_REACH * spacing, PRESSURE_REACH * spacing);
    let highest = if gas.viscosity > 0.0 { (3.0 * lift).max(depth) } else { depth };
    let (from, to) = shape.own();
    for row in shape.rows(from, to) {
        for p in row..row + shape.edge[0] {
            let at = places.padded_point(block, shape.at(p));
            for (body, load) in near.iter().zip(loads.iter_mut()) {
                if marks[p] != 0 && marks[p] != *body + 1 {
                    continue;
                }
                let body = &bodies[usize::from(*body)];
                let (height, normal) = body.height(at);
                if height >= highest || height <= -depth {
                    continue;
                }
                let pressing = delta(height, depth) * (room.pressure[p] - rest);
                let mut traction = normal.map(|n| -n * pressing);
                if gas.viscosity > 0.0 && height > 0.0 {
                    let share = 2.0 * delta(height - lift, lift) - delta(height - 2.0 * lift, lift);
                    let shear = shear(places, gas, room, (p, spacing), normal);
                    (0..3).for_each(|a| traction[a] += share * shear[a]);
                }
                let foot = std::array::from_fn(|a| at[a] - height * normal[a]);
                load.add(traction.map(|t| t * volume), body.arm(foot));
            }
        }
    }
}

/// Stress of friction on a surface of a normal at a point [Pa].
fn shear(
    places: &BlockPlaces,
    gas: &Gas,
    room: &GasRoom,
    (p, spacing): (usize, f64),
    normal: [f64; 3],
) -> [f64; 3] {
    let shape = &places.shape;
    let viscosity = gas.viscosity_at(room.temperature[p]) / spacing;
    let mut slope = [[0.0; 3]; 3];
    for i in 0..shape.dims {
        for j in 0..shape.dims {
            slope[i][j] = at_point(&room.velocity[i], p, shape.stride[j]);
        }
    }
    let divergence = slope[0][0] + slope[1][1] + slope[2][2];
    std::array::from_fn(|i| {
        let along: f64 = (0..3).map(|j| (slope[i][j] + slope[j][i]) * normal[j]).sum();
        viscosity * (along - 2.0 / 3.0 * divergence * normal[i])
    })
}
