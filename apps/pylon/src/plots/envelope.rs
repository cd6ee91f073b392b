//! Draws a long series of a flight as curves of a diagram.

use std::ops::Range;

use crate::compare::{Envelope, Slot};

/// The least and the greatest values, slot by slot; `seconds` converts the times.
pub(super) fn edges(envelope: &Envelope, seconds: impl Fn(u64) -> f64) -> [Vec<(f64, f64)>; 2] {
    let edge = |value: fn(&Slot) -> f32| -> Vec<(f64, f64)> {
        envelope.slots().iter().map(|slot| (seconds(slot.time_us), f64::from(value(slot)))).collect()
    };
    [edge(|slot| slot.least), edge(|slot| slot.greatest)]
}

/// The envelope as one line that touches the least and the greatest value of every slot; `seconds` converts
/// the times.
pub(super) fn outline(envelope: &Envelope, seconds: impl Fn(u64) -> f64) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = Vec::new();
    for slot in envelope.slots() {
        let x = seconds(slot.time_us);
        let (least, greatest) = (f64::from(slot.least), f64::from(slot.greatest));
        let before = points.last().map_or(least, |(_, y)| *y);
        let (first, second) = if (before - least).abs() <= (before - greatest).abs() {
            (least, greatest)
        } else {
            (greatest, least)
        };
        points.push((x, first));
        if second != first {
            points.push((x, second));
        }
    }
    points
}

/// First and last time of several envelopes; `seconds` converts them.
pub(super) fn span<'a>(
    envelopes: impl Iterator<Item = &'a Envelope>,
    seconds: impl Fn(u64) -> f64,
) -> Option<Range<f64>> {
    let (mut first, mut last) = (u64::MAX, 0);
    for envelope in envelopes {
        if let (Some(from), Some(to)) = (envelope.slots().first(), envelope.slots().last()) {
            first = first.min(from.time_us);
            last = last.max(to.time_us);
        }
    }
    (first < last).then(|| seconds(first)..seconds(last))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outline_touches_every_extreme() {
        let mut envelope = Envelope::new(crate::compare::FIGURE_SLOTS);
        for (time_us, value) in [(0, 1.0), (100, -2.0), (200, 3.0), (5_000, 0.5)] {
            envelope.push(time_us, value);
        }
        let points = outline(&envelope, |us| us as f64);
        assert_eq!(points, vec![(0.0, -2.0), (0.0, 3.0), (5_000.0, 0.5)]);
    }
}
