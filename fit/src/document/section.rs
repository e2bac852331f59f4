//! The door of every TOML input: keys are looked up by name and type, and whatever is wrong is said
//! with its line.
//!
//! serde's own messages stop at "unknown field"; walking the parsed document keeps the line of
//! every key, so that an error can name the file, the line, the key and the nearest key that would
//! have been right.

use std::path::{Path, PathBuf};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::document::bounds::Bounds;
use crate::document::error::Error;
use crate::document::line::FileLine;
use crate::names::Spectrum;

/// The text of a TOML file and where it came from.
#[derive(Debug)]
pub(crate) struct Document {
    file: PathBuf,
    text: String,
}

/// Longest TOML that is read: ten times that of a thousand photographs.
const MOST_BYTES: u64 = 1 << 20;

impl Document {
    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::Read`] where the system does not give it, it is not UTF-8 or longer than a MiB.
    pub(crate) fn read(file: &Path) -> Result<Document, Error> {
        let text = crate::document::text::read(file, MOST_BYTES).map_err(|source| Error::Read {
            file: file.to_owned(),
            source,
        })?;
        Ok(Document {
            file: file.to_owned(),
            text,
        })
    }

    /// Parses it; duplicate keys are errors of syntax.
    ///
    /// # Errors
    /// [`Error::Syntax`] with the line of the first error.
    pub(crate) fn parse(&self) -> Result<Spanned<DeTable<'_>>, Error> {
        DeTable::parse(&self.text).map_err(|error| Error::Syntax {
            place: self.place(error.span().map_or(0, |span| span.start)),
            message: error.message().replace('\n', ", "),
        })
    }

    fn place(&self, offset: usize) -> FileLine {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        FileLine {
            file: self.file.clone(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
        }
    }
}

/// One table of a document, all of whose keys are known ones.
#[derive(Debug)]
pub(crate) struct Section<'d> {
    document: &'d Document,
    table: &'d DeTable<'d>,
    name: String,
    place: FileLine,
}

impl<'d> Section<'d> {
    /// The whole document as a table with no keys but `known`.
    ///
    /// # Errors
    /// [`Error::UnknownKey`].
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
            return Ok(self);
        };
        let distance = |candidate: &&str| strsim::damerau_levenshtein(candidate, key.get_ref());
        Err(Error::UnknownKey {
            place: self.document.place(key.span().start),
            key: key.get_ref().to_string(),
            section: self.name,
            nearest: known.iter().copied().min_by_key(distance).unwrap_or(""),
        })
    }

    /// Where the table begins.
    pub(crate) fn place(&self) -> &FileLine {
        &self.place
    }

    /// All keys of the table, in lexicographic order.
    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        self.table.keys().map(|key| key.get_ref().as_ref())
    }

    /// Where `key` is set; the table itself where it is not.
    pub(crate) fn place_of(&self, key: &str) -> FileLine {
        self.table
            .iter()
            .find(|(name, _)| name.get_ref() == key)
            .map_or_else(
                || self.place.clone(),
                |(name, _)| self.document.place(name.span().start),
            )
    }

    /// The value of `key`, or the error that it is missing.
    ///
    /// # Errors
    /// [`Error::Missing`].
    pub(crate) fn required<T>(&self, key: &'static str, value: Option<T>) -> Result<T, Error> {
        value.ok_or_else(|| Error::Missing {
            place: self.place.clone(),
            key,
            section: self.name.clone(),
        })
    }

    fn get(&self, key: &str) -> Option<&'d Spanned<DeValue<'d>>> {
        self.table.get(key)
    }

    fn wrong_type(&self, key: &str, expected: &'static str, found: &DeValue<'_>) -> Error {
        Error::WrongType {
            place: self.place_of(key),
            key: key.to_owned(),
            expected,
            found: type_name(found),
        }
    }

    /// A finite number within `bounds`; integers count.
    ///
    /// # Errors
    /// [`Error::WrongType`], [`Error::OutOfRange`] (also for NaN and infinities).
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

    /// A whole number from `least` up to the largest that f64 holds exactly.
    ///
    /// # Errors
    /// [`Error::WrongType`], [`Error::OutOfRange`].
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

    /// `true` or `false`.
    ///
    /// # Errors
    /// [`Error::WrongType`].
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

    /// A string.
    ///
    /// # Errors
    /// [`Error::WrongType`].
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

    /// A string that is one of `names`, as `parse` understands them.
    ///
    /// # Errors
    /// [`Error::WrongType`], [`Error::UnknownName`].
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

    /// Strings that are each one of `names`, at least one.
    ///
    /// # Errors
    /// [`Error::WrongType`], [`Error::UnknownName`].
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

    /// `N` whole numbers, 0 or greater.
    ///
    /// # Errors
    /// [`Error::WrongType`] where it is not an array of that many whole numbers,
    /// [`Error::OutOfRange`].
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

    /// Three finite numbers.
    ///
    /// # Errors
    /// [`Error::WrongType`] where it is not an array of three numbers, [`Error::OutOfRange`].
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

    /// The number or the table of numbers under `key`: `Err(section)` of the answer is the table.
    ///
    /// # Errors
    /// As [`Section::number`].
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

    /// The spectrum under the key `wavelength_nm`: a number, or text as [`Spectrum::parse`] reads
    /// it.
    ///
    /// # Errors
    /// [`Error::Spectrum`], or that the value is neither.
    pub(crate) fn spectrum(&self) -> Result<Option<Spectrum>, Error> {
        let key = "wavelength_nm";
        let spectrum = match self.text(key) {
            Ok(None) => None,
            Ok(Some(text)) => Some(Spectrum::parse(text)),
            // Not a string: a number is as good, and the message of `number` covers the rest.
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

    /// The table `[key]` with no keys but `known`.
    ///
    /// # Errors
    /// [`Error::WrongType`], [`Error::UnknownKey`].
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

    /// The tables `[[key]]` with no keys but `known`; empty where there is none.
    ///
    /// # Errors
    /// [`Error::WrongType`], [`Error::UnknownKey`].
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

/// One number for all, or one per entry of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NumberOrTable {
    /// The one number.
    Number(f64),
    /// Key and number of each entry.
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
