//! Fluid cells of the box, and links that end at static solids.
//!
//! A cell is solid if its centre is in a solid. A link between two fluid cells that meets a surface
//! on its way is a wall too: a sheet thinner than a cell. With points `inside` given, only cells
//! that links lead to from there are fluid.

use crate::cells::centres::Centres;
use crate::cells::grid::{Grid, Reach};
use crate::cells::links::Links;
use crate::cells::obstacles::{Obstacles, Sheet};
use crate::survey::solids::Solid;
use tremie_geometry::RowScratch;

/// The box, cell by cell.
pub struct Voxels {
    /// Ways from a cell to its neighbours.
    pub links: Links,
    /// Solid cells and sheets.
    pub obstacles: Obstacles,
    /// Number of fluid cells.
    pub fluid: usize,
    /// Cells that are not fluid because no way leads there from the points inside.
    pub unreached: usize,
    /// Without points inside: regions of fluid that no way joins, by number of cells, the largest
    /// first.
    pub regions: Vec<usize>,
}

/// Number of the solid that stands for cells to which no way leads.
pub fn unreached(solids: &[Solid]) -> u16 {
    solids.len() as u16
}

impl Voxels {
    /// Of solids in a box; the points are cells.
    pub fn new(
        grid: &Grid,
        links: Links,
        centres: &Centres,
        solids: &[Solid],
        inside: &[[i32; 3]],
    ) -> Self {
        let mut obstacles = Obstacles { solid: vec![0; grid.len()], sheets: Vec::new() };
        for (number, solid) in solids.iter().enumerate() {
            cover(grid, centres, solid, number as u16 + 1, &mut obstacles.solid);
        }
        let solid_at_all = !solids.is_empty();
        obstacles.sheets = sheets(grid, links, centres, solids, &obstacles.solid);
        let mut voxels = Self { links, obstacles, fluid: 0, unreached: 0, regions: Vec::new() };
        if !solid_at_all {
            // Everything is one region.
        } else if inside.is_empty() {
            voxels.regions = regions(grid, links, &voxels.obstacles);
        } else {
            let starts: Vec<usize> = inside.iter().map(|&at| grid.index(at)).collect();
            let reached = flood(grid, links, &voxels.obstacles, &starts);
            for (solid, reached) in voxels.obstacles.solid.iter_mut().zip(reached) {
                if *solid == 0 && !reached {
                    *solid = unreached(solids) + 1;
                    voxels.unreached += 1;
                }
            }
            let solid = &voxels.obstacles.solid;
            voxels.obstacles.sheets.retain(|sheet| solid[sheet.cell as usize] == 0);
        }
        voxels.fluid = voxels.obstacles.solid.iter().filter(|&&s| s == 0).count();
        voxels
    }

    /// Links that meet the surfaces of more solids, of which no link knows here: as
    /// `obstacles.sheets` has those of its own.
    pub fn sheets_of(&self, grid: &Grid, centres: &Centres, more: &[Solid]) -> Vec<Sheet> {
        let mut marks = self.obstacles.solid.clone();
        for solid in more {
            cover(grid, centres, solid, u16::MAX, &mut marks);
        }
        sheets(grid, self.links, centres, more, &marks)
    }

    /// True if a cell is fluid.
    pub fn is_fluid(&self, grid: &Grid, at: [i32; 3]) -> bool {
        self.obstacles.solid[grid.index(at)] == 0
    }
}

/// Marks the cells of a solid that no earlier one has.
fn cover(grid: &Grid, centres: &Centres, solid: &Solid, mark: u16, marks: &mut [u16]) {
    let mut scratch = RowScratch::default();
    let mut inside = vec![false; grid.n[0] as usize];
    for z in 0..grid.n[2] {
        for y in 0..grid.n[1] {
            solid.fill_row(grid, centres, [y, z], &mut inside, &mut scratch);
            let first = grid.index([0, y, z]);
            for (mark_here, &inside) in marks[first..].iter_mut().zip(&inside) {
                if inside && *mark_here == 0 {
                    *mark_here = mark;
                }
            }
        }
    }
}

/// Links between fluid cells that meet a surface, from both of their ends, sorted.
fn sheets(
    grid: &Grid,
    links: Links,
    centres: &Centres,
    solids: &[Solid],
    marks: &[u16],
) -> Vec<Sheet> {
    let mut sheets = Vec::new();
    let with_back = links.each().map(|(i, step)| (i, step, links.opposite(i)));
    let pairs: Vec<_> = with_back.filter(|(i, _, back)| i < back).collect();
    for (number, solid) in solids.iter().enumerate().filter(|(_, s)| s.bounds().is_some()) {
        let mut near = vec![0_u64; grid.len().div_ceil(64)];
        solid.each_near(grid, centres, |[first, last]| {
            for z in first[2]..=last[2] {
                for y in first[1]..=last[1] {
                    for index in grid.index([first[0], y, z])..=grid.index([last[0], y, z]) {
                        near[index / 64] |= 1 << (index % 64);
                    }
                }
            }
        });
        let is_near = |index: usize| near[index / 64] >> (index % 64) & 1 == 1;
        for index in (0..grid.len()).filter(|&k| marks[k] == 0 && is_near(k)) {
            let at = grid.at(index);
            // Of each pair of opposite steps one: the other end has the other.
            for (i, step, back) in pairs.iter().copied() {
                let to = std::array::from_fn(|a| at[a] + step[a]);
                let Reach::Cell { at: end, mirrors: 0 } = grid.reach(to) else { continue };
                let end = grid.index(end);
                if marks[end] == 0 && solid.crossing(centres, at, to).is_some() {
                    let solid = number as u16;
                    sheets.push(Sheet { cell: index as u32, dir: i as u8, solid });
                    sheets.push(Sheet { cell: end as u32, dir: back as u8, solid });
                }
            }
        }
    }
    sheets.sort_unstable();
    // Of several solids on a link the first.
    sheets.dedup_by_key(|sheet| (sheet.cell, sheet.dir));
    sheets
}

/// True for fluid cells to which links lead from the fluid cells among the starts.
pub fn flood(grid: &Grid, links: Links, obstacles: &Obstacles, starts: &[usize]) -> Vec<bool> {
    let mut reached = vec![false; grid.len()];
    let mut front = Vec::new();
    for &start in starts {
        if obstacles.solid[start] == 0 && !reached[start] {
            reached[start] = true;
            front.push(start as u32);
        }
    }
    spread(grid, links, obstacles, &mut front, |cell| !std::mem::replace(&mut reached[cell], true));
    reached
}

/// Follows links from the cells of `front`; `enter` says whether a cell is new.
fn spread(
    grid: &Grid,
    links: Links,
    obstacles: &Obstacles,
    front: &mut Vec<u32>,
    mut enter: impl FnMut(usize) -> bool,
) {
    while let Some(cell) = front.pop() {
        each_neighbour(grid, links, obstacles, cell as usize, |next| {
            if enter(next) {
                front.push(next as u32);
            }
        });
    }
}

/// Calls `visit` for each fluid cell to which a link leads from a cell.
pub fn each_neighbour(
    grid: &Grid,
    links: Links,
    obstacles: &Obstacles,
    cell: usize,
    mut visit: impl FnMut(usize),
) {
    let at = grid.at(cell);
    let first = obstacles.sheets.partition_point(|sheet| (sheet.cell as usize) < cell);
    let own = obstacles.sheets[first..].iter().take_while(|sheet| sheet.cell as usize == cell);
    let blocked = own.fold(0_u32, |bits, sheet| bits | 1 << sheet.dir);
    for (_, step) in links.each().filter(|(i, _)| blocked >> i & 1 == 0) {
        if let Reach::Cell { at, .. } = grid.reach(std::array::from_fn(|a| at[a] + step[a])) {
            let next = grid.index(at);
            if obstacles.solid[next] == 0 {
                visit(next);
            }
        }
    }
}

/// Sizes of the regions of fluid that no way joins, the largest first.
fn regions(grid: &Grid, links: Links, obstacles: &Obstacles) -> Vec<usize> {
    let mut reached = vec![false; grid.len()];
    let mut sizes = Vec::new();
    let mut front = Vec::new();
    for start in 0..grid.len() {
        if obstacles.solid[start] == 0 && !reached[start] {
            reached[start] = true;
            front.push(start as u32);
            let mut size = 1;
            spread(grid, links, obstacles, &mut front, |cell| {
                let new = !std::mem::replace(&mut reached[cell], true);
                size += usize::from(new);
                new
            });
            sizes.push(size);
        }
    }
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    sizes
}
