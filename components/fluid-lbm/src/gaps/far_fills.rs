//! Fills that leave the cells of a rank: the ranks ask each other for the cells beyond.

use crate::gaps::modelled::POCKET;
use crate::gaps::pockets::{is_at_open_face, is_wet};
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::layout::{Layout, faces};
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use std::collections::{BTreeSet, HashMap};

/// What a rank knows of a cell: the fluid around it, by numbers in the whole lattice; `None` at an open face.
type Around = Option<Vec<u32>>;

/// The fluid around the cells of this rank, and around those that it asked others for.
pub struct FarFills<'a> {
    flags: &'a CellFlags,
    layout: &'a Layout,
    numbers: &'a WholeNumbers,
    told: HashMap<u32, Around>,
}

/// A fill, by numbers in the whole lattice.
struct FarFill {
    cells: Vec<u32>,
    next: usize,
}

impl<'a> FarFills<'a> {
    /// Of a rank that was told nothing yet.
    pub fn new(flags: &'a CellFlags, layout: &'a Layout, numbers: &'a WholeNumbers) -> Self {
        Self { flags, layout, numbers, told: HashMap::new() }
    }

    /// The cells of the pockets in which some of these cells are, by numbers in the whole lattice. All ranks look for
    /// theirs together.
    pub fn closed(&mut self, seeds: &[u32], ranks: &mut Ranks) -> Vec<i64> {
        let fill = |&seed: &u32| FarFill { cells: vec![self.numbers.in_whole(seed)], next: 0 };
        let mut fills: Vec<FarFill> = seeds.iter().map(fill).collect();
        let mut closed = Vec::new();
        loop {
            let mut wanted = BTreeSet::new();
            fills.retain_mut(|fill| {
                let unknown = self.go_on(fill);
                if unknown.is_none() && fill.next == fill.cells.len() {
                    closed.extend(fill.cells.iter().map(|&cell| i64::from(cell)));
                }
                wanted.extend(unknown.map(i64::from));
                unknown.is_some()
            });
            let wanted: Vec<i64> = wanted.into_iter().collect();
            let asked = ranks.collect(&wanted);
            if asked.is_empty() {
                return closed;
            }
            self.take(&ranks.collect(&self.answers(&asked)));
        }
    }

    /// Goes on with a fill; gives the cell of which nothing is known yet, if it comes to one. Else the fill has been
    /// everywhere, or knows that it is in no pocket.
    fn go_on(&self, fill: &mut FarFill) -> Option<u32> {
        while fill.next < fill.cells.len() && fill.cells.len() < POCKET {
            let cell = fill.cells[fill.next];
            let own = self.own(cell);
            let around = match &own {
                Some(around) => around,
                None => match self.told.get(&cell) {
                    Some(around) => around,
                    None => return Some(cell),
                },
            };
            // Fluid has a way out through an open face.
            let Some(around) = around else { return None };
            for &near in around {
                if !fill.cells.contains(&near) {
                    fill.cells.push(near);
                }
            }
            fill.next += 1;
        }
        None
    }

    /// What is around a cell that this rank counts.
    fn own(&self, cell: u32) -> Option<Around> {
        let own = self.numbers.here(cell).filter(|&cell| self.numbers.is_own(cell))?;
        if is_at_open_face(self.layout, own) {
            return Some(None);
        }
        let wet = faces(self.layout, own).filter(|&near| is_wet(self.flags, near));
        Some(Some(wet.map(|near| self.numbers.in_whole(near)).collect()))
    }

    /// Of each cell that is asked for and counted here: the cell, how many are around it or -1, and these.
    fn answers(&self, asked: &[i64]) -> Vec<i64> {
        let mut answers = Vec::new();
        for &cell in asked {
            let Some(around) = self.own(cell as u32) else { continue };
            answers.push(cell);
            match around {
                None => answers.push(-1),
                Some(around) => {
                    answers.push(around.len() as i64);
                    answers.extend(around.into_iter().map(i64::from));
                }
            }
        }
        answers
    }

    /// Takes what all answered.
    fn take(&mut self, mut answers: &[i64]) {
        while let [cell, count, rest @ ..] = answers {
            let (around, rest) = rest.split_at((*count).max(0) as usize);
            let cells = around.iter().map(|&cell| cell as u32).collect();
            self.told.insert(*cell as u32, (*count >= 0).then_some(cells));
            answers = rest;
        }
    }
}
