//! Typed access to the values of a TOML file. Every error names the line.
//!
//! serde alone would report an unknown field without the nearest valid key. This module walks the
//! parsed document instead and keeps the line of every key. So an error can name the file, the
//! line, the key and the nearest valid key.

use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use crate::document::bounds::Bounds;
use crate::document::error::Error;
use crate::document::line::FileLine;
use crate::names::Spectrum;

/// Text of a TOML file, with the path that it was read from.
#[derive(Debug)]
pub(crate) struct Document {
    file: PathBuf,
    text: String,
    /// Offsets of the line feeds, ascending.
    feeds: Vec<usize>,
}

/// Size of the longest TOML file that is read, bytes: ten times that of a thousand photographs.
const MOST_BYTES: u64 = 1 << 20;

impl Document {
    /// Reads a TOML file into memory.
    ///
    /// # Errors
    /// Returns [`Error::Read`] if the file cannot be opened or read, is not UTF-8, or is longer
    /// than 1 MiB.
    pub(crate) fn read(file: &Path) -> Result<Document, Error> {
        let text = crate::document::text::read(file, MOST_BYTES).map_err(|source| Error::Read {
            file: file.to_owned(),
            source,
        })?;
        Ok(Document::new(file, text))
    }

    /// Makes the document of a text in memory; `file` is its name for messages.
    pub(crate) fn new(file: &Path, text: String) -> Document {
        let bytes = text.bytes().enumerate();
        let feeds = bytes.filter(|&(_, byte)| byte == b'\n');
        Document {
            file: file.to_owned(),
            feeds: feeds.map(|(offset, _)| offset).collect(),
            text,
        }
    }

    /// Parses the text of the document as TOML.
    ///
    /// # Errors
    /// Returns [`Error::Syntax`] with the line of the first error if the text is not valid TOML. A
    /// duplicate key is an error too.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'_>>, Error> {
        DeTable::parse(&self.text).map_err(|error| Error::Syntax {
            place: self.place(error.span().map_or(0, |span| span.start)),
            message: error.message().replace('\n', ", "),
        })
    }

    fn place(&self, offset: usize) -> FileLine {
        FileLine {
            file: self.file.clone(),
            line: 1 + self.feeds.partition_point(|&feed| feed < offset),
        }
    }
}

/// Names that keys had in version 0.1, with their names of today.
///
/// A table that has both among its known keys may be written with either.
const RENAMED: [(&str, &str); 2] = [
    ("ior", "refractive_index"),
    ("distance_mm", "floating_distance_mm"),
];

/// One table of a document. All its keys are known.
#[derive(Debug)]
pub(crate) struct Section<'d> {
    document: &'d Document,
    table: &'d DeTable<'d>,
    name: String,
    place: FileLine,
}

impl<'d> Section<'d> {
    /// Returns the top level of a document as a table that may have only the keys `known`.
    ///
    /// # Errors
    /// Returns [`Error::UnknownKey`] if the top level has another key.
    pub(crate) fn root(
        document: &'d Document,
        table: &'d Spanned<DeTable<'d>>,
        known: &[&'static str],
    ) -> Result<Section<'d>, Error> {
        let place = document.place(0);
        Section {
            document,
            table: table.get_ref(),
            name: "the top level".to_owned(),
            place,
        }
        .checked(known)
    }

    fn checked(self, known: &[&'static str]) -> Result<Section<'d>, Error> {
        let mut keys: Vec<_> = self
            .table
            .keys()
            .filter(|key| !known.contains(&key.get_ref().as_ref()))
            .collect();
        keys.sort_by_key(|key| key.span().start);
        let Some(key) = keys.first() else {
            return self.named_once();
        };
        let distance = |candidate: &&str| strsim::damerau_levenshtein(candidate, key.get_ref());
        Err(Error::UnknownKey {
            place: self.document.place(key.span().start),
            key: key.get_ref().to_string(),
            section: self.name,
            nearest: known.iter().copied().min_by_key(distance).unwrap_or(""),
        })
    }

    /// Returns the table, unless it holds a key both by its old name and by its name of today.
    fn named_once(self) -> Result<Section<'d>, Error> {
        let twice = RENAMED
            .iter()
            .find(|(old, new)| [old, new].iter().all(|key| self.table.contains_key(**key)));
        match twice {
            None => Ok(self),
            Some(&(old, new)) => Err(Error::TwoNames {
                place: self.place_of(old),
                old,
                new,
            }),
        }
    }

    /// Returns the place where the table begins.
    pub(crate) fn place(&self) -> &FileLine {
        &self.place
    }

    /// Returns all keys of the table, in lexicographic order.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        self.table.keys().map(|key| key.get_ref().as_ref())
    }

    /// Returns the place of `key`, or of the table if `key` is not set.
    pub(crate) fn place_of(&self, key: &str) -> FileLine {
        self.entry(key).map_or_else(
            || self.place.clone(),
            |(name, _)| self.document.place(name.span().start),
        )
    }

    /// Returns the value of a key that must be set.
    ///
    /// # Errors
    /// Returns [`Error::Missing`] if `value` is `None`.
    pub(crate) fn required<T>(&self, key: &'static str, value: Option<T>) -> Result<T, Error> {
        value.ok_or_else(|| Error::Missing {
            place: self.place.clone(),
            key,
            section: self.name.clone(),
        })
    }

    /// Returns the key as the file has it, by its name of today or by its old name, and its value.
    fn entry(&self, key: &str) -> Option<(&'d Spanned<DeString<'d>>, &'d Spanned<DeValue<'d>>)> {
        let old = RENAMED.iter().find(|(_, new)| *new == key);
        let by_old = || old.and_then(|(old, _)| self.table.get_key_value(*old));
        self.table.get_key_value(key).or_else(by_old)
    }

    fn get(&self, key: &str) -> Option<&'d Spanned<DeValue<'d>>> {
        self.entry(key).map(|(_, value)| value)
    }

    fn wrong_type(&self, key: &str, expected: &'static str, found: &DeValue<'_>) -> Error {
        Error::WrongType {
            place: self.place_of(key),
            key: key.to_owned(),
            expected,
            found: type_name(found),
        }
    }

    /// Returns the finite number under `key`, or `None` if `key` is not set. An integer counts as a
    /// number.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not a number, and [`Error::OutOfRange`] if it
    /// is NaN, infinite or outside `bounds`.
    pub(crate) fn number(&self, key: &str, bounds: Bounds) -> Result<Option<f64>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let number = as_number(value.get_ref())
            .ok_or_else(|| self.wrong_type(key, "a number", value.get_ref()))?;
        self.within(key, number, bounds).map(Some)
    }

    fn within(&self, key: &str, value: f64, bounds: Bounds) -> Result<f64, Error> {
        if value.is_finite() && (bounds.holds)(value) {
            Ok(value)
        } else {
            Err(Error::OutOfRange {
                place: self.place_of(key),
                key: key.to_owned(),
                value,
                must_be: bounds.words,
            })
        }
    }

    /// Returns the whole number under `key`, or `None` if `key` is not set.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not a whole number that fits into an `i64`, and
    /// [`Error::OutOfRange`] if it is below `least`.
    pub(crate) fn whole(&self, key: &str, least: u64) -> Result<Option<u64>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let Some(number) = as_integer(value.get_ref()) else {
            return Err(self.wrong_type(key, "a whole number", value.get_ref()));
        };
        match u64::try_from(number) {
            Ok(number) if number >= least => Ok(Some(number)),
            _ => Err(Error::OutOfRange {
                place: self.place_of(key),
                key: key.to_owned(),
                value: number as f64,
                must_be: if least == 0 {
                    "a whole number, 0 or greater"
                } else {
                    "a whole number, 1 or greater"
                },
            }),
        }
    }

    /// Returns the boolean under `key`, or `None` if `key` is not set.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is neither `true` nor `false`.
    pub(crate) fn flag(&self, key: &str) -> Result<Option<bool>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        value
            .get_ref()
            .as_bool()
            .map(Some)
            .ok_or_else(|| self.wrong_type(key, "true or false", value.get_ref()))
    }

    /// Returns the string under `key`, or `None` if `key` is not set.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not a string.
    pub(crate) fn text(&self, key: &str) -> Result<Option<&'d str>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        value
            .get_ref()
            .as_str()
            .map(Some)
            .ok_or_else(|| self.wrong_type(key, "a string", value.get_ref()))
    }

    /// Returns the choice that the string under `key` names, or `None` if `key` is not set. `parse`
    /// turns a name into a choice; `names` lists the valid names for the message.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not a string, and [`Error::UnknownName`] if
    /// `parse` does not know it.
    pub(crate) fn choice<T>(
        &self,
        key: &str,
        names: &'static [&'static str],
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<T>, Error> {
        let text = self.text(key)?;
        text.map(|text| parse(text).ok_or_else(|| self.unknown(key, text, names)))
            .transpose()
    }

    fn unknown(&self, key: &str, name: &str, names: &'static [&'static str]) -> Error {
        Error::UnknownName {
            place: self.place_of(key),
            key: key.to_owned(),
            name: name.to_owned(),
            names,
        }
    }

    /// Returns the choices that the strings under `key` name, or `None` if `key` is not set. There
    /// must be at least one.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not an array of one or more strings, and
    /// [`Error::UnknownName`] if `parse` does not know one of them.
    pub(crate) fn choices<T>(
        &self,
        key: &str,
        names: &'static [&'static str],
        parse: impl Fn(&str) -> Option<T>,
    ) -> Result<Option<Vec<T>>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let wrong = || self.wrong_type(key, "an array of one or more strings", value.get_ref());
        let array = value.get_ref().as_array().filter(|array| !array.is_empty());
        let one = |element: &Spanned<DeValue<'_>>| {
            let text = element.get_ref().as_str().ok_or_else(wrong)?;
            parse(text).ok_or_else(|| self.unknown(key, text, names))
        };
        let array = array.ok_or_else(wrong)?;
        array.iter().map(one).collect::<Result<_, _>>().map(Some)
    }

    /// Returns the array of `N` whole numbers under `key`, or `None` if `key` is not set.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not an array of `N` whole numbers, and
    /// [`Error::OutOfRange`] if one of them is below 0. `expected` names the right type in the
    /// message.
    pub(crate) fn whole_array<const N: usize>(
        &self,
        key: &str,
        expected: &'static str,
    ) -> Result<Option<[usize; N]>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let wrong = || self.wrong_type(key, expected, value.get_ref());
        let array = value
            .get_ref()
            .as_array()
            .filter(|array| array.len() == N)
            .ok_or_else(wrong)?;
        let mut numbers = [0; N];
        for (number, element) in numbers.iter_mut().zip(array.iter()) {
            let integer = as_integer(element.get_ref()).ok_or_else(wrong)?;
            *number = usize::try_from(integer).map_err(|_| Error::OutOfRange {
                place: self.place_of(key),
                key: key.to_owned(),
                value: integer as f64,
                must_be: "made of whole numbers, 0 or greater",
            })?;
        }
        Ok(Some(numbers))
    }

    /// Returns the array of three finite numbers under `key`, or `None` if `key` is not set.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not an array of three numbers, and
    /// [`Error::OutOfRange`] if one of them is NaN or infinite.
    pub(crate) fn vector(&self, key: &str) -> Result<Option<[f64; 3]>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let found = value.get_ref();
        let numbers = found.as_array().map_or(Vec::new(), |array| {
            let numbers = array.iter().map(|element| as_number(element.get_ref()));
            numbers.collect()
        });
        let [Some(x), Some(y), Some(z)] = numbers[..] else {
            return Err(self.wrong_type(key, "three numbers in brackets", found));
        };
        for number in [x, y, z] {
            self.within(key, number, Bounds::FINITE)?;
        }
        Ok(Some([x, y, z]))
    }

    /// Returns the number, or the table of numbers, under `key`, or `None` if `key` is not set.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is neither a number nor a table of numbers, and
    /// [`Error::OutOfRange`] if a number is NaN, infinite or outside `bounds`.
    pub(crate) fn number_or_table(
        &self,
        key: &str,
        bounds: Bounds,
    ) -> Result<Option<NumberOrTable>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let DeValue::Table(table) = value.get_ref() else {
            let expected = "a number or a table of numbers";
            let number = as_number(value.get_ref())
                .ok_or_else(|| self.wrong_type(key, expected, value.get_ref()))?;
            return self
                .within(key, number, bounds)
                .map(|number| Some(NumberOrTable::Number(number)));
        };
        let inner = self.nested(key, table, value.span().start);
        let mut entries = Vec::new();
        for name in inner.keys() {
            if let Some(number) = inner.number(name, bounds)? {
                entries.push((name.to_owned(), number));
            }
        }
        Ok(Some(NumberOrTable::Table(entries)))
    }

    /// Returns the spectrum under the key `wavelength_nm`, or `None` if the key is not set. The
    /// value is a number, or text that [`Spectrum::parse`] reads.
    ///
    /// # Errors
    /// Returns [`Error::Spectrum`] if the text or the number is not a valid spectrum,
    /// [`Error::WrongType`] if the value is neither text nor a number, and [`Error::OutOfRange`] if
    /// it is NaN or infinite.
    pub(crate) fn spectrum(&self) -> Result<Option<Spectrum>, Error> {
        let key = "wavelength_nm";
        let spectrum = match self.text(key) {
            Ok(None) => None,
            Ok(Some(text)) => Some(Spectrum::parse(text)),
            // The value is not a string. If it is not a number either, the message of `number` is
            // right.
            Err(_) => self
                .number(key, Bounds::FINITE)?
                .map(Spectrum::monochromatic),
        };
        spectrum.transpose().map_err(|source| Error::Spectrum {
            place: self.place_of(key),
            source,
        })
    }

    fn nested(&self, key: &str, table: &'d DeTable<'d>, offset: usize) -> Section<'d> {
        Section {
            document: self.document,
            table,
            name: format!("[{key}]"),
            place: self.document.place(offset),
        }
    }

    /// Returns the table `[key]`, or `None` if there is none. The table may have only the keys
    /// `known`.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not a table, and [`Error::UnknownKey`] if the
    /// table has another key.
    pub(crate) fn section(
        &self,
        key: &str,
        known: &[&'static str],
    ) -> Result<Option<Section<'d>>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(None);
        };
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self.wrong_type(key, "a table", value.get_ref()));
        };
        self.nested(key, table, value.span().start)
            .checked(known)
            .map(Some)
    }

    /// Returns the tables `[[key]]`, or an empty list if there are none. Each table may have only
    /// the keys `known`.
    ///
    /// # Errors
    /// Returns [`Error::WrongType`] if the value is not an array of tables, and
    /// [`Error::UnknownKey`] if one of the tables has another key.
    pub(crate) fn sections(
        &self,
        key: &str,
        known: &[&'static str],
    ) -> Result<Vec<Section<'d>>, Error> {
        let Some(value) = self.get(key) else {
            return Ok(Vec::new());
        };
        let expected = "one or more tables under a heading in double brackets";
        let wrong = |found: &DeValue<'_>| self.wrong_type(key, expected, found);
        let DeValue::Array(array) = value.get_ref() else {
            return Err(wrong(value.get_ref()));
        };
        let mut sections = Vec::with_capacity(array.len());
        for element in array.iter() {
            let DeValue::Table(table) = element.get_ref() else {
                return Err(wrong(element.get_ref()));
            };
            let mut section = self.nested(key, table, element.span().start);
            section.name = format!("[[{key}]]");
            sections.push(section.checked(known)?);
        }
        Ok(sections)
    }
}

/// One number for all entries, or one number per entry.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NumberOrTable {
    /// The one number for all entries.
    Number(f64),
    /// Key and number of each entry of a table.
    Table(Vec<(String, f64)>),
}

fn as_integer(value: &DeValue<'_>) -> Option<i64> {
    let integer = value.as_integer()?;
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        other => as_integer(other).map(|integer| integer as f64),
    }
}

fn type_name(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
