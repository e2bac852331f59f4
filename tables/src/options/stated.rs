//! Options that a table states.

use std::fmt;

use crate::options::scene::SceneOptions;
use crate::options::scene::{DEVIATIONS, ELEMENT, FRONT, GLASS_INDEX, NORMALS, ROUGHNESS};
use crate::options::values::{Element, Front, NormalsFrom};
use crate::options::word::{Named, Word};

/// Options that a table states: the text, which is kept as it is, and the options that this version
/// knows.
#[derive(Debug, Clone)]
pub struct StatedOptions {
    text: String,
    understood: SceneOptions,
    /// True if this version knows all of the text.
    whole: bool,
}

/// Two records are equal if their texts are equal.
impl PartialEq for StatedOptions {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl StatedOptions {
    /// Returns the record of no options: all are at their default.
    pub fn none() -> StatedOptions {
        SceneOptions::default().into()
    }

    /// Returns the text as it stands in the file; empty if all options are at their default.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the options, or `None` if a later version wrote some that this version does not
    /// know.
    pub fn known(&self) -> Option<SceneOptions> {
        self.whole.then_some(self.understood)
    }

    /// Returns the optical element, as far as this version knows it.
    pub fn element(&self) -> Element {
        self.understood.element
    }

    /// Returns the treatment of light at the front face, as far as this version knows it.
    pub fn front(&self) -> Front {
        self.understood.front
    }

    /// Returns whether light went through bodies of glass, whatever their index.
    pub fn has_glass(&self) -> bool {
        let mut words = self.text.split_whitespace();
        words.any(|word| word == GLASS_INDEX) || self.understood.glass_index.is_some()
    }

    /// Returns the text of the options that make a cell.
    ///
    /// Options are left out that say how light is recorded, not where it goes.
    pub fn of_the_cell(&self) -> String {
        let mut left_out = false;
        let kept = self.text.split_whitespace().filter(|word| {
            let value = left_out;
            left_out = *word == DEVIATIONS;
            !value && !left_out
        });
        kept.collect::<Vec<_>>().join(" ")
    }
}

impl Default for StatedOptions {
    fn default() -> Self {
        StatedOptions::none()
    }
}

impl From<SceneOptions> for StatedOptions {
    fn from(options: SceneOptions) -> Self {
        StatedOptions {
            text: options.to_string(),
            understood: options,
            whole: true,
        }
    }
}

impl From<&str> for StatedOptions {
    fn from(text: &str) -> Self {
        let mut understood = SceneOptions::default();
        let mut whole = true;
        let mut seen = Vec::new();
        let mut words = text.split_whitespace();
        while let Some(word) = words.next() {
            let (name, value) = match word.split_once('=') {
                Some((name, value)) => (name, Some(value)),
                None => (word, None),
            };
            let names = [NORMALS, ROUGHNESS, DEVIATIONS, ELEMENT, GLASS_INDEX, FRONT];
            if !names.contains(&name) {
                whole = false;
                continue;
            }
            let value = value.or_else(|| words.next()).unwrap_or_default();
            whole &= !seen.contains(&name) && take(&mut understood, name, value).is_some();
            seen.push(name);
        }
        StatedOptions {
            text: text.to_owned(),
            understood,
            whole,
        }
    }
}

/// Sets the option `name`, one of the six known names; `None` if this version does not know the
/// value.
fn take(options: &mut SceneOptions, name: &str, value: &str) -> Option<()> {
    match name {
        NORMALS => options.normals = word::<NormalsFrom>(value)?,
        ROUGHNESS => options.roughness = Some(value.parse().ok()?),
        DEVIATIONS => options.deviations = value.parse().ok()?,
        ELEMENT => options.element = word(value)?,
        FRONT => options.front = word(value)?,
        _ => options.glass_index = Some(value.parse().ok()?),
    }
    Some(())
}

/// Reads a named value; `None` if this version does not know it.
fn word<T: Named>(text: &str) -> Option<T> {
    Word::read(text.to_owned()).known()
}

impl fmt::Display for StatedOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{Record, Roughness, Slopes};

    #[test]
    fn what_a_table_says_is_read_back() {
        let plain = SceneOptions::default();
        let rough = |slopes, alpha| SceneOptions {
            roughness: Roughness::new(slopes, alpha).ok(),
            ..plain
        };
        let cases = [
            plain,
            SceneOptions {
                normals: NormalsFrom::File,
                ..plain
            },
            rough(Slopes::Beckmann, 0.001),
            rough(Slopes::Ggx, 1.0 / 3.0),
            SceneOptions {
                deviations: Record::Off,
                ..plain
            },
            SceneOptions {
                normals: NormalsFrom::File,
                deviations: Record::Within(2.5),
                ..plain
            },
            SceneOptions {
                element: Element::Plate,
                ..plain
            },
            SceneOptions {
                glass_index: Some(1.93),
                ..plain
            },
            SceneOptions {
                front: Front::Trapped,
                ..plain
            },
        ];
        for options in cases {
            let stated = StatedOptions::from(options);
            let read = StatedOptions::from(stated.text());
            assert_eq!(read, stated);
            assert_eq!(read.known(), Some(options), "{stated}");
            assert_eq!(read.has_glass(), options.glass_index.is_some());
            assert_eq!(read.front(), options.front);
        }
        assert_eq!(StatedOptions::none().text(), "");
    }

    #[test]
    fn options_of_a_later_version_are_kept() {
        let cases = [
            ("--of-a-later-version 3", Element::Retroreflector, false),
            ("--coating 3 --element plate", Element::Plate, false),
            ("--element lens", Element::Retroreflector, false),
            ("--glass-index bk7", Element::Retroreflector, true),
            ("--element", Element::Retroreflector, false),
            ("--element plate --element plate", Element::Plate, false),
        ];
        for (text, element, glass) in cases {
            let read = StatedOptions::from(text);
            assert_eq!(read.known(), None, "{text}");
            assert_eq!(read.text(), text);
            assert_eq!((read.element(), read.has_glass()), (element, glass));
        }
        // The text is not as `bake` writes it, and is kept nevertheless.
        let read = StatedOptions::from("--element=plate  --normals facets");
        let plate = SceneOptions {
            element: Element::Plate,
            ..SceneOptions::default()
        };
        assert_eq!(read.known(), Some(plate));
        assert_eq!(read.text(), "--element=plate  --normals facets");
    }

    #[test]
    fn a_cell_is_not_how_its_light_is_recorded() {
        for (text, cell) in [
            ("", ""),
            ("--deviations off", ""),
            ("--roughness 0.001 --deviations 2.5", "--roughness 0.001"),
            ("--deviations off --element plate", "--element plate"),
            ("--later 3 --deviations off", "--later 3"),
        ] {
            assert_eq!(StatedOptions::from(text).of_the_cell(), cell);
        }
    }
}
