//! Directions in which fluid gets from a cell to its neighbours.

/// Steps to the neighbours of a cell that fluid gets to directly: a fluid on faces has six, a
/// lattice those of its stencil. A step of no length may stand among them, and counts for nothing.
/// For each there is the opposite one.
#[derive(Clone, Copy, Debug)]
pub struct Links(pub &'static [[i32; 3]]);

impl Links {
    /// Through the faces of a cell.
    pub const FACES: Self =
        Self(&[[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]);

    /// Number of each step, and the step.
    pub fn each(self) -> impl Iterator<Item = (usize, [i32; 3])> {
        self.0.iter().copied().enumerate().filter(|(_, step)| *step != [0; 3])
    }

    /// Number of the opposite step.
    pub fn opposite(self, number: usize) -> usize {
        let back = self.0[number].map(|k| -k);
        self.0.iter().position(|step| *step == back).expect("each step has an opposite one")
    }
}
