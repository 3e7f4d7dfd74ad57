//! Sorting of particles by cell, so that neighbours in space are neighbours in memory.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::particle_arrays::ParticleArrays;

/// Order of particles by cell, and the memory in which they are sorted.
#[derive(Clone, Debug, Default)]
pub struct CellOrder {
    /// Particles of the cell at place k stand from entry k to entry k + 1.
    first: Vec<u32>,
    cell: Vec<u32>,
    target: Vec<u32>,
    sorted: Vec<f64>,
}

impl CellOrder {
    /// Places of the cells that hold particles, ascending, and the particles of each.
    pub fn cells(&self) -> impl Iterator<Item = (usize, std::ops::Range<usize>)> + '_ {
        let ranges = self.first.windows(2).map(|pair| pair[0] as usize..pair[1] as usize);
        ranges.enumerate().filter(|(_, particles)| !particles.is_empty())
    }

    /// Particles of the cell at a place, when they were sorted.
    #[inline]
    pub fn in_cell(&self, place: usize) -> std::ops::Range<usize> {
        self.first[place] as usize..self.first[place + 1] as usize
    }

    /// Sorts particles by cell. Those of one cell keep their order.
    pub fn sort<const D: usize>(
        &mut self,
        grid: &StaggeredGrid<D>,
        particles: &mut ParticleArrays<D>,
    ) {
        let count = particles.len();
        self.first.clear();
        self.first.resize(grid.stored + 1, 0);
        self.cell.clear();
        for particle in 0..count {
            let place = cell_of(grid, particles.at(particle));
            self.cell.push(place as u32);
            self.first[place + 1] += 1;
        }
        for place in 0..grid.stored {
            self.first[place + 1] += self.first[place];
        }
        self.target.clear();
        for &cell in &self.cell {
            let next = &mut self.first[cell as usize];
            self.target.push(*next);
            *next += 1;
        }
        // Each entry has moved to the next cell's: move them back.
        self.first.copy_within(0..grid.stored, 1);
        self.first[0] = 0;
        let ParticleArrays { position, velocity, gradient, .. } = particles;
        let arrays = position.iter_mut().chain(velocity).chain(gradient.iter_mut().flatten());
        for array in arrays.filter(|array| !array.is_empty()) {
            self.sorted.resize(count, 0.0);
            for (&value, &target) in array.iter().zip(&self.target) {
                self.sorted[target as usize] = value;
            }
            std::mem::swap(array, &mut self.sorted);
        }
    }
}

/// Place of the cell that holds a point.
#[inline]
pub fn cell_of<const D: usize>(grid: &StaggeredGrid<D>, point: [f64; D]) -> usize {
    let inverse = 1.0 / grid.spacing;
    grid.place(std::array::from_fn(|a| {
        let along = ((point[a] - grid.origin[a]) * inverse).max(0.0) as isize;
        along.min(grid.cells[a] as isize - 1)
    }))
}
