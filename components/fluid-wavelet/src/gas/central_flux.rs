//! Fluxes without dissipation: central differences of fourth order that keep the kinetic energy
//! (Pirozzoli, *J. Comput. Phys.* 229 (2010) 7180, with the splitting of Kennedy and Gruber).
//!
//! The flux through the face between points i and i + 1 is
//! `2 [a1 f(i, i+1) + a2 (f(i-1, i+1) + f(i, i+2))]` with a1 = 2/3, a2 = -1/12. The flux of two
//! points is the product of their means: of density, velocity and what is carried.

use crate::gas::block_rates::GasRoom;
use crate::grid::block_shape::BlockShape;

/// Weights of pairs of points at a distance of one and two.
const WEIGHTS: [f64; 2] = [2.0 / 3.0, -1.0 / 12.0];

/// Fluxes through the faces above `run` points from `row` on, across an axis.
#[inline(always)]
pub fn central_fluxes(
    shape: &BlockShape,
    axis: usize,
    room: &mut GasRoom,
    density: &[f64],
    row: usize,
    run: usize,
) {
    let stride = shape.stride[axis];
    let dims = shape.dims;
    let GasRoom { velocity, pressure, enthalpy, flux, .. } = room;
    let along = &velocity[axis];
    // Mass and pressure that go through, of the three pairs.
    let pairs = |p: usize| {
        [
            (p, p + stride, WEIGHTS[0]),
            (p - stride, p + stride, WEIGHTS[1]),
            (p, p + 2 * stride, WEIGHTS[1]),
        ]
    };
    for p in row..row + run {
        let (mut mass, mut push) = (0.0, 0.0);
        for (i, j, weight) in pairs(p) {
            mass += weight * 0.5 * (density[i] + density[j]) * (along[i] + along[j]);
            push += weight * (pressure[i] + pressure[j]);
        }
        flux[0][p] = mass;
        flux[1 + axis][p] = push;
    }
    for a in 0..dims {
        let carried = &velocity[a];
        let is_pushed = if a == axis { 1.0 } else { 0.0 };
        for p in row..row + run {
            let mut sum = 0.0;
            for (i, j, weight) in pairs(p) {
                let mass = 0.5 * (density[i] + density[j]) * (along[i] + along[j]);
                sum += weight * mass * 0.5 * (carried[i] + carried[j]);
            }
            flux[1 + a][p] = sum + if is_pushed > 0.0 { flux[1 + a][p] } else { 0.0 };
        }
    }
    for p in row..row + run {
        let mut sum = 0.0;
        for (i, j, weight) in pairs(p) {
            let mass = 0.5 * (density[i] + density[j]) * (along[i] + along[j]);
            sum += weight * mass * 0.5 * (enthalpy[i] + enthalpy[j]);
        }
        flux[1 + dims][p] = sum;
    }
}
