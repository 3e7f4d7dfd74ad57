//! Sums and extremes over all ranks, the same bits for any number of them.

use crate::lattice::exact_sum::{ExactSum, LIMBS};
use crate::lattice::momentum_exchange::ExchangeTally;
use crate::ranks::communicator::Communicator;
use std::sync::{Mutex, PoisonError};
use tremie_state::StateError;

/// The ranks that compute a lattice together, as one of them sees them; most lattices have one alone.
#[derive(Default)]
pub struct Ranks {
    /// The way to the others, if there are others. Under a lock, because some who only look ask the others, too.
    way: Option<Mutex<Box<dyn Communicator>>>,
    number: usize,
    count: usize,
    limbs: Vec<i64>,
}

impl Ranks {
    /// Those that a way leads to.
    pub fn along(way: Box<dyn Communicator>) -> Self {
        let (number, count) = (way.rank(), way.ranks());
        Self { way: Some(Mutex::new(way)), number, count, limbs: Vec::new() }
    }

    /// True if there are no others.
    pub fn is_alone(&self) -> bool {
        self.way.is_none()
    }

    /// Number of this rank.
    pub fn number(&self) -> usize {
        self.number
    }

    /// Number of ranks, if there are others.
    pub fn count_of_many(&self) -> Option<usize> {
        self.way.as_ref().map(|_| self.count)
    }

    /// The way to the others.
    pub fn way(&mut self) -> Option<&mut dyn Communicator> {
        open(&mut self.way).map(|way| &mut **way as &mut dyn Communicator)
    }

    /// Makes sums of this rank those of all.
    pub fn add_up<'s>(&mut self, sums: impl IntoIterator<Item = &'s mut ExactSum>) {
        let Self { way, limbs, .. } = self;
        let Some(way) = open(way) else { return };
        let sums: Vec<&mut ExactSum> = sums.into_iter().collect();
        limbs.clear();
        limbs.extend(sums.iter().flat_map(|sum| sum.limbs()));
        way.add_up(limbs);
        for (sum, limbs) in sums.into_iter().zip(limbs.chunks_exact(LIMBS)) {
            *sum = ExactSum::from_limbs(std::array::from_fn(|k| limbs[k]));
        }
    }

    /// Makes tallies of this rank those of all.
    pub fn join_tallies(&mut self, tallies: &mut [ExchangeTally]) {
        let Self { way, limbs, .. } = self;
        let Some(way) = open(way) else { return };
        limbs.clear();
        tallies.iter().for_each(|tally| tally.put_limbs(limbs));
        way.add_up(limbs);
        for (tally, limbs) in tallies.iter_mut().zip(limbs.chunks_exact(ExchangeTally::LIMBS)) {
            *tally = ExchangeTally::from_limbs(limbs);
        }
    }

    /// The same for many of which most ranks have nothing, as those of bodies.
    pub fn join_few(&mut self, tallies: &mut [ExchangeTally]) {
        if self.is_alone() {
            return;
        }
        let all = self.tell_tallies((0..).zip(&*tallies));
        tallies.fill(ExchangeTally::default());
        let mut rest = &all[..];
        while let Some((place, tally)) = ExchangeTally::take_bytes(&mut rest) {
            if let Some(own) = tallies.get_mut(place as usize) {
                *own += &tally;
            }
        }
    }

    /// The same for tallies with keys, in the order of the keys, of which ranks may have different ones.
    pub fn join_keyed(&mut self, tallies: &mut Vec<(u32, ExchangeTally)>) {
        if self.is_alone() {
            return;
        }
        let all = self.tell_tallies(tallies.iter().map(|(key, tally)| (*key, tally)));
        tallies.clear();
        let mut rest = &all[..];
        while let Some((key, tally)) = ExchangeTally::take_bytes(&mut rest) {
            match tallies.binary_search_by_key(&key, |own| own.0) {
                Ok(place) => tallies[place].1 += &tally,
                Err(place) => tallies.insert(place, (key, tally)),
            }
        }
    }

    /// Tallies of all ranks as few bytes, each with a number.
    fn tell_tallies<'t>(&self, own: impl Iterator<Item = (u32, &'t ExchangeTally)>) -> Vec<u8> {
        let mut bytes = Vec::new();
        own.for_each(|(number, tally)| tally.put_bytes(number, &mut bytes));
        self.gather_to_all(&bytes)
    }

    /// Makes rows of sums of this rank, most of which are zero, those of all.
    pub fn join_rows<const N: usize>(&mut self, rows: &mut [[ExactSum; N]]) {
        if self.is_alone() {
            return;
        }
        let mut bytes = Vec::new();
        let own = (0_u32..).zip(&*rows).filter(|(_, row)| **row != [ExactSum::default(); N]);
        for (place, row) in own {
            bytes.extend(place.to_le_bytes());
            for limb in row.iter().flat_map(ExactSum::limbs) {
                bytes.extend(limb.to_le_bytes());
            }
        }
        let all = self.gather_to_all(&bytes);
        rows.fill([ExactSum::default(); N]);
        let limb = |bytes: &[u8]| i64::from_le_bytes(std::array::from_fn(|k| bytes[k]));
        for told in all.chunks_exact(4 + N * LIMBS * 8) {
            let (place, limbs) = told.split_at(4);
            let place = u32::from_le_bytes(std::array::from_fn(|k| place[k]));
            let Some(row) = rows.get_mut(place as usize) else { continue };
            for (sum, limbs) in row.iter_mut().zip(limbs.chunks_exact(LIMBS * 8)) {
                *sum += ExactSum::from_limbs(std::array::from_fn(|k| limb(&limbs[8 * k..])));
            }
        }
    }

    /// Makes whole numbers of this rank the sums of all.
    pub fn count(&mut self, numbers: &mut [i64]) {
        if let Some(way) = open(&mut self.way) {
            way.add_up(numbers);
        }
    }

    /// Numbers of all ranks, in the order of the ranks.
    pub fn collect(&self, numbers: &[i64]) -> Vec<i64> {
        if self.is_alone() {
            return numbers.to_vec();
        }
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        let all = self.gather_to_all(&bytes);
        let number = |bytes: &[u8]| i64::from_le_bytes(std::array::from_fn(|k| bytes[k]));
        all.chunks_exact(8).map(number).collect()
    }

    /// Bytes of all ranks, one after the other in the order of the ranks.
    pub fn gather_to_all(&self, bytes: &[u8]) -> Vec<u8> {
        let Some(way) = &self.way else { return bytes.to_vec() };
        way.lock().unwrap_or_else(PoisonError::into_inner).gather_to_all(bytes)
    }

    /// Bytes of all ranks, in the order of the ranks, on rank 0; nothing on others.
    pub fn gather(&self, bytes: &[u8]) -> Vec<Vec<u8>> {
        match &self.way {
            Some(way) => way.lock().unwrap_or_else(PoisonError::into_inner).gather(bytes),
            None => vec![bytes.to_vec()],
        }
    }

    /// Goes on where no rank has an error.
    ///
    /// # Errors
    /// That of the first rank that has one.
    pub fn agree(&mut self, own: Result<(), StateError>) -> Result<(), StateError> {
        let number = self.number;
        let Some(way) = self.way() else { return own };
        let text = own.as_ref().err().map(|error| format!("rank {number}: {error}"));
        let all = way.gather(text.unwrap_or_default().as_bytes());
        let mut first = all.into_iter().find(|text| !text.is_empty()).unwrap_or_default();
        way.broadcast(&mut first);
        match first.is_empty() {
            true => own,
            false => Err(StateError::Unfit(String::from_utf8_lossy(&first).into_owned())),
        }
    }

    /// Makes numbers of this rank the largest of all; what is no number counts as none.
    pub fn largest<const N: usize>(&mut self, numbers: [f64; N]) -> [f64; N] {
        let Some(way) = open(&mut self.way) else { return numbers };
        let mut keys = numbers.map(key_of);
        way.largest(&mut keys);
        keys.map(of_key)
    }
}

/// The way, if there is one.
fn open(way: &mut Option<Mutex<Box<dyn Communicator>>>) -> Option<&mut Box<dyn Communicator>> {
    way.as_mut().map(|way| way.get_mut().unwrap_or_else(PoisonError::into_inner))
}

/// A whole number in the order of numbers.
fn key_of(x: f64) -> i64 {
    let bits = if x.is_nan() { f64::NEG_INFINITY } else { x }.to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

/// The number of such a whole number.
fn of_key(key: i64) -> f64 {
    f64::from_bits((key ^ (((key >> 63) as u64) >> 1) as i64) as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_order_of_their_numbers() {
        let numbers =
            [f64::NEG_INFINITY, -3.5, -1e-300, -0.0, 0.0, 2e-308, 0.1, 7.0, f64::INFINITY];
        assert!(numbers.map(key_of).is_sorted());
        assert_eq!(numbers.map(key_of).map(of_key).map(f64::to_bits), numbers.map(f64::to_bits));
        assert_eq!(key_of(f64::NAN), key_of(f64::NEG_INFINITY));
    }
}
