//! Pages and figures that a browser shows.

mod compare;
mod explore;
mod figures;
mod report_page;
