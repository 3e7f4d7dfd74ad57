//! What lies beyond the faces of the domain.

use crate::gas::gas_law::{MOST_FIELDS, field_count};
use crate::grid::block_shape::BlockShape;
use crate::grid::block_tree::{BlockAddress, BlockTree};
use crate::grid::block_values::BeyondDomain;

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DomainFace {
    /// The other end lies beyond.
    Periodic,
    /// A mirror lies in it: a wall along which gas slips, and that takes no heat.
    Mirror,
    /// A wall that the gas sticks to and that takes no heat: its velocity along itself [m/s].
    Wall([f64; 3]),
    /// Gas of one state flows in, or lies beyond: its fields.
    Given([f64; MOST_FIELDS]),
    /// What reaches it leaves: the last points' values go on beyond.
    Open,
    /// The same, but for the pressure: the heat of a volume of gas that has it [J/m^3].
    Pressure(f64),
}

/// The faces of a domain, the lower and the upper one of each axis.
pub type DomainFaces = [[DomainFace; 2]; 3];

impl BeyondDomain for DomainFaces {
    fn fill(&self, tree: &BlockTree, block: BlockAddress, padded: &mut [f64]) {
        let shape = &tree.domain.shape;
        for axis in 0..shape.dims {
            let last = tree.domain.blocks_along(block.level, axis) - 1;
            for (side, end) in [(0, 0), (1, last)] {
                if block.at[axis] == end {
                    FaceOfBlock::new(shape, axis, side).fill(self[axis][side], padded);
                }
            }
        }
    }
}

/// Fields of a point.
type Fields = [f64; MOST_FIELDS];

/// A face of the domain in a block. The upper face's points are no block's own, and those of the
/// lower are treated like them.
struct FaceOfBlock<'a> {
    shape: &'a BlockShape,
    axis: usize,
    /// Steps along the axis from the first ghost to the point on the face.
    on_face: usize,
    /// Step in memory inwards.
    inward: isize,
    /// Ghosts beyond.
    reach: isize,
}

impl<'a> FaceOfBlock<'a> {
    fn new(shape: &'a BlockShape, axis: usize, side: usize) -> Self {
        let (stride, ghosts, edge) = (shape.stride[axis], shape.ghosts[axis], shape.edge[axis]);
        let (on_face, inward, reach) = if side == 0 {
            (ghosts, stride as isize, ghosts)
        } else {
            (ghosts + edge, -(stride as isize), ghosts - 1)
        };
        Self { shape, axis, on_face, inward, reach: reach as isize }
    }

    /// Places of the points on the face.
    fn places(&self) -> impl Iterator<Item = usize> + use<> {
        let shape = *self.shape;
        let mut end = shape.padded;
        end[self.axis] = 1;
        let run = if self.axis == 0 { 1 } else { shape.padded[0] };
        let first = self.on_face * shape.stride[self.axis];
        shape.rows([0; 3], end).flat_map(move |row| row + first..row + first + run)
    }

    /// Fills the points on the face and those beyond it.
    fn fill(&self, face: DomainFace, padded: &mut [f64]) {
        match face {
            DomainFace::Periodic => {}
            DomainFace::Mirror => self.mirror(padded),
            DomainFace::Wall(velocity) => self.stick(velocity, padded),
            DomainFace::Given(state) => self.set(padded, |_| state),
            DomainFace::Open => self.set(padded, |last| last),
            DomainFace::Pressure(heat) => self.set(padded, |last| {
                let mut beyond = last;
                beyond[1 + self.shape.dims] = heat + self.motion(&last);
                beyond
            }),
        }
    }

    fn mirror(&self, padded: &mut [f64]) {
        let stored = self.shape.stored;
        for (field, values) in
            padded.chunks_exact_mut(stored).enumerate().take(field_count(self.shape.dims))
        {
            let is_normal = field == 1 + self.axis;
            let sign = if is_normal { -1.0 } else { 1.0 };
            for place in self.places() {
                let at = |steps: isize| (place as isize + steps * self.inward) as usize;
                values[place] =
                    if is_normal { 0.0 } else { mirrored(values[at(1)], values[at(2)]) };
                (1..=self.reach).for_each(|k| values[at(-k)] = sign * values[at(k)]);
            }
        }
    }

    /// Gives the points on the face and beyond what `beyond` makes of the last inside.
    fn set(&self, padded: &mut [f64], beyond: impl Fn(Fields) -> Fields) {
        for place in self.places() {
            let at = |steps: isize| (place as isize + steps * self.inward) as usize;
            let state = beyond(self.read(padded, at(1)));
            (0..=self.reach).for_each(|k| self.write(padded, at(-k), &state));
        }
    }

    /// A wall with the gas's velocity turned over about its own beyond.
    fn stick(&self, wall: [f64; 3], padded: &mut [f64]) {
        let dims = self.shape.dims;
        for place in self.places() {
            let at = |steps: isize| (place as isize + steps * self.inward) as usize;
            let [first, second] = [at(1), at(2)].map(|place| self.read(padded, place));
            let heat = |fields: &Fields| fields[1 + dims] - self.motion(fields);
            let mut on_face = [0.0; MOST_FIELDS];
            on_face[0] = mirrored(first[0], second[0]);
            (0..dims).for_each(|a| on_face[1 + a] = on_face[0] * wall[a]);
            on_face[1 + dims] = mirrored(heat(&first), heat(&second)) + self.motion(&on_face);
            self.write(padded, place, &on_face);
            for k in 1..=self.reach {
                let inside = self.read(padded, at(k));
                let mut beyond = inside;
                (0..dims).for_each(|a| beyond[1 + a] = 2.0 * wall[a] * inside[0] - inside[1 + a]);
                beyond[1 + dims] = heat(&inside) + self.motion(&beyond);
                self.write(padded, at(-k), &beyond);
            }
        }
    }

    /// Energy of motion of a volume of gas.
    fn motion(&self, fields: &Fields) -> f64 {
        let square: f64 = fields[1..=self.shape.dims].iter().map(|m| m * m).sum();
        0.5 * square / fields[0]
    }

    fn read(&self, padded: &[f64], place: usize) -> Fields {
        let count = field_count(self.shape.dims);
        std::array::from_fn(|field| {
            if field < count { padded[field * self.shape.stored + place] } else { 0.0 }
        })
    }

    fn write(&self, padded: &mut [f64], place: usize, fields: &Fields) {
        for (field, value) in fields.iter().enumerate().take(field_count(self.shape.dims)) {
            padded[field * self.shape.stored + place] = *value;
        }
    }
}

/// Value in a mirror of what has these values at one and two points from it: of fourth order, and
/// the first where that would leave what both are.
fn mirrored(first: f64, second: f64) -> f64 {
    let value = first + (first - second) / 3.0;
    if (value - first).abs() <= 0.5 * first.abs() { value } else { first }
}
