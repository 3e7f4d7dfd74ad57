//! Points that are near each other, found by sorting them into boxes: a bed of 200,000 listed spheres is checked in the
//! time that it takes to read.

use tremie_messages::scene::Domain;

/// Points of a domain, sorted into boxes no smaller than the distance that counts as near.
pub(super) struct Boxes {
    count: [usize; 3],
    periodic: [bool; 3],
    /// The box of each point.
    home: Vec<[usize; 3]>,
    /// Where the points of each box begin in `sorted`, and where the last ones end.
    start: Vec<usize>,
    sorted: Vec<usize>,
}

impl Boxes {
    /// Of points [m] that are near where they are less than `reach` [m] apart. Points beyond a face count as in the
    /// box there.
    pub fn new(domain: &Domain, points: &[[f64; 3]], reach: f64) -> Self {
        let (size, periodic) = (domain.size(), [0, 1, 2].map(|axis| domain.is_periodic(axis)));
        // No more boxes than a few a point: larger ones are as right.
        let most = 4 * points.len() + 64;
        let mut edge = reach.max(f64::MIN_POSITIVE);
        let count = loop {
            let count = size.map(|length| ((length / edge) as usize).clamp(1, 1 << 20));
            if count.iter().product::<usize>() <= most {
                break count;
            }
            edge *= 1.1;
        };
        let home = points.iter().map(|point| {
            std::array::from_fn(|axis| {
                let along = (point[axis] - domain.min[axis]) / size[axis];
                let along = if periodic[axis] { along.rem_euclid(1.0) } else { along };
                ((along * count[axis] as f64) as usize).min(count[axis] - 1)
            })
        });
        let mut own = Self {
            count,
            periodic,
            home: home.collect(),
            start: vec![0; count.iter().product::<usize>() + 1],
            sorted: vec![0; points.len()],
        };
        own.sort();
        own
    }

    /// Points by box, in each by number.
    fn sort(&mut self) {
        for &home in &self.home {
            let slot = self.slot(home);
            self.start[slot + 1] += 1;
        }
        for slot in 1..self.start.len() {
            self.start[slot] += self.start[slot - 1];
        }
        let mut next = self.start.clone();
        for (point, &home) in self.home.iter().enumerate() {
            let slot = self.slot(home);
            self.sorted[next[slot]] = point;
            next[slot] += 1;
        }
    }

    fn slot(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.count[1] + y) * self.count[0] + x
    }

    /// Of the points before `point` that may be near it the first for which `is_one` holds.
    pub fn first_before(&self, point: usize, is_one: impl Fn(usize) -> bool) -> Option<usize> {
        let around = [0, 1, 2].map(|axis| self.around(self.home[point][axis], axis));
        let mut first = None;
        for &z in around[2].iter().flatten() {
            for &y in around[1].iter().flatten() {
                for &x in around[0].iter().flatten() {
                    let slot = self.slot([x, y, z]);
                    let points = &self.sorted[self.start[slot]..self.start[slot + 1]];
                    let end = first.unwrap_or(point);
                    let found = points.iter().take_while(|&&other| other < end);
                    first = found.copied().find(|&other| is_one(other)).or(first);
                }
            }
        }
        first
    }

    /// The places along an axis of a box and of those beside it, each once.
    fn around(&self, place: usize, axis: usize) -> [Option<usize>; 3] {
        let count = self.count[axis];
        let wraps = self.periodic[axis] && count > 2;
        let before = if place > 0 { Some(place - 1) } else { wraps.then(|| count - 1) };
        let after = if place + 1 < count { Some(place + 1) } else { wraps.then_some(0) };
        [before, Some(place), after]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use tremie_messages::scene::Face;

    fn distance(domain: &Domain, a: [f64; 3], b: [f64; 3]) -> f64 {
        let size = domain.size();
        let along = |axis: usize| {
            let d = a[axis] - b[axis];
            if domain.is_periodic(axis) { d - size[axis] * (d / size[axis]).round() } else { d }
        };
        (0..3).map(|axis| along(axis).powi(2)).sum::<f64>().sqrt()
    }

    proptest! {
        /// As if all were compared; also in boxes that are few, and with points beyond faces.
        #[test]
        fn who_is_near_is_found(
            points in prop::collection::vec(prop::array::uniform3(-0.2f64..1.2), 1..60),
            periodic in prop::array::uniform3(any::<bool>()),
            reach in 0.01f64..0.9,
        ) {
            let face = |p: bool| if p { Face::Periodic } else { Face::WALL };
            let domain = Domain::new([0.0; 3], [1.0, 0.7, 1.1], periodic.map(|p| [face(p), face(p)]));
            let boxes = Boxes::new(&domain, &points, reach);
            for (k, &point) in points.iter().enumerate() {
                let is_near = |&j: &usize| distance(&domain, point, points[j]) < reach;
                prop_assert_eq!(boxes.first_before(k, |j| is_near(&j)), (0..k).find(is_near));
            }
        }
    }
}
