//! Word of a table.

use std::fmt;

/// Values that have a name each, one for the command line and for tables.
pub trait Named: Copy + 'static {
    /// All values of the type.
    const ALL: &'static [Self];

    /// Returns the name of this value.
    fn name(self) -> &'static str;
}

/// Word of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Word<T> {
    /// Value that this version knows.
    Known(T),
    /// Word of a later version, kept as it is.
    Other(String),
}

impl<T: Named> Word<T> {
    /// Reads a word of a table.
    pub(crate) fn read(text: String) -> Word<T> {
        let known = T::ALL.iter().find(|value| value.name() == text);
        known.map_or(Word::Other(text), |value| Word::Known(*value))
    }

    /// Returns the word as it stands in the file.
    pub fn text(&self) -> &str {
        match self {
            Word::Known(value) => value.name(),
            Word::Other(text) => text,
        }
    }

    /// Returns the value, or `None` if this version does not know the word.
    pub fn known(&self) -> Option<T> {
        match self {
            Word::Known(value) => Some(*value),
            Word::Other(_) => None,
        }
    }

    /// Returns whether the word is this value.
    pub fn is(&self, value: T) -> bool
    where
        T: PartialEq,
    {
        self.known() == Some(value)
    }
}

impl<T> From<T> for Word<T> {
    fn from(value: T) -> Word<T> {
        Word::Known(value)
    }
}

impl<T: Named> fmt::Display for Word<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Back;

    #[test]
    fn every_word_is_kept() {
        for (text, known) in [
            ("mirror", Some(Back::Mirror)),
            ("tir", Some(Back::Tir)),
            ("TIR", None),
            ("", None),
            ("of a later version", None),
        ] {
            let word = Word::<Back>::read(text.into());
            assert_eq!((word.text(), word.known()), (text, known));
            assert_eq!(Word::read(word.to_string()), word);
        }
        assert!(Word::from(Back::Tir).is(Back::Tir) && !Word::from(Back::Tir).is(Back::Mirror));
    }
}
