//! Which bodies are near each other.

use crate::{
    Vec3,
    bodies::{Ball, Mobility},
    cells::Cells,
};

/// A body near another one, as the other sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Neighbour {
    /// Index of the body.
    pub other: u32,
    /// Image through which it is seen; see [`crate::periodic::image`].
    pub image: u32,
}

/// Rows of neighbours, one a body; each pair of bodies stands in one row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    /// `start[i]..start[i + 1]` are the entries of body i.
    pub start: Vec<u32>,
    /// The neighbours.
    pub neighbours: Vec<Neighbour>,
}

impl Rows {
    /// Fills the rows anew with pairs whose surfaces are closer than `gap`. `cells` holds the bodies
    /// sorted.
    pub fn fill(
        &mut self,
        cells: &Cells,
        shifts: &[Vec3; 27],
        balls: &[Ball],
        mobility: &[Mobility],
        gap: f64,
    ) {
        self.start.clear();
        self.neighbours.clear();
        self.start.push(0);
        for i in 0..balls.len() {
            near(cells, shifts, balls, mobility, gap, i, |neighbour, _, _| {
                self.neighbours.push(neighbour);
            });
            self.start.push(self.neighbours.len() as u32);
        }
    }

    /// Entries of body i.
    #[inline(always)]
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }
}

/// Visits the bodies of body i's row: those ahead of it in the cells whose surfaces are closer to
/// i's than `gap`, where at least one of the two is free and they are not joined; with them goes the square of the distance.
#[inline(always)]
pub(crate) fn near(
    cells: &Cells,
    shifts: &[Vec3; 27],
    balls: &[Ball],
    mobility: &[Mobility],
    gap: f64,
    i: usize,
    mut visit: impl FnMut(Neighbour, usize, f64),
) {
    let ball = balls[i];
    cells.ahead(i, |other, image| {
        let j = other as usize;
        let reach = ball.radius + balls[j].radius + gap;
        let distance = (balls[j].x - ball.x) + shifts[image as usize];
        let square = distance.norm_squared();
        if square < reach * reach && mobility[i].meets(mobility[j]) && j != i {
            visit(Neighbour { other, image }, j, square);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{periodic::PeriodicBox, random::Random};
    use proptest::prelude::*;
    use tremie_messages::scene::{Domain, Face};

    const FREE: Mobility =
        Mobility { inverse_mass: 1.0, inverse_inertia: 1.0, clump: crate::bodies::ALONE };

    fn random_balls(bounds: &PeriodicBox, n: usize, seed: u64) -> Vec<Ball> {
        (0..n)
            .map(|i| {
                let mut random = Random::new(seed, i as u64);
                let unit = Vec3::from_fn(|_, _| random.unit());
                Ball {
                    x: bounds.min + unit.component_mul(&bounds.size),
                    radius: 0.04 + 0.06 * random.unit(),
                }
            })
            .collect()
    }

    /// All pairs by the nearest image along each periodic axis.
    fn brute_force(bounds: &PeriodicBox, balls: &[Ball], gap: f64) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for i in 0..balls.len() {
            for j in i + 1..balls.len() {
                let mut d = balls[j].x - balls[i].x;
                for a in 0..3 {
                    if bounds.periodic[a] {
                        d[a] -= bounds.size[a] * (d[a] / bounds.size[a]).round();
                    }
                }
                let reach = balls[i].radius + balls[j].radius + gap;
                if d.norm_squared() < reach * reach {
                    pairs.push((i, j));
                }
            }
        }
        pairs
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn rows_equal_brute_force(
            seed in any::<u64>(),
            n in 1usize..120,
            size in prop::array::uniform3(0.55f64..2.0),
            periodic in prop::array::uniform3(any::<bool>()),
        ) {
            let gap = 0.03;
            let face = |p: bool| if p { Face::Periodic } else { Face::WALL };
            let domain = Domain::new(
                [-0.3, 0.1, 2.0],
                [size[0] - 0.3, size[1] + 0.1, size[2] + 2.0],
                periodic.map(|p| [face(p), face(p)]),
            );
            let bounds = PeriodicBox::new(&domain);
            let balls = random_balls(&bounds, n, seed);
            let mut cells = Cells::new(bounds.clone(), 0.2 + gap, n);
            cells.sort(&balls);
            let mut rows = Rows::default();
            rows.fill(&cells, &bounds.shifts, &balls, &vec![FREE; n], gap);
            let mut found = Vec::new();
            for i in 0..n {
                for k in rows.row(i) {
                    let seen = rows.neighbours[k];
                    let j = seen.other as usize;
                    found.push((i.min(j), i.max(j)));
                    let d = balls[j].x + bounds.shifts[seen.image as usize] - balls[i].x;
                    prop_assert!(d.norm() < balls[i].radius + balls[j].radius + gap);
                }
            }
            found.sort_unstable();
            prop_assert_eq!(found, brute_force(&bounds, &balls, gap));
        }
    }
}
