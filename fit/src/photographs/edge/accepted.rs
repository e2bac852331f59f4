//! Faults of an edge that a user takes as they are.

/// A refusal that a user who knows better may overrule; a warning is left of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Accepted {
    /// A second edge: [`Fault::Doubled`](crate::photographs::edge::fault::Fault::Doubled).
    Doubled,
}

impl Accepted {
    /// The names that a manifest may use, in the order of the variants.
    pub const NAMES: [&'static str; 1] = ["doubled"];

    /// What is called `name` in a manifest.
    pub fn from_name(name: &str) -> Option<Accepted> {
        (name == "doubled").then_some(Accepted::Doubled)
    }
}
