//! Viscous stress and conduction of heat, of fourth order and in the form of fluxes through faces.
//!
//! Derivatives across a face come from the four points around it, those along it from derivatives
//! at points, interpolated like all else by `(-1, 9, 9, -1)/16`. The divergence takes four faces.

use crate::gas::block_rates::GasRoom;
use crate::gas::central_flux::{MOST_RUN, shifted};
use crate::gas::gas_law::Gas;
use crate::grid::block_shape::BlockShape;

/// A number for each face of a row.
type RowOfFaces = [f64; MOST_RUN];

/// Values on the faces above a row of points.
#[inline(always)]
fn on_faces(field: &[f64], (row, run): (usize, usize), stride: usize) -> RowOfFaces {
    let s = stride as isize;
    let of = |by: isize| shifted(field, row, run, by);
    let (f0, f1, f2, f3) = (of(-s), of(0), of(s), of(2 * s));
    let mut faces = [0.0; MOST_RUN];
    for k in 0..run {
        faces[k] = (9.0 * (f1[k] + f2[k]) - (f0[k] + f3[k])) * (1.0 / 16.0);
    }
    faces
}

/// Derivatives across the faces above a row of points, times the spacing.
#[inline(always)]
fn across_faces(field: &[f64], (row, run): (usize, usize), stride: usize) -> RowOfFaces {
    let s = stride as isize;
    let of = |by: isize| shifted(field, row, run, by);
    let (f0, f1, f2, f3) = (of(-s), of(0), of(s), of(2 * s));
    let mut faces = [0.0; MOST_RUN];
    for k in 0..run {
        faces[k] = (27.0 * (f2[k] - f1[k]) - (f3[k] - f0[k])) * (1.0 / 24.0);
    }
    faces
}

/// Derivative at a point along an axis, times the spacing.
#[inline(always)]
pub fn at_point(field: &[f64], p: usize, stride: usize) -> f64 {
    let inner = field[p + stride] - field[p - stride];
    (8.0 * inner - field[p + 2 * stride] + field[p - 2 * stride]) / 12.0
}

/// Derivatives of the velocity at points along the other axes, which the faces across one need.
#[inline(always)]
pub fn tangential_slopes(shape: &BlockShape, axis: usize, room: &mut GasRoom) {
    let GasRoom { velocity, slope, .. } = room;
    // All points along the axis, the block's own along the others.
    let (mut from, mut to) = shape.own();
    (from[axis], to[axis]) = (0, shape.padded[axis]);
    for b in (0..shape.dims).filter(|&b| b != axis) {
        for component in [axis, b] {
            let which = if component == axis { &mut slope[2 * b] } else { &mut slope[2 * b + 1] };
            let (run, s) = (to[0] - from[0], shape.stride[b] as isize);
            for row in shape.rows(from, to) {
                let of = |by: isize| shifted(&velocity[component], row, run, by);
                let (f0, f1, f2, f3) = (of(-2 * s), of(-s), of(s), of(2 * s));
                let which = &mut which[row..row + run];
                for k in 0..run {
                    which[k] = (8.0 * (f2[k] - f1[k]) - (f3[k] - f0[k])) * (1.0 / 12.0);
                }
            }
        }
    }
}

/// Viscous fluxes through the faces above `run` points from `row` on, across an axis, in place of
/// what stands there. Momentum and heat that go *down* the axis.
#[inline(always)]
pub fn viscous_fluxes(
    (shape, gas): (&BlockShape, &Gas),
    axis: usize,
    spacing: f64,
    room: &mut GasRoom,
    (row, run): (usize, usize),
) {
    let (dims, stride) = (shape.dims, shape.stride[axis]);
    let conduction = gas.conduction();
    let GasRoom { velocity, temperature, viscosity, slope, flux, .. } = room;
    let (rows, across) = ((row, run), across_faces(&velocity[axis], (row, run), stride));
    let factor = on_faces(viscosity, rows, stride).map(|factor| factor / spacing);
    let mut divergence = across;
    for b in (0..dims).filter(|&b| b != axis) {
        let along = on_faces(&slope[2 * b + 1], rows, stride);
        (0..run).for_each(|k| divergence[k] += along[k]);
    }
    let mut energy = across_faces(temperature, rows, stride);
    (0..run).for_each(|k| energy[k] *= factor[k] * conduction);
    for b in 0..dims {
        let mut stress = [0.0; MOST_RUN];
        if b == axis {
            for k in 0..run {
                stress[k] = factor[k] * (2.0 * across[k] - 2.0 / 3.0 * divergence[k]);
            }
        } else {
            let turned = on_faces(&slope[2 * b], rows, stride);
            let sheared = across_faces(&velocity[b], rows, stride);
            (0..run).for_each(|k| stress[k] = factor[k] * (sheared[k] + turned[k]));
        }
        let carried = on_faces(&velocity[b], rows, stride);
        for k in 0..run {
            energy[k] += stress[k] * carried[k];
        }
        flux[1 + b][row..row + run].copy_from_slice(&stress[..run]);
    }
    flux[1 + dims][row..row + run].copy_from_slice(&energy[..run]);
}

/// Flux whose difference the divergence of fourth order is.
#[inline(always)]
pub fn through_face(flux: &[f64], p: usize, stride: usize) -> f64 {
    (26.0 * flux[p] - flux[p + stride] - flux[p - stride]) / 24.0
}
