//! The `bake` program.
