//! Describes a chart ([`Chart`]) or a table ([`Table`]) once, and draws it as [`svg`], in a [`page`], or as
//! [`text`]. It depends on no file, flight or analysis, and also builds for a browser.

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
