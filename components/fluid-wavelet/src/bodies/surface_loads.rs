//! Loads of the gas on bodies, by stress at their surfaces.
//!
//! `F = int sigma N dS` is taken over the points near a surface with a smoothed delta function of
//! the distance: what stands inside a body goes on as it does outside, so that stress is smooth
//! there. Pressure counts from that of the gas at rest, which has no resultant.

use crate::bodies::body_mask::BlockPlaces;
use crate::bodies::gas_body::{BodyLoad, GasBody};
use crate::gas::block_rates::GasRoom;
use crate::gas::gas_law::Gas;
use crate::gas::viscous_flux::at_point;
use crate::grid::block_tree::BlockAddress;

/// Half of the width of the delta function, in points.
const REACH: f64 = 2.0;

/// Adds the loads on the bodies that come near a block of its points, whose state the room holds.
pub fn add_surface_loads(
    (places, gas): (&BlockPlaces, &Gas),
    block: BlockAddress,
    rest: f64,
    (bodies, near): (&[impl GasBody], &[u16]),
    room: &GasRoom,
    loads: &mut [BodyLoad],
) {
    let shape = &places.shape;
    let spacing = places.spacing(block.level);
    let volume = spacing.powi(shape.dims as i32);
    let (from, to) = shape.own();
    for row in shape.rows(from, to) {
        for p in row..row + shape.edge[0] {
            let at = places.padded_point(block, shape.at(p));
            for (body, load) in near.iter().zip(loads.iter_mut()) {
                let body = &bodies[usize::from(*body)];
                let (height, normal) = body.height(at);
                let relative = height / (REACH * spacing);
                if relative.abs() >= 1.0 {
                    continue;
                }
                let delta =
                    (1.0 + (std::f64::consts::PI * relative).cos()) / (2.0 * REACH * spacing);
                let traction = traction(places, gas, room, (p, spacing), rest, normal);
                let foot = std::array::from_fn(|a| at[a] - height * normal[a]);
                load.add(traction.map(|t| t * delta * volume), body.arm(foot));
            }
        }
    }
}

/// Stress on a surface of a normal at a point [Pa].
fn traction(
    places: &BlockPlaces,
    gas: &Gas,
    room: &GasRoom,
    (p, spacing): (usize, f64),
    rest: f64,
    normal: [f64; 3],
) -> [f64; 3] {
    let shape = &places.shape;
    let mut traction = normal.map(|n| -n * (room.pressure[p] - rest));
    if gas.viscosity > 0.0 {
        let viscosity = gas.viscosity_at(room.temperature[p]) / spacing;
        let mut slope = [[0.0; 3]; 3];
        for i in 0..shape.dims {
            for j in 0..shape.dims {
                slope[i][j] = at_point(&room.velocity[i], p, shape.stride[j]);
            }
        }
        let divergence = slope[0][0] + slope[1][1] + slope[2][2];
        for i in 0..shape.dims {
            let shear: f64 = (0..3).map(|j| (slope[i][j] + slope[j][i]) * normal[j]).sum();
            traction[i] += viscosity * (shear - 2.0 / 3.0 * divergence * normal[i]);
        }
    }
    traction
}
