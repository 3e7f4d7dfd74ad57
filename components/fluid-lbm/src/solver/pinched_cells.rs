//! Cells that nothing flows through: pinched under a grain, between a grain and a wall, in a nook.
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

use crate::boundary::refill::Content;
use crate::lattice::d3q19::{C_F64, Q, W, dot};
use crate::lattice::ledger::add_scaled;
use crate::lattice::populations::Real;
use crate::solver::lattice_state::LatticeState;
use tremie_state::{StateError, StateExchange};

/// Links into fluid from which on fluid flows through a cell: those of a cell along the edge of a
/// box.
const OPEN_LINKS: usize = 9;

/// Steps from one mean to the next.
const EVERY: u64 = 64;

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
    pub impulse: [f64; 3],
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

    /// Keeps the cells with their momenta, or puts them back; `all` cells are stored.
    ///
    /// # Errors
    /// A state of another lattice.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        all: usize,
    ) -> Result<(), StateError> {
        let mut cells: Vec<u32> = self.cells.iter().map(|pinched| pinched.cell).collect();
        let mut momenta: Vec<[f64; 3]> = self.cells.iter().map(|pinched| pinched.j).collect();
        state.list("cells", &mut cells)?;
        state.list("momenta", &mut momenta)?;
        state.value("noted", &mut self.noted)?;
        if !state.restores() {
            return Ok(());
        }
        self.cells.clear();
        self.listed.fill(0);
        for (&cell, &j) in cells.iter().zip(&momenta) {
            if cell as usize >= all || self.is_listed(cell) {
                return state.unfit("the pinched cells of the state are none of this lattice");
            }
            self.list(cell);
            self.cells.last_mut().expect("a cell was listed").j = j;
        }
        if momenta.len() != cells.len() || self.noted > cells.len() {
            return state.unfit("the pinched cells of the state lack momenta");
        }
        Ok(())
    }

    fn is_listed(&self, cell: u32) -> bool {
        self.listed[cell as usize / 64] >> (cell % 64) & 1 == 1
    }

    fn list(&mut self, cell: u32) {
        self.listed[cell as usize / 64] |= 1 << (cell % 64);
        self.cells.push(Cell { cell, j: [0.0; 3] });
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
        if !self.is_listed(cell) && is_pinched(lattice, cell) {
            self.list(cell);
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

    /// Calms pinched cells at the end of a step, if it is their turn.
    pub fn calm<T: Real>(&mut self, lattice: &LatticeState<T>) {
        self.impulse = [0.0; 3];
        match lattice.steps % EVERY {
            0 => self.note(lattice),
            1 => self.mean(lattice),
            _ => {}
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
            add_scaled(impulse, got, 1.0);
            add_scaled(impulse, now, -1.0);
        }
    }
}

/// True if a cell is fluid through which nothing flows.
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
