//! Curves on one time axis, thinned out without changing how they look.

use std::ops::Range;
use std::rc::Rc;

use crate::curve::{Curve, Flown, curve};
use crate::engine::{Attachments, Engine, Progress, Refused, refused};
use crate::protocol::{Drawn, Series, SeriesRequest};

/// Rows read between checks whether there are too many values to draw each.
const ROWS_AT_ONCE: usize = 1 << 15;
/// More pixels than any screen has.
const MOST_PIXELS: u32 = 16_384;

/// One curve on the axis.
#[derive(Debug, Default, PartialEq)]
pub struct OnAxis {
    /// Least value at each point; NaN where there is none.
    pub least: Vec<f64>,
    /// Greatest value.
    pub greatest: Vec<f64>,
    /// Largest sigma, if the curve has one.
    pub sigma: Option<Vec<f64>>,
}

/// The requested curves.
pub fn series(
    engine: &mut Engine,
    request: SeriesRequest,
    attachments: &mut Attachments,
    progress: &mut Progress<'_>,
) -> Result<Series, Refused> {
    let SeriesRequest { flight, model, times: given, signals, from_s, to_s, pixels } = request;
    if !(1..=MOST_PIXELS).contains(&pixels) {
        return Err(refused(format!("{pixels} pixels, expected 1 to {MOST_PIXELS}")));
    }
    let times = &engine.flight(&flight)?.flight.time_s;
    let from_s = from_s.unwrap_or_else(|| times.iter().copied().fold(f64::INFINITY, f64::min));
    let to_s = to_s.unwrap_or_else(|| times.iter().copied().fold(f64::NEG_INFINITY, f64::max));
    if !(from_s.is_finite() && to_s.is_finite() && from_s <= to_s) {
        return Err(refused(format!("no time from {from_s} s to {to_s} s")));
    }
    let flown = Flown { flight: &flight, model: &model, times: given };
    let curves: Result<Vec<Rc<Curve>>, Refused> =
        signals.iter().map(|signal| curve(engine, &flown, signal, progress)).collect();
    let curves = curves?;
    let axis = Axis::new(&curves, (from_s, to_s), pixels);
    let time_s = attachments.put(axis.times());
    let drawn = signals.into_iter().zip(&curves).map(|(signal, curve)| {
        let range = curve.range(from_s, to_s);
        let on_axis = axis.put(curve, range.clone());
        let (gaps_s, values) = gaps(curve, range, axis.width_s());
        let least = attachments.put(on_axis.least);
        let greatest = if axis.is_thinned() { attachments.put(on_axis.greatest) } else { least };
        Drawn {
            signal,
            unit: curve.unit.to_owned(),
            least,
            greatest,
            sigma: on_axis.sigma.map(|sigma| attachments.put(sigma)),
            gaps_s: attachments.put(gaps_s),
            values,
        }
    });
    let curves = drawn.collect();
    Ok(Series { time_s, is_thinned: axis.is_thinned(), curves })
}

/// The points of a time axis.
enum Axis {
    /// Every value's own time.
    Exact(Vec<f64>),
    /// This many slots of equal width, starting at `from_s`.
    Slots { from_s: f64, width_s: f64, slots: usize },
}

impl Axis {
    /// Each value's own time if there are at most two of them per pixel, otherwise one slot per pixel.
    fn new(curves: &[Rc<Curve>], (from_s, to_s): (f64, f64), pixels: u32) -> Self {
        let most = 2 * pixels as usize;
        let mut times = Vec::new();
        for curve in curves {
            let range = curve.range(from_s, to_s);
            let mut own = Vec::new();
            // Many rows may hold few values; if they hold many, the first rows already show it.
            for start in range.clone().step_by(ROWS_AT_ONCE) {
                let rows = start..(start + ROWS_AT_ONCE).min(range.end);
                curve.each(rows, &mut |_, time_s, _| own.push(time_s));
                if own.len() > most {
                    break;
                }
            }
            times.append(&mut own);
            times.sort_by(f64::total_cmp);
            times.dedup();
            if times.len() > most {
                let width_s = ((to_s - from_s) / f64::from(pixels)).max(f64::MIN_POSITIVE);
                return Self::Slots { from_s, width_s, slots: pixels as usize };
            }
        }
        Self::Exact(times)
    }

    const fn is_thinned(&self) -> bool {
        matches!(self, Self::Slots { .. })
    }

    const fn width_s(&self) -> f64 {
        match self {
            Self::Exact(_) => 0.0,
            Self::Slots { width_s, .. } => *width_s,
        }
    }

    fn times(&self) -> Vec<f64> {
        match self {
            Self::Exact(times) => times.clone(),
            Self::Slots { from_s, width_s, slots } => {
                (0..*slots).map(|slot| from_s + (slot as f64 + 0.5) * width_s).collect()
            }
        }
    }

    /// A curve's values at the points of the axis.
    fn put(&self, curve: &Curve, range: Range<usize>) -> OnAxis {
        let length = match self {
            Self::Exact(times) => times.len(),
            Self::Slots { slots, .. } => *slots,
        };
        let mut on_axis = OnAxis {
            least: vec![f64::NAN; length],
            greatest: vec![f64::NAN; length],
            sigma: curve.sigma.as_ref().map(|_| vec![f64::NAN; length]),
        };
        let mut next = 0;
        curve.each(range, &mut |place, time_s, value| {
            let point = match self {
                Self::Exact(times) => {
                    while times.get(next).is_some_and(|point_s| *point_s < time_s) {
                        next += 1;
                    }
                    next
                }
                Self::Slots { from_s, width_s, slots } => {
                    (((time_s - from_s) / width_s) as usize).min(slots.saturating_sub(1))
                }
            };
            // `min` and `max` of NaN and a number return the number.
            if let Some(least) = on_axis.least.get_mut(point) {
                *least = least.min(value);
            }
            if let Some(greatest) = on_axis.greatest.get_mut(point) {
                *greatest = greatest.max(value);
            }
            let sigma = curve.sigma.as_ref().and_then(|sigma| sigma.get(place));
            if let (Some(sigma), Some(shown)) = (sigma, on_axis.sigma.as_mut().and_then(|s| s.get_mut(point)))
            {
                *shown = shown.max(*sigma);
            }
        });
        on_axis
    }
}

/// Start and end of every gap wider than a point of the axis, and the number of values.
fn gaps(curve: &Curve, range: Range<usize>, width_s: f64) -> (Vec<f64>, u32) {
    let gap_s = curve.gap_s(range.clone()).unwrap_or(f64::INFINITY).max(width_s);
    let (mut gaps_s, mut values, mut last) = (Vec::new(), 0, None);
    curve.each(range, &mut |_, time_s, _| {
        values += 1;
        if let Some(last_s) = last.replace(time_s)
            && time_s - last_s > gap_s
        {
            gaps_s.extend([last_s, time_s]);
        }
    });
    (gaps_s, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spike_of_one_sample_is_in_its_pixel_whatever_the_width() {
        let rows = 720_000_usize;
        let times: Vec<f64> = (0..rows).map(|row| row as f64 * 0.005).collect();
        let mut values = vec![0.0; rows];
        values[123_457] = 50.0;
        values[600_001] = -70.0;
        let curve = Rc::new(Curve::own(times, values, "m"));
        for pixels in [1, 7, 800, 2_560] {
            let axis = Axis::new(std::slice::from_ref(&curve), (0.0, 3_600.0), pixels);
            let on_axis = axis.put(&curve, curve.range(0.0, 3_600.0));
            let slot = |time_s: f64| (time_s / (3_600.0 / f64::from(pixels))) as usize;
            assert_eq!(on_axis.greatest[slot(123_457.0 * 0.005)], 50.0);
            assert_eq!(on_axis.least[slot(600_001.0 * 0.005)], -70.0);
            assert_eq!(on_axis.greatest.iter().filter(|value| **value != 0.0).count(), 1);
            assert_eq!(on_axis.least.iter().filter(|value| **value != 0.0).count(), 1);
        }
    }

    #[test]
    fn few_values_are_drawn_as_they_are_and_gaps_are_told() {
        let times = vec![0.0, 1.0, 2.0, 3.0, 20.0, 21.0];
        let curve = Curve::own(times, vec![1.0, 2.0, f64::NAN, 4.0, 5.0, 6.0], "m");
        let curve = Rc::new(curve);
        let axis = Axis::new(std::slice::from_ref(&curve), (0.0, 30.0), 100);
        assert!(!axis.is_thinned());
        assert_eq!(axis.times(), [0.0, 1.0, 3.0, 20.0, 21.0]);
        let range = curve.range(0.0, 30.0);
        assert_eq!(axis.put(&curve, range.clone()).least, [1.0, 2.0, 4.0, 5.0, 6.0]);
        assert_eq!(gaps(&curve, range, 0.0), (vec![3.0, 20.0], 5));
        assert_eq!(curve.range(0.5, 3.0), 1..4);
    }
}
