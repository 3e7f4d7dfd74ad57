//! Pairs of bodies near each other.

use crate::Vec3;
use crate::neighbours::linked_cells::LinkedCells;
use crate::space::rigid_body::{BoundingSphere, Mobility};

/// A body near another one, as the other sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbour {
    /// Index of the body.
    pub other: u32,
    /// Image through which it is seen; see [`crate::space::periodic::image`].
    pub image: u32,
}

/// Rows of neighbours, one a body; each pair of bodies stands in one row.
#[derive(Clone, Debug, Default)]
pub struct CellPairs {
    /// `start[i]..start[i + 1]` are the entries of body i.
    pub start: Vec<u32>,
    /// The neighbours.
    pub neighbours: Vec<Neighbour>,
}

impl CellPairs {
    /// Fills the rows anew with pairs whose surfaces are closer than their classes' skins. `cells`
    /// holds the bodies sorted.
    pub fn fill(
        &mut self,
        cells: &LinkedCells,
        shifts: &[Vec3; 27],
        balls: &[BoundingSphere],
        mobility: &[Mobility],
    ) {
        self.start.clear();
        self.neighbours.clear();
        self.start.push(0);
        for i in 0..balls.len() {
            near(cells, shifts, balls, mobility, i, |neighbour, _, _| {
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

/// Visits the bodies of body i's row: those ahead of it in the cells of its class, and those of
/// larger classes around it, whose surfaces are closer to i's than the skins of both reach, where
/// at least one of the two is free and they are not joined; with them goes the square of the
/// distance. So the row of a body holds none that are much smaller: each of thousands of grains on
/// a large one lists it.
#[inline(always)]
pub fn near(
    cells: &LinkedCells,
    shifts: &[Vec3; 27],
    balls: &[BoundingSphere],
    mobility: &[Mobility],
    i: usize,
    mut visit: impl FnMut(Neighbour, usize, f64),
) {
    let (ball, own, skins) = (balls[i], cells.class_of(i), cells.skins());
    let mut look = |gap: f64, other: u32, image: u32| {
        let j = other as usize;
        let reach = ball.radius + balls[j].radius + gap;
        let distance = (balls[j].x - ball.x) + shifts[image as usize];
        let square = distance.norm_squared();
        if square < reach * reach && mobility[i].meets(mobility[j]) && j != i {
            visit(Neighbour { other, image }, j, square);
        }
    };
    let gap = skins.between(own, own);
    cells.ahead(i, |other, image| look(gap, other, image));
    for class in (0..own).rev() {
        let gap = skins.between(own, class);
        let farthest = ball.radius + 0.5 * skins.largest(class) + gap;
        cells.above(class, ball.x, farthest, |other, image| look(gap, other, image));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;
    use crate::neighbours::size_classes::Skins;
    use crate::space::periodic::PeriodicBox;
    use proptest::prelude::*;
    use tremie_messages::scene::{Domain, Face};

    const FREE: Mobility = Mobility {
        inverse_mass: 1.0,
        inverse_inertia: 1.0,
        clump: crate::space::rigid_body::ALONE,
    };

    /// Balls of classes of sizes, each class half as wide as the one before, `ratio` apart at most;
    /// crowded into a part of the box.
    fn random_balls(
        bounds: &PeriodicBox,
        n: usize,
        (ratio, part): (f64, f64),
        seed: u64,
    ) -> Vec<BoundingSphere> {
        let ball = |i: usize| {
            let mut random = Random::new(seed, i as u64);
            let unit = Vec3::from_fn(|_, _| random.unit()) * part;
            BoundingSphere {
                x: bounds.min + unit.component_mul(&bounds.size),
                radius: 0.1 * libm::pow(ratio, -random.unit()),
            }
        };
        (0..n).map(ball).collect()
    }

    fn skins_of(balls: &[BoundingSphere]) -> Skins {
        Skins::new(balls.iter().map(|ball| [2.0 * ball.radius; 2]), 0.2, 0.01)
    }

    /// All pairs by the nearest image along each periodic axis.
    fn brute_force(
        bounds: &PeriodicBox,
        balls: &[BoundingSphere],
        skins: &Skins,
    ) -> Vec<(usize, usize)> {
        let mut pairs = Vec::new();
        for i in 0..balls.len() {
            for j in i + 1..balls.len() {
                let mut d = balls[j].x - balls[i].x;
                for a in 0..3 {
                    if bounds.periodic[a] {
                        d[a] -= bounds.size[a] * (d[a] / bounds.size[a]).round();
                    }
                }
                let [a, b] = [i, j].map(|k| skins.class(balls[k].radius));
                let reach = balls[i].radius + balls[j].radius + skins.between(a, b);
                if d.norm_squared() < reach * reach {
                    pairs.push((i, j));
                }
            }
        }
        pairs
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]
        #[test]
        fn rows_equal_brute_force(
            seed in any::<u64>(),
            n in 1usize..160,
            size in prop::array::uniform3(0.55f64..2.0),
            periodic in prop::array::uniform3(any::<bool>()),
            ratio in prop_oneof![Just(1.5), 2.0f64..300.0],
            part in prop_oneof![Just(1.0), 0.05f64..1.0],
        ) {
            let face = |p: bool| if p { Face::Periodic } else { Face::WALL };
            let domain = Domain::new(
                [-0.3, 0.1, 2.0],
                [size[0] - 0.3, size[1] + 0.1, size[2] + 2.0],
                periodic.map(|p| [face(p), face(p)]),
            );
            let bounds = PeriodicBox::new(&domain);
            let balls = random_balls(&bounds, n, (ratio, part), seed);
            let skins = skins_of(&balls);
            let mut cells = LinkedCells::new(bounds.clone(), skins.clone());
            let mut rows = CellPairs::default();
            // What was sorted before must not show.
            for balls in [&balls[..n / 2], &balls] {
                cells.sort(balls);
                rows.fill(&cells, &bounds.shifts, balls, &vec![FREE; balls.len()]);
            }
            let mut found = Vec::new();
            for i in 0..n {
                for k in rows.row(i) {
                    let seen = rows.neighbours[k];
                    let j = seen.other as usize;
                    found.push((i.min(j), i.max(j)));
                    let d = balls[j].x + bounds.shifts[seen.image as usize] - balls[i].x;
                    let [a, b] = [i, j].map(|k| skins.class(balls[k].radius));
                    prop_assert!(a >= b, "the smaller one lists the larger one");
                    prop_assert!(d.norm() < balls[i].radius + balls[j].radius + skins.between(a, b));
                }
            }
            found.sort_unstable();
            prop_assert_eq!(found, brute_force(&bounds, &balls, &skins));
        }
    }

    /// Number of candidates for each body of a mix in a box of edge 1, at random places in a part
    /// of it.
    fn looked_at(radii: impl Iterator<Item = f64>, part: f64) -> f64 {
        let face = || if part < 1.0 { Face::WALL } else { Face::Periodic };
        let faces = [(); 3].map(|()| [face(), face()]);
        let bounds = PeriodicBox::new(&Domain::new([0.0; 3], [1.0; 3], faces));
        let centre = |i: u64| {
            let mut random = Random::new(3, i);
            Vec3::from_fn(|_, _| part * random.unit())
        };
        let balls: Vec<BoundingSphere> =
            (0..).zip(radii).map(|(i, radius)| BoundingSphere { x: centre(i), radius }).collect();
        let skins = Skins::new(balls.iter().map(|ball| [2.0 * ball.radius; 2]), 0.1, 0.0);
        let mut cells = LinkedCells::new(bounds.clone(), skins);
        cells.sort(&balls);
        let mut looked = 0_u64;
        for (i, ball) in balls.iter().enumerate() {
            cells.ahead(i, |_, _| looked += 1);
            for class in 0..cells.class_of(i) {
                let reach = ball.radius
                    + 0.5 * cells.skins().largest(class)
                    + cells.skins().between(class, cells.class_of(i));
                cells.above(class, ball.x, reach, |_, _| looked += 1);
            }
        }
        looked as f64 / balls.len() as f64
    }

    /// Relative diameter of body `i` of `n`.
    type DiameterOf = fn(u64, u64) -> f64;

    /// Mixes that fill the same part of the space, made of `n` and of eight times as many bodies of
    /// half the size: what is looked at for each does not grow. Random places overlap, but what
    /// counts is how many share a cell.
    #[test]
    fn what_is_looked_at_grows_with_the_number_alone() {
        let filled = 0.5;
        let cases: [(&str, DiameterOf, f64); 6] = [
            ("one size", |_, _| 1.0, 1.0),
            ("one size, in a corner", |_, _| 1.0, 0.3),
            (
                "1 : 60, one large in the midst of small",
                |i, _| if i == 0 { 60.0 } else { 1.0 },
                1.0,
            ),
            ("1 : 60, many of both", |i, n| if i < n / 500 { 60.0 } else { 1.0 }, 1.0),
            (
                "1 : 5 : 25",
                |i, _| [1.0, 5.0, 25.0][usize::from(i % 30 == 0) + usize::from(i % 900 == 0)],
                1.0,
            ),
            (
                "log-normal, spread 2",
                |i, _| {
                    let unit = Random::new(9, i).unit();
                    // The logistic distribution has tails that are longer than a normal one's.
                    libm::pow(2.0, 0.55 * libm::log(unit / (1.0 - unit))).clamp(0.1, 10.0)
                },
                1.0,
            ),
        ];
        for (name, size, part) in cases {
            let of = |n: u64| {
                let volume: f64 = (0..n).map(|i| size(i, n).powi(3)).sum::<f64>() * 4.0 / 3.0
                    * core::f64::consts::PI;
                let scale = libm::cbrt(filled * part.powi(3) / volume);
                looked_at((0..n).map(|i| scale * size(i, n)), part)
            };
            let (few, many) = (of(4_000), of(32_000));
            println!("{name}: {few:.1} of 4,000, {many:.1} of 32,000");
            assert!(many < 1.35 * few, "{name}: {few} {many}");
            assert!(many < 250.0, "{name}: {many}");
        }
    }
}
