//! Diagrams as SVG: a sheet of panels, one above the other.

mod canvas;
mod chart;
mod legend;
mod panel;

use plotters::prelude::{DrawingAreaErrorKind, DrawingBackend, SVGBackend};
use thiserror::Error;

pub use canvas::sheet;
pub use chart::{Legends, stack};
pub use panel::{
    BLACK, BLUE, GREEN, GREY, LIGHT_BLUE, Layer, MAGENTA, ORANGE, PALE_BLUE, PALE_GREY, Panel, range,
};

/// A colour: red, green and blue.
pub type Colour = plotters::style::RGBColor;

/// Why a sheet was not drawn.
#[derive(Debug, Error)]
#[error(transparent)]
pub struct DrawingError(#[from] DrawingAreaErrorKind<<SVGBackend<'static> as DrawingBackend>::ErrorType>);
