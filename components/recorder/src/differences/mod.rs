//! What differs between two lists of values, as messages and frames carry them: whose value, which
//! field, and by how much.

mod fields;

use crate::item::Item;
use fields::Fields;
use serde::Serialize;
use tremie_messages::schedule::Content;
use tremie_messages::{
    BodyEvent, BodyState, FacetLoad, Load, Message, PortState, SurfaceVertex, values_of,
};

/// Most differing values that are listed; all are counted.
const LISTED: usize = 8;

/// A number of a value.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub enum Number {
    /// A number with a fraction.
    Real(f64),
    /// The same with 32 bits.
    Single(f32),
    /// An integer.
    Whole(u64),
}

impl Number {
    fn bits(self) -> u64 {
        match self {
            Self::Real(x) => x.to_bits(),
            Self::Single(x) => u64::from(x.to_bits()),
            Self::Whole(n) => n,
        }
    }

    fn value(self) -> f64 {
        match self {
            Self::Real(x) => x,
            Self::Single(x) => f64::from(x),
            Self::Whole(n) => n as f64,
        }
    }

    /// Place among all numbers of its kind: neighbours are one apart.
    fn place(self) -> i64 {
        let (bits, sign) = match self {
            Self::Real(x) => (x.to_bits() as i64, i64::MIN),
            Self::Single(x) => (i64::from(x.to_bits()), 1 << 31),
            Self::Whole(n) => return n as i64,
        };
        if bits & sign == 0 { bits } else { -(bits & !sign) }
    }
}

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Real(x) => write!(f, "{x:?}"),
            Self::Single(x) => write!(f, "{x:?}"),
            Self::Whole(n) => write!(f, "{n}"),
        }
    }
}

/// A number that differs.
#[derive(Clone, Debug, Serialize)]
pub struct FieldDifference {
    /// Whose: `body 7`, `vertex 3`, `node 2, 5`; empty where the field says it all.
    pub of: String,
    /// Which: `position.x`.
    pub field: String,
    /// The number in the first run.
    pub one: Number,
    /// The number in the second.
    pub other: Number,
    /// Absolute difference; `None` if one of them is no number.
    pub absolute: Option<f64>,
    /// That difference over the larger magnitude.
    pub relative: Option<f64>,
    /// The same in units in the last place: how many numbers of this kind the other is away.
    pub ulps: Option<u64>,
}

impl FieldDifference {
    /// Of two numbers whose bits differ.
    pub fn new(of: String, field: String, one: Number, other: Number) -> Self {
        let (a, b) = (one.value(), other.value());
        let absolute = Some((a - b).abs()).filter(|difference| difference.is_finite());
        let relative = absolute.map(|difference| match a.abs().max(b.abs()) {
            0.0 => 0.0,
            larger => difference / larger,
        });
        let is_number = !a.is_nan() && !b.is_nan();
        let ulps = is_number.then(|| one.place().abs_diff(other.place()));
        Self { of, field, one, other, absolute, relative, ulps }
    }
}

impl std::fmt::Display for FieldDifference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { of, field, one, other, absolute, relative, ulps } = self;
        let of = if of.is_empty() { String::new() } else { format!("{of}, ") };
        write!(f, "{of}{field}: {one} and {other}")?;
        if let (Some(absolute), Some(relative), Some(ulps)) = (absolute, relative, ulps) {
            write!(f, " (differs by {absolute:.3e}, relative {relative:.3e}, {ulps} ulp)")?;
        }
        Ok(())
    }
}

/// Everything that differs between two lists of values.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Differences {
    /// The first numbers that differ.
    pub first: Vec<FieldDifference>,
    /// Number of all numbers that differ.
    pub count: u64,
    /// Differences that are no matter of a number, in words: `body 7 is in the first alone`.
    pub others: Vec<String>,
}

impl Differences {
    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.count == 0 && self.others.is_empty()
    }

    /// How much it is, a few words.
    pub fn amount(&self) -> String {
        match (self.count, self.others.len()) {
            (0, 0) => "nothing differs".into(),
            (0, 1) => "another value".into(),
            (0, others) => format!("{others} other values"),
            (1, _) => "1 number differs".into(),
            (count, _) => format!("{count} numbers differ"),
        }
    }

    /// In lines.
    pub fn lines(&self) -> Vec<String> {
        self.first_lines(LISTED)
    }

    /// The first numbers in lines, at most so many.
    pub(crate) fn first_lines(&self, most: usize) -> Vec<String> {
        let mut lines: Vec<String> = self.others.iter().take(most).cloned().collect();
        lines.extend(self.first.iter().take(most).map(ToString::to_string));
        let left_out = (self.others.len() as u64 + self.count) - lines.len() as u64;
        if left_out > 0 {
            lines.push(format!("and {left_out} more"));
        }
        lines
    }

    /// Notes a number; only numbers of other bits count.
    fn note(&mut self, of: impl Fn() -> String, field: &str, one: Number, other: Number) {
        if one.bits() == other.bits() {
            return;
        }
        self.count += 1;
        if self.first.len() < LISTED {
            self.first.push(FieldDifference::new(of(), field.into(), one, other));
        }
    }
}

/// Differences of two lists of values, whose keys ascend.
fn of_values<T: Fields>(one: &[T], other: &[T]) -> Differences {
    of_named(one, other, T::name)
}

/// The same, with other names.
fn of_named<T: Fields>(one: &[T], other: &[T], name: fn(u64) -> String) -> Differences {
    let mut found = Differences::default();
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let (mut i, mut j) = (0, 0);
    while i < one.len() || j < other.len() {
        let keys = (one.get(i).map(|v| v.key(i)), other.get(j).map(|v| v.key(j)));
        match keys {
            (Some(key), Some(same)) if key == same => {
                a.clear();
                b.clear();
                one[i].fields(&mut a);
                other[j].fields(&mut b);
                for ((field, x), (_, y)) in a.iter().zip(&b) {
                    found.note(|| name(key), field, *x, *y);
                }
                (i, j) = (i + 1, j + 1);
            }
            (Some(key), later) if later.is_none_or(|later| key < later) => {
                found.others.push(format!("{} is in the first alone", name(key)));
                i += 1;
            }
            (_, key) => {
                let name = name(key.unwrap_or_default());
                found.others.push(format!("{name} is in the second alone"));
                j += 1;
            }
        }
    }
    found
}

/// Differences of two messages of a content, from their values as they lie in memory.
pub fn of_messages(content: Content, one: &[u8], other: &[u8]) -> Differences {
    fn of<T: Fields + Message>(one: &[u8], other: &[u8]) -> Differences {
        named::<T>(one, other, T::name)
    }
    fn named<T: Fields + Message>(
        one: &[u8],
        other: &[u8],
        name: fn(u64) -> String,
    ) -> Differences {
        match (values_of::<T>(one), values_of::<T>(other)) {
            (Some(one), Some(other)) => of_named(&one, &other, name),
            _ => Differences {
                others: vec!["a message is cut off".into()],
                ..Differences::default()
            },
        }
    }
    match content {
        Content::Events => of::<BodyEvent>(one, other),
        Content::State => of::<BodyState>(one, other),
        Content::Load => of::<Load>(one, other),
        // Their ids are numbers of surfaces.
        Content::Carrier => named::<BodyState>(one, other, |key| format!("surface {key}")),
        Content::Resultant => named::<Load>(one, other, |key| format!("surface {key}")),
        Content::Ports => of::<PortState>(one, other),
        Content::Surface | Content::Trial => of::<SurfaceVertex>(one, other),
        Content::SurfaceLoad | Content::Contact => of::<FacetLoad>(one, other),
    }
}

/// Differences of two frames of one stream and window; none of frames that are no matter of the
/// physics.
pub fn of_frames(one: &Item, other: &Item) -> Differences {
    match (one, other) {
        (Item::Bodies { bodies: one, .. }, Item::Bodies { bodies: other, .. }) => {
            of_values(one, other)
        }
        (Item::Surfaces { samples: one, .. }, Item::Surfaces { samples: other, .. }) => {
            of_values(one, other)
        }
        (
            Item::Slice { nodes: one, header: grid, .. },
            Item::Slice { nodes: other, header, .. },
        ) => match (grid.origin, grid.step, grid.count)
            == (header.origin, header.step, header.count)
        {
            true => of_values(one, other),
            false => Differences {
                others: vec!["the cut lies elsewhere, or has other nodes".into()],
                ..Differences::default()
            },
        },
        (
            Item::Signals { names, values: one, .. },
            Item::Signals { names: theirs, values: other, .. },
        ) => {
            let mut found = Differences::default();
            for (k, (name, value)) in names.iter().zip(one).enumerate() {
                // Most often at the same place.
                let at = match theirs.get(k) {
                    Some(same) if same.name == name.name => Some(k),
                    _ => theirs.iter().position(|signal| signal.name == name.name),
                };
                let Some(there) = at.and_then(|at| other.get(at)) else { continue };
                found.note(String::new, &name.name, Number::Real(*value), Number::Real(*there));
            }
            found
        }
        _ => Differences::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::bytes_of;

    fn bodies(ids: &[u64]) -> Vec<BodyState> {
        ids.iter().map(|id| BodyState::at_rest(*id, [0.1, 0.2, 0.3])).collect()
    }

    #[test]
    fn a_bit_of_one_body_is_found_with_its_size() {
        let one = bodies(&[3, 5, 9]);
        let mut other = one.clone();
        other[1].position[2] = other[1].position[2].next_up();
        let found = of_messages(Content::State, bytes_of(&one), bytes_of(&other));
        assert_eq!((found.count, found.first.len()), (1, 1));
        let first = &found.first[0];
        assert_eq!((first.of.as_str(), first.field.as_str()), ("body 5", "position.z"));
        assert_eq!(first.ulps, Some(1));
        let relative = first.relative.unwrap();
        assert!(relative > 0.0 && relative < 2e-16, "{relative}");
        assert!(of_messages(Content::State, bytes_of(&one), bytes_of(&one)).is_empty());
    }

    #[test]
    fn bodies_that_only_one_has_are_named() {
        let found = of_messages(
            Content::State,
            bytes_of(&bodies(&[1, 2, 4])),
            bytes_of(&bodies(&[2, 3, 4, 7])),
        );
        assert_eq!(found.count, 0);
        let expected = [
            "body 1 is in the first alone",
            "body 3 is in the second alone",
            "body 7 is in the second alone",
        ];
        assert_eq!(found.others, expected);
    }

    #[test]
    fn signs_and_what_is_no_number_differ_too() {
        let difference = |one: f64, other: f64| {
            let name = String::new();
            FieldDifference::new(name.clone(), name, Number::Real(one), Number::Real(other))
        };
        assert_eq!(difference(0.0, -0.0).ulps, Some(0));
        assert_eq!(difference(f64::MIN_POSITIVE, -f64::MIN_POSITIVE).ulps, Some(2 << 52));
        assert_eq!(difference(1.0, f64::NAN).ulps, None);
        assert_eq!(difference(1.0, f64::INFINITY).absolute, None);
        let load = |x: f64| [Load { id: 1, force: [x, 0.0, 0.0], ..Load::default() }];
        let found = of_messages(Content::Load, bytes_of(&load(0.0)), bytes_of(&load(-0.0)));
        assert_eq!(found.count, 1);
        let found =
            of_messages(Content::Load, bytes_of(&load(f64::NAN)), bytes_of(&load(f64::NAN)));
        assert!(found.is_empty());
    }
}
