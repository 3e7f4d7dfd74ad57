//! Leak of a fluid: the narrowest place of the widest way from inside to outside.

use crate::cells::grid::Grid;
use crate::cells::links::Links;
use crate::cells::obstacles::Obstacles;
use crate::survey::voxels::each_neighbour;
use std::collections::BinaryHeap;

/// The narrowest place of a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Narrowest {
    /// Cell.
    pub at: [i32; 3],
    /// Width there [cells]: twice the distance from the cell's centre to the nearest solid cell's
    /// face.
    pub width: f64,
}

/// The narrowest place of the widest way from any of the cells `from` to any of `to`; `None` if
/// there is no way. Widths are those of the solid cells; sheets and the domain's faces do not count
/// as narrow.
pub fn narrowest(
    grid: &Grid,
    links: Links,
    obstacles: &Obstacles,
    from: &[usize],
    to: &[usize],
) -> Option<Narrowest> {
    let room = squared_distances(grid, &obstacles.solid);
    // For each cell reached, the narrowest cell of the widest way to it.
    let mut through = vec![u32::MAX; grid.len()];
    let mut heap = BinaryHeap::new();
    let mut is_end = vec![false; grid.len()];
    to.iter().for_each(|&end| is_end[end] = true);
    let narrower = |a: usize, b: u32| if room[a] < room[b as usize] { a as u32 } else { b };
    for &start in from.iter().filter(|&&start| obstacles.solid[start] == 0) {
        through[start] = start as u32;
        heap.push((room[start], std::cmp::Reverse(start as u32)));
    }
    while let Some((_, std::cmp::Reverse(cell))) = heap.pop() {
        let so_far = through[cell as usize];
        if is_end[cell as usize] {
            let width = 2.0 * f64::from(room[so_far as usize]).sqrt() - 1.0;
            return Some(Narrowest { at: grid.at(so_far as usize), width });
        }
        each_neighbour(grid, links, obstacles, cell as usize, |next| {
            if through[next] == u32::MAX {
                through[next] = narrower(next, so_far);
                heap.push((room[through[next] as usize], std::cmp::Reverse(next as u32)));
            }
        });
    }
    None
}

/// Squared distance from each cell to the nearest solid cell [cells²]; large where there is none.
/// One axis after the other, by lower envelopes of parabolas (Felzenszwalb & Huttenlocher 2012).
fn squared_distances(grid: &Grid, solid: &[u16]) -> Vec<u32> {
    let far = grid.n.iter().map(|&n| (n as u32) * (n as u32)).sum::<u32>();
    let mut distance: Vec<u32> = solid.iter().map(|&s| if s == 0 { far } else { 0 }).collect();
    let [nx, ny, nz] = grid.n.map(|n| n as usize);
    let strides = [1, nx, nx * ny];
    for axis in 0..3 {
        let n = [nx, ny, nz][axis];
        let mut line = vec![0_u32; n];
        let mut envelope = Envelope::default();
        for start in (0..grid.len()).filter(|&k| grid.at(k)[axis] == 0) {
            for (k, value) in line.iter_mut().enumerate() {
                *value = distance[start + k * strides[axis]];
            }
            envelope.build(&line);
            for k in 0..n {
                distance[start + k * strides[axis]] = envelope.at(k as i64).min(far);
            }
        }
    }
    distance
}

/// Lower envelope of the parabolas `line[k] + (x - k)^2`.
#[derive(Default)]
struct Envelope {
    /// Bottoms of the parabolas in it: place and height.
    bottoms: Vec<(i64, i64)>,
    /// From which `x` on each is the lowest.
    from: Vec<i64>,
}

impl Envelope {
    fn build(&mut self, line: &[u32]) {
        self.bottoms.clear();
        self.from.clear();
        for (k, &height) in (0..).zip(line) {
            let height = i64::from(height);
            let mut start = i64::MIN;
            while let Some(&(place, low)) = self.bottoms.last() {
                // The first whole x at which the new one is lower.
                let (above, twice) = (height + k * k - low - place * place, 2 * (k - place));
                start = above.div_euclid(twice) + 1;
                if start > *self.from.last().expect("as many as bottoms") {
                    break;
                }
                self.bottoms.pop();
                self.from.pop();
                start = i64::MIN;
            }
            self.bottoms.push((k, height));
            self.from.push(start);
        }
    }

    fn at(&self, x: i64) -> u32 {
        let place = self.from.partition_point(|&from| from <= x) - 1;
        let (bottom, height) = self.bottoms[place];
        (height + (x - bottom) * (x - bottom)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::grid::Side;

    /// A box with a wall across x at 6 and holes in it.
    fn walled(holes: &[([i32; 2], [i32; 2])]) -> (Grid, Obstacles) {
        let grid = Grid::new([13, 20, 20], [[Side::Wall; 2]; 3]);
        let mut solid = vec![0; grid.len()];
        for y in 0..20 {
            for z in 0..20 {
                let open = |&([y0, z0], [y1, z1]): &([i32; 2], [i32; 2])| {
                    y0 <= y && y <= y1 && z0 <= z && z <= z1
                };
                if !holes.iter().any(open) {
                    solid[grid.index([6, y, z])] = 1;
                }
            }
        }
        (grid, Obstacles { solid, sheets: Vec::new() })
    }

    #[test]
    fn distances_are_those_of_the_nearest_solid() {
        let (grid, obstacles) = walled(&[([3, 3], [8, 9])]);
        let found = squared_distances(&grid, &obstacles.solid);
        let solids: Vec<_> =
            (0..grid.len()).filter(|&k| obstacles.solid[k] != 0).map(|k| grid.at(k)).collect();
        for k in 0..grid.len() {
            let at = grid.at(k);
            let squared = |s: &[i32; 3]| (0..3).map(|a| (s[a] - at[a]).pow(2)).sum::<i32>();
            assert_eq!(found[k] as i32, solids.iter().map(squared).min().unwrap());
        }
    }

    #[test]
    fn the_way_leads_through_the_widest_hole() {
        let (grid, obstacles) = walled(&[([2, 2], [2, 2]), ([8, 10], [12, 14])]);
        let (from, to) = (grid.index([0, 2, 2]), grid.index([12, 2, 2]));
        let found = narrowest(&grid, Links::FACES, &obstacles, &[from], &[to]).unwrap();
        assert_eq!(found, Narrowest { at: [6, 10, 12], width: 5.0 });
        let (grid, obstacles) = walled(&[]);
        assert_eq!(narrowest(&grid, Links::FACES, &obstacles, &[from], &[to]), None);
    }
}
