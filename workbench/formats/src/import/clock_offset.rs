//! Time offset between the barometer and the receiver.
//!
//! Both record the same climb. The change of the barometer's altitude over some seconds is correlated with
//! that of the receiver's, shifted later and earlier; the offset is where they agree best. A barometer that
//! lags and a clock that is behind look the same, and a receiver has a delay of its own. The offset is
//! therefore reported but never applied.

use kf_core::atmosphere::pressure_altitude_m;

use flight_data::{Channel, Column, Flight};

/// Interval of a change, seconds: over longer ones a receiver's wander grows, over shorter ones its noise.
const OVER_S: f64 = 4.0;
/// Largest offset that is searched, in both directions, seconds.
const MOST_S: f64 = 6.0;
/// Step between the offsets that are tried first, seconds.
const STEP_S: f64 = 0.2;
/// Steps of least squares from the best of those: each leaves a tenth of the remaining error.
const ROUNDS: usize = 4;
/// Half interval over which a change's rise is taken, seconds: a shorter one would contain the same noise of
/// the fixes as the change itself.
const RISE_S: f64 = 1.0;
/// Samples farther apart than this are not interpolated, seconds.
const GAP_S: f64 = 2.5;
/// Moments at which both are compared: in a long flight, fewer than five a second.
const MOMENTS: f64 = 10_000.0;
/// Stretches of the flight, whose independent estimates give the standard error of the whole.
const BLOCKS: usize = 20;
/// Fewest moments for an estimate: twenty seconds of both.
const LEAST_MOMENTS: usize = 100;
/// Below this correlation there is too little climb for an estimate.
const LEAST_CORRELATION: f64 = 0.6;
/// Largest useful standard error, seconds.
const MOST_SIGMA_S: f64 = 0.5;

/// An offset between the barometer and the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockOffset {
    /// How much later than the receiver the barometer shows the same climb, seconds.
    pub behind_s: f64,
    /// Its standard error, seconds.
    pub sigma_s: f64,
    /// Correlation of the two at that offset.
    pub correlation: f64,
}

impl ClockOffset {
    /// The offset as text.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { behind_s, sigma_s, correlation } = *self;
        let which = if behind_s >= 0.0 { "behind" } else { "ahead of" };
        let doubt = if behind_s.abs() < 2.0 * sigma_s { ", which may be zero" } else { "" };
        format!(
            "clocks: the barometer is {:.2} s {which} the receiver{doubt} (1 sigma {sigma_s:.2} s; their climbs correlate by \
             {correlation:.2} then): an offset of the clocks, or a lag of the sensor; no times are shifted",
            behind_s.abs()
        )
    }
}

/// An altitude over time, in stretches without gaps.
struct Course {
    /// Time and metres.
    points: Vec<(f64, f64)>,
    /// Indices of the points that begin a stretch, except the first one: a number with every point would be a
    /// third of the memory.
    breaks: Vec<usize>,
}

impl Course {
    /// From `count` samples in time order: altitudes, or with `is_rate` climb rates, which are integrated.
    fn new(samples: impl Iterator<Item = (f64, f64)>, count: usize, is_rate: bool) -> Self {
        let mut points: Vec<(f64, f64)> = Vec::with_capacity(count);
        let mut breaks = Vec::new();
        let mut before: Option<(f64, f64)> = None;
        let mut metres = 0.0;
        for (time_s, value) in samples.filter(|(_, value)| value.is_finite()) {
            if let Some((earlier_s, earlier)) = before {
                if time_s <= earlier_s {
                    continue;
                }
                if time_s - earlier_s > GAP_S {
                    breaks.push(points.len());
                }
                metres += (time_s - earlier_s) * (value + earlier) / 2.0;
            }
            before = Some((time_s, value));
            points.push((time_s, if is_rate { metres } else { value }));
        }
        Self { points, breaks }
    }

    fn of(flight: &Flight, column: &Column, value: impl Fn(f32) -> Option<f64>, is_rate: bool) -> Self {
        let samples = column.samples().filter_map(|(row, own)| Some((*flight.time_s.get(row)?, value(own)?)));
        Self::new(samples, column.samples().count(), is_rate)
    }

    /// Start of a walk along it.
    const fn walk(&self) -> Walk<'_> {
        Walk { points: self.points.as_slice(), breaks: self.breaks.as_slice(), places: [0; 2] }
    }
}

/// How many points ahead the next moment is searched, before all points are searched.
const NEAR: usize = 8;

/// Changes at one moment after another: each search begins where the last one ended, because there are a
/// hundred passes over ten thousand moments.
struct Walk<'a> {
    points: &'a [(f64, f64)],
    breaks: &'a [usize],
    /// The points after the beginning and the end of the last change.
    places: [usize; 2],
}

impl Walk<'_> {
    /// The change of the altitude around a moment.
    fn change(&mut self, time_s: f64) -> Option<f64> {
        let [from, to] = self.places;
        let from = self.after(time_s - OVER_S / 2.0, from);
        let to = self.after(time_s + OVER_S / 2.0, to);
        self.places = [from, to];
        let is_one_stretch = from > 0 && self.stretch(from - 1) == self.stretch(to);
        let (before, after) = (self.at(time_s - OVER_S / 2.0, from)?, self.at(time_s + OVER_S / 2.0, to)?);
        is_one_stretch.then_some(after - before)
    }

    /// The first point after a time, searched from an index on.
    fn after(&self, time_s: f64, place: usize) -> usize {
        let is_after = |place: usize| self.points.get(place).is_none_or(|point| point.0 > time_s);
        let is_first =
            |place: usize| is_after(place) && place.checked_sub(1).is_none_or(|last| !is_after(last));
        let mut near = place..=place.saturating_add(NEAR).min(self.points.len());
        near.find(|place| is_first(*place))
            .unwrap_or_else(|| self.points.partition_point(|point| point.0 <= time_s))
    }

    /// The stretch of a point.
    fn stretch(&self, place: usize) -> usize {
        self.breaks.partition_point(|start| *start <= place)
    }

    /// The altitude between a point and the one before it.
    fn at(&self, time_s: f64, next: usize) -> Option<f64> {
        let (from_s, from) = *self.points.get(next.checked_sub(1)?)?;
        let (to_s, to) = *self.points.get(next)?;
        Some(from + (to - from) * (time_s - from_s) / (to_s - from_s))
    }
}

/// The result as text, if the flight has a barometer and a receiver.
#[must_use]
pub fn text(flight: &Flight) -> Option<String> {
    let has =
        |channel: Channel| flight.channel(channel).is_some_and(|column| column.samples().next().is_some());
    let has_both = (has(Channel::BaroPa) || has(Channel::BaroAltM)) && has(Channel::GpsAltM);
    has_both.then(|| {
        estimate(flight).map_or_else(
            || {
                "clocks: barometer and receiver climb too little together, or are recorded too seldom, to tell whether their times agree"
                    .to_owned()
            },
            |offset| offset.text(),
        )
    })
}

/// Estimates the offset; `None` where the flight does not allow it.
#[must_use]
pub fn estimate(flight: &Flight) -> Option<ClockOffset> {
    let metres = |value: f32| Some(f64::from(value));
    let barometer = match (flight.channel(Channel::BaroPa), flight.channel(Channel::BaroAltM)) {
        (Some(column), _) => Course::of(flight, column, |pa| pressure_altitude_m(pa).map(f64::from), false),
        (None, Some(column)) => Course::of(flight, column, metres, false),
        (None, None) => return None,
    };
    // A velocity is less noisy than the differences of an altitude; but some logs have none, or one with the
    // wrong sign. The second one is only made if needed, so that only one of them is in memory.
    let by_velocity = flight.channel(Channel::GpsVdMps).and_then(|column| {
        between(&barometer, &Course::of(flight, column, |down| Some(-f64::from(down)), true))
    });
    by_velocity.or_else(|| {
        let column = flight.channel(Channel::GpsAltM)?;
        between(&barometer, &Course::of(flight, column, metres, false))
    })
}

fn between(barometer: &Course, receiver: &Course) -> Option<ClockOffset> {
    let (first, last) = (barometer.points.first()?.0, barometer.points.last()?.0);
    let pace_s = ((last - first) / MOMENTS).max(0.2);
    let count = ((last - first) / pace_s) as usize;
    let mut own = barometer.walk();
    let moments: Vec<(f64, f64)> = (0..count)
        // Between two fixes an altitude has less noise than at one: with evenly spaced moments, the offsets
        // in between would seem better. The golden ratio spreads the moments evenly over all of these places.
        .map(|k| first + (k as f64 + (k as f64 * 0.618_033_988_75).fract()) * pace_s)
        .filter_map(|time_s| Some((time_s, own.change(time_s)?)))
        .collect();
    let line_at = |shift_s: f64| {
        let mut receiver = receiver.walk();
        let pair = |(time_s, own): &(f64, f64)| Some((receiver.change(time_s + shift_s)?, *own));
        Line::through(moments.iter().filter_map(pair).collect())
    };
    let steps = (MOST_S / STEP_S) as i32;
    let tried: Vec<(f64, f64)> = (-steps..=steps)
        .map(|k| f64::from(k) * STEP_S)
        .filter_map(|shift_s| Some((shift_s, line_at(shift_s)?.correlation)))
        .collect();
    let (mut shift_s, highest) = tried.iter().copied().max_by(|one, other| one.1.total_cmp(&other.1))?;
    let lowest = tried.iter().map(|tried| tried.1).fold(0.0, f64::min);
    // A velocity with the wrong sign has a stronger negative correlation than any positive one.
    if highest < LEAST_CORRELATION || -lowest > highest {
        return None;
    }
    let mut sigma_s = f64::INFINITY;
    for _ in 0..ROUNDS {
        let step = step(&moments, receiver, shift_s)?;
        shift_s += step.0;
        sigma_s = step.1;
    }
    // At the edge, an offset outside the range may be better.
    let is_inside = shift_s.abs() < MOST_S - STEP_S;
    (is_inside && sigma_s <= MOST_SIGMA_S).then_some(ClockOffset {
        behind_s: -shift_s,
        sigma_s,
        correlation: highest,
    })
}

/// Gauss-Newton step of the offset from the residuals, and its standard error, computed from each stretch's
/// own contribution as if they were independent.
fn step(moments: &[(f64, f64)], receiver: &Course, shift_s: f64) -> Option<(f64, f64)> {
    let mut walks = [receiver.walk(), receiver.walk(), receiver.walk()];
    let triple = |(time_s, own): &(f64, f64)| {
        let mut at = |walk: usize, more_s: f64| walks.get_mut(walk)?.change(time_s + shift_s + more_s);
        Some((at(0, 0.0)?, *own, (at(1, RISE_S)? - at(2, -RISE_S)?) / (2.0 * RISE_S)))
    };
    let triples: Vec<(f64, f64, f64)> = moments.iter().filter_map(triple).collect();
    let Line { slope, offset, .. } = Line::through(triples.iter().map(|(x, y, _)| (*x, *y)).collect())?;
    let stiffness: f64 = triples.iter().map(|(_, _, rise)| (slope * rise).powi(2)).sum();
    let pull = |(x, y, rise): &(f64, f64, f64)| (y - slope * x - offset) * slope * rise;
    let block = triples.len().div_ceil(BLOCKS).max(1);
    let pulls: Vec<f64> = triples.chunks(block).map(|block| block.iter().map(pull).sum()).collect();
    let step_s = pulls.iter().sum::<f64>() / stiffness;
    let sigma_s = pulls.iter().map(|pull| pull * pull).sum::<f64>().sqrt() / stiffness;
    (step_s.abs() <= MOST_S && sigma_s.is_finite()).then_some((step_s, sigma_s))
}

/// A straight line through pairs: the barometer's change over the receiver's.
struct Line {
    slope: f64,
    offset: f64,
    correlation: f64,
}

impl Line {
    fn through(pairs: Vec<(f64, f64)>) -> Option<Self> {
        let n = pairs.len() as f64;
        let (x, y) = pairs.iter().fold((0.0, 0.0), |(x, y), pair| (x + pair.0 / n, y + pair.1 / n));
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for pair in &pairs {
            let (dx, dy) = (pair.0 - x, pair.1 - y);
            xx += dx * dx;
            yy += dy * dy;
            xy += dx * dy;
        }
        (pairs.len() >= LEAST_MOMENTS && xx > 0.0 && yy > 0.0).then(|| Self {
            slope: xy / xx,
            offset: y - xy / xx * x,
            correlation: xy / (xx * yy).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight that climbs and sinks irregularly, with a barometer at 10 Hz that is late by `behind_s`, and
    /// fixes at 5 Hz.
    fn flight(seconds: u32, climb_mps: f64, behind_s: f64, seed: u32, has_velocity: bool) -> Flight {
        let mut seed = seed;
        let mut noise = || {
            // The sum of twelve uniform numbers is nearly normal.
            let mut uniform = || {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
            };
            (0..12).map(|_| uniform()).sum::<f64>()
        };
        let altitude = |time_s: f64| {
            let wave = |period_s: f64| (std::f64::consts::TAU * time_s / period_s).sin() * period_s;
            500.0 + climb_mps * (wave(23.0) + wave(61.0) + wave(7.3)) / std::f64::consts::TAU
        };
        let mut flight = Flight::default();
        let (mut pa, mut fix, mut down) = (Column::default(), Column::default(), Column::default());
        for k in 0..seconds * 10 {
            let time_s = f64::from(k) / 10.0;
            flight.time_s.push(time_s);
            pa.push(Some((altitude(time_s - behind_s) + 0.5 * noise()) as f32));
            let has_fix = k % 2 == 0;
            fix.push(has_fix.then(|| (altitude(time_s) + noise()) as f32));
            let climb = (altitude(time_s + 0.01) - altitude(time_s - 0.01)) / 0.02;
            down.push(has_fix.then(|| (-climb + 0.2 * noise()) as f32));
        }
        flight.set_channel(Channel::BaroAltM, pa);
        flight.set_channel(Channel::GpsAltM, fix);
        if has_velocity {
            flight.set_channel(Channel::GpsVdMps, down);
        }
        flight
    }

    #[test]
    fn an_offset_is_found_within_its_own_sigma() {
        let mut beyond = 0;
        for seed in 1..=20 {
            for (behind_s, has_velocity) in [(0.83, true), (-1.4, false), (0.0, true)] {
                let found = estimate(&flight(300, 2.0, behind_s, seed, has_velocity)).unwrap();
                assert!(found.sigma_s > 0.001 && found.sigma_s < 0.1, "{found:?}");
                let off = (found.behind_s - behind_s).abs() / found.sigma_s;
                assert!(off < 5.0, "{found:?} {behind_s}");
                beyond += usize::from(off > 2.0);
            }
        }
        // One in twenty is expected; the blocks are few.
        assert!(beyond <= 9, "{beyond} of 60");
        let text = text(&flight(300, 2.0, 0.83, 1, true)).unwrap();
        assert!(text.contains("the barometer is 0.8") && text.contains("s behind the receiver"), "{text}");
    }

    #[test]
    fn what_does_not_tell_says_so() {
        assert_eq!(estimate(&flight(300, 0.0, 1.0, 1, true)), None);
        assert_eq!(estimate(&flight(5, 2.0, 1.0, 1, true)), None);
        assert!(text(&flight(300, 0.0, 1.0, 1, true)).unwrap().contains("too little"));
        assert_eq!(estimate(&Flight::default()), None);
        assert_eq!(text(&Flight::default()), None);
        // Beyond the offsets that are searched.
        assert_eq!(estimate(&flight(300, 2.0, 30.0, 1, true)), None);
    }

    #[test]
    fn a_velocity_with_the_wrong_sign_gives_way_to_the_altitude() {
        let mut turned = flight(300, 2.0, 0.5, 3, true);
        crate::import::signs::turn(&mut turned, "gps_vd_mps");
        let found = estimate(&turned).unwrap();
        assert!((found.behind_s - 0.5).abs() < 5.0 * found.sigma_s, "{found:?}");
    }
}
