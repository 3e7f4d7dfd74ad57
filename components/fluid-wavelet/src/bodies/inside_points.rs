//! What stands inside bodies: the gas's own values go on along the surface's normal.
//!
//! The characteristic-based volume penalisation of Brown-Dymkoski, Kasimov and Vasilyev (*J. Comput.
//! Phys.* 262 (2014) 344) lets temperature and density run into a body along its normal at a speed
//! 1/eta_c, and holds the velocity to the body's within a time eta_b. Here both times are zero:
//! what these equations tend to is found in one sweep from the surface inwards, by differences
//! against the normal. So nothing is stiff, and bodies that move need no term for it. Density goes
//! on with the slope that it has in the gas, as there. So does the velocity, from that of the
//! surface at its foot, which places the surface between points: of second order, where holding
//! points to the body's velocity is of first.

use crate::bodies::body_mask::{BAND, BlockPlaces, BodyMask};
use crate::bodies::gas_body::{GasBody, SurfaceHeat};
use crate::gas::gas_law::{Gas, GasState, MOST_FIELDS};
use crate::grid::block_shape::{BlockShape, GHOSTS};
use crate::grid::block_tree::{BlockTree, NONE};

/// Depth to which points have values of their own, in points: stencils of the gas reach three
/// points, and a body may go on by one before the grid is adapted.
const REACH: f64 = 4.0;

/// Values that are carried inwards: density, temperature, velocity.
type Carried = [f64; 5];

/// A point inside a body.
#[derive(Clone, Debug)]
struct InsidePoint {
    /// Place of its first field.
    place: usize,
    /// Body.
    body: u16,
    /// Depth below the surface [m].
    depth: f64,
    /// Outward normal.
    normal: [f64; 3],
    /// Velocity of the surface at its foot [m/s].
    surface: [f64; 3],
    /// For each axis the point beside it towards the surface, and its share.
    before: [(Before, f64); 3],
}

/// A point that another follows on.
#[derive(Clone, Copy, Debug)]
enum Before {
    /// One in the gas, by its place and those of its neighbours below and above along each axis.
    Gas([usize; 7]),
    /// One inside, by its number in the order.
    Inside(u32),
    /// None: the normal has no part along the axis.
    None,
    /// None along any axis.
    Alone,
}

/// The points near surfaces inside bodies, in the order of their depth.
#[derive(Clone, Debug, Default)]
pub struct InsidePoints {
    points: Vec<InsidePoint>,
    values: Vec<Carried>,
    slopes: Vec<Carried>,
    /// Points far inside, by the place of their first field, with the body's velocity there.
    deep: Vec<(usize, [f64; 3])>,
}

impl InsidePoints {
    /// Finds the points, and whom each follows on.
    pub fn find(
        &mut self,
        tree: &BlockTree,
        places: &BlockPlaces,
        mask: &BodyMask,
        bodies: &[impl GasBody],
    ) {
        let shape = &places.shape;
        let fields = shape.dims + 2;
        let finest = places.spacing(tree.domain.deepest);
        let mut found = Vec::new();
        self.deep.clear();
        for (slot, &block) in tree.blocks.iter().enumerate() {
            let Some(marks) = mask.of(shape, slot) else { continue };
            let (from, to) = shape.own();
            for (number, row) in shape.rows(from, to).enumerate() {
                for k in 0..shape.edge[0] {
                    let mark = marks[row + k];
                    if mark == 0 {
                        continue;
                    }
                    let own = number * shape.edge[0] + k;
                    let at = places.padded_point(block, shape.at(row + k));
                    let body = &bodies[mark as usize - 1];
                    let (height, normal) = body.height(at);
                    let place = slot * fields * shape.points + own;
                    let reach = (REACH + 0.01) * finest;
                    if block.level == tree.domain.deepest && -height <= reach {
                        let foot = std::array::from_fn(|a| at[a] - height * normal[a]);
                        found.push((
                            slot,
                            own,
                            InsidePoint {
                                place,
                                body: mark - 1,
                                depth: -height,
                                normal,
                                surface: body.velocity(foot),
                                before: [(Before::None, 0.0); 3],
                            },
                        ));
                    } else {
                        self.deep.push((place, body.velocity(at)));
                    }
                }
            }
        }
        found.sort_by(|(_, _, a), (_, _, b)| {
            a.depth.total_cmp(&b.depth).then(a.place.cmp(&b.place))
        });
        self.link(tree, places, mask, found);
    }

    /// Links each point to those it follows on.
    fn link(
        &mut self,
        tree: &BlockTree,
        places: &BlockPlaces,
        mask: &BodyMask,
        found: Vec<(usize, usize, InsidePoint)>,
    ) {
        let shape = &places.shape;
        let numbers: std::collections::HashMap<_, _> =
            (0_u32..).zip(&found).map(|(number, (_, _, point))| (point.place, number)).collect();
        let length = (shape.dims + 2) * shape.points;
        self.points.clear();
        for (number, (slot, own, mut point)) in (0_u32..).zip(found) {
            let sum: f64 = point.normal[..shape.dims].iter().map(|n| n.abs()).sum();
            let mut shares = 0.0;
            for a in 0..shape.dims {
                let outward = if point.normal[a] > 0.0 { 1 } else { -1 };
                let share = point.normal[a].abs() / sum;
                let Some((beside, own)) = beside(tree, shape, (slot, own), a, outward) else {
                    continue;
                };
                let place = beside * length + own;
                let is_inside =
                    mask.of(shape, beside).is_some_and(|marks| marks[shape.padded_place(own)] != 0);
                let before = match numbers.get(&place) {
                    // One that is as deep comes later or earlier by its place: it is left out.
                    Some(&other) if other < number => Before::Inside(other),
                    None if !is_inside => match stencil(tree, shape, (beside, own), length) {
                        Some(stencil) => Before::Gas(stencil),
                        None => continue,
                    },
                    _ => continue,
                };
                point.before[a] = (before, share);
                shares += share;
            }
            if shares == 0.0 {
                // Nothing to follow on, as in a body thinner than a point: it takes part in nothing.
                self.deep.push((point.place, point.surface));
                point.before = [(Before::Alone, 0.0); 3];
            }
            point.before.iter_mut().for_each(|(_, share)| *share /= shares.max(f64::MIN_POSITIVE));
            self.points.push(point);
        }
        self.values.resize(self.points.len(), [0.0; 5]);
        self.slopes.resize(self.points.len(), [0.0; 5]);
    }

    /// Gives the points their values, from the surface inwards.
    pub fn extend(
        &mut self,
        (shape, gas): (&BlockShape, &Gas),
        spacing: f64,
        bodies: &[impl GasBody],
        own: &mut [f64],
    ) {
        for number in 0..self.points.len() {
            let point = &self.points[number];
            if matches!(point.before[0].0, Before::Alone) {
                continue;
            }
            let (mut value, mut slope) = ([0.0; 5], [0.0; 5]);
            let mut reach = 0.0;
            for (a, (before, share)) in point.before.iter().enumerate() {
                let (from, fall) = match before {
                    Before::None | Before::Alone => continue,
                    Before::Inside(other) => {
                        (self.values[*other as usize], self.slopes[*other as usize])
                    }
                    Before::Gas(stencil) => gas_values((shape, gas), spacing, point, stencil, own),
                };
                for k in 0..5 {
                    value[k] += share * from[k];
                    slope[k] += share * fall[k];
                }
                reach += share * point.normal[a].abs();
            }
            // The point is as far below the mean of those that it follows on as their shares say.
            let below = spacing * reach;
            self.slopes[number] = slope;
            let density = value[0] + below * slope[0];
            value[0] = if density > 0.5 * value[0] && density < 2.0 * value[0] {
                density
            } else {
                value[0]
            };
            if let SurfaceHeat::Isothermal(surface) = bodies[point.body as usize].heat() {
                value[1] = (surface + point.depth * slope[1]).max(0.5 * surface);
            }
            let along: f64 = (0..3).map(|a| value[2 + a] * point.normal[a]).sum();
            let slope_along: f64 = (0..3).map(|a| slope[2 + a] * point.normal[a]).sum();
            let surface_along: f64 = (0..3).map(|a| point.surface[a] * point.normal[a]).sum();
            for a in 0..3 {
                value[2 + a] = if gas.viscosity > 0.0 {
                    point.surface[a] + point.depth * slope[2 + a]
                } else {
                    // Without viscosity gas slips: only what goes through the surface is held.
                    let through = surface_along + point.depth * slope_along;
                    value[2 + a] + (through - along) * point.normal[a]
                };
            }
            self.values[number] = value;
            write(shape, gas, value, point.place, own);
        }
        let still = self.points.first().map(|point| read(shape, gas, point.place, own));
        if let Some(still) = still {
            for &(place, velocity) in &self.deep {
                let [density, temperature, ..] = still;
                let [u, v, w] = velocity;
                write(shape, gas, [density, temperature, u, v, w], place, own);
            }
        }
    }
}

/// Density, temperature and velocity at a place.
fn read(shape: &BlockShape, gas: &Gas, place: usize, own: &[f64]) -> Carried {
    let mut fields = [0.0; MOST_FIELDS];
    for (field, value) in fields.iter_mut().enumerate().take(shape.dims + 2) {
        *value = own[place + field * shape.points];
    }
    let GasState { density, velocity: [u, v, w], pressure } = gas.state(shape.dims, &fields);
    [density, pressure / (density * gas.gas_constant), u, v, w]
}

/// Writes density, temperature and velocity at a place.
fn write(shape: &BlockShape, gas: &Gas, value: Carried, place: usize, own: &mut [f64]) {
    let [density, temperature, u, v, w] = value;
    let pressure = density * gas.gas_constant * temperature;
    let fields = gas.fields(shape.dims, GasState { density, velocity: [u, v, w], pressure });
    for (field, value) in fields.iter().enumerate().take(shape.dims + 2) {
        own[place + field * shape.points] = *value;
    }
}

/// Values of a point in the gas, and their slopes inwards along a normal [1/m].
fn gas_values(
    (shape, gas): (&BlockShape, &Gas),
    spacing: f64,
    point: &InsidePoint,
    stencil: &[usize; 7],
    own: &[f64],
) -> (Carried, Carried) {
    let value = read(shape, gas, stencil[0], own);
    let mut slope = [0.0; 5];
    for a in 0..shape.dims {
        let [low, high] = [1 + 2 * a, 2 + 2 * a].map(|k| read(shape, gas, stencil[k], own));
        for k in 0..5 {
            slope[k] -= point.normal[a] * (high[k] - low[k]) / (2.0 * spacing);
        }
    }
    (value, slope)
}

/// The point beside another along an axis, in the same block or the next of the same level.
fn beside(
    tree: &BlockTree,
    shape: &BlockShape,
    (slot, own): (usize, usize),
    axis: usize,
    by: isize,
) -> Option<(usize, usize)> {
    let [nx, ny, _] = shape.edge;
    let mut at = shape.own_at(own);
    let along = at[axis] as isize + by;
    let edge = shape.edge[axis] as isize;
    let mut step = [0, 0, 0];
    step[axis] = along.div_euclid(edge) as i32;
    at[axis] = along.rem_euclid(edge) as usize;
    let number = ((step[2] + 1) * 9 + (step[1] + 1) * 3 + step[0] + 1) as usize;
    let slot = tree.neighbours[slot][number];
    (slot != NONE).then_some((slot as usize, at[0] + nx * (at[1] + ny * at[2])))
}

/// Places of a point and its neighbours.
fn stencil(
    tree: &BlockTree,
    shape: &BlockShape,
    point: (usize, usize),
    length: usize,
) -> Option<[usize; 7]> {
    let place = |(slot, own): (usize, usize)| slot * length + own;
    let mut places = [place(point); 7];
    for a in 0..shape.dims {
        places[1 + 2 * a] = place(beside(tree, shape, point, a, -1)?);
        places[2 + 2 * a] = place(beside(tree, shape, point, a, 1)?);
    }
    Some(places)
}

const _: () = assert!(REACH >= GHOSTS as f64 && BAND > REACH);
