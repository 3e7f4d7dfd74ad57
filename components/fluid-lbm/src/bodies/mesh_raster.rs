//! The cells that a moving part covers.

use tremie_geometry::RowScratch;

/// Cells of a box of cells, which may reach beyond periodic faces, in layers along z. Along an axis
/// on which the part is endless they are those of the domain, and coordinates beyond its faces mean
/// the cells that stand there.
#[derive(Clone, Debug)]
pub struct Cover {
    pub origin: [i32; 3],
    pub size: [i32; 3],
    /// Cells of the domain along axes on which the part is endless; zero along others.
    pub period: [i32; 3],
    pub layers: Vec<Layer>,
}

/// A layer of a cover.
#[derive(Clone, Debug)]
pub struct Layer {
    pub cells: Vec<bool>,
    /// For each row whether it holds any cell.
    pub rows: Vec<bool>,
    pub scratch: RowScratch,
}

impl Cover {
    /// Of so many cells along the axes on which the part has ends; `period` tells the others.
    pub fn new(side: i32, period: [i32; 3]) -> Self {
        let size = period.map(|n| if n > 0 { n } else { side });
        let layer = Layer {
            cells: vec![false; (size[0] * size[1]) as usize],
            rows: vec![false; size[1] as usize],
            scratch: RowScratch::default(),
        };
        Self { origin: [0; 3], size, period, layers: vec![layer; size[2] as usize] }
    }

    /// A coordinate as the cover counts it.
    #[inline(always)]
    pub fn own(&self, axis: usize, k: i32) -> i32 {
        match self.period[axis] {
            0 => k,
            n => k.rem_euclid(n),
        }
    }

    /// The row `(y, z)`, if it holds any cell.
    #[inline]
    pub fn row(&self, y: i32, z: i32) -> Option<&[bool]> {
        let (j, k) = (self.own(1, y) - self.origin[1], self.own(2, z) - self.origin[2]);
        if !(0..self.size[1]).contains(&j) || !(0..self.size[2]).contains(&k) {
            return None;
        }
        let (layer, j, wide) = (&self.layers[k as usize], j as usize, self.size[0] as usize);
        layer.rows[j].then(|| &layer.cells[j * wide..(j + 1) * wide])
    }

    /// Calls `visit` with the coordinates of each of its cells that is not in `other`.
    pub fn minus(&self, other: &Self, mut visit: impl FnMut([i32; 3])) {
        for (z, layer) in (self.origin[2]..).zip(&self.layers) {
            for (y, _) in (self.origin[1]..).zip(&layer.rows).filter(|(_, holds)| **holds) {
                let row = self.row(y, z).unwrap_or_default();
                let others = other.row(y, z).unwrap_or_default();
                for (x, _) in (self.origin[0]..).zip(row).filter(|(_, inside)| **inside) {
                    let k = (x - other.origin[0]) as usize;
                    if !others.get(k).copied().unwrap_or(false) {
                        visit([x, y, z]);
                    }
                }
            }
        }
    }
}

/// Side of the cover that a surface of the side `needed` gets, the other of its two having the side
/// `other`: as large, or with some room to grow.
pub fn room_for(needed: i32, other: i32) -> i32 {
    if needed <= other { other } else { needed + needed / 8 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two covers change places in each search.
    #[test]
    fn covers_grow_with_their_surface_and_no_further() {
        let (mut now, mut other) = (40, 40);
        for search in 0..1000 {
            std::mem::swap(&mut now, &mut other);
            let needed = 40 + (search / 100).min(4);
            now = now.max(room_for(needed, other));
            assert!(now >= needed && now <= 41 + 41 / 8, "search {search}: {now}");
        }
        assert_eq!(now, other);
    }
}
