//! Momentum exchange at links: what populations that ran into a wall or a body gave to it (Ladd
//! 1994; Wen et al. 2014).

use crate::lattice::d3q19::cross;
use crate::lattice::exact_sum::{ExactSum, LIMBS, add_vector, values};
use crate::lattice::ledger::add_scaled;
use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Momentum, torque and mass that links exchanged in a step [lattice units].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MomentumExchange {
    /// Force on the body.
    pub force: [f64; 3],
    /// Torque on the body about its centre.
    pub torque: [f64; 3],
    /// Momentum that went to the fluid besides: `(f_i' - g_i) u_w`.
    pub swept: [f64; 3],
    /// Of the force, what the mirrored half of the fluid gave: links through a mirror are reckoned
    /// as those of the mirrored cell, whose force is the mirrored one.
    pub image: [f64; 3],
    /// The same for `swept`.
    pub image_swept: [f64; 3],
    /// Momentum that mirrors are reckoned to have given to populations of links that are cut on
    /// their way through them.
    pub unmirrored: [f64; 3],
    /// Mass that went to the fluid.
    pub mass: f64,
    /// Volume by which the wall receded, the sum of `6 w_i (c_i.u_w)`, and the sum of `6 w_i`; of
    /// parts, and where bodies keep accounts of mass.
    pub receded: f64,
    /// See `receded`.
    pub weight: f64,
    /// Volume by which it receded from gaps that hold no fluid.
    pub drawn: f64,
    /// Number of links.
    pub links: usize,
    /// Those without a second fluid cell where it was needed.
    pub fallbacks: usize,
}

/// Exchange of one link.
#[derive(Clone, Copy, Debug)]
pub struct LinkExchange {
    /// Force on the wall.
    pub force: [f64; 3],
    /// Torque about the point from which the arm is.
    pub torque: [f64; 3],
    /// Momentum that went to the fluid besides.
    pub swept: [f64; 3],
}

impl LinkExchange {
    /// Of a link along `c`, on which `g_i` ran into a wall of velocity `u` at an `arm` and `f_i'`
    /// came back, `sum` being `g_i + f_i'` and `gain` `f_i' - g_i`: the Galilean-invariant exchange
    /// of Wen et al. 2014, `g_i (c_i - u) - f_i' (c_i' - u)`.
    #[inline(always)]
    pub fn of(c: [f64; 3], sum: f64, gain: f64, u: [f64; 3], arm: [f64; 3]) -> Self {
        let swept = [gain * u[0], gain * u[1], gain * u[2]];
        let force = [sum * c[0] + swept[0], sum * c[1] + swept[1], sum * c[2] + swept[2]];
        Self { force, torque: cross(arm, force), swept }
    }
}

impl MomentumExchange {
    /// Adds a link; see [`LinkExchange::of`]. Returns the force.
    #[inline(always)]
    pub fn add_link(
        &mut self,
        c: [f64; 3],
        [sum, gain]: [f64; 2],
        u: [f64; 3],
        arm: [f64; 3],
    ) -> [f64; 3] {
        let LinkExchange { force, torque, swept } = LinkExchange::of(c, sum, gain, u, arm);
        add_scaled(&mut self.force, force, 1.0);
        add_scaled(&mut self.torque, torque, 1.0);
        add_scaled(&mut self.swept, swept, 1.0);
        self.mass += gain;
        force
    }

    /// Adds a force that acts at an arm, of links that share it.
    #[inline(always)]
    pub fn add_force(&mut self, force: [f64; 3], arm: [f64; 3]) {
        add_scaled(&mut self.force, force, 1.0);
        add_scaled(&mut self.torque, cross(arm, force), 1.0);
    }

    /// Adds another.
    pub fn join(&mut self, other: &Self) {
        add_scaled(&mut self.force, other.force, 1.0);
        add_scaled(&mut self.torque, other.torque, 1.0);
        add_scaled(&mut self.swept, other.swept, 1.0);
        add_scaled(&mut self.image, other.image, 1.0);
        add_scaled(&mut self.image_swept, other.image_swept, 1.0);
        add_scaled(&mut self.unmirrored, other.unmirrored, 1.0);
        self.mass += other.mass;
        self.receded += other.receded;
        self.weight += other.weight;
        self.drawn += other.drawn;
        self.links += other.links;
        self.fallbacks += other.fallbacks;
    }
}

/// Sums of momentum exchange that depend on no order; see [`MomentumExchange`] for each.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExchangeTally {
    /// Force, torque, and momentum that went to the fluid besides.
    pub force: [ExactSum; 3],
    /// See `force`.
    pub torque: [ExactSum; 3],
    /// See `force`.
    pub swept: [ExactSum; 3],
    /// Of the force and of `swept`, what the mirrored half of the fluid gave.
    pub image: [ExactSum; 3],
    /// See `image`.
    pub image_swept: [ExactSum; 3],
    /// Momentum that mirrors are reckoned to have given.
    pub unmirrored: [ExactSum; 3],
    /// Mass that went to the fluid.
    pub mass: ExactSum,
    /// Volume by which the wall receded, and the sum of `6 w_i`.
    pub receded: ExactSum,
    /// See `receded`.
    pub weight: ExactSum,
    /// Volume by which it receded from gaps that hold no fluid.
    pub drawn: ExactSum,
    /// Number of links, and of those that took the wall half-way.
    pub links: usize,
    /// See `links`.
    pub fallbacks: usize,
}

/// Bytes before the sums of a tally in bytes: place, which sums follow, which are no numbers, and the counts.
const HEAD: usize = 20;

impl ExchangeTally {
    /// Numbers that carry a tally to other parts of a lattice.
    pub const LIMBS: usize = 22 * LIMBS + 2;

    /// Adds what a piece of a wall exchanged, in whatever order.
    pub fn add(&mut self, piece: &MomentumExchange) {
        add_vector(&mut self.force, piece.force);
        add_vector(&mut self.torque, piece.torque);
        add_vector(&mut self.swept, piece.swept);
        add_vector(&mut self.image, piece.image);
        add_vector(&mut self.image_swept, piece.image_swept);
        add_vector(&mut self.unmirrored, piece.unmirrored);
        self.mass.add(piece.mass);
        self.receded.add(piece.receded);
        self.weight.add(piece.weight);
        self.drawn.add(piece.drawn);
        self.links += piece.links;
        self.fallbacks += piece.fallbacks;
    }

    /// Its sums, in one order.
    fn sums(&mut self) -> impl Iterator<Item = &mut ExactSum> {
        let vectors = [
            &mut self.force,
            &mut self.torque,
            &mut self.swept,
            &mut self.image,
            &mut self.image_swept,
            &mut self.unmirrored,
        ];
        let single = [&mut self.mass, &mut self.receded, &mut self.weight, &mut self.drawn];
        vectors.into_iter().flatten().chain(single)
    }

    /// Appends numbers that may be added up with those of other tallies, each by itself.
    pub fn put_limbs(&self, limbs: &mut Vec<i64>) {
        let mut own = *self;
        limbs.extend(own.sums().flat_map(|sum| sum.limbs()));
        limbs.extend([self.links as i64, self.fallbacks as i64]);
    }

    /// The tally of [`ExchangeTally::LIMBS`] limbs, or sums of limbs.
    pub fn from_limbs(limbs: &[i64]) -> Self {
        let mut own = Self::default();
        for (sum, limbs) in own.sums().zip(limbs.chunks_exact(LIMBS)) {
            *sum = ExactSum::from_limbs(std::array::from_fn(|k| limbs[k]));
        }
        if let [.., links, fallbacks] = limbs {
            (own.links, own.fallbacks) = (*links as usize, *fallbacks as usize);
        }
        own
    }

    /// Appends the tally as few bytes: those of its sums alone that are not zero. Nothing of one without any.
    pub fn put_bytes(&self, place: u32, bytes: &mut Vec<u8>) {
        let mut own = *self;
        let (mut filled, mut strange) = (0_u32, 0_u32);
        let head = bytes.len();
        bytes.extend([0; HEAD]);
        for (k, sum) in own.sums().enumerate() {
            let (units, is_strange) = sum.parts();
            strange |= u32::from(is_strange) << k;
            if units != 0 {
                filled |= 1 << k;
                bytes.extend(units.to_le_bytes());
            }
        }
        if filled == 0 && strange == 0 && self.links == 0 {
            return bytes.truncate(head);
        }
        let words = [place, filled, strange, self.links as u32, self.fallbacks as u32];
        for (word, room) in words.iter().zip(bytes[head..].chunks_exact_mut(4)) {
            room.copy_from_slice(&word.to_le_bytes());
        }
    }

    /// Takes a tally off such bytes, with its place; `None` at their end.
    pub fn take_bytes(bytes: &mut &[u8]) -> Option<(u32, Self)> {
        let (head, rest) = bytes.split_at_checked(HEAD)?;
        let word = |k: usize| u32::from_le_bytes(std::array::from_fn(|b| head[4 * k + b]));
        let [place, filled, strange] = [0, 1, 2].map(word);
        let mut own =
            Self { links: word(3) as usize, fallbacks: word(4) as usize, ..Self::default() };
        *bytes = rest;
        for (k, sum) in own.sums().enumerate() {
            let mut units = 0;
            if filled >> k & 1 == 1 {
                let (first, rest) = bytes.split_first_chunk()?;
                (units, *bytes) = (i128::from_le_bytes(*first), rest);
            }
            *sum = ExactSum::from_parts(units, strange >> k & 1 == 1);
        }
        Some((place, own))
    }

    /// The sums, each rounded once.
    pub fn value(&self) -> MomentumExchange {
        MomentumExchange {
            force: values(&self.force),
            torque: values(&self.torque),
            swept: values(&self.swept),
            image: values(&self.image),
            image_swept: values(&self.image_swept),
            unmirrored: values(&self.unmirrored),
            mass: self.mass.value(),
            receded: self.receded.value(),
            weight: self.weight.value(),
            drawn: self.drawn.value(),
            links: self.links,
            fallbacks: self.fallbacks,
        }
    }
}

impl AddAssign<&Self> for ExchangeTally {
    fn add_assign(&mut self, other: &Self) {
        let mut other = *other;
        let (links, fallbacks) = (other.links, other.fallbacks);
        self.sums().zip(other.sums()).for_each(|(own, other)| *own += *other);
        self.links += links;
        self.fallbacks += fallbacks;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tallies_travel_as_few_bytes() {
        let mut some = ExchangeTally::default();
        some.add(&MomentumExchange {
            force: [0.5, -1e-9, 0.0],
            mass: 3.25,
            links: 7,
            ..MomentumExchange::default()
        });
        let mut lost = some;
        lost.torque[1].add(f64::NAN);
        let mut bytes = Vec::new();
        for (place, tally) in [(4, &some), (6, &ExchangeTally::default()), (9, &lost)] {
            tally.put_bytes(place, &mut bytes);
        }
        assert_eq!(bytes.len(), 2 * (HEAD + 3 * 16));
        let mut rest = &bytes[..];
        let (place, first) = ExchangeTally::take_bytes(&mut rest).unwrap();
        assert_eq!((place, first.value()), (4, some.value()));
        let (place, second) = ExchangeTally::take_bytes(&mut rest).unwrap();
        assert!(place == 9 && second.value().torque[1].is_nan() && second.links == 7);
        assert!(ExchangeTally::take_bytes(&mut rest).is_none());
    }
}
