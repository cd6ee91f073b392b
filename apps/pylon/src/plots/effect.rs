//! Draws an effect's picture.

use view::svg::{Legends, sheet, stack};

use super::PlotError;
use crate::effect_guide::Picture;

/// Draws an effect's picture (SVG).
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn draw_effect(picture: &Picture) -> Result<String, PlotError> {
    let caption = picture.caption();
    let (first, second) = caption.split_once("; ").unwrap_or((&caption, ""));
    let lines = [first.to_owned(), second.to_owned()];
    sheet(
        &format!("What {} looks like", picture.effect.name()),
        lines,
        &stack(&picture.charts(), Legends::Each),
    )
    .map_err(|reason| PlotError::Drawing { figure: "the effect's picture", reason })
}
