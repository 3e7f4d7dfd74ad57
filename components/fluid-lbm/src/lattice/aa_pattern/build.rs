//! Building the table of places, line by line.

use super::{AaPattern, Blocked, BlockedLinks, Kind, Piece, Reflection};
use crate::lattice::aa_rows::{RowEnd, Way};
use crate::lattice::cell_list::{BoundaryId, CellList, LinkEnd};
use crate::lattice::d3q19::{OPPOSITE, Q, mirrored};
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::cells::obstacles::Obstacles;

/// Numbers from one plane to the next for `cells` cells in lines of `line`: planes start 3 cache
/// lines apart modulo 4 KiB, so that the 19 streams of a step use different sets of the first-level
/// cache.
pub fn stride(cells: u64, line: u64) -> u64 {
    let mut lines = cells.div_ceil(line).max(1);
    lines += (67 - lines % 64) % 64;
    lines * line
}

impl BlockedLinks {
    /// Lists a lane's reflecting link; those of its line and direction begin at `found`.
    fn reflect(&mut self, found: usize, own: Reflection) {
        let same = |r: &&mut Reflection| {
            (r.place, r.mirrors, r.fixture) == (own.place, own.mirrors, own.fixture)
        };
        match self.reflections[found..].iter_mut().find(same) {
            Some(reflection) => reflection.lanes |= own.lanes,
            None => self.reflections.push(own),
        }
    }
}

impl AaPattern {
    /// The table for stored cells in lines of `line`. `special` says which fixtures' links are
    /// listed in [`BlockedLinks::blocked`] instead of [`BlockedLinks::reflections`].
    pub fn new(
        grid: &Grid,
        cells: &CellList,
        obstacles: &Obstacles,
        line: usize,
        special: impl Fn(BoundaryId) -> bool,
    ) -> (Self, BlockedLinks) {
        let stride = stride(cells.len() as u64, line as u64) as usize;
        let count = cells.len().div_ceil(line);
        let mut places = Self {
            stride,
            line_bits: line.trailing_zeros(),
            lines: Vec::with_capacity(count),
            kinds: Vec::with_capacity(count),
            ways: Vec::with_capacity(count + Way::AHEAD),
            pieces: Vec::new(),
        };
        debug_assert!(line.is_power_of_two());
        let mut survey = BlockedLinks::default();
        let mut ends = vec![[LinkEnd::Cell { cell: 0, mirrors: 0 }; Q]; line];
        let mut sheets = obstacles.sheets.as_slice();
        for first in (0..cells.len()).step_by(line) {
            let lanes = line.min(cells.len() - first);
            for lane in 0..lanes {
                let index = cells.index((first + lane) as u32);
                let at = grid.at(index);
                for i in 1..Q {
                    ends[lane][i] = cells.end(grid, obstacles, at, i);
                }
                // Sheets are sorted by cell, as the cells are: one pass goes through both.
                while let Some((sheet, rest)) = sheets.split_first() {
                    if sheet.cell as usize > index {
                        break;
                    }
                    if sheet.cell as usize == index {
                        ends[lane][sheet.dir as usize] =
                            LinkEnd::BoundaryId(BoundaryId::solid(sheet.solid));
                    }
                    sheets = rest;
                }
            }
            places.add_line(first, &ends[..lanes], &special, &mut survey);
        }
        // A sweep looks ahead beyond the last line.
        places.ways.resize(count + Way::AHEAD, Way::default());
        places.pieces.shrink_to_fit();
        survey.blocked.sort_unstable_by_key(|b| (b.cell, b.dir));
        (places, survey)
    }

    /// Adds a line of cells with the ends of their links.
    fn add_line(
        &mut self,
        first: usize,
        ends: &[[LinkEnd; Q]],
        special: impl Fn(BoundaryId) -> bool,
        survey: &mut BlockedLinks,
    ) {
        let all = (u32::MAX >> (32 - (1 << self.line_bits))) as u16;
        let mut entry = [0u32; Q];
        let first_piece = self.pieces.len();
        for i in 1..Q {
            let begin = self.pieces.len();
            let found = survey.reflections.len();
            for (lane, ends) in ends.iter().enumerate() {
                let from = ends[OPPOSITE[i]];
                let (plane, cell) = match from {
                    LinkEnd::Cell { cell, mirrors } => {
                        (OPPOSITE[mirrored(i, mirrors)], cell as usize)
                    }
                    LinkEnd::BoundaryId(_) => (i, first + lane),
                };
                let place = (plane * self.stride + cell - lane) as u32;
                self.add_to_piece(begin, place, lane, i);
                let own = Reflection {
                    place,
                    mirror_cell: cell as i32 - lane as i32,
                    line: (first >> self.line_bits) as u32,
                    lanes: 1 << lane,
                    dir: i as u8,
                    mirrors: 0,
                    fixture: BoundaryId(u16::MAX),
                };
                match from {
                    LinkEnd::Cell { mirrors: 0, .. } => {}
                    LinkEnd::Cell { mirrors, .. } => {
                        survey.reflect(found, Reflection { mirrors, ..own });
                    }
                    LinkEnd::BoundaryId(fixture) if special(fixture) => {
                        let (cell, dir) = ((first + lane) as u32, OPPOSITE[i] as u8);
                        survey.blocked.push(Blocked { cell, dir, fixture });
                    }
                    LinkEnd::BoundaryId(fixture) => {
                        survey.reflect(found, Reflection { fixture, ..own });
                    }
                }
            }
            self.end_direction(i, begin, all, &mut entry);
        }
        let kind = self.sort_pieces(first_piece, &mut entry);
        let row_end = RowEnd::of(&self.pieces[first_piece..], all);
        if let Some(end) = row_end {
            for (k, i) in end.directions().into_iter().enumerate() {
                entry[i] = self.pieces[first_piece + 2 * k + end.others()].place;
            }
        }
        let follows = self.follows(&entry, row_end);
        self.lines.push(entry);
        self.kinds.push(kind);
        self.ways.push(Way { follows, row_end });
    }

    /// Adds a lane of direction `i` to the piece at its place; those of the direction are from
    /// `begin` on.
    fn add_to_piece(&mut self, begin: usize, place: u32, lane: usize, i: usize) {
        // Lanes with the same `place` lie side by side in memory.
        match self.pieces[begin..].iter_mut().find(|piece| piece.place == place) {
            Some(piece) => piece.lanes |= 1 << lane,
            None => {
                let dir = i as u8;
                self.pieces.push(Piece { place, lanes: 1 << lane, dir, last: false });
            }
        }
    }

    /// Ends the pieces of direction `i`, those from `begin` on: one that has `all` lanes becomes
    /// the line's entry.
    fn end_direction(&mut self, i: usize, begin: usize, all: u16, entry: &mut [u32; Q]) {
        match self.pieces[begin..] {
            [Piece { place, lanes, .. }] if lanes == all => {
                entry[i] = place;
                self.pieces.truncate(begin);
            }
            _ => {
                self.pieces.last_mut().expect("a line has a cell").last = true;
                // Direction 0 never moves, so its entry has room for the bits of directions in
                // pieces.
                entry[0] |= 1 << i;
            }
        }
    }

    /// True if the places of a line follow those of the last one.
    fn follows(&self, entry: &[u32; Q], row_end: Option<RowEnd>) -> bool {
        let is_straight =
            |entry: &[u32; Q], row_end: Option<RowEnd>| entry[0] == 0 || row_end.is_some();
        is_straight(entry, row_end)
            && self.lines.last().zip(self.ways.last()).is_some_and(|(before, way)| {
                let line = 1 << self.line_bits;
                is_straight(before, way.row_end) && (1..Q).all(|i| entry[i] == before[i] + line)
            })
    }

    /// Brings the pieces of the last line, those from `first` on, into the order of [`Kind`], and
    /// writes to its entry where those of each direction begin.
    fn sort_pieces(&mut self, first: usize, entry: &mut [u32; Q]) -> Kind {
        let unsorted = self.pieces.split_off(first);
        let mut kind = Kind { first: first as u32, ..Kind::default() };
        let is_of = |count: usize, wanted| {
            if wanted == 4 { !(2..=3).contains(&count) } else { count == wanted }
        };
        for wanted in 2..=4 {
            for own in
                unsorted.chunk_by(|a, b| a.dir == b.dir).filter(|own| is_of(own.len(), wanted))
            {
                entry[usize::from(own[0].dir)] = self.pieces.len() as u32;
                self.pieces.extend_from_slice(own);
                match wanted {
                    2 => kind.two += 1,
                    3 => kind.three += 1,
                    _ => kind.others += 1,
                }
            }
        }
        kind
    }
}
