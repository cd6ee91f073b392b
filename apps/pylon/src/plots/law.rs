//! Draws a law: measured against law, and the remainder against each of its signals.

use std::fs;
use std::path::{Path, PathBuf};

use analysis::discover::{Discovery, FoundLaw, PictureSignal};

use crate::discover::significant;
use view::svg::{BLUE, DrawingError, GREY, Layer, ORANGE, PALE_BLUE, Panel, range, sheet};

use super::PlotError;
use crate::output_file::write_atomically;

/// Bins of a diagram, each with the same number of blocks.
const BINS: usize = 24;
/// A bin's band holds the middle 80 % of its blocks: this share is left out on each side.
const OUTSIDE: f64 = 0.1;

/// Draws `law-1.svg` and so on into `directory`, which is made if need be, and returns the files written. All
/// are drawn before the first is written.
///
/// # Errors
/// [`PlotError`].
pub fn draw_laws(directory: &Path, discovery: &Discovery) -> Result<Vec<PathBuf>, PlotError> {
    let draw = |(k, law)| {
        let svg = draw_law(discovery, law, k + 1);
        svg.map_err(|reason| PlotError::Drawing { figure: "the picture of a law", reason })
    };
    let drawn: Vec<String> = discovery.laws.iter().enumerate().map(draw).collect::<Result<_, _>>()?;
    fs::create_dir_all(directory)
        .map_err(|reason| PlotError::Directory { directory: directory.to_path_buf(), reason })?;
    let write = |(k, svg): (usize, &String)| {
        let file = directory.join(format!("law-{}.svg", k + 1));
        write_atomically(&file, |out| out.write_all(svg.as_bytes()))?;
        Ok(file)
    };
    drawn.iter().enumerate().map(write).collect()
}

fn draw_law(discovery: &Discovery, law: &FoundLaw, number: usize) -> Result<String, DrawingError> {
    let picture = &law.picture;
    let mut against_law = Binned::new(&picture.law_m, &picture.measured_m)
        .panel("law, m", format!("measured on {}, m", law.on));
    let ends = range(picture.law_m.iter().copied());
    against_law.layers.push(Layer::Curve {
        points: vec![(ends.start, ends.start), (ends.end, ends.end)],
        colour: ORANGE,
        width: 2,
        name: "the law",
    });
    let mut panels = vec![against_law];
    let rest_m = picture.rest_m();
    let with_unit = |signal: &PictureSignal| match signal.unit.as_str() {
        "1" => signal.name.clone(),
        unit => format!("{}, {unit}", signal.name),
    };
    let names: Vec<String> = picture.signals.iter().map(with_unit).collect();
    for (signal, name) in picture.signals.iter().zip(&names) {
        let mut panel = Binned::new(&signal.values, &rest_m).panel(name, "left by it, m".to_owned());
        panel.layers.push(Layer::Level { value: 0.0, colour: GREY, name: "" });
        panels.push(panel);
    }
    let title = format!("{number}. {} += c * {}", law.on, law.regressor);
    let lines = [
        format!("c = {} +- {} {}", significant(law.coefficient), significant(law.sigma), law.unit),
        format!("{}, model {}", discovery.flights.join(", "), discovery.model),
    ];
    sheet(&title, lines, &panels)
}

/// Blocks in bins of equal count, ordered by the quantity of the horizontal axis.
struct Binned {
    /// For each bin: the means of both quantities, and the inner range of the vertical one.
    bins: Vec<(f64, f64, [f64; 2])>,
}

impl Binned {
    fn new(x: &[f64], y: &[f64]) -> Self {
        let mut pairs: Vec<(f64, f64)> = x
            .iter()
            .copied()
            .zip(y.iter().copied())
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let size = pairs.len().div_ceil(BINS).max(1);
        // Blocks at the same place share a bin: a retracted flap, for example, is always at one place.
        let mut bins = Vec::new();
        let mut rest = pairs.as_slice();
        while let Some(last) = rest.get(size.min(rest.len()).wrapping_sub(1)) {
            let end = rest.partition_point(|pair| pair.0 <= last.0);
            let (bin, after) = rest.split_at(end);
            rest = after;
            let count = bin.len() as f64;
            let mut values: Vec<f64> = bin.iter().map(|pair| pair.1).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
            bins.push((
                bin.iter().map(|pair| pair.0).sum::<f64>() / count,
                values.iter().sum::<f64>() / count,
                [at(OUTSIDE), at(1.0 - OUTSIDE)],
            ));
        }
        Self { bins }
    }

    fn panel<'a>(&self, x_name: &'a str, y_name: String) -> Panel<'a> {
        let bins = || self.bins.iter();
        Panel {
            x_range: range(bins().map(|bin| bin.0)),
            y_range: range(bins().flat_map(|bin| bin.2)),
            x_name,
            y_name,
            has_legend: true,
            layers: vec![
                Layer::Band {
                    from: bins().map(|bin| (bin.0, bin.2[0])).collect(),
                    to: bins().map(|bin| (bin.0, bin.2[1])).collect(),
                    colour: PALE_BLUE,
                    name: "middle 80 % of the blocks",
                },
                Layer::Curve {
                    points: bins().map(|bin| (bin.0, bin.1)).collect(),
                    colour: BLUE,
                    width: 3,
                    name: "mean",
                },
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_the_same_place_is_one_bin_and_none_is_lost() {
        let x: Vec<f64> = (0..480).map(|k| if k < 240 { 0.0 } else { f64::from(k) }).collect();
        let y: Vec<f64> = (0..480).map(f64::from).collect();
        let binned = Binned::new(&x, &y);
        assert_eq!(binned.bins.len(), 13, "240 of one place, and 12 bins of 20");
        assert_eq!(binned.bins[0], (0.0, 119.5, [24.0, 215.0]));
        assert!((binned.bins[12].0 - 469.5).abs() < 1e-9);
        assert!(Binned::new(&[f64::NAN], &[1.0]).bins.is_empty());
    }
}
