//! Checks of a table: against its mesh, against what it says of its bake, and against another one.

pub(super) mod claims;
pub(super) mod comparison;
pub(super) mod retrace;
