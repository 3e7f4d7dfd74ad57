//! What the gas's motion changes at the points of a block: the compressible equations of Navier and
//! Stokes (Goetsch 2015, Eqs. 2.1 to 2.5).

use crate::gas::central_flux::{central_fluxes, shifted};
use crate::gas::gas_law::{Gas, MOST_FIELDS, field_count};
use crate::gas::shock_flux::shock_fluxes;
use crate::gas::viscous_flux::{tangential_slopes, through_face, viscous_fluxes};
use crate::grid::block_shape::BlockShape;
use tremie_team::Variant;
use tremie_team::instructions::Work;

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
    /// Point of the block along each axis, counted from its first ghost.
    pub at: [usize; 3],
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
    #[inline(always)]
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
            let row = first..first + run;
            let (density, energy) = (&density[row.clone()], &energy[row.clone()]);
            square[..run].fill(0.0);
            for a in 0..dims {
                let momentum = &fields[1 + a][row.clone()];
                let velocity = &mut self.velocity[a][row.clone()];
                for k in 0..run {
                    let u = momentum[k] / density[k];
                    velocity[k] = u;
                    square[k] += u * u;
                }
            }
            let pressure = &mut self.pressure[row.clone()];
            let temperature = &mut self.temperature[row.clone()];
            let enthalpy = &mut self.enthalpy[row];
            for k in 0..run {
                let p = (gas.heat_ratio - 1.0) * (energy[k] - 0.5 * density[k] * square[k]);
                pressure[k] = p;
                temperature[k] = p / (density[k] * gas.gas_constant);
                enthalpy[k] = (energy[k] + p) / density[k];
                is_gas &= density[k] > 0.0 && p > 0.0;
            }
        }
        if is_gas { Ok(()) } else { Err(self.first_without_gas(shape, density)) }
    }

    fn first_without_gas(&self, shape: &BlockShape, density: &[f64]) -> NoGas {
        let holds = |p: usize| density[p] > 0.0 && self.pressure[p] > 0.0;
        let p = (0..shape.stored).find(|&p| !holds(p)).unwrap_or(0);
        NoGas { at: shape.at(p), density: density[p], pressure: self.pressure[p] }
    }
}

/// Sees what goes through the faces above a block's points.
pub trait FaceWatch {
    /// The fluxes across an axis: `flux(field, p)` goes up the axis through the face above the point
    /// at place `p`. It is called for what gas and pressure carry, and for friction.
    fn see(&mut self, axis: usize, flux: &dyn Fn(usize, usize) -> f64);
}

/// What the rates of a block are found of.
pub struct RatesOfBlock<'a> {
    /// Shape of the block.
    pub shape: &'a BlockShape,
    /// The gas.
    pub gas: &'a Gas,
    /// Spacing of its points [m].
    pub spacing: f64,
    /// Details of density and pressure that the grid takes as smooth.
    pub bounds: [f64; 2],
    /// Its fields with ghosts, one after the other.
    pub padded: &'a [f64],
    /// Room for a thread.
    pub room: &'a mut GasRoom,
    /// Rates of change of its own points, which are found.
    pub rates: &'a mut [f64],
    /// Who sees the fluxes, if anybody does.
    pub watch: Option<&'a mut dyn FaceWatch>,
}

/// Finds rates, and says whether there was gas.
struct FindRates<'a, 'b> {
    of: RatesOfBlock<'a>,
    outcome: &'b mut Result<(), NoGas>,
}

impl Work for FindRates<'_, '_> {
    #[inline(always)]
    fn run(self) {
        *self.outcome = self.of.find_here();
    }
}

impl RatesOfBlock<'_> {
    /// Finds the rates, in a variant's instructions.
    ///
    /// # Errors
    /// If a point has no density or pressure.
    pub fn find(self, variant: Variant) -> Result<(), NoGas> {
        let mut outcome = Ok(());
        variant.run(FindRates { of: self, outcome: &mut outcome });
        outcome
    }

    #[inline(always)]
    fn find_here(mut self) -> Result<(), NoGas> {
        let (shape, count) = (self.shape, field_count(self.shape.dims));
        let padded = self.padded;
        let fields: [&[f64]; MOST_FIELDS] = std::array::from_fn(|field| {
            &padded[field.min(count - 1) * shape.stored..][..shape.stored]
        });
        self.room.find_state(shape, self.gas, &fields)?;
        self.rates.fill(0.0);
        for axis in 0..shape.dims {
            self.add_transport(axis, &fields);
        }
        if self.gas.viscosity > 0.0 {
            let GasRoom { viscosity, temperature, .. } = &mut *self.room;
            for (viscosity, temperature) in viscosity.iter_mut().zip(&*temperature) {
                *viscosity = self.gas.viscosity_at(*temperature);
            }
            for axis in 0..shape.dims {
                self.add_friction(axis);
            }
        }
        Ok(())
    }

    /// Adds what gas and pressure carry along an axis.
    #[inline(always)]
    fn add_transport(&mut self, axis: usize, fields: &[&[f64]; MOST_FIELDS]) {
        let Self { shape, gas, spacing, bounds, room, rates, watch, .. } = self;
        for (row, run) in face_rows(shape, axis, 1) {
            central_fluxes(shape, axis, room, fields[0], row, run);
            shock_fluxes((shape, gas), axis, room, fields, *bounds, (row, run));
        }
        let fluxes = &room.flux[..field_count(shape.dims)];
        add_differences(shape, rates, -1.0 / *spacing, fluxes, shape.stride[axis]);
        if let Some(watch) = watch {
            watch.see(axis, &|field, p| fluxes[field][p]);
        }
    }

    /// Adds what friction and conduction carry along an axis.
    #[inline(always)]
    fn add_friction(&mut self, axis: usize) {
        let Self { shape, gas, spacing, room, rates, watch, .. } = self;
        tangential_slopes(shape, axis, room);
        for (row, run) in face_rows(shape, axis, 2) {
            viscous_fluxes((shape, gas), axis, *spacing, room, (row, run));
        }
        let (fluxes, stride) = (&room.flux[..field_count(shape.dims)], shape.stride[axis]);
        add_divergences(shape, rates, 1.0 / (24.0 * *spacing), fluxes, stride);
        if let Some(watch) = watch {
            watch.see(axis, &|field, p| -through_face(&fluxes[field], p, stride));
        }
    }
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

/// Adds differences of fluxes to the rates of a block's own points.
#[inline(always)]
fn add_differences(
    shape: &BlockShape,
    rates: &mut [f64],
    factor: f64,
    fluxes: &[Vec<f64>],
    stride: usize,
) {
    let (from, to) = shape.own();
    let (run, s) = (shape.edge[0], stride as isize);
    for (flux, rates) in fluxes.iter().zip(rates.chunks_exact_mut(shape.points)) {
        for (row, rates) in shape.rows(from, to).zip(rates.chunks_exact_mut(run)) {
            let of = |by: isize| shifted(flux, row, run, by);
            let (below, above) = (of(-s), of(0));
            for k in 0..run {
                rates[k] += factor * (above[k] - below[k]);
            }
        }
    }
}

/// Adds divergences of fourth order to the rates of a block's own points.
#[inline(always)]
fn add_divergences(
    shape: &BlockShape,
    rates: &mut [f64],
    factor: f64,
    fluxes: &[Vec<f64>],
    stride: usize,
) {
    let (from, to) = shape.own();
    let (run, s) = (shape.edge[0], stride as isize);
    for (flux, rates) in fluxes.iter().zip(rates.chunks_exact_mut(shape.points)).skip(1) {
        for (row, rates) in shape.rows(from, to).zip(rates.chunks_exact_mut(run)) {
            let of = |by: isize| shifted(flux, row, run, by);
            let (f0, f1, f2, f3) = (of(-2 * s), of(-s), of(0), of(s));
            for k in 0..run {
                rates[k] += factor * (27.0 * (f2[k] - f1[k]) - (f3[k] - f0[k]));
            }
        }
    }
}
