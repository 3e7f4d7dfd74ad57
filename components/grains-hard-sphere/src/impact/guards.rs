//! Guards against inelastic collapse.
//!
//! Hard bodies that lose energy collide infinitely often in a finite time: a ball on a floor, three
//! in a row with `e < 7 - 4 sqrt 3` (McNamara & Young 1992). Two guards make collisions elastic
//! that could belong to such a collapse: the TC model (Luding & McNamara, *Granular Matter* 1,
//! 1998: either partner collided less than `t_c` ago), and a least impact speed `v_c` (Goetsch
//! 2015).

use serde::{Deserialize, Serialize};

/// The guards of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guards {
    /// `t_c` [s]; 0 for none.
    pub contact_time: f64,
    /// `v_c` [m/s]; 0 for none.
    pub elastic_speed: f64,
}

/// The guard that made a collision elastic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// None did.
    None,
    /// A partner had collided within `t_c`.
    ContactTime,
    /// The impact was slower than `v_c`.
    ElasticSpeed,
}

impl Guards {
    /// The guard that takes hold of an impact of a speed [m/s], the time since either partner's last
    /// collision [s].
    #[inline]
    pub fn of(&self, speed: f64, since: f64) -> Guard {
        if speed < self.elastic_speed {
            Guard::ElasticSpeed
        } else if since < self.contact_time {
            Guard::ContactTime
        } else {
            Guard::None
        }
    }
}

/// Collisions since the start, and those among them that a guard changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CollisionCount {
    /// Between bodies.
    pub pairs: u64,
    /// Of bodies with walls and parts.
    pub walls: u64,
    /// Made elastic because a partner had just collided.
    pub by_contact_time: u64,
    /// Made elastic because they were slow.
    pub by_speed: u64,
    /// Bodies, summed over steps, that had more collisions in a step than are resolved.
    pub crowded: u64,
}

impl CollisionCount {
    /// Counts a collision, and what a guard changed of it: nothing where it was elastic anyway.
    #[inline]
    pub fn add(&mut self, is_pair: bool, guard: Guard, restitution: f64) {
        if is_pair {
            self.pairs += 1
        } else {
            self.walls += 1
        }
        if restitution < 1.0 {
            match guard {
                Guard::None => {}
                Guard::ContactTime => self.by_contact_time += 1,
                Guard::ElasticSpeed => self.by_speed += 1,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_impacts_and_those_that_follow_each_other_are_guarded_and_counted() {
        let guards = Guards { contact_time: 1e-3, elastic_speed: 1e-2 };
        assert_eq!(guards.of(1.0, 1.0), Guard::None);
        assert_eq!(guards.of(1e-3, 1.0), Guard::ElasticSpeed);
        assert_eq!(guards.of(1.0, 1e-4), Guard::ContactTime);
        let none = Guards { contact_time: 0.0, elastic_speed: 0.0 };
        assert_eq!(none.of(0.0, 0.0), Guard::None);
        let mut count = CollisionCount::default();
        count.add(true, guards.of(1e-3, 1.0), 0.9);
        count.add(false, guards.of(1.0, 1e-4), 0.9);
        count.add(true, guards.of(1.0, 1e-4), 1.0);
        assert_eq!((count.pairs, count.walls), (2, 1));
        assert_eq!((count.by_speed, count.by_contact_time), (1, 1));
    }
}
