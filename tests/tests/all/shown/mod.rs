//! Pages that a browser shows.

mod explore;
mod report_page;
