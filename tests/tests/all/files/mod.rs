//! Files: what is refused, what is kept, and what a stranger cannot do.

mod bad_inputs;
mod caps;
mod corpus;
mod forged;
mod hostile;
pub(crate) mod kills;
mod reader;
mod streams;
mod together;
