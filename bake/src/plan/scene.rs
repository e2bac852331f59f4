//! Options that a scene names only where it has what they are for. Each costs nothing where it is left out.

use crate::optics::element::Element;
use crate::optics::roughness::Roughness;
use crate::plan::plan::Record;
use clap::{Args, Parser};
use std::fmt;

/// Which normals facets reflect about.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Normals {
    /// Their own: facets are planes.
    #[default]
    Facets,
    /// Those of the mesh file, interpolated between a facet's corners: facets stand for a curved face.
    File,
}

/// The options. A table holds those that are not at their default, as typed ([`fmt::Display`], [`SceneOptions::read`]).
#[derive(Debug, Clone, Copy, Default, PartialEq, Args)]
pub struct SceneOptions {
    /// Which normals facets reflect about
    #[arg(long, value_enum, default_value_t = Normals::Facets)]
    pub normals: Normals,
    /// Roughness of the facets, whose normals are drawn at each reflection: alpha of Beckmann's slopes (sqrt 2 times their rms)
    /// or ggx:ALPHA
    #[arg(long, value_name = "ALPHA", allow_negative_numbers = true)]
    pub roughness: Option<Roughness>,
    /// Records where the light of rays goes, jointly with its shift: auto where the cell is not ideal, off, or bins over plus and
    /// minus so many mrad
    #[arg(long, value_name = "MRAD", default_value_t = Record::Auto)]
    pub deviations: Record,
    /// What the mesh is to do with light
    #[arg(long, value_enum, default_value_t = Element::Retroreflector)]
    pub element: Element,
    /// Refractive index of bodies of glass: light goes through faces of the material named glass, wound outward, and every other
    /// face is a mirror on both sides. Retroreflected is then what leaves straight back within --angular-tolerance
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub glass_index: Option<f64>,
}

impl SceneOptions {
    /// The option that leaves no plane mirrors for the exact method, as typed.
    pub fn no_planes(&self) -> Option<String> {
        let of_rays = SceneOptions {
            deviations: Record::Auto,
            element: Element::default(),
            ..*self
        };
        Some(of_rays.to_string()).filter(|option| !option.is_empty())
    }

    /// The options of `text`, as a table has them; `None` where this program does not know them.
    pub fn read(text: &str) -> Option<SceneOptions> {
        let words = std::iter::once("table").chain(text.split_whitespace());
        let Alone { options } = Alone::try_parse_from(words).ok()?;
        Some(options)
    }
}

#[derive(Parser)]
struct Alone {
    #[command(flatten)]
    options: SceneOptions,
}

impl fmt::Display for SceneOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut named = Vec::new();
        if self.normals == Normals::File {
            named.push("--normals file".to_owned());
        }
        if let Some(roughness) = self.roughness {
            named.push(format!("--roughness {roughness}"));
        }
        if self.deviations != Record::Auto {
            named.push(format!("--deviations {}", self.deviations));
        }
        if self.element != Element::default() {
            named.push(format!("--element {}", self.element.name()));
        }
        if let Some(index) = self.glass_index {
            named.push(format!("--glass-index {index}"));
        }
        f.write_str(&named.join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::roughness::Slopes;

    #[test]
    fn what_a_table_says_is_read_back() {
        let cases = [
            SceneOptions::default(),
            SceneOptions {
                normals: Normals::File,
                ..SceneOptions::default()
            },
            SceneOptions {
                roughness: Roughness::new(Slopes::Beckmann, 0.001).ok(),
                ..SceneOptions::default()
            },
            SceneOptions {
                roughness: Roughness::new(Slopes::Ggx, 1.0 / 3.0).ok(),
                ..SceneOptions::default()
            },
            SceneOptions {
                deviations: Record::Off,
                ..SceneOptions::default()
            },
            SceneOptions {
                normals: Normals::File,
                deviations: Record::Within(2.5),
                ..SceneOptions::default()
            },
            SceneOptions {
                element: Element::Plate,
                ..SceneOptions::default()
            },
            SceneOptions {
                glass_index: Some(1.93),
                ..SceneOptions::default()
            },
        ];
        for options in cases {
            let text = options.to_string();
            assert_eq!(SceneOptions::read(&text), Some(options), "{text}");
        }
        assert_eq!(SceneOptions::default().to_string(), "");
        assert_eq!(SceneOptions::read("--of-a-later-version 3"), None);
    }
}
