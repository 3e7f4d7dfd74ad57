//! Ghost cells of axes that wrap around: copies of the cells at the other end.

use std::ops::AddAssign;

/// Ghost cells of a stored box, and the cells inside that they stand for. Without an axis that wraps
/// around there are none, and nothing is done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PeriodicGhosts {
    /// Axis by axis, so that ghosts of several axes copy ghosts of the axes before.
    pairs: Vec<(u32, u32)>,
}

impl PeriodicGhosts {
    /// Of a box of so many cells, with room for so many and a ghost on each side.
    pub fn new<const D: usize>(
        cells: [usize; D],
        room: [usize; D],
        is_periodic: [bool; D],
    ) -> Self {
        let mut pairs = Vec::new();
        let mut stride = 1;
        for a in 0..D {
            let stored = room[a] + 2;
            let all: usize = room.iter().map(|n| n + 2).product();
            for place in (0..all).filter(|_| is_periodic[a]) {
                let along = place / stride % stored;
                let inside = match along {
                    0 => cells[a],
                    _ if along == cells[a] + 1 => 1,
                    _ => continue,
                };
                pairs.push((place as u32, (place - along * stride + inside * stride) as u32));
            }
            stride *= stored;
        }
        Self { pairs }
    }

    /// True if no axis wraps around.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// Copies the values of cells to the ghosts that stand for them.
    #[inline]
    pub fn fill<T: Copy>(&self, values: &mut [T]) {
        for &(ghost, inside) in &self.pairs {
            values[ghost as usize] = values[inside as usize];
        }
    }

    /// Sets the values of ghosts to that of nothing.
    pub fn clear<T: Copy + Default>(&self, values: &mut [T]) {
        for &(ghost, _) in &self.pairs {
            values[ghost as usize] = T::default();
        }
    }

    /// Adds what ghosts got to the cells that they stand for, and copies the sums to the ghosts.
    pub fn fold<T: Copy + AddAssign>(&self, values: &mut [T]) {
        for &(ghost, inside) in &self.pairs {
            let share = values[ghost as usize];
            values[inside as usize] += share;
        }
        self.fill(values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ghosts_at_a_corner_stand_for_the_opposite_corner() {
        // 3 by 2 cells, with room for 4 by 2.
        let ghosts = PeriodicGhosts::new([3, 2], [4, 2], [true, true]);
        let place = |x: usize, y: usize| x + 6 * y;
        let mut values = vec![0.0; 24];
        values[place(1, 1)] = 7.0;
        values[place(3, 2)] = 5.0;
        ghosts.fill(&mut values);
        assert_eq!(values[place(4, 3)], 7.0);
        assert_eq!(values[place(0, 0)], 5.0);
        assert_eq!(values[place(4, 1)], 7.0);
        let mut spread = vec![0.0; 24];
        spread[place(4, 3)] = 2.0;
        spread[place(0, 1)] = 3.0;
        ghosts.fold(&mut spread);
        assert_eq!((spread[place(1, 1)], spread[place(3, 1)]), (2.0, 3.0));
        assert_eq!(spread[place(4, 3)], 2.0);
    }
}
