//! The `bake` program.

fn main() {}
