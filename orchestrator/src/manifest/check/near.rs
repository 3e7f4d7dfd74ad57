//! Bodies that are near each other, found by sorting their centres into boxes, for each class of
//! sizes by itself: a bed of 200,000 listed spheres is checked in the time that it takes to read,
//! also where one of them is a hundred times as wide as the others.

use tremie_messages::scene::Domain;

/// Bodies of a domain, sorted into boxes by size and place.
pub(super) struct Boxes<'a> {
    min: [f64; 3],
    size: [f64; 3],
    periodic: [bool; 3],
    points: &'a [[f64; 3]],
    widths: &'a [f64],
    /// The widest bodies first.
    levels: Vec<BoxGrid>,
}

/// The boxes of bodies that are within a factor of two as wide.
struct BoxGrid {
    /// Width of the widest of them [m].
    widest: f64,
    /// The box that is filled: the domain's along axes that wrap around, and else that of the
    /// bodies.
    min: [f64; 3],
    size: [f64; 3],
    count: [usize; 3],
    /// Index in `sorted` at which the bodies of each box begin, and at which the last ones end.
    start: Vec<usize>,
    sorted: Vec<usize>,
}

impl<'a> Boxes<'a> {
    /// Of bodies with their centres [m] and how wide they are [m]: two are near each other where
    /// their centres are less apart than the mean of their widths.
    pub fn new(domain: &Domain, points: &'a [[f64; 3]], widths: &'a [f64]) -> Self {
        let mut own = Self {
            min: domain.min,
            size: domain.size(),
            periodic: [0, 1, 2].map(|axis| domain.is_periodic(axis)),
            points,
            widths,
            levels: Vec::new(),
        };
        // The widest first; from each level's widest on down to half of it.
        let mut rest: Vec<usize> = (0..points.len()).collect();
        rest.sort_by(|&a, &b| widths[b].total_cmp(&widths[a]).then(a.cmp(&b)));
        let mut rest = &rest[..];
        while let Some(&first) = rest.first() {
            let widest = widths[first];
            let count = rest.partition_point(|&body| widths[body] >= 0.5 * widest).max(1);
            let (level, others) = rest.split_at(count);
            let level = own.level(widest, level);
            own.levels.push(level);
            rest = others;
        }
        own
    }

    /// The boxes of some bodies; in each they stand by number.
    fn level(&self, widest: f64, bodies: &[usize]) -> BoxGrid {
        let (mut min, mut size) = (self.min, self.size);
        for axis in (0..3).filter(|&axis| !self.periodic[axis]) {
            let places = bodies.iter().map(|&body| self.points[body][axis]);
            min[axis] = places.clone().fold(f64::INFINITY, f64::min);
            size[axis] = places.fold(min[axis], f64::max) - min[axis];
        }
        // No more boxes than a few a body: larger ones are as right.
        let most = 4 * bodies.len() + 64;
        let mut edge = widest.max(f64::MIN_POSITIVE);
        let count = loop {
            let count = size.map(|length| ((length / edge) as usize).clamp(1, 1 << 20));
            if count.iter().product::<usize>() <= most {
                break count;
            }
            edge *= 1.1;
        };
        let mut level = BoxGrid { widest, min, size, count, start: Vec::new(), sorted: Vec::new() };
        let mut bodies = bodies.to_vec();
        bodies.sort_unstable();
        let home = |body: usize| {
            let at = |axis| (self.along(&level, body, axis) * count[axis] as f64) as usize;
            slot(count, [0, 1, 2].map(|axis| at(axis).min(count[axis] - 1)))
        };
        let mut start = vec![0; count.iter().product::<usize>() + 1];
        bodies.iter().for_each(|&body| start[home(body) + 1] += 1);
        for slot in 1..start.len() {
            start[slot] += start[slot - 1];
        }
        let (mut next, mut sorted) = (start.clone(), vec![0; bodies.len()]);
        for &body in &bodies {
            let next = &mut next[home(body)];
            sorted[*next] = body;
            *next += 1;
        }
        (level.start, level.sorted) = (start, sorted);
        level
    }

    /// Position of a body along an axis, in lengths of a level's box.
    fn along(&self, level: &BoxGrid, body: usize, axis: usize) -> f64 {
        let size = level.size[axis].max(f64::MIN_POSITIVE);
        let along = (self.points[body][axis] - level.min[axis]) / size;
        if self.periodic[axis] { along.rem_euclid(1.0) } else { along }
    }

    /// Of the bodies before `body` that may be near it the first for which `is_one` holds.
    pub fn first_before(&self, body: usize, is_one: impl Fn(usize) -> bool) -> Option<usize> {
        let mut first = None;
        for level in &self.levels {
            let reach = 0.5 * (self.widths[body] + level.widest);
            let around = [0, 1, 2].map(|axis| self.around(level, body, axis, reach));
            for z in around[2].clone() {
                for y in around[1].clone() {
                    for x in around[0].clone() {
                        let place = [x, y, z].map(|place| place as usize);
                        let slot =
                            slot(level.count, std::array::from_fn(|a| place[a] % level.count[a]));
                        let bodies = &level.sorted[level.start[slot]..level.start[slot + 1]];
                        let end = first.unwrap_or(body);
                        let found = bodies.iter().take_while(|&&other| other < end);
                        first = found.copied().find(|&other| is_one(other)).or(first);
                    }
                }
            }
        }
        first
    }

    /// The boxes along an axis that overlap what is within `reach` [m] of a body, each once; those
    /// beyond a face that wraps around count on.
    fn around(
        &self,
        level: &BoxGrid,
        body: usize,
        axis: usize,
        reach: f64,
    ) -> std::ops::RangeInclusive<i64> {
        let count = level.count[axis] as i64;
        // A hair more than it is: places of bodies were rounded too.
        let reach = reach / level.size[axis].max(f64::MIN_POSITIVE) + 1e-9;
        let along = self.along(level, body, axis);
        if !self.periodic[axis] {
            let at = |along: f64| ((along * count as f64) as i64).clamp(0, count - 1);
            return at(along - reach)..=at(along + reach);
        }
        if 2.0 * reach >= 1.0 {
            return 0..=count - 1;
        }
        let at = |along: f64| (along * count as f64) as i64;
        let (low, high) = (at(along - reach + 1.0), at(along + reach + 1.0));
        low..=high.min(low + count - 1)
    }
}

fn slot(count: [usize; 3], [x, y, z]: [usize; 3]) -> usize {
    (z * count[1] + y) * count[0] + x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::cell::Cell;
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
        /// As if all were compared; also in boxes that are few, with bodies of many sizes, and with
        /// points beyond faces.
        #[test]
        fn who_is_near_is_found(
            bodies in prop::collection::vec((prop::array::uniform3(-0.2f64..1.2), -6.0f64..0.0), 1..60),
            periodic in prop::array::uniform3(any::<bool>()),
            widest in 0.01f64..0.9,
        ) {
            let face = |p: bool| if p { Face::Periodic } else { Face::WALL };
            let domain = Domain::new([0.0; 3], [1.0, 0.7, 1.1], periodic.map(|p| [face(p), face(p)]));
            let points: Vec<[f64; 3]> = bodies.iter().map(|body| body.0).collect();
            let widths: Vec<f64> = bodies.iter().map(|body| widest * body.1.exp()).collect();
            let boxes = Boxes::new(&domain, &points, &widths);
            for (k, &point) in points.iter().enumerate() {
                let is_near =
                    |&j: &usize| distance(&domain, point, points[j]) < 0.5 * (widths[k] + widths[j]);
                prop_assert_eq!(boxes.first_before(k, |j| is_near(&j)), (0..k).find(is_near));
            }
        }
    }

    /// A lattice of small bodies and a wide one among them: what is compared for each does not grow
    /// with their number.
    #[test]
    fn what_is_compared_grows_with_the_number_alone() {
        for n in [12, 24, 36_u32] {
            let domain = Domain::new([0.0; 3], [1.0; 3], Face::WALLS);
            let edge = 1.0 / f64::from(n);
            let at = |k: u32| (f64::from(k) + 0.5) * edge;
            let mut points: Vec<[f64; 3]> =
                (0..n.pow(3)).map(|k| [at(k % n), at(k / n % n), at(k / n / n)]).collect();
            let mut widths = vec![0.9 * edge; points.len()];
            points.push([0.5; 3]);
            widths.push(0.4);
            let boxes = Boxes::new(&domain, &points, &widths);
            let compared = Cell::new(0_u32);
            for k in 0..points.len() {
                boxes.first_before(k, |_| {
                    compared.set(compared.get() + 1);
                    false
                });
            }
            assert!(compared.get() < 14 * points.len() as u32, "{n}: {}", compared.get());
        }
    }
}
