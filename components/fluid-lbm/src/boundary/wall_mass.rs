//! The mass that curved walls at rest owe the fluid, and how it is paid.
//!
//! A link that meets a wall at `q` other than 1/2 reflects half-way what is not there:
//! interpolation (see `static_wall_links`) makes or takes some mass in each step. Most of it comes
//! and goes with the pressure at the wall, as the volume between the wall and the half-way plane
//! fills and empties: about `(2q - 1) w_i` for each unit of density. The rest runs one way for as
//! long as the fluid flows, and would empty a closed box or make the flow differ from one section
//! of a pipe to the next.
//!
//! So each patch of wall, the cells at a solid in a cube of 8, keeps an account:
//!
//! ```text
//! owed     -= sum over links (f_i' - g_i)                        in each step, with what is paid
//! smoothed += 4 r (owed - smoothed)
//! pay       = r smoothed / (sum over links 6 w_i)
//! f_i'     += 6 w_i pay                                          at each link of the patch
//! ```
//!
//! The fluid's mass and what is owed are together constant to rounding. In a steady flow a patch
//! pays in each step what its links take, and owes 500 times that. Sound does not feel it: paid at
//! once, what fills and empties the volume at the wall would be taken from each wave, and between
//! walls a few cells apart that kills the wave, or drives it. The smoothing keeps what is paid a
//! quarter of a period behind what is owed, which neither damps nor drives. The account is
//! critically damped.
//!
//! A patch pays through its links as a wall does that breathes: on a closed surface the momentum of
//! that is zero.
//!
//! Cells at open faces belong to no patch: the face replaces all that they hold (see
//! `open_boundary`, `face`). The mass that links brought them counts as come through the face.
//!
//! Cubes are counted from the reference of the solid that a cell meets first: a part has the same
//! patches wherever it stands, and half of one at a symmetry plane those of the whole.

use crate::boundary::static_wall_links::WallItem;
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::d3q19::{Q, W};
use crate::lattice::exact_sum::{ExactSum, values};
use crate::ranks::rank_sums::Ranks;
use std::collections::{BTreeMap, HashMap};
use tremie_fluid_kit::cells::grid::Grid;
use tremie_state::{StateError, StateExchange};

/// Part of what is owed that a step pays, once smoothed.
const RATE: f64 = 0.002;

/// Cells along an edge of a patch's cube.
const PATCH: f64 = 8.0;

/// The share of a direction in what a patch pays: `6 w_i`.
pub const WEIGHT: [f64; Q] = {
    let mut weight = W;
    let mut i = 0;
    while i < Q {
        weight[i] *= 6.0;
        i += 1;
    }
    weight
};

/// Holder of a patch's mass.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Holder {
    /// An account, by number.
    Account(u32),
    /// An open face, `2 axis + side`.
    Face(u8),
}

/// The cells of a patch of wall in one item of work.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    holder: Holder,
    /// Mass that a link pays for each unit of `6 w_i`.
    pub pay: f64,
    /// Mass that links to solid walls gave to the fluid in this step.
    pub gained: f64,
    /// Mass that links to faces of the domain gave.
    pub of_faces: f64,
    /// Sum of the weights of links to solid walls.
    pub weight: f64,
}

impl Patch {
    const fn of(holder: Holder) -> Self {
        Self { holder, pay: 0.0, gained: 0.0, of_faces: 0.0, weight: 0.0 }
    }

    /// Begins a step.
    pub fn begin(&mut self) {
        (self.gained, self.of_faces, self.weight) = (0.0, 0.0, 0.0);
    }
}

/// Mass that links brought to the cells at an open face in a step: those to solid walls, and those
/// to other faces.
#[derive(Clone, Copy, Debug, Default)]
pub struct Brought {
    /// From solid walls.
    pub by_parts: f64,
    /// From faces that slide.
    pub by_faces: f64,
}

impl Brought {
    /// Both.
    pub fn total(&self) -> f64 {
        self.by_parts + self.by_faces
    }
}

/// Number of a solid, and a cube of cells by its place from the solid's reference.
type Cube = (u16, [i32; 3]);

/// The cube of a cell at a solid with a reference [cells].
fn cube(grid: &Grid, at: [i32; 3], fixture: BoundaryId, reference: [f64; 3]) -> Cube {
    // A cell in line with the reference is on the same side of it wherever both are.
    const HAIR: f64 = 1e-6;
    let place = grid.arm(reference, at).map(|x| (x / PATCH + HAIR).floor() as i32);
    (fixture.0, place)
}

/// Mass that a patch of wall owes [cells at density 1].
#[derive(Clone, Copy, Debug, Default)]
struct PatchAccount {
    owed: f64,
    smoothed: f64,
    /// What its links gave in this step, and the sum of their weights.
    gained: ExactSum,
    weight: ExactSum,
    /// Mass that a link pays for each unit of weight.
    pay: f64,
}

impl PatchAccount {
    /// Settles what the links gave, and decides what they pay.
    fn settle(&mut self) {
        self.owed -= self.gained.value();
        self.smoothed += 4.0 * RATE * (self.owed - self.smoothed);
        let weight = self.weight.value();
        // Without links there is nothing to pay at: it stays owed.
        self.pay = if weight > 0.0 { RATE * self.smoothed / weight } else { 0.0 };
    }
}

/// All patches.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// Number of the patch in each cube that has one.
    numbers: HashMap<Cube, u32>,
    accounts: Vec<PatchAccount>,
    /// The patches that have cells of several ranks, in an order that all ranks know, each with the number of its
    /// account here, if it has one.
    shared: Vec<Option<u32>>,
    /// Of each account, whether another rank adds up what it owes.
    is_elsewhere: Vec<bool>,
}

impl Patches {
    /// Place of a cell's patch in the list of its item; the cell meets a fixture with a reference.
    pub fn place(
        &mut self,
        grid: &Grid,
        at: [i32; 3],
        (fixture, reference): (BoundaryId, [f64; 3]),
        of_item: &mut Vec<Patch>,
    ) -> u16 {
        let holder = match grid.open_faces(at).next() {
            Some((axis, side)) => Holder::Face((2 * axis + side) as u8),
            None => Holder::Account(self.number(cube(grid, at, fixture, reference))),
        };
        // Neighbours in the list are mostly of one patch.
        let known = of_item.iter().rposition(|patch| patch.holder == holder);
        let place = known.unwrap_or_else(|| {
            of_item.push(Patch::of(holder));
            of_item.len() - 1
        });
        place as u16
    }

    /// Number of the account of a cube.
    fn number(&mut self, cube: Cube) -> u32 {
        let new = self.numbers.len() as u32;
        let number = *self.numbers.entry(cube).or_insert(new);
        if number == new {
            self.accounts.push(PatchAccount::default());
            self.is_elsewhere.push(false);
        }
        number
    }

    /// Finds out which patches have cells of several ranks.
    pub fn share(&mut self, items: &[WallItem], ranks: &mut Ranks) {
        if ranks.is_alone() {
            return;
        }
        let mut counts = vec![false; self.accounts.len()];
        for patch in items.iter().filter(|item| item.is_own).flat_map(|item| &item.patches) {
            if let Holder::Account(number) = patch.holder {
                counts[number as usize] = true;
            }
        }
        let own = ranks.number() as i64;
        let number = |(&(fixture, [x, y, z]), &account): (&Cube, &u32)| {
            let counts = i64::from(counts[account as usize]);
            [fixture.into(), x.into(), y.into(), z.into(), own, counts]
        };
        let numbers: Vec<i64> = self.numbers.iter().flat_map(number).collect();
        let all = ranks.collect(&numbers);
        // Those who hold a patch, and those of them who count cells of it.
        let mut holders: BTreeMap<Cube, [Vec<i64>; 2]> = BTreeMap::new();
        for known in all.chunks_exact(6) {
            let cube = (known[0] as u16, [known[1] as i32, known[2] as i32, known[3] as i32]);
            let [hold, count] = holders.entry(cube).or_default();
            hold.push(known[4]);
            if known[5] != 0 {
                count.push(known[4]);
            }
        }
        for (cube, [hold, count]) in holders.iter().filter(|(_, [hold, _])| hold.len() > 1) {
            let account = self.numbers.get(cube).copied();
            self.shared.push(account);
            if let Some(account) = account {
                let first = count.iter().min().or(hold.iter().min());
                self.is_elsewhere[account as usize] = first != Some(&own);
            }
        }
    }

    /// Mass that links brought to the cells at each open face in this step, `2 axis + side` [cells
    /// at density 1].
    pub fn brought(items: &[WallItem], ranks: &mut Ranks) -> [Brought; 6] {
        let mut all = [[ExactSum::default(); 2]; 6];
        for patch in items.iter().filter(|item| item.is_own).flat_map(|item| &item.patches) {
            if let Holder::Face(face) = patch.holder {
                let [by_parts, by_faces] = &mut all[usize::from(face)];
                by_parts.add(patch.gained);
                by_faces.add(patch.of_faces);
            }
        }
        ranks.add_up(all.iter_mut().flatten());
        all.map(|sums| {
            let [by_parts, by_faces] = values(&sums);
            Brought { by_parts, by_faces }
        })
    }

    /// Settles all accounts at the end of a step; returns what is owed.
    pub fn settle(&mut self, items: &mut [WallItem], ranks: &mut Ranks) -> f64 {
        for account in &mut self.accounts {
            (account.gained, account.weight) = Default::default();
        }
        for patch in items.iter().filter(|item| item.is_own).flat_map(|item| &item.patches) {
            if let Holder::Account(number) = patch.holder {
                let account = &mut self.accounts[number as usize];
                account.gained.add(patch.gained);
                account.weight.add(patch.weight);
            }
        }
        self.join_shared(ranks);
        let mut owed = ExactSum::default();
        for (account, is_elsewhere) in self.accounts.iter_mut().zip(&self.is_elsewhere) {
            account.settle();
            if !is_elsewhere {
                owed.add(account.owed);
            }
        }
        ranks.add_up([&mut owed]);
        self.let_pay(items);
        owed.value()
    }

    /// Adds up what patches with cells of several ranks took.
    fn join_shared(&mut self, ranks: &mut Ranks) {
        if self.shared.is_empty() {
            return;
        }
        let of = |account: Option<u32>, accounts: &[PatchAccount]| {
            account.map_or([ExactSum::default(); 2], |number| {
                let PatchAccount { gained, weight, .. } = accounts[number as usize];
                [gained, weight]
            })
        };
        let mut sums: Vec<_> =
            self.shared.iter().map(|&account| of(account, &self.accounts)).collect();
        ranks.add_up(sums.iter_mut().flatten());
        for (account, [gained, weight]) in self.shared.iter().zip(sums) {
            if let Some(number) = account {
                let account = &mut self.accounts[*number as usize];
                (account.gained, account.weight) = (gained, weight);
            }
        }
    }

    /// Keeps what is owed and what the coming step pays, or puts it back, for these items too.
    ///
    /// # Errors
    /// A state of other walls.
    pub fn exchange(
        &mut self,
        items: &mut [WallItem],
        state: &mut StateExchange<'_>,
    ) -> Result<(), StateError> {
        let mut known: Vec<_> =
            self.numbers.iter().map(|(cube, number)| (*number, *cube)).collect();
        known.sort_unstable();
        let own = known.iter().filter(|(number, _)| !self.is_elsewhere[*number as usize]);
        let (mut cubes, mut owed) = (Vec::new(), Vec::new());
        for &(number, (fixture, [x, y, z])) in own {
            let PatchAccount { owed: mass, smoothed, pay, .. } = self.accounts[number as usize];
            cubes.push([i32::from(fixture), x, y, z]);
            owed.push([mass, smoothed, pay]);
        }
        state.shared_list("patches", &mut cubes)?;
        state.shared_list("owed", &mut owed)?;
        if !state.restores() {
            return Ok(());
        }
        let kept: HashMap<[i32; 4], [f64; 3]> = cubes.into_iter().zip(owed).collect();
        for (number, (fixture, [x, y, z])) in known {
            let Some(&[owed, smoothed, pay]) = kept.get(&[fixture.into(), x, y, z]) else {
                return state.unfit("the patches of wall of the state are those of another scene");
            };
            let account = PatchAccount { owed, smoothed, pay, ..PatchAccount::default() };
            self.accounts[number as usize] = account;
        }
        self.let_pay(items);
        Ok(())
    }

    /// Tells the patches of the items what they pay, once their accounts are settled.
    fn let_pay(&self, items: &mut [WallItem]) {
        for patch in items.iter_mut().flat_map(|item| &mut item.patches) {
            if let Holder::Account(number) = patch.holder {
                patch.pay = self.accounts[number as usize].pay;
            }
        }
    }

    /// Forgets what is owed: the fluid begins anew.
    pub fn forgive(&mut self, items: &mut [WallItem]) {
        self.accounts.fill(PatchAccount::default());
        for patch in items.iter_mut().flat_map(|item| &mut item.patches) {
            *patch = Patch::of(patch.holder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A steady loss is paid as it arises after some thousand steps; the account neither swings nor
    /// grows.
    #[test]
    fn a_steady_loss_is_paid() {
        let weight = ExactSum::of(3.0);
        let mut account = PatchAccount { weight, ..PatchAccount::default() };
        let mut most = 0.0_f64;
        for _ in 0..6000 {
            account.gained = ExactSum::of(3.0 * account.pay - 1e-6);
            account.settle();
            most = most.max(account.owed);
        }
        let pay = account.pay;
        assert!((3.0 * pay / 1e-6 - 1.0).abs() < 1e-6, "{pay}");
        assert!((account.owed / (1e-6 / RATE) - 1.0).abs() < 1e-6 && most < 1.2e-6 / RATE);
    }

    /// Of what comes and goes within 50 steps less than 1e-4 is paid in phase, which would feed or
    /// damp it.
    #[test]
    fn sound_is_not_paid() {
        let weight = ExactSum::of(1.0);
        let mut account = PatchAccount { weight, ..PatchAccount::default() };
        let turn = std::f64::consts::TAU / 50.0;
        let mut in_phase = 0.0;
        for step in 0..20_000 {
            let angle = turn * f64::from(step);
            account.gained = ExactSum::of(account.pay + angle.cos());
            in_phase += if step >= 10_000 { account.pay * angle.sin() / 5000.0 } else { 0.0 };
            account.settle();
        }
        // The mass owed is that sine, as large as 1 / turn.
        assert!((in_phase * turn).abs() < 1e-4, "{in_phase}");
    }
}
