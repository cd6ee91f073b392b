//! A figure of a flight, with the heading that all figures share.

use view::Chart;
use view::svg::{DrawingError, Legends, sheet, stack};

use crate::compare::Comparison;

/// Draws a figure: a title, the source of the data, and the diagrams, one above the other.
pub(super) fn figure(
    title: &str,
    comparison: &Comparison,
    charts: &[Chart],
    legends: Legends,
) -> Result<String, DrawingError> {
    sheet(title, subtitles(comparison), &stack(charts, legends))
}

/// Flight, model and the source of the data: a figure states whether they were measured.
fn subtitles(comparison: &Comparison) -> [String; 2] {
    let flight = &comparison.flight;
    let file = std::path::Path::new(&flight.file)
        .file_name()
        .map_or_else(|| flight.file.clone(), |name| name.to_string_lossy().into_owned());
    let source = if flight.source.is_empty() { "not stated" } else { &flight.source };
    [format!("{file}, model {}", comparison.model), format!("source: {source}")]
}
