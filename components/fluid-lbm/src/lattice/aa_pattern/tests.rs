//! Places of random porous boxes with every kind of face.

use super::*;
use crate::lattice::aa_rows::RowEnd;
use crate::lattice::cell_list::{CellList, LinkEnd};
use crate::lattice::d3q19::C;
use proptest::prelude::*;
use proptest::test_runner::{TestCaseError, TestCaseResult};
use std::collections::HashSet;
use tremie_fluid_kit::cells::grid::{Grid, Side};
use tremie_fluid_kit::cells::obstacles::{Obstacles, Sheet};

/// Faces, cells and solids of a box.
fn boxes() -> impl Strategy<Value = (Grid, Obstacles)> {
    let side = prop::sample::select(vec![Side::Wall, Side::Symmetry, Side::Open]);
    let pair =
        prop_oneof![Just([Side::Periodic; 2]), [side.clone(), side].prop_map(|sides| sides),];
    (prop::array::uniform3(1..12_usize), prop::array::uniform3(pair), 0..8_u32, any::<u64>())
        .prop_map(|(n, sides, porosity, seed)| {
            let grid = Grid::new(n, sides);
            let mut dice = seed | 1;
            let mut roll = move || {
                dice = dice.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (dice >> 33) as u32
            };
            let mut solid: Vec<u16> =
                (0..grid.len()).map(|_| u16::from(roll() % 8 < porosity)).collect();
            solid[0] = 0;
            let sheets = sheets(&grid, &solid, &mut roll);
            (grid, Obstacles { solid, sheets })
        })
}

/// Thin solids on some links between cells, from both sides.
fn sheets(grid: &Grid, solid: &[u16], roll: &mut impl FnMut() -> u32) -> Vec<Sheet> {
    let mut sheets = Vec::new();
    for index in (0..grid.len()).filter(|&k| solid[k] == 0) {
        let at = grid.at(index);
        for i in 1..10 {
            if let Reach::Cell { at: to, mirrors: 0 } =
                grid.reach(std::array::from_fn(|a| at[a] + C[i][a]))
                && solid[grid.index(to)] == 0
                && roll().is_multiple_of(20)
            {
                sheets.push(Sheet { cell: index as u32, dir: i as u8, solid: 0 });
                let back = OPPOSITE[i] as u8;
                sheets.push(Sheet { cell: grid.index(to) as u32, dir: back, solid: 0 });
            }
        }
    }
    sheets.sort_unstable();
    sheets.dedup();
    sheets
}
use tremie_fluid_kit::cells::grid::Reach;

/// True if a line may be in a run with others.
fn is_straight(places: &AaPattern, line: usize) -> bool {
    !places.kind(line).is_in_pieces() || places.way(line).row_end.is_some()
}

/// Pieces of a line hold each of its lanes once, and stand in the order of their kind.
fn pieces_hold_each_lane_once(places: &AaPattern, cells: &CellList, line: usize) -> TestCaseResult {
    // Places in pieces beside the line's own lanes are never written: each lane once.
    let mut first = 0;
    for (number, entries) in places.lines().iter().enumerate() {
        let kind = places.kind(number);
        prop_assert_eq!(kind.first as usize, first);
        let counts = [(kind.two, 2), (kind.three, 3), (kind.others, 0)];
        let mut mixed = 0_u32;
        for wanted in counts.iter().flat_map(|&(times, count)| (0..times).map(move |_| count)) {
            let pieces = &places.pieces()[first..];
            let count = pieces.iter().take_while(|piece| !piece.last).count() + 1;
            prop_assert!(count == wanted || wanted == 0 && count != 2 && count != 3);
            let (own, dir) = (&pieces[..count], usize::from(pieces[0].dir));
            prop_assert!(own.iter().all(|piece| usize::from(piece.dir) == dir));
            prop_assert_eq!(places.pieces_of(number, dir)[0], own[0]);
            prop_assert_eq!(places.pieces_of(number, dir).len(), places.pieces().len() - first);
            prop_assert!(
                own.iter().map(|piece| piece.lanes.count_ones()).sum::<u32>() as usize
                    == line.min(cells.len() - number * line)
            );
            prop_assert!(
                own.iter().fold(0, |lanes, piece| lanes | piece.lanes)
                    == (u32::MAX >> (32 - line.min(cells.len() - number * line))) as u16
            );
            mixed |= 1 << dir;
            first += count;
        }
        prop_assert_eq!(mixed, entries[0]);
    }
    prop_assert_eq!(first, places.pieces().len());
    Ok(())
}

/// Within a run each line's places follow those of the line before.
fn runs_follow_on(places: &AaPattern, cells: &CellList, line: usize) -> TestCaseResult {
    // In a run each line's places follow those of the line before.
    let mut start = 0;
    while start < places.lines().len() {
        let end = places.run_end::<false>(start, places.lines().len());
        prop_assert!(end == start + 1 || !places.kind(start).is_in_pieces());
        for cell in (start * line + line)..(end * line).min(cells.len()) {
            for i in 0..Q {
                let [own, before] = [cell, cell - line].map(|c| places.odd(c as u32, i));
                prop_assert_eq!(own, before + line);
            }
        }
        start = end;
    }
    Ok(())
}

/// Within a run with ends of rows all places follow but those at the ends.
fn rows_follow_on_but_at_their_ends(places: &AaPattern, line: usize) -> TestCaseResult {
    // In one with ends of rows all but these do.
    let mut start = 0;
    while start < places.lines().len() {
        let end = places.run_end::<true>(start, places.lines().len());
        prop_assert!(end == start + 1 || is_straight(places, start));
        for number in (start + 1)..end {
            prop_assert!(is_straight(places, number));
            for (lane, i) in (0..line).flat_map(|lane| (1..Q).map(move |i| (lane, i))) {
                let is_beyond = places.way(number).row_end.is_some_and(|end| {
                    let last = if end == RowEnd::Lower { 0 } else { line - 1 };
                    lane == last && end.directions().contains(&i)
                });
                let first = places.lines()[start][i] as usize;
                let straight = first + (number - start) * line + lane;
                let place = places.odd((number * line + lane) as u32, i);
                prop_assert_eq!(place == straight, !is_beyond);
            }
        }
        start = end;
    }
    Ok(())
}

/// Neighbours see each other; the number of links that end.
fn neighbours_see_each_other(
    places: &AaPattern,
    cells: &CellList,
    grid: &Grid,
    obstacles: &Obstacles,
) -> Result<usize, TestCaseError> {
    // Neighbours see each other, and every link that ends is listed once.
    let mut ended = 0;
    for cell in 0..cells.len() as u32 {
        for i in 1..Q {
            let at = cells.coordinates(grid, cell);
            let sheet = obstacles
                .sheets
                .iter()
                .any(|s| s.cell as usize == cells.index(cell) && s.dir as usize == i);
            let end = cells.end(grid, obstacles, at, i);
            match (places.neighbour(cell, i), end) {
                (found, LinkEnd::Cell { cell: expected, mirrors: 0 }) if !sheet => {
                    prop_assert_eq!(found, Some(expected));
                    prop_assert_eq!(places.neighbour(expected, OPPOSITE[i]), Some(cell));
                }
                (found, LinkEnd::Cell { cell: expected, .. }) if !sheet => {
                    prop_assert!(found == Some(expected) || (found.is_none() && expected == cell));
                    ended += 1;
                }
                (found, _) => {
                    prop_assert_eq!(found, None);
                    ended += 1;
                }
            }
        }
    }
    Ok(ended)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn every_place_belongs_to_one_cell_and_direction(
        (grid, obstacles) in boxes(), line in prop::sample::select(vec![8_usize, 16]),
    ) {
        let cells = CellList::new(&grid, &obstacles, (|_| true, BoundaryId::solid(9)));
        let (places, survey) = AaPattern::new(&grid, &cells, &obstacles, line, |o| o.0 % 2 == 0);
        for parity in [Parity::Even, Parity::Odd] {
            let mut seen = HashSet::new();
            for cell in 0..cells.len() as u32 {
                for i in 0..Q {
                    let place = places.of(parity, cell, i);
                    prop_assert!(place < Q * places.stride());
                    prop_assert!(place % places.stride() < cells.len());
                    prop_assert!(seen.insert(place), "{parity:?} {cell} {i}");
                }
            }
        }
        pieces_hold_each_lane_once(&places, &cells, line)?;
        runs_follow_on(&places, &cells, line)?;
        rows_follow_on_but_at_their_ends(&places, line)?;
        let ended = neighbours_see_each_other(&places, &cells, &grid, &obstacles)?;
        let listed: u32 = survey.reflections.iter().map(|r| r.lanes.count_ones()).sum();
        prop_assert_eq!(listed as usize + survey.blocked.len(), ended);
    }
}
