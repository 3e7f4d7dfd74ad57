//! Velocities by the displacement since the sample before.

use serde::{Deserialize, Serialize};
use tremie_messages::scene::Domain;

/// Places of the grains at the sample before, and those of this one as they come.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Displacements {
    /// By ascending ids.
    before: Vec<(u64, [f64; 3])>,
    now: Vec<(u64, [f64; 3])>,
    /// The grains before this place have been looked at.
    place: usize,
    /// Length of a period of each axis that wraps around [m].
    periods: [Option<f64>; 3],
    /// Lower corner of the domain [m].
    min: [f64; 3],
}

/// A grain's way since the sample before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way {
    /// Displacement [m].
    pub by: [f64; 3],
    /// Its middle, in the domain [m].
    pub middle: [f64; 3],
}

impl Displacements {
    /// In a domain, with room for so many grains.
    pub fn new(domain: &Domain, grains: usize) -> Self {
        let size = domain.size();
        Self {
            before: Vec::with_capacity(grains),
            now: Vec::with_capacity(grains),
            place: 0,
            periods: [0, 1, 2].map(|a| domain.is_periodic(a).then_some(size[a])),
            min: domain.min,
        }
    }

    /// Way of a grain to where it is now; `None` where it was not there before. Grains come by
    /// ascending ids.
    pub fn of(&mut self, id: u64, to: [f64; 3]) -> Option<Way> {
        self.now.push((id, to));
        let rest = &self.before[self.place..];
        self.place += rest.iter().take_while(|(other, _)| *other < id).count();
        let (other, from) = *self.before.get(self.place)?;
        if other != id {
            return None;
        }
        let by: [f64; 3] = std::array::from_fn(|a| {
            let way = to[a] - from[a];
            match self.periods[a] {
                Some(period) => way - period * libm::floor(way / period + 0.5),
                None => way,
            }
        });
        let middle = std::array::from_fn(|a| {
            let x = to[a] - 0.5 * by[a];
            match self.periods[a] {
                Some(period) if x < self.min[a] => x + period,
                Some(period) if x >= self.min[a] + period => x - period,
                _ => x,
            }
        });
        Some(Way { by, middle })
    }

    /// Ends the sample.
    pub fn end(&mut self) {
        std::mem::swap(&mut self.before, &mut self.now);
        self.now.clear();
        self.place = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::Face;

    #[test]
    fn ways_lead_across_periodic_faces_and_follow_ids() {
        let mut faces = Face::WALLS;
        faces[0] = [Face::Periodic, Face::Periodic];
        let domain = Domain::new([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], faces);
        let mut ways = Displacements::new(&domain, 3);
        for (id, x) in [(2, 1.25), (5, 1.9375), (7, 1.5)] {
            assert_eq!(ways.of(id, [x, 0.25, 0.5]), None);
        }
        ways.end();
        assert_eq!(ways.of(1, [1.0, 0.0, 0.0]), None, "it has come since");
        let across = ways.of(5, [1.0625, 0.5, 0.5]).unwrap();
        assert_eq!(across.by, [0.125, 0.25, 0.0]);
        assert_eq!(across.middle, [1.0, 0.375, 0.5], "on the face, which is the lower one");
        let back = ways.of(7, [1.25, 0.25, 0.75]).unwrap();
        assert_eq!(back.by, [-0.25, 0.0, 0.25], "grain 2 has gone since");
        ways.end();
        assert_eq!(ways.of(2, [1.25, 0.25, 0.5]), None, "it was away for a sample");
        let on = ways.of(5, [1.9375, 0.5, 0.5]).unwrap();
        assert_eq!((on.by[0], on.middle[0]), (-0.125, 1.0));
    }
}
