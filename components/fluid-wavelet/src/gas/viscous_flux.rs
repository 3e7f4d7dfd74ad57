//! Viscous stress and conduction of heat, of fourth order and in the form of fluxes through faces.
//!
//! Derivatives across a face come from the four points around it, those along it from derivatives
//! at points, interpolated like all else by `(-1, 9, 9, -1)/16`. The divergence takes four faces.

use crate::gas::block_rates::GasRoom;
use crate::gas::gas_law::Gas;
use crate::grid::block_shape::BlockShape;

/// Value on the face above a point.
#[inline(always)]
fn on_face(field: &[f64], p: usize, stride: usize) -> f64 {
    let inner = field[p] + field[p + stride];
    (9.0 * inner - field[p - stride] - field[p + 2 * stride]) / 16.0
}

/// Derivative across the face above a point, times the spacing.
#[inline(always)]
fn across_face(field: &[f64], p: usize, stride: usize) -> f64 {
    let inner = field[p + stride] - field[p];
    (27.0 * inner + field[p - stride] - field[p + 2 * stride]) / 24.0
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
            for row in shape.rows(from, to) {
                for p in row..row + to[0] - from[0] {
                    which[p] = at_point(&velocity[component], p, shape.stride[b]);
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
    for p in row..row + run {
        let factor = on_face(viscosity, p, stride) / spacing;
        let along = across_face(&velocity[axis], p, stride);
        let mut divergence = along;
        for b in (0..dims).filter(|&b| b != axis) {
            divergence += on_face(&slope[2 * b + 1], p, stride);
        }
        let mut energy = factor * conduction * across_face(temperature, p, stride);
        for b in 0..dims {
            let stress = if b == axis {
                factor * (2.0 * along - 2.0 / 3.0 * divergence)
            } else {
                let turned = on_face(&slope[2 * b], p, stride);
                factor * (across_face(&velocity[b], p, stride) + turned)
            };
            flux[1 + b][p] = stress;
            energy += stress * on_face(&velocity[b], p, stride);
        }
        flux[1 + dims][p] = energy;
    }
}

/// Divergence of fluxes at a point, times the spacing.
#[inline(always)]
pub fn divergence(flux: &[f64], p: usize, stride: usize) -> f64 {
    let inner = flux[p] - flux[p - stride];
    (27.0 * inner - flux[p + stride] + flux[p - 2 * stride]) / 24.0
}

/// What the divergence is the difference of.
#[inline(always)]
pub fn through_face(flux: &[f64], p: usize, stride: usize) -> f64 {
    (26.0 * flux[p] - flux[p + stride] - flux[p - stride]) / 24.0
}
