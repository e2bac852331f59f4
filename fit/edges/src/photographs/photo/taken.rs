//! The relation between stored values and light that was taken for a photograph.

use crate::photographs::photo::{Curve, Transfer};

/// A relation between stored values and light, and who named it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Taken {
    /// Name of the relation: `linear`, `sRGB`, `BT.709`, `gamma` with an exponent, or `tone curve`.
    pub name: String,
    /// Origin of the relation: the key or option `transfer`, a part of the file, or the default of
    /// the format.
    pub from: String,
}

impl Default for Taken {
    /// Returns the relation of a photograph that never was a file: linear light.
    fn default() -> Taken {
        Taken::linear("memory")
    }
}

impl Taken {
    /// Returns the linear relation, as named by `from`.
    pub(crate) fn linear(from: &str) -> Taken {
        Taken {
            name: Curve::Named(Transfer::Linear).name(),
            from: from.into(),
        }
    }
}

impl std::fmt::Display for Taken {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} ({})", self.name, self.from)
    }
}

/// Name of the key and of the option by which a user chooses the relation.
pub(crate) const GIVEN: &str = "given as `transfer`";

/// The curves of a photograph: one for all channels, or one for each of red, green and blue.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curves {
    /// One curve, or three.
    pub(crate) each: Vec<Curve>,
    /// Origin of the curves.
    pub(crate) from: String,
    /// Warning about a statement of the file that names no curve.
    pub(crate) doubt: Option<String>,
}

impl Curves {
    /// Returns one curve for all channels.
    pub(crate) fn one(curve: Curve, from: impl Into<String>) -> Curves {
        Curves {
            each: vec![curve],
            from: from.into(),
            doubt: None,
        }
    }

    /// Returns the curve of a channel.
    pub(crate) fn of(&self, channel: usize) -> &Curve {
        &self.each[channel.min(self.each.len() - 1)]
    }

    /// Returns whether all channels are linear.
    pub(crate) fn are_linear(&self) -> bool {
        self.each.iter().all(Curve::is_linear)
    }

    /// Returns the name and the origin of the curves.
    pub(crate) fn taken(&self) -> Taken {
        let first = self.each[0].name();
        let alike = self.each.iter().all(|curve| curve.name() == first);
        Taken {
            name: if alike { first } else { "tone curve".into() },
            from: self.from.clone(),
        }
    }
}
