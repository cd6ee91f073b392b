//! What an effect looks like.

use view::svg::{BLUE, GREY, Layer, MAGENTA, Panel, range, sheet};

use super::PlotError;
use crate::effect_guide::Picture;

/// Draws an effect's picture (SVG).
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn draw_effect(picture: &Picture) -> Result<String, PlotError> {
    let x_range = 0.0..picture.time_s.last().copied().unwrap_or(1.0).max(1.0);
    let panel = |values: &[f64], x_name, y_name: String, colour| Panel {
        x_range: x_range.clone(),
        y_range: range(values.iter().copied()),
        x_name,
        y_name,
        has_legend: true,
        layers: vec![
            Layer::Curve {
                points: picture.time_s.iter().copied().zip(values.iter().copied()).collect(),
                colour,
                width: 2,
                name: "",
            },
            Layer::Moment { at: picture.launch_s, colour: MAGENTA, name: "launch".to_owned() },
        ],
    };
    let panels = [
        panel(&picture.altitude_m, "", "altitude, m".to_owned(), GREY),
        panel(&picture.error_m, "time, s", format!("error of {}, m", picture.victim()), BLUE),
    ];
    let caption = picture.caption();
    let (first, second) = caption.split_once("; ").unwrap_or((&caption, ""));
    let lines = [first.to_owned(), second.to_owned()];
    sheet(&format!("What {} looks like", picture.effect.name()), lines, &panels)
        .map_err(|reason| PlotError::Drawing { figure: "the effect's picture", reason })
}
