//! What the gas's motion changes at the points of a block: the compressible equations of Navier and
//! Stokes (Goetsch 2015, Eqs. 2.1 to 2.5).

use crate::bodies::gas_body::BodyLoad;
use crate::gas::central_flux::central_fluxes;
use crate::gas::gas_law::{Gas, MOST_FIELDS, field_count};
use crate::gas::shock_flux::shock_fluxes;
use crate::gas::viscous_flux::{divergence, tangential_slopes, through_face, viscous_fluxes};
use crate::grid::block_shape::BlockShape;

/// Room to find the rates of a block in: fields with ghosts.
#[derive(Clone, Debug)]
pub struct GasRoom {
    /// Velocity [m/s].
    pub(crate) velocity: [Vec<f64>; 3],
    /// Pressure [Pa].
    pub(crate) pressure: Vec<f64>,
    /// Temperature [K].
    pub(crate) temperature: Vec<f64>,
    /// Enthalpy and energy of motion [J/kg].
    pub(crate) enthalpy: Vec<f64>,
    /// Viscosity [Pa s].
    pub(crate) viscosity: Vec<f64>,
    /// Derivatives along axis b of the velocity across the faces and of that along b, at 2 b and
    /// 2 b + 1, times the spacing [m/s].
    pub(crate) slope: [Vec<f64>; 6],
    /// Fluxes through the faces above points.
    pub(crate) flux: [Vec<f64>; MOST_FIELDS],
}

/// A point where the gas has no density or no pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoGas {
    /// Point of the block along each axis; ghosts are outside the block.
    pub at: [isize; 3],
    /// Density there [kg/m^3].
    pub density: f64,
    /// Pressure there [Pa].
    pub pressure: f64,
}

impl GasRoom {
    /// For blocks of a shape.
    pub fn new(shape: &BlockShape) -> Self {
        let field = || vec![0.0; shape.stored];
        Self {
            velocity: std::array::from_fn(|_| field()),
            pressure: field(),
            temperature: field(),
            enthalpy: field(),
            viscosity: field(),
            slope: std::array::from_fn(|_| field()),
            flux: std::array::from_fn(|_| field()),
        }
    }

    /// Velocity, pressure, temperature and enthalpy from the fields.
    ///
    /// # Errors
    /// If a point has no density or pressure.
    pub(crate) fn find_state(
        &mut self,
        shape: &BlockShape,
        gas: &Gas,
        fields: &[&[f64]; MOST_FIELDS],
    ) -> Result<(), NoGas> {
        let dims = shape.dims;
        let (density, energy) = (fields[0], fields[1 + dims]);
        let mut square = [0.0; 64];
        let mut is_gas = true;
        for first in (0..shape.stored).step_by(64) {
            let run = 64.min(shape.stored - first);
            square[..run].fill(0.0);
            for a in 0..dims {
                for k in 0..run {
                    let p = first + k;
                    let u = fields[1 + a][p] / density[p];
                    self.velocity[a][p] = u;
                    square[k] += u * u;
                }
            }
            for k in 0..run {
                let p = first + k;
                let pressure = (gas.heat_ratio - 1.0) * (energy[p] - 0.5 * density[p] * square[k]);
                self.pressure[p] = pressure;
                self.temperature[p] = pressure / (density[p] * gas.gas_constant);
                self.enthalpy[p] = (energy[p] + pressure) / density[p];
                is_gas &= density[p] > 0.0 && pressure > 0.0;
            }
        }
        if is_gas { Ok(()) } else { Err(self.first_without_gas(shape, density)) }
    }

    fn first_without_gas(&self, shape: &BlockShape, density: &[f64]) -> NoGas {
        let holds = |p: usize| density[p] > 0.0 && self.pressure[p] > 0.0;
        let p = (0..shape.stored).find(|&p| !holds(p)).unwrap_or(0);
        let [nx, ny, _] = shape.padded;
        let at = [p % nx, p / nx % ny, p / (nx * ny)];
        let at = std::array::from_fn(|a| at[a] as isize - shape.ghosts[a] as isize);
        NoGas { at, density: density[p], pressure: self.pressure[p] }
    }
}

/// Momentum that goes into bodies through the faces between points in the gas and points inside.
pub struct IntoBodies<'a> {
    /// For each point, ghosts included, 0 in gas, or the body's number and one inside it.
    pub marks: &'a [u16],
    /// Place of the block's first ghost [m].
    pub low: [f64; 3],
    /// Centres of the bodies [m].
    pub centres: &'a [[f64; 3]],
    /// The loads, to which is added.
    pub loads: &'a mut [BodyLoad],
}

impl IntoBodies<'_> {
    /// Adds what goes through the faces across an axis above a block's own points.
    fn add(
        &mut self,
        shape: &BlockShape,
        axis: usize,
        spacing: f64,
        flux: impl Fn(usize, usize) -> f64,
    ) {
        let (from, to) = shape.own();
        let area = spacing.powi(shape.dims as i32 - 1);
        for row in shape.rows(from, to) {
            for p in row..row + shape.edge[0] {
                let [below, above] = [p, p + shape.stride[axis]].map(|p| self.marks[p]);
                if below == above {
                    continue;
                }
                let mut at: [f64; 3] = shape.at(p).map(|k| k as f64);
                at[axis] += 0.5;
                for (mark, sign) in [(above, area), (below, -area)] {
                    let Some(body) = (mark as usize).checked_sub(1) else { continue };
                    let mut force = [0.0; 3];
                    (0..shape.dims).for_each(|a| force[a] = sign * flux(1 + a, p));
                    let mut arm = [0.0; 3];
                    for a in 0..shape.dims {
                        arm[a] = self.low[a] + spacing * at[a] - self.centres[body][a];
                    }
                    self.loads[body].add(force, arm);
                }
            }
        }
    }
}

/// Rates of change of a block's own points. `padded` are its fields with ghosts, one after the
/// other, and `bounds` the details of density and pressure that the grid takes as smooth.
///
/// # Errors
/// If a point has no density or pressure.
pub fn find_rates(
    (shape, gas): (&BlockShape, &Gas),
    spacing: f64,
    bounds: [f64; 2],
    padded: &[f64],
    room: &mut GasRoom,
    rates: &mut [f64],
    mut into_bodies: Option<IntoBodies<'_>>,
) -> Result<(), NoGas> {
    let count = field_count(shape.dims);
    let fields: [&[f64]; MOST_FIELDS] =
        std::array::from_fn(|field| &padded[field.min(count - 1) * shape.stored..][..shape.stored]);
    room.find_state(shape, gas, &fields)?;
    rates.fill(0.0);
    for axis in 0..shape.dims {
        for (row, run) in face_rows(shape, axis, 1) {
            central_fluxes(shape, axis, room, fields[0], row, run);
            shock_fluxes((shape, gas), axis, room, &fields, bounds, (row, run));
        }
        let stride = shape.stride[axis];
        add(shape, rates, -1.0 / spacing, count, |field, p| {
            room.flux[field][p] - room.flux[field][p - stride]
        });
        if let Some(into) = &mut into_bodies {
            into.add(shape, axis, spacing, |field, p| room.flux[field][p]);
        }
    }
    if gas.viscosity > 0.0 {
        for p in 0..shape.stored {
            room.viscosity[p] = gas.viscosity_at(room.temperature[p]);
        }
        room.flux[0].fill(0.0);
        for axis in 0..shape.dims {
            tangential_slopes(shape, axis, room);
            for (row, run) in face_rows(shape, axis, 2) {
                viscous_fluxes((shape, gas), axis, spacing, room, (row, run));
            }
            let stride = shape.stride[axis];
            add(shape, rates, 1.0 / spacing, count, |field, p| {
                divergence(&room.flux[field], p, stride)
            });
            if let Some(into) = &mut into_bodies {
                into.add(shape, axis, spacing, |field, p| {
                    -through_face(&room.flux[field], p, stride)
                });
            }
        }
    }
    Ok(())
}

/// Rows of points along the first axis, and their length, the faces above which are those of a
/// block's own points across an axis, and of `beyond` points on both sides but the upper last.
fn face_rows(
    shape: &BlockShape,
    axis: usize,
    beyond: usize,
) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (mut from, mut to) = shape.own();
    from[axis] -= beyond;
    to[axis] += beyond - 1;
    shape.rows(from, to).map(move |row| (row, to[0] - from[0]))
}

/// Adds to the rates of a block's own points.
#[inline(always)]
fn add(
    shape: &BlockShape,
    rates: &mut [f64],
    factor: f64,
    count: usize,
    of: impl Fn(usize, usize) -> f64,
) {
    let (from, to) = shape.own();
    for (field, rates) in rates.chunks_exact_mut(shape.points).enumerate().take(count) {
        for (row, rates) in shape.rows(from, to).zip(rates.chunks_exact_mut(shape.edge[0])) {
            for (k, rate) in rates.iter_mut().enumerate() {
                *rate += factor * of(field, row + k);
            }
        }
    }
}
