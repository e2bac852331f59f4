//! Faults of an edge that the user may accept.

/// A fault that the user may accept. It then becomes a warning instead of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Accepted {
    /// A second edge: [`Fault::Doubled`](crate::photographs::edge::fault::Fault::Doubled).
    Doubled,
}

impl Accepted {
    /// The names that a manifest may use, in the order of the variants.
    pub const NAMES: [&'static str; 1] = ["doubled"];

    /// Returns the fault that has this name in a manifest, or `None`.
    pub fn from_name(name: &str) -> Option<Accepted> {
        (name == "doubled").then_some(Accepted::Doubled)
    }
}
