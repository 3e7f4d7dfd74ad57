//! Possible contacts of every body, with what each contact remembers.

use crate::{
    Vec3,
    bodies::{Ball, Mobility},
    cells::Cells,
    contact::Memory,
};

/// The other side of a possible contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Neighbour {
    /// Index of the other body, or of the wall.
    pub other: u32,
    /// Image through which the other body is seen; see [`crate::periodic::image`].
    pub image: u32,
}

/// Rows of neighbours, one a body, each sorted by the other's index: a deterministic order for
/// sums, and one in which histories move to a new list by merging.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactList {
    /// `start[i]..start[i + 1]` are the entries of body i.
    pub start: Vec<u32>,
    /// The neighbours.
    pub neighbours: Vec<Neighbour>,
    /// `sqrt(m*)` of each entry's pair [kg^(1/2)].
    pub root_mass: Vec<f64>,
    /// Whether the pair touched at the last evaluation.
    pub touching: Vec<bool>,
    /// History, meaningful while touching.
    pub memory: Vec<Memory>,
}

impl ContactList {
    /// Fills the list anew: `row(i, out)` appends the neighbours of body i, `root_mass(i, other)`
    /// is the pair's. Contacts that `old` knows keep their history.
    pub fn refill(
        &mut self,
        old: &Self,
        bodies: usize,
        mut row: impl FnMut(usize, &mut Vec<Neighbour>),
        root_mass: impl Fn(usize, usize) -> f64,
    ) {
        self.start.clear();
        self.neighbours.clear();
        self.start.push(0);
        for i in 0..bodies {
            let begin = self.neighbours.len();
            row(i, &mut self.neighbours);
            self.neighbours[begin..].sort_unstable();
            self.start.push(self.neighbours.len() as u32);
        }
        self.root_mass.clear();
        for i in 0..bodies {
            for k in self.row(i) {
                self.root_mass.push(root_mass(i, self.neighbours[k].other as usize));
            }
        }
        self.touching.clear();
        self.touching.resize(self.neighbours.len(), false);
        self.memory.clear();
        self.memory.resize(self.neighbours.len(), Memory::default());
        if old.start.len() == self.start.len() {
            for i in 0..bodies {
                self.inherit(old, i);
            }
        }
    }

    /// Entries of body i.
    #[inline(always)]
    pub fn row(&self, i: usize) -> std::ops::Range<usize> {
        self.start[i] as usize..self.start[i + 1] as usize
    }

    /// Takes over the histories of body i's contacts. The image is no part of the key: bodies may
    /// have been wrapped since, and a pair is never near through two images at once.
    fn inherit(&mut self, old: &Self, i: usize) {
        let mut k = self.start[i] as usize;
        let end = self.start[i + 1] as usize;
        for o in old.row(i) {
            if !old.touching[o] {
                continue;
            }
            let other = old.neighbours[o].other;
            while k < end && self.neighbours[k].other < other {
                k += 1;
            }
            if k < end && self.neighbours[k].other == other {
                self.touching[k] = true;
                self.memory[k] = old.memory[o];
            }
        }
    }
}

/// Appends the bodies `j > i` whose surfaces are closer to i's than `skin`, where at least one of
/// the two is free. `cells` holds the bodies sorted.
pub(crate) fn near_bodies(
    cells: &Cells,
    shifts: &[Vec3; 27],
    balls: &[Ball],
    mobility: &[Mobility],
    skin: f64,
    i: usize,
    out: &mut Vec<Neighbour>,
) {
    let ball = balls[i];
    cells.around(i, |j, image| {
        let other = &balls[j as usize];
        let reach = ball.radius + other.radius + skin;
        let distance = other.x + shifts[image as usize] - ball.x;
        if j as usize > i
            && distance.norm_squared() < reach * reach
            && (mobility[i].is_free() || mobility[j as usize].is_free())
        {
            out.push(Neighbour { other: j, image });
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{periodic::PeriodicBox, random::Random};
    use proptest::prelude::*;
    use tremie_messages::scene::{Domain, Face};

    const FREE: Mobility = Mobility { inverse_mass: 1.0, inverse_inertia: 1.0 };

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
    fn brute_force(bounds: &PeriodicBox, balls: &[Ball], skin: f64) -> Vec<(usize, u32)> {
        let mut pairs = Vec::new();
        for i in 0..balls.len() {
            for j in i + 1..balls.len() {
                let mut d = balls[j].x - balls[i].x;
                for a in 0..3 {
                    if bounds.periodic[a] {
                        d[a] -= bounds.size[a] * (d[a] / bounds.size[a]).round();
                    }
                }
                let reach = balls[i].radius + balls[j].radius + skin;
                if d.norm_squared() < reach * reach {
                    pairs.push((i, j as u32));
                }
            }
        }
        pairs
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn lists_equal_brute_force(
            seed in any::<u64>(),
            n in 1usize..120,
            size in prop::array::uniform3(0.55f64..2.0),
            periodic in prop::array::uniform3(any::<bool>()),
        ) {
            let skin = 0.03;
            let face = |p: bool| if p { Face::Periodic } else { Face::WALL };
            let domain = Domain::new(
                [-0.3, 0.1, 2.0],
                [size[0] - 0.3, size[1] + 0.1, size[2] + 2.0],
                periodic.map(|p| [face(p), face(p)]),
            );
            let bounds = PeriodicBox::new(&domain);
            let balls = random_balls(&bounds, n, seed);
            let mobility = vec![FREE; n];
            let mut cells = Cells::new(bounds.clone(), 0.2 + skin, n);
            cells.sort(&balls);
            let mut list = ContactList::default();
            list.refill(
                &ContactList::default(),
                n,
                |i, out| near_bodies(&cells, &bounds.shifts, &balls, &mobility, skin, i, out),
                |_, _| 1.0,
            );
            let found: Vec<(usize, u32)> = (0..n)
                .flat_map(|i| list.row(i).map(move |k| (i, k)))
                .map(|(i, k)| (i, list.neighbours[k].other))
                .collect();
            prop_assert_eq!(found, brute_force(&bounds, &balls, skin));
        }
    }

    fn list_of(rows: &[&[u32]], old: &ContactList) -> ContactList {
        let mut list = ContactList::default();
        let row = |i: usize, out: &mut Vec<Neighbour>| {
            out.extend(rows[i].iter().map(|&other| Neighbour { other, image: 13 }));
        };
        list.refill(old, rows.len(), row, |_, _| 1.0);
        list
    }

    #[test]
    fn histories_survive_a_refill() {
        let mut old = list_of(&[&[1, 3, 4], &[2, 5]], &ContactList::default());
        for k in [1, 2, 4] {
            old.touching[k] = true;
            old.memory[k].xi.x = k as f64;
        }
        let new = list_of(&[&[2, 3], &[5, 4, 2]], &old);
        assert_eq!(new.touching, [false, true, false, false, true]);
        assert_eq!(new.memory[1].xi.x, 1.0);
        assert_eq!(new.memory[4].xi.x, 4.0);
        assert_eq!(new.memory[0], Memory::default());
    }
}
