//! What a diagram shows, described once ([`Chart`]), and how it is drawn: as [`svg`], or in a [`page`]. Knows no file, no flight and
//! no analysis; builds for a browser too.

mod chart;
pub mod page;
mod palette;
mod places;
pub mod svg;

pub use chart::{Band, Chart, Level, Line, Moment, Role, Shade, Values};
pub use palette::Ink;
pub use places::common_places;
