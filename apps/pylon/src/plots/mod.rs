//! The paper's Figures 2, 3 and 4, drawn for any flight (SVG).

mod calibration;
mod effect;
mod envelope;
mod figure;
mod free_flight;
mod law;
mod residuals;

use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;
use view::svg::DrawingError;

pub use effect::draw_effect;
pub use law::draw_laws;

use crate::compare::{Comparison, Traces};
use crate::output_file::{OutputError, write_atomically};

/// Why figures were not drawn.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PlotError {
    /// The directory could not be made.
    #[error("{}: cannot create the directory: {reason}", directory.display())]
    Directory {
        /// The directory.
        directory: PathBuf,
        /// Why not.
        #[source]
        reason: std::io::Error,
    },
    /// A figure could not be drawn.
    #[error("{figure}: cannot be drawn: {reason}")]
    Drawing {
        /// The figure's file name.
        figure: &'static str,
        /// Why not.
        #[source]
        reason: DrawingError,
    },
    /// A figure could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Figure 2: the estimated parameters over captive flight.
pub const CALIBRATION: &str = "figure-2-calibration.svg";
/// Figure 3: the residuals over captive flight.
pub const RESIDUALS: &str = "figure-3-residuals.svg";
/// Figure 4: the errors in free flight.
pub const FREE_FLIGHT: &str = "figure-4-free-flight.svg";

/// Draws the figures that the flight has data for into `directory`, which is made if need be, and returns the
/// files written. All are drawn before the first is written.
///
/// # Errors
/// [`PlotError`].
pub fn draw(directory: &Path, comparison: &Comparison, traces: &Traces) -> Result<Vec<PathBuf>, PlotError> {
    let figures = [
        (CALIBRATION, calibration::draw(comparison, traces)),
        (RESIDUALS, residuals::draw(comparison, traces)),
        (FREE_FLIGHT, free_flight::draw(comparison, traces)),
    ];
    let mut drawn = Vec::new();
    for (figure, svg) in figures {
        match svg {
            None => {}
            Some(Ok(svg)) => drawn.push((figure, svg)),
            Some(Err(reason)) => return Err(PlotError::Drawing { figure, reason }),
        }
    }
    fs::create_dir_all(directory)
        .map_err(|reason| PlotError::Directory { directory: directory.to_path_buf(), reason })?;
    let mut files = Vec::new();
    for (figure, svg) in drawn {
        let file = directory.join(figure);
        write_atomically(&file, |out| out.write_all(svg.as_bytes()))?;
        files.push(file);
    }
    Ok(files)
}
