//! Cells that nothing flows through: pinched under a grain, between a grain and a wall, in a nook.
//!
//! Where almost all links of a cell end at walls, each step turns its momentum round: `j(t + 1) = -j(t)`. No viscosity acts on that,
//! for viscosity acts on what passes between cells. The cell then rings for ever at the velocity that it had when the grain came to rest,
//! and so may two or three such cells together. (Checkerboard and staggered invariants of lattice gases: Zanetti 1989.)
//!
//! A cell counts as pinched if fewer of its links lead to fluid than those of a cell along the edge of a box, which has nine. Every
//! [`EVERY`] steps its momentum becomes the mean of two steps, which a flow that changes slowly does not feel:
//!
//! ```text
//! f_i += 3 w_i c_i.(j(t-1) - j(t))/2
//! ```

use crate::boundary::open_boundary::open_faces;
use crate::boundary::refill::Content;
use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::d3q19::{C_F64, Q, W, dot};
use crate::lattice::ledger::add_scaled;
use crate::solver::lbm_solver::{LbmSolver, before};

/// Links into fluid from which on fluid flows through a cell: those of a cell along the edge of a box.
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
    /// How many of the cells, from the first, had their momentum taken in the step before a mean.
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
}

impl<T: CollisionKernel> LbmSolver<T> {
    /// Whether a cell is fluid through which nothing flows.
    fn is_pinched(&self, cell: u32) -> bool {
        let (layout, owners) = (&self.layout, &self.owners);
        let is_open = |&i: &usize| {
            let neighbour = layout.neighbour(cell, i);
            neighbour.is_some_and(|n| owners.is_fluid(n)) || layout.sees_itself(cell, i)
        };
        owners.is_fluid(cell)
            && (1..Q).filter(is_open).take(OPEN_LINKS).count() < OPEN_LINKS
            && open_faces(&layout.grid, layout.at(cell)).next().is_none()
    }

    /// Looks for pinched cells everywhere.
    pub(crate) fn find_pinched(&mut self) {
        for cell in 0..self.layout.cells.len() as u32 {
            self.list_if_pinched(cell);
        }
    }

    fn list_if_pinched(&mut self, cell: u32) {
        if !self.pinched.is_listed(cell) && self.is_pinched(cell) {
            self.pinched.list(cell);
        }
    }

    /// Looks for pinched cells where cells joined the fluid or left it in this step.
    pub(crate) fn find_pinched_anew(&mut self) {
        for k in 0..self.owners.vacated.len() {
            self.list_if_pinched(self.owners.vacated[k].cell);
        }
        for k in 0..self.owners.covered.len() {
            self.list_beside(self.owners.covered[k]);
        }
        for k in 0..self.owners.enclosed.len() {
            self.list_beside(self.owners.enclosed[k]);
        }
    }

    fn list_beside(&mut self, cell: u32) {
        for i in 1..Q {
            if let Some(neighbour) = self.layout.neighbour(cell, i) {
                self.list_if_pinched(neighbour);
            }
        }
    }

    /// Calms pinched cells at the end of a step, if it is their turn.
    pub(crate) fn calm_pinched(&mut self) {
        self.pinched.impulse = [0.0; 3];
        match self.steps % EVERY {
            0 => self.note_pinched(),
            1 => self.mean_pinched(),
            _ => {}
        }
    }

    /// Takes the momentum of pinched cells, and forgets those that are not any more.
    fn note_pinched(&mut self) {
        let mut cells = std::mem::take(&mut self.pinched.cells);
        cells.retain_mut(|pinched| {
            let stays = self.is_pinched(pinched.cell);
            if stays {
                pinched.j = self.before().content(pinched.cell).j;
            } else {
                self.pinched.listed[pinched.cell as usize / 64] &= !(1 << (pinched.cell % 64));
            }
            stays
        });
        self.pinched.noted = cells.len();
        self.pinched.cells = cells;
    }

    /// Gives those whose momentum was taken one step before the mean of both.
    fn mean_pinched(&mut self) {
        let before = before!(self);
        let Pinched { cells, noted, impulse, .. } = &mut self.pinched;
        for pinched in &cells[..*noted] {
            if !self.owners.is_fluid(pinched.cell) {
                continue;
            }
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
