//! What a chart ([`Chart`]) or a table ([`Table`]) shows, described once, and how it is drawn: as [`svg`], in
//! a [`page`], or as [`text`]. Knows no file, no flight and no analysis; builds for a browser too.

mod chart;
pub mod page;
mod palette;
mod places;
pub mod svg;
mod table;
pub mod text;

pub use chart::{Band, Chart, Level, Line, Moment, Role, Shade, Values};
pub use palette::Ink;
pub use places::common_places;
pub use table::{Align, Cell, Column, Row, Table, Tone};
