//! Fluxes where the grid does not resolve what stands there: shocks, contacts, and young bodies'
//! surfaces.
//!
//! A face is rough where the fourth differences of density or pressure beside it exceed what the
//! wavelets tolerate: at the finest level the grid cannot answer by refinement. There the flux is
//! that of a weighted essentially non-oscillatory scheme of fifth order (Jiang and Shu 1996; weights
//! of Borges and others 2008) with the splitting of Lax and Friedrichs. Smooth wakes have no such
//! faces, and so no dissipation but the gas's own. Where gas is thin beside what is largest in the
//! domain, its own values are the measure.
//!
//! Where that flux could empty a point of density or pressure, the flux of first order takes its
//! place, which cannot (Hu, Adams and Shu, *J. Comput. Phys.* 242 (2013) 169).

use crate::gas::block_rates::GasRoom;
use crate::gas::central_flux::{MOST_RUN, shifted};
use crate::gas::gas_law::{Gas, MOST_FIELDS};
use crate::grid::block_shape::BlockShape;

/// Fourth difference over 16 times that is as large as a wavelet's detail.
const DETAIL: f64 = 3.0 / 16.0;

/// Detail of density or pressure as a share of what stands there that is rough, whatever stands
/// elsewhere.
const STEEP: f64 = 0.05;

/// Share of its density and pressure that a face leaves a point at least.
const LEAST_LEFT: f64 = 0.02;

/// Marks the faces above a row's points beside which a field is rough: what wavelets would be there
/// exceeds a bound.
#[inline(always)]
fn mark_rough(
    field: &[f64],
    (row, run): (usize, usize),
    stride: usize,
    bound: f64,
    is_rough: &mut [bool; MOST_RUN],
) {
    let s = stride as isize;
    let of = |by: isize| shifted(field, row, run, by);
    let (f0, f1, f2, f3, f4, f5) = (of(-2 * s), of(-s), of(0), of(s), of(2 * s), of(3 * s));
    for k in 0..run {
        let below = (f0[k] + f4[k]) - 4.0 * (f1[k] + f3[k]) + 6.0 * f2[k];
        let above = (f1[k] + f5[k]) - 4.0 * (f2[k] + f4[k]) + 6.0 * f3[k];
        let bound = bound.min(STEEP * f2[k].min(f3[k]));
        is_rough[k] |= DETAIL * below.abs().max(above.abs()) > bound;
    }
}

/// Replaces the fluxes through rough faces above `run` points from `row` on, across an axis.
/// `bounds` are the details of density and pressure that are still smooth.
#[inline(always)]
pub fn shock_fluxes(
    (shape, gas): (&BlockShape, &Gas),
    axis: usize,
    room: &mut GasRoom,
    fields: &[&[f64]; MOST_FIELDS],
    bounds: [f64; 2],
    (row, run): (usize, usize),
) {
    let stride = shape.stride[axis];
    let mut is_rough = [false; MOST_RUN];
    mark_rough(fields[0], (row, run), stride, bounds[0], &mut is_rough);
    mark_rough(&room.pressure, (row, run), stride, bounds[1], &mut is_rough);
    for p in (row..row + run).zip(is_rough).filter(|(_, is)| *is).map(|(p, _)| p) {
        let flux = upwind_flux(gas, shape.dims, axis, room, fields, (p, stride));
        for (field, flux) in flux.iter().enumerate().take(shape.dims + 2) {
            room.flux[field][p] = *flux;
        }
    }
}

/// The flux of the face above a point.
fn upwind_flux(
    gas: &Gas,
    dims: usize,
    axis: usize,
    room: &GasRoom,
    fields: &[&[f64]; MOST_FIELDS],
    (p, stride): (usize, usize),
) -> [f64; MOST_FIELDS] {
    let at: [usize; 6] = std::array::from_fn(|k| p + k * stride - 2 * stride);
    let speed = at.iter().fold(0.0_f64, |fastest, &q| {
        let sound = gas.sound_speed(fields[0][q], room.pressure[q]);
        fastest.max(room.velocity[axis][q].abs() + sound)
    });
    let half = |field: usize, k: usize, sign: f64| {
        let (q, along) = (at[k], room.velocity[axis][at[k]]);
        let push = match field {
            _ if field == 1 + axis => room.pressure[q],
            _ if field == 1 + dims => room.pressure[q] * along,
            _ => 0.0,
        };
        0.5 * (fields[field][q] * along + push + sign * speed * fields[field][q])
    };
    let flux = std::array::from_fn(|field| {
        if field >= dims + 2 {
            return 0.0;
        }
        let up = [0, 1, 2, 3, 4].map(|k| half(field, k, 1.0));
        let down = [5, 4, 3, 2, 1].map(|k| half(field, k, -1.0));
        weighted(up) + weighted(down)
    });
    let leaves_gas = [(p, -1.0), (p + stride, 1.0)].into_iter().all(|(q, sign)| {
        let left = std::array::from_fn(|field| {
            if field < dims + 2 { fields[field][q] + sign * flux[field] / speed } else { 0.0 }
        });
        is_gas(
            dims,
            &left,
            LEAST_LEFT * fields[0][q],
            LEAST_LEFT * room.pressure[q] / (gas.heat_ratio - 1.0),
        )
    });
    if leaves_gas {
        return flux;
    }
    std::array::from_fn(|field| {
        if field < dims + 2 { half(field, 2, 1.0) + half(field, 3, -1.0) } else { 0.0 }
    })
}

/// True if fields are those of gas of at least a density and a heat of a volume [J/m^3].
fn is_gas(dims: usize, fields: &[f64; MOST_FIELDS], density: f64, heat: f64) -> bool {
    let square: f64 = fields[1..=dims].iter().map(|m| m * m).sum();
    fields[0] > density && fields[1 + dims] - 0.5 * square / fields[0] > heat
}

/// Value between the third and the fourth of five points: three parabolas, by their smoothness.
fn weighted([a, b, c, d, e]: [f64; 5]) -> f64 {
    let square = |x: f64| x * x;
    let smooth = [
        13.0 / 12.0 * square(a - 2.0 * b + c) + 0.25 * square(a - 4.0 * b + 3.0 * c),
        13.0 / 12.0 * square(b - 2.0 * c + d) + 0.25 * square(b - d),
        13.0 / 12.0 * square(c - 2.0 * d + e) + 0.25 * square(3.0 * c - 4.0 * d + e),
    ];
    let global = (smooth[0] - smooth[2]).abs();
    let least = 1e-40 + 1e-12 * (square(a) + square(c) + square(e));
    let weights: [f64; 3] =
        std::array::from_fn(|k| [0.1, 0.6, 0.3][k] * (1.0 + square(global / (smooth[k] + least))));
    let values = [
        (2.0 * a - 7.0 * b + 11.0 * c) / 6.0,
        (-b + 5.0 * c + 2.0 * d) / 6.0,
        (2.0 * c + 5.0 * d - e) / 6.0,
    ];
    let sum = weights[0] + weights[1] + weights[2];
    (weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]) / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_profile_is_of_fifth_order_and_a_jump_does_not_overshoot() {
        // Means over cells of sin(x): the value between is found to h^5.
        let error = |h: f64| {
            let mean = |k: f64| (((k - 0.5) * h).cos() - ((k + 0.5) * h).cos()) / h;
            let exact = (0.5 * h).sin();
            (weighted([-2.0, -1.0, 0.0, 1.0, 2.0].map(mean)) - exact).abs()
        };
        let order = (error(0.2) / error(0.1)).log2();
        assert!(order > 4.7, "{order}");
        for jump in
            [[0.0, 0.0, 0.0, 1.0, 1.0], [1.0, 1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 1.0, 1.0]]
        {
            let value = weighted(jump);
            assert!((-1e-6..=1.0 + 1e-6).contains(&value), "{jump:?}: {value}");
        }
    }
}
