//! Values with a short and a long form. They are read by hand: serde's untagged enums forget
//! which key inside them was wrong.

use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer, StrDeserializer};
use serde::{Deserialize, Deserializer, de};
use std::fmt;
use std::marker::PhantomData;

/// What a value turned out to be.
pub(super) enum Form<W, L, T> {
    /// A word, or a number with its unit.
    Word(W),
    /// A list.
    List(L),
    /// A table.
    Table(T),
}

/// A form that a value never has.
pub(super) enum Never {}

impl<'de> Deserialize<'de> for Never {
    fn deserialize<D: Deserializer<'de>>(_: D) -> Result<Self, D::Error> {
        Err(de::Error::custom(NEVER))
    }
}

/// What [`Never`] says; replaced by a sentence that knows what was found.
const NEVER: &str = "\u{0}";

/// Reads a value in one of its forms; [`Never`] stands for one that it has not. `expecting`
/// completes the sentence "expected ...".
pub(super) fn read<'de, D, W, L, T>(
    deserializer: D,
    expecting: &'static str,
) -> Result<Form<W, L, T>, D::Error>
where
    D: Deserializer<'de>,
    W: Deserialize<'de>,
    L: Deserialize<'de>,
    T: Deserialize<'de>,
{
    deserializer.deserialize_any(Visitor { expecting, forms: PhantomData })
}

struct Visitor<W, L, T> {
    expecting: &'static str,
    forms: PhantomData<(W, L, T)>,
}

impl<W, L, T> Visitor<W, L, T> {
    /// The error of a form that the value never has, in words.
    fn unless_never<E: de::Error>(&self, error: E, found: de::Unexpected<'_>) -> E {
        if error.to_string() == NEVER { E::invalid_type(found, &self.expecting) } else { error }
    }
}

impl<'de, W, L, T> de::Visitor<'de> for Visitor<W, L, T>
where
    W: Deserialize<'de>,
    L: Deserialize<'de>,
    T: Deserialize<'de>,
{
    type Value = Form<W, L, T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.expecting)
    }

    fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
        W::deserialize(StrDeserializer::new(text))
            .map(Form::Word)
            .map_err(|error: E| self.unless_never(error, de::Unexpected::Str(text)))
    }

    fn visit_seq<A: de::SeqAccess<'de>>(self, seq: A) -> Result<Self::Value, A::Error> {
        L::deserialize(SeqAccessDeserializer::new(seq))
            .map(Form::List)
            .map_err(|error: A::Error| self.unless_never(error, de::Unexpected::Seq))
    }

    fn visit_map<A: de::MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
        T::deserialize(MapAccessDeserializer::new(map))
            .map(Form::Table)
            .map_err(|error: A::Error| self.unless_never(error, de::Unexpected::Map))
    }
}

/// Reads an enum of forms: `Enum: "what is expected", Word => Variant, Table => Variant`. A form
/// that is left out is refused in those words.
macro_rules! read_by_form {
    ($name:ident: $expecting:expr, Word => $word:ident, Table => $table:ident) => {
        read_by_form!(@ $name, $expecting, _, Never, _, Word $word, Table $table, List);
    };
    ($name:ident: $expecting:expr, List => $list:ident, Table => $table:ident) => {
        read_by_form!(@ $name, $expecting, Never, _, _, List $list, Table $table, Word);
    };
    ($name:ident: $expecting:expr, Word => $word:ident, List => $list:ident) => {
        read_by_form!(@ $name, $expecting, _, _, Never, Word $word, List $list, Table);
    };
    (@ $name:ident, $expecting:expr, $w:ty, $l:ty, $t:ty, $one:ident $first:ident, $two:ident $second:ident, $none:ident) => {
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                use $crate::manifest::document::forms::{Form, Never, read};
                let form: Form<$w, $l, $t> = read(deserializer, $expecting)?;
                Ok(match form {
                    Form::$one(value) => Self::$first(value),
                    Form::$two(value) => Self::$second(value),
                    Form::$none(never) => match never {},
                })
            }
        }
    };
}
pub(super) use read_by_form;
