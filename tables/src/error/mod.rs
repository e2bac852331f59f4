//! Errors of tables: typed, one sentence each, with the file, the place in it and the remedy.
//!
//! A fault that another room met enters. An [`error::Error`] leaves that says who can fix it. The
//! room touches the rules of a table, which are one kind of fault, and otherwise holds only types.

pub(crate) mod error;
pub(crate) mod mismatch;
pub(crate) mod no_direction;
pub(crate) mod output;
