//! Random damage to bytes.

use crate::random::Random;

/// Numbers that break things, as text.
const NUMBERS: [&str; 16] = [
    "0",
    "-0",
    "1",
    "-1",
    "255",
    "65536",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "-9223372036854775808",
    "1e308",
    "-1e308",
    "5e-324",
    "nan",
    "inf",
    "0.1e99999",
];

/// A piece of something `length` long: mostly short.
fn piece(random: &mut Random, length: usize) -> std::ops::Range<usize> {
    let longest = *random.one(&[1, 4, 16, 64, usize::MAX]);
    let count = random.below(longest.min(length)) + usize::from(length > 0);
    let start = random.below(length - count + 1);
    start..start + count
}

/// Longest input [bytes].
const LONGEST: usize = 1 << 15;

/// Damages `bytes` in one to eight places: with pieces of `other`, with `words`, with numbers.
pub fn damage(bytes: &mut Vec<u8>, other: &[u8], words: &[&str], random: &mut Random) {
    for _ in 0..=random.below(8) {
        damage_once(bytes, other, words, random);
        bytes.truncate(LONGEST);
    }
}

fn damage_once(bytes: &mut Vec<u8>, other: &[u8], words: &[&str], random: &mut Random) {
    let cut = piece(random, bytes.len());
    match random.below(12) {
        0 => bytes.iter_mut().skip(cut.start).take(1).for_each(|b| *b ^= 1 << random.below(8)),
        1 => bytes.iter_mut().skip(cut.start).take(1).for_each(|b| *b = random.word() as u8),
        2 => drop(bytes.drain(cut)),
        3 => bytes.truncate(cut.start),
        4 => {
            let copy = bytes[cut.clone()].to_vec();
            let times = *random.one(&[1, 1, 2, 8, 300]);
            insert(bytes, cut.start, &copy.repeat(times));
        }
        5 => {
            let from = other[piece(random, other.len())].to_vec();
            let at = cut.start;
            bytes.drain(cut);
            insert(bytes, at, &from);
        }
        6 if !words.is_empty() => {
            let at = cut.start;
            insert(bytes, at, random.one(words).as_bytes());
        }
        7 if !words.is_empty() => replace_word(bytes, cut.start, random.one::<&str>(words)),
        8 | 9 => replace_number(bytes, cut.start, random.one::<&str>(&NUMBERS)),
        10 => {
            let value =
                *random.one(&[0, 1, 0x7f, 0xff, 0xffff, 0x7fff_ffff, u64::MAX >> 1, u64::MAX]);
            let width = *random.one(&[1, 2, 4, 8]);
            let numbers = value.to_le_bytes();
            bytes.iter_mut().skip(cut.start).zip(&numbers[..width]).for_each(|(b, n)| *b = *n);
        }
        _ => swap_lines(bytes, random),
    }
}

fn insert(bytes: &mut Vec<u8>, at: usize, what: &[u8]) {
    let room = LONGEST.saturating_sub(bytes.len()).min(what.len());
    let tail = bytes.split_off(at.min(bytes.len()));
    bytes.extend_from_slice(&what[..room]);
    bytes.extend_from_slice(&tail);
}

/// Puts another word in the place of the first from `at` on.
fn replace_word(bytes: &mut Vec<u8>, at: usize, word: &str) {
    replace(bytes, at, |b| b.is_ascii_alphabetic() || b == b'_', word);
}

/// Puts another number in the place of the first from `at` on.
fn replace_number(bytes: &mut Vec<u8>, at: usize, number: &str) {
    replace(bytes, at, |b| b.is_ascii_digit() || b"+-.".contains(&b), number);
}

fn replace(bytes: &mut Vec<u8>, at: usize, belongs: impl Fn(u8) -> bool, by: &str) {
    let Some(start) = bytes.iter().skip(at).position(|b| belongs(*b)).map(|k| at + k) else {
        return;
    };
    let length = bytes[start..].iter().position(|b| !belongs(*b)).unwrap_or(bytes.len() - start);
    bytes.drain(start..start + length);
    insert(bytes, start, by.as_bytes());
}

fn swap_lines(bytes: &mut Vec<u8>, random: &mut Random) {
    let mut lines: Vec<Vec<u8>> = bytes.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
    let (a, b) = (random.below(lines.len()), random.below(lines.len()));
    lines.swap(a, b);
    *bytes = lines.join(&b'\n');
}
