//! Cells that next to nothing flows through: pinched under a grain, between a grain and a wall, in a nook.
//!
//! If almost all links of a cell end at walls, each step turns its momentum round:
//! `j(t + 1) = -j(t)`. No viscosity acts on that, for viscosity acts on what passes between cells.
//! The cell then rings for ever at the velocity that it had when the grain came to rest, and so may
//! two or three such cells together. (Checkerboard and staggered invariants of lattice gases:
//! Zanetti 1989.)
//!
//! A cell counts as pinched if fewer of its links lead to fluid than those of a cell along the edge
//! of a box, which has nine. Every [`EVERY`] steps its momentum becomes the mean of two steps,
//! which a flow that changes slowly does not feel:
//!
//! ```text
//! f_i += 3 w_i c_i.(j(t-1) - j(t))/2
//! ```
//!
//! Nor does the density of such a cell follow that of the fluid beside it. Between walls a population
//! comes back in each step. As `tau` comes near to 1/2, what is odd in the directions and is no momentum
//! is reflected by the collision, too, and so stays as it is for ever: it takes up every difference of
//! density to the cells around. What a cell sends through a link that is open is then, to `tau - 1/2`,
//! what it got from there a step before. A cell in a nook under a piston that moves by a tenth of a cell
//! so had a tenth less density than the fluid beside it; a gap of one layer, of cells with eight open links,
//! kept a pressure of 2 MPa for good between two chambers without any. Where such a part would not die by
//! itself ([`PERSISTS`]), every [`ODD_EVERY`]th step takes it from pinched cells; mass, momentum and stress
//! stay.
//!
//! ```text
//! (f_i - f_i')/2 = 3 w_i c_i.j
//! ```

use crate::boundary::refill::Content;
use crate::lattice::d3q19::{C_F64, OPPOSITE, Q, W, dot};
use crate::lattice::exact_sum::{ExactSum, add_vector};
use crate::lattice::populations::Real;
use crate::lattice::whole_numbers::WholeNumbers;
use crate::solver::lattice_state::LatticeState;
use tremie_state::{StateError, StateExchange};

/// Links into fluid from which on fluid flows through a cell: those of a cell along the edge of a
/// box.
const OPEN_LINKS: usize = 9;

/// Steps from one mean to the next.
const EVERY: u64 = 64;

/// Part of the odd rest that a collision leaves, from which on it does not die by itself within some
/// steps: `|1 - 1/tau-|`.
const PERSISTS: f64 = 0.9;

/// Steps from one to the next that takes the odd rest. Density follows within some `18 ODD_EVERY` steps: a
/// link along an axis has a weight of 1/18.
const ODD_EVERY: u64 = 4;

/// A pinched cell.
#[derive(Clone, Copy, Debug)]
struct Cell {
    cell: u32,
    /// Its momentum one step before a mean.
    j: [f64; 3],
}

/// All pinched cells. Cells that are not pinched any more stay listed until the next mean.
#[derive(Clone, Debug, Default)]
pub struct Pinched {
    cells: Vec<Cell>,
    /// One bit for each cell of the fluid: whether it is listed.
    listed: Vec<u64>,
    /// Number of cells, from the first, whose momentum was taken in the step before a mean.
    noted: usize,
    /// Momentum that the last mean gave to the fluid.
    pub impulse: [ExactSum; 3],
}

impl Pinched {
    /// None, of so many cells.
    pub fn among(cells: usize) -> Self {
        Self { listed: vec![0; cells.div_ceil(64)], ..Self::default() }
    }

    /// Makes room for so many more.
    pub fn reserve(&mut self, cells: usize) {
        self.cells.reserve(cells);
    }

    /// Keeps the cells with their momenta, or puts them back.
    ///
    /// # Errors
    /// A state of another lattice.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
    ) -> Result<(), StateError> {
        let [noted, others] = [0..self.noted, self.noted..self.cells.len()]
            .map(|cells| self.cells[cells].iter().map(|pinched| pinched.cell).collect::<Vec<_>>());
        let mut momenta: Vec<[f64; 3]> =
            self.cells[..self.noted].iter().map(|pinched| pinched.j).collect();
        // Each is of the rank that counts it.
        let [mut noted, mut others] = [noted, others].map(|cells| numbers.kept(&cells));
        state.shared_list("noted", &mut noted)?;
        state.shared_list("momenta", &mut momenta)?;
        state.shared_list("others", &mut others)?;
        if !state.restores() {
            return Ok(());
        }
        if momenta.len() != noted.len() {
            return state.unfit("the pinched cells of the state lack momenta");
        }
        self.cells.clear();
        self.listed.fill(0);
        momenta.resize(noted.len() + others.len(), [0.0; 3]);
        let count = noted.len();
        self.noted = 0;
        for (number, (&cell, &j)) in noted.iter().chain(&others).zip(&momenta).enumerate() {
            let Some(cell) = numbers.here(cell).filter(|&cell| numbers.is_own(cell)) else {
                continue;
            };
            if self.is_listed(cell) {
                return state.unfit("the pinched cells of the state are there twice");
            }
            self.noted += usize::from(number < count);
            self.list(Cell { cell, j });
        }
        Ok(())
    }

    fn is_listed(&self, cell: u32) -> bool {
        self.listed[cell as usize / 64] >> (cell % 64) & 1 == 1
    }

    fn list(&mut self, pinched: Cell) {
        self.listed[pinched.cell as usize / 64] |= 1 << (pinched.cell % 64);
        self.cells.push(pinched);
    }

    /// Memory that the list takes [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.cells.as_slice()) + size_of_val(self.listed.as_slice())
    }

    /// Looks for pinched cells everywhere.
    pub fn find<T: Real>(&mut self, lattice: &LatticeState<T>) {
        for cell in 0..lattice.layout.cells.len() as u32 {
            self.list_if_pinched(lattice, cell);
        }
    }

    fn list_if_pinched<T: Real>(&mut self, lattice: &LatticeState<T>, cell: u32) {
        // Whose cell it is, calms it; and from the last copies links lead to cells that are not stored.
        let is_own = lattice.layout.is_own(cell);
        if is_own && !self.is_listed(cell) && is_pinched(lattice, cell) {
            self.list(Cell { cell, j: [0.0; 3] });
        }
    }

    /// Looks for pinched cells where cells joined the fluid or left it in this step.
    pub fn find_anew<T: Real>(&mut self, lattice: &LatticeState<T>) {
        let flags = &lattice.flags;
        for vacated in &flags.vacated {
            self.list_if_pinched(lattice, vacated.cell);
        }
        for &cell in flags.covered.iter().chain(&flags.enclosed) {
            for neighbour in (1..Q).filter_map(|i| lattice.layout.neighbour(cell, i)) {
                self.list_if_pinched(lattice, neighbour);
            }
        }
    }

    /// Calms pinched cells at the end of a step.
    pub fn calm<T: Real>(&mut self, lattice: &LatticeState<T>) {
        self.impulse = Default::default();
        let relaxation = &lattice.relaxation;
        let persists = !relaxation.central && (1.0 - relaxation.odd).abs() > PERSISTS;
        if persists && lattice.steps.is_multiple_of(ODD_EVERY) {
            self.take_odd_rest(lattice);
        }
        match lattice.steps % EVERY {
            0 => self.note(lattice),
            1 => self.mean(lattice),
            _ => {}
        }
    }

    /// Takes from pinched cells what is odd in the directions and is no momentum.
    fn take_odd_rest<T: Real>(&self, lattice: &LatticeState<T>) {
        let (before, flags) = (lattice.before(), &lattice.flags);
        for pinched in self.cells.iter().filter(|pinched| flags.is_fluid(pinched.cell)) {
            let mut h = before.populations(pinched.cell);
            let j = Content::of(&h).j;
            for i in 1..Q {
                let opposite = OPPOSITE[i];
                if i < opposite {
                    let (even, odd) = (0.5 * (h[i] + h[opposite]), 3.0 * W[i] * dot(C_F64[i], j));
                    (h[i], h[opposite]) = (even + odd, even - odd);
                }
            }
            before.put(pinched.cell, &h);
        }
    }

    /// Takes the momentum of pinched cells, and forgets those that are not any more.
    fn note<T: Real>(&mut self, lattice: &LatticeState<T>) {
        let Self { cells, listed, .. } = self;
        cells.retain_mut(|pinched| {
            let stays = is_pinched(lattice, pinched.cell);
            if stays {
                pinched.j = lattice.before().content(pinched.cell).j;
            } else {
                listed[pinched.cell as usize / 64] &= !(1 << (pinched.cell % 64));
            }
            stays
        });
        self.noted = cells.len();
    }

    /// Gives those whose momentum was taken one step before the mean of both.
    fn mean<T: Real>(&mut self, lattice: &LatticeState<T>) {
        let before = lattice.before();
        let Self { cells, noted, impulse, .. } = self;
        for pinched in cells[..*noted].iter().filter(|cell| lattice.flags.is_fluid(cell.cell)) {
            let mut h = before.populations(pinched.cell);
            let now = Content::of(&h).j;
            let change = std::array::from_fn(|a| 0.5 * (pinched.j[a] - now[a]));
            for i in 1..Q {
                h[i] += 3.0 * W[i] * dot(C_F64[i], change);
            }
            before.put(pinched.cell, &h);
            let got = before.content(pinched.cell).j;
            add_vector(impulse, std::array::from_fn(|a| got[a] - now[a]));
        }
    }
}

/// Whether a cell is a fluid cell through which next to nothing flows.
fn is_pinched<T: Real>(lattice: &LatticeState<T>, cell: u32) -> bool {
    let LatticeState { layout, flags, .. } = lattice;
    let is_open = |&i: &usize| {
        let neighbour = layout.neighbour(cell, i);
        neighbour.is_some_and(|n| flags.is_fluid(n)) || layout.sees_itself(cell, i)
    };
    flags.is_fluid(cell)
        && (1..Q).filter(is_open).take(OPEN_LINKS).count() < OPEN_LINKS
        && layout.grid.open_faces(layout.at(cell)).next().is_none()
}
