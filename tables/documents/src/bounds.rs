//! Readers of single values for serde: numbers within bounds, and words from a list.
//!
//! No length in mm, angle, factor or count of this field is beyond the bounds, and sums and
//! products of such numbers stay finite. The message of an error follows the name of the key.

use std::fmt;
use std::marker::PhantomData;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use toml::Value;

/// Least number above 0: a picometre in mm, and less.
const LEAST: f64 = 1e-9;
/// Greatest number: a thousand kilometres in mm.
const MOST: f64 = 1e9;

/// A condition that a number must meet in a TOML file, a result or an option.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// The condition in words, to follow "must be" in a message.
    pub words: &'static str,
    /// The condition as a function: true for a finite number that meets it.
    pub holds: fn(f64) -> bool,
}

impl Bounds {
    /// Any number of the field.
    pub const FINITE: Bounds =
        Bounds::new("a finite number, at most 1e9 in size", |x| x.abs() <= MOST);
    /// A number above 0.
    pub const POSITIVE: Bounds = Bounds::new("greater than 0, from 1e-9 to 1e9", |x| {
        (LEAST..=MOST).contains(&x)
    });
    /// 0 or a number above 0.
    pub const NOT_NEGATIVE: Bounds = Bounds::new("0, or from 1e-9 to 1e9", |x| {
        x == 0.0 || (LEAST..=MOST).contains(&x)
    });
    /// A share of a whole, above 0 and at most 1.
    pub const SHARE: Bounds = Bounds::new("greater than 0 and at most 1", |x| x > 0.0 && x <= 1.0);
    /// Incidence, degrees from the sheet's normal: from 0 to below 90.
    pub const INCIDENCE: Bounds = Bounds::new("at least 0 and below 90 degrees", |x| {
        (0.0..90.0).contains(&x)
    });
    /// Angle of a turn about an axis, degrees, from -360 to 360.
    pub const TURN: Bounds = Bounds::new("from -360 to 360 degrees", |x| x.abs() <= 360.0);

    /// Makes a condition of words and a function.
    pub const fn new(words: &'static str, holds: fn(f64) -> bool) -> Bounds {
        Bounds { words, holds }
    }

    /// Returns the number if it is finite and meets the condition.
    pub fn checked<E: Error>(self, value: f64) -> Result<f64, E> {
        if value.is_finite() && (self.holds)(value) {
            return Ok(value);
        }
        let words = self.words;
        Err(E::custom(format!(
            "is {value} but must be {words}; correct the value"
        )))
    }
}

/// A table of keys. Without this wrapper serde would read its struct from an array too.
pub struct Table<T>(pub T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Table<T> {
    fn deserialize<D: Deserializer<'de>>(value: D) -> Result<Table<T>, D::Error> {
        struct Keys<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Keys<T> {
            type Value = T;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a table")
            }

            fn visit_map<A: MapAccess<'de>>(self, keys: A) -> Result<T, A::Error> {
                T::deserialize(MapAccessDeserializer::new(keys))
            }
        }
        value.deserialize_map(Keys(PhantomData)).map(Table)
    }
}

/// Reads a table of keys.
pub fn table<'de, T: Deserialize<'de>, D: Deserializer<'de>>(value: D) -> Result<T, D::Error> {
    Table::deserialize(value).map(|table| table.0)
}

/// Reads one table of keys, `[name]`, or several, `[[name]]`.
pub fn tables<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
    value: D,
) -> Result<Vec<T>, D::Error> {
    struct OneOrMore<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrMore<T> {
        type Value = Vec<T>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("a table")
        }

        fn visit_map<A: MapAccess<'de>>(self, keys: A) -> Result<Vec<T>, A::Error> {
            Ok(vec![T::deserialize(MapAccessDeserializer::new(keys))?])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut tables: A) -> Result<Vec<T>, A::Error> {
            let mut all = Vec::new();
            while let Some(Table(table)) = tables.next_element()? {
                all.push(table);
            }
            Ok(all)
        }
    }
    value.deserialize_any(OneOrMore(PhantomData))
}

/// A value whose numbers all meet the same condition.
pub trait Bounded: Sized {
    /// Reads and checks the value.
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Self, D::Error>;
}

/// An integer counts as a number.
impl Bounded for f64 {
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<f64, D::Error> {
        bounds.checked(f64::deserialize(value)?)
    }
}

macro_rules! bounded_whole {
    ($($whole:ident)*) => { $(impl Bounded for $whole {
        fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Self, D::Error> {
            let whole = i64::deserialize(value)?;
            bounds.checked(whole as f64).map(|_| whole as $whole)
        }
    })* };
}
bounded_whole! { u32 u64 usize }

impl<T: Bounded> Bounded for Option<T> {
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Self, D::Error> {
        T::within(value, bounds).map(Some)
    }
}

/// An array.
impl<T: Bounded> Bounded for Vec<T> {
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Vec<T>, D::Error> {
        let all = Vec::<Value>::deserialize(value)?.into_iter();
        let read = all.map(|one| T::within(one, bounds));
        read.collect::<Result<_, _>>().map_err(D::Error::custom)
    }
}

/// A range `{ from = ..., to = ... }`.
impl Bounded for [f64; 2] {
    fn within<'de, D: Deserializer<'de>>(value: D, bounds: Bounds) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Ends {
            from: f64,
            to: f64,
        }
        let Ends { from, to } = table(value)?;
        if bounds.checked::<D::Error>(from)? <= bounds.checked::<D::Error>(to)? {
            return Ok([from, to]);
        }
        Err(D::Error::custom(format!(
            "goes from {from} to {to}; write the smaller number under `from`"
        )))
    }
}

/// Defines functions for `#[serde(deserialize_with)]` that read values within bounds.
#[macro_export]
macro_rules! readers {
    ($($visibility:vis $name:ident = $bounds:expr;)*) => {
        $(
            /// Reads a value within its bounds.
            $visibility fn $name<'de, T, D>(value: D) -> Result<T, D::Error>
        where
            T: $crate::Bounded,
            D: serde::Deserializer<'de>,
        {
            T::within(value, $bounds)
        })*
    };
}

readers! {
    pub finite = Bounds::FINITE;
    pub positive = Bounds::POSITIVE;
    pub not_negative = Bounds::NOT_NEGATIVE;
    pub share = Bounds::SHARE;
    pub incidence = Bounds::INCIDENCE;
    pub turn = Bounds::TURN;
}

/// Reads a word that `parse` knows; `names` lists such words for the message.
pub fn choice<'de, T, D: Deserializer<'de>>(
    value: D,
    names: &[&str],
    parse: fn(&str) -> Option<T>,
) -> Result<T, D::Error> {
    named(&String::deserialize(value)?, names, parse)
}

/// Reads an array of one or more words that `parse` knows.
pub fn choices<'de, T, D: Deserializer<'de>>(
    value: D,
    names: &[&str],
    parse: fn(&str) -> Option<T>,
) -> Result<Vec<T>, D::Error> {
    let words = Vec::<String>::deserialize(value)?;
    if words.is_empty() {
        let wrong = "must be an array of one or more strings; change the value";
        return Err(D::Error::custom(wrong));
    }
    words.iter().map(|word| named(word, names, parse)).collect()
}

fn named<T, E: Error>(word: &str, names: &[&str], parse: fn(&str) -> Option<T>) -> Result<T, E> {
    parse(word).ok_or_else(|| {
        let names = names.join(", ");
        E::custom(format!(
            "is \"{word}\", which means nothing; use one of {names}"
        ))
    })
}
