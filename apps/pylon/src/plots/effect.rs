//! What an effect looks like.

use view::svg::{Legends, range, sheet, stack};
use view::{Chart, Moment, Role};

use super::PlotError;
use crate::effect_guide::Picture;

/// Draws an effect's picture (SVG).
///
/// # Errors
/// [`PlotError::Drawing`].
pub fn draw_effect(picture: &Picture) -> Result<String, PlotError> {
    let end_s = picture.time_s.last().copied().unwrap_or(1.0).max(1.0);
    let chart = |values: &[f64], y_name: String, role| {
        let y_range = range(values.iter().copied());
        let column = values.iter().copied().map(Some).collect();
        let mut chart = Chart::new(String::new(), String::new(), "time, s", y_name, picture.time_s.clone())
            .line("", role, column);
        chart.moments.push(Moment { name: "launch".to_owned(), role: Role::Event, x: picture.launch_s });
        chart.x_range = Some([0.0, end_s]);
        chart.y_range = Some([y_range.start, y_range.end]);
        chart
    };
    let charts = [
        chart(&picture.altitude_m, "altitude, m".to_owned(), Role::Measured),
        chart(&picture.error_m, format!("error of {}, m", picture.victim()), Role::Effect),
    ];
    let caption = picture.caption();
    let (first, second) = caption.split_once("; ").unwrap_or((&caption, ""));
    let lines = [first.to_owned(), second.to_owned()];
    sheet(&format!("What {} looks like", picture.effect.name()), lines, &stack(&charts, Legends::Each))
        .map_err(|reason| PlotError::Drawing { figure: "the effect's picture", reason })
}
