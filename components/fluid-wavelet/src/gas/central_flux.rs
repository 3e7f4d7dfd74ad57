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

/// Most points of a row at once.
pub const MOST_RUN: usize = 32;

/// A row of a field, some points further along an axis.
#[inline(always)]
pub fn shifted(field: &[f64], row: usize, run: usize, by: isize) -> &[f64] {
    &field[row.wrapping_add_signed(by)..][..run]
}

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
    let s = shape.stride[axis] as isize;
    let GasRoom { velocity, pressure, enthalpy, flux, .. } = room;
    // Half of the mass that goes through, of the three pairs.
    let mut mass = [[0.0; MOST_RUN]; 3];
    let [near, far] = WEIGHTS.map(|weight| 0.25 * weight * 2.0);
    {
        let of =
            |by: isize| (shifted(density, row, run, by), shifted(&velocity[axis], row, run, by));
        let ((d0, u0), (d1, u1), (d2, u2), (d3, u3)) = (of(-s), of(0), of(s), of(2 * s));
        let through = &mut flux[0][row..row + run];
        for k in 0..run {
            mass[0][k] = near * (d1[k] + d2[k]) * (u1[k] + u2[k]);
            mass[1][k] = far * (d0[k] + d2[k]) * (u0[k] + u2[k]);
            mass[2][k] = far * (d1[k] + d3[k]) * (u1[k] + u3[k]);
            through[k] = mass[0][k] + mass[1][k] + mass[2][k];
        }
    }
    let carry = |carried: &[f64], through: &mut [f64]| {
        let of = |by: isize| shifted(carried, row, run, by);
        let (c0, c1, c2, c3) = (of(-s), of(0), of(s), of(2 * s));
        for k in 0..run {
            let sum = mass[0][k] * (c1[k] + c2[k]) + mass[1][k] * (c0[k] + c2[k]);
            through[k] = 0.5 * (sum + mass[2][k] * (c1[k] + c3[k]));
        }
    };
    for a in 0..shape.dims {
        carry(&velocity[a], &mut flux[1 + a][row..row + run]);
    }
    carry(enthalpy, &mut flux[1 + shape.dims][row..row + run]);
    let of = |by: isize| shifted(pressure, row, run, by);
    let (p0, p1, p2, p3) = (of(-s), of(0), of(s), of(2 * s));
    let push = &mut flux[1 + axis][row..row + run];
    for k in 0..run {
        push[k] += WEIGHTS[0] * (p1[k] + p2[k]) + WEIGHTS[1] * ((p0[k] + p2[k]) + (p1[k] + p3[k]));
    }
}
