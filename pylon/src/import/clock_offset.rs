//! How far the barometer's time is from the receiver's.
//!
//! Both show the same climb. The change of the barometer's altitude over some seconds is correlated with that of the receiver's,
//! later and earlier; where they agree best is the offset. A barometer that lags and a clock that is behind look alike, and a
//! receiver has a delay of its own: so the offset is shown and never applied.

use kf_core::atmosphere::pressure_altitude_m;

use crate::flight::{Channel, Column, Flight};

/// Changes are taken over so long: beyond it a receiver's wander grows, below it its noise does.
const OVER_S: f64 = 4.0;
/// Offsets that are looked for, to either side.
const MOST_S: f64 = 6.0;
/// From one offset that is tried to the next.
const STEP_S: f64 = 0.1;
/// Samples that are farther apart than this have nothing between them.
const GAP_S: f64 = 2.5;
/// Moments at which both are compared: of a long flight not each fifth of a second.
const MOMENTS: f64 = 20_000.0;
/// Stretches of the flight, whose estimates are independent of each other and say how sure all of them are.
const BLOCKS: usize = 20;
/// Below this correlation there is too little climb to tell.
const LEAST_CORRELATION: f64 = 0.6;
/// A standard error above this tells nothing, seconds.
const MOST_SIGMA_S: f64 = 0.5;

/// An offset between the barometer and the receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockOffset {
    /// So much later than the receiver does the barometer show the same climb, seconds.
    pub behind_s: f64,
    /// Its standard error, seconds.
    pub sigma_s: f64,
    /// Correlation of the two at that offset.
    pub correlation: f64,
}

impl ClockOffset {
    /// In words.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { behind_s, sigma_s, correlation } = *self;
        let which = if behind_s >= 0.0 { "behind" } else { "ahead of" };
        let doubt = if behind_s.abs() < 2.0 * sigma_s { ", which may be none at all" } else { "" };
        format!(
            "clocks: the barometer is {:.2} s {which} the receiver{doubt} (1 sigma {sigma_s:.2} s; their climbs correlate by \
             {correlation:.2} then): an offset of the clocks, or a lag of the sensor; nothing is shifted by it",
            behind_s.abs()
        )
    }
}

/// An altitude over time, in stretches without gaps.
struct Course {
    /// Time, metres, and the stretch.
    points: Vec<(f64, f64, usize)>,
}

impl Course {
    /// Of samples in order of time: altitudes, or with `is_rate` climb rates, which are integrated.
    fn new(samples: impl Iterator<Item = (f64, f64)>, is_rate: bool) -> Self {
        let mut points: Vec<(f64, f64, usize)> = Vec::new();
        let mut before: Option<(f64, f64)> = None;
        let (mut metres, mut stretch) = (0.0, 0);
        for (time_s, value) in samples.filter(|(_, value)| value.is_finite()) {
            if let Some((earlier_s, earlier)) = before {
                if time_s <= earlier_s {
                    continue;
                }
                stretch += usize::from(time_s - earlier_s > GAP_S);
                metres += (time_s - earlier_s) * (value + earlier) / 2.0;
            }
            before = Some((time_s, value));
            points.push((time_s, if is_rate { metres } else { value }, stretch));
        }
        Self { points }
    }

    fn of(flight: &Flight, column: &Column, value: impl Fn(f32) -> Option<f64>, is_rate: bool) -> Self {
        let samples = column.samples().filter_map(|(row, own)| Some((*flight.time_s.get(row)?, value(own)?)));
        Self::new(samples, is_rate)
    }

    fn at(&self, time_s: f64) -> Option<(f64, usize)> {
        let next = self.points.partition_point(|point| point.0 <= time_s);
        let (from_s, from, stretch) = *self.points.get(next.checked_sub(1)?)?;
        let (to_s, to, of_next) = *self.points.get(next)?;
        (stretch == of_next).then(|| (from + (to - from) * (time_s - from_s) / (to_s - from_s), stretch))
    }

    /// Its change around a moment.
    fn change(&self, time_s: f64) -> Option<f64> {
        let (before, after) = (self.at(time_s - OVER_S / 2.0)?, self.at(time_s + OVER_S / 2.0)?);
        (before.1 == after.1).then_some(after.0 - before.0)
    }
}

/// Sums of two changes that are compared.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    yy: f64,
    xy: f64,
}

impl Sums {
    fn add(mut self, (x, y): (f64, f64)) -> Self {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.yy += y * y;
        self.xy += x * y;
        self
    }

    fn correlation(&self) -> Option<f64> {
        let xx = self.xx - self.x * self.x / self.n;
        let yy = self.yy - self.y * self.y / self.n;
        (self.n >= 100.0 && xx > 0.0 && yy > 0.0)
            .then(|| (self.xy - self.x * self.y / self.n) / (xx * yy).sqrt())
    }

    /// Metres of the barometer for one of the receiver.
    fn slope(&self) -> f64 {
        (self.xy - self.x * self.y / self.n) / (self.yy - self.y * self.y / self.n)
    }
}

/// What the clocks say, if the flight has a barometer and a receiver.
#[must_use]
pub fn text(flight: &Flight) -> Option<String> {
    let has =
        |channel: Channel| flight.channel(channel).is_some_and(|column| column.samples().next().is_some());
    let has_both = (has(Channel::BaroPa) || has(Channel::BaroAltM)) && has(Channel::GpsAltM);
    has_both.then(|| {
        estimate(flight).map_or_else(
            || {
                "clocks: barometer and receiver climb too little together to tell whether their times agree"
                    .to_owned()
            },
            |offset| offset.text(),
        )
    })
}

/// Estimates the offset; none where the flight does not tell.
#[must_use]
pub fn estimate(flight: &Flight) -> Option<ClockOffset> {
    let metres = |value: f32| Some(f64::from(value));
    let barometer = match (flight.channel(Channel::BaroPa), flight.channel(Channel::BaroAltM)) {
        (Some(column), _) => Course::of(flight, column, |pa| pressure_altitude_m(pa).map(f64::from), false),
        (None, Some(column)) => Course::of(flight, column, metres, false),
        (None, None) => return None,
    };
    // A velocity is less noisy than the differences of an altitude; but some logs have none, or one with the wrong sign.
    let by_velocity = flight
        .channel(Channel::GpsVdMps)
        .map(|column| Course::of(flight, column, |down| Some(-f64::from(down)), true));
    let by_altitude =
        flight.channel(Channel::GpsAltM).map(|column| Course::of(flight, column, metres, false));
    [by_velocity, by_altitude].into_iter().flatten().find_map(|receiver| between(&barometer, &receiver))
}

fn between(barometer: &Course, receiver: &Course) -> Option<ClockOffset> {
    let (first, last) = (barometer.points.first()?.0, barometer.points.last()?.0);
    let pace_s = ((last - first) / MOMENTS).max(0.2);
    let count = ((last - first) / pace_s) as usize;
    let moments: Vec<(f64, f64)> = (0..count)
        // Between two fixes an altitude has less noise than at one: at even moments the offsets between would seem the better
        // ones. By the golden ratio they fall everywhere alike.
        .map(|k| first + (k as f64 + (k as f64 * 0.618_033_988_75).fract()) * pace_s)
        .filter_map(|time_s| Some((time_s, barometer.change(time_s)?)))
        .collect();
    let pairs = |shift_s: f64| {
        moments.iter().filter_map(move |(time_s, own)| Some((*own, receiver.change(time_s + shift_s)?)))
    };
    let correlation = |shift_s: f64| pairs(shift_s).fold(Sums::default(), Sums::add).correlation();
    let steps = (MOST_S / STEP_S) as i32;
    let tried: Vec<Option<f64>> = (-steps..=steps).map(|k| correlation(f64::from(k) * STEP_S)).collect();
    let best = (0..tried.len()).filter(|place| tried.get(*place).is_some_and(Option::is_some)).max_by(
        |one, other| tried.get(*one).partial_cmp(&tried.get(*other)).unwrap_or(std::cmp::Ordering::Equal),
    )?;
    let of = |place: usize| tried.get(place).copied().flatten();
    // At the edge it may be better beyond.
    let (before, highest, after) = (of(best.checked_sub(1)?)?, of(best)?, of(best + 1)?);
    // A velocity with its sign turned is nowhere as like as it is unlike.
    let lowest = tried.iter().copied().flatten().fold(0.0, f64::min);
    if highest < LEAST_CORRELATION || -lowest > highest {
        return None;
    }
    let curvature = before - 2.0 * highest + after;
    let between = if curvature < 0.0 { (before - after) / (2.0 * curvature) } else { 0.0 };
    let shift_s = (best as f64 - f64::from(steps) + between) * STEP_S;
    let sigma_s = sigma_s(&moments, receiver, shift_s)?;
    (sigma_s <= MOST_SIGMA_S).then_some(ClockOffset { behind_s: -shift_s, sigma_s, correlation: highest })
}

/// The standard error: what each stretch of the flight would move the offset by, as if they were independent.
fn sigma_s(moments: &[(f64, f64)], receiver: &Course, shift_s: f64) -> Option<f64> {
    let paired = |(time_s, own): &(f64, f64)| {
        let at = |more_s: f64| receiver.change(time_s + shift_s + more_s);
        Some((*own, at(0.0)?, (at(STEP_S)? - at(-STEP_S)?) / (2.0 * STEP_S)))
    };
    let triples: Vec<(f64, f64, f64)> = moments.iter().filter_map(paired).collect();
    let sums = triples.iter().map(|(x, y, _)| (*x, *y)).fold(Sums::default(), Sums::add);
    let slope = sums.slope();
    let offset = (sums.x - slope * sums.y) / sums.n;
    let rise: f64 = triples.iter().map(|(_, _, rise)| (slope * rise).powi(2)).sum();
    let block = (triples.len() / BLOCKS).max(1);
    let pulls = triples.chunks(block).map(|block| {
        let pull = |(x, y, rise): &(f64, f64, f64)| (x - slope * y - offset) * slope * rise;
        block.iter().map(pull).sum::<f64>().powi(2)
    });
    let sigma_s = pulls.sum::<f64>().sqrt() / rise;
    sigma_s.is_finite().then_some(sigma_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight that climbs and sinks irregularly, with a barometer at 10 Hz that is so late, and fixes at 5 Hz.
    fn flight(seconds: u32, climb_mps: f64, behind_s: f64, seed: u32, has_velocity: bool) -> Flight {
        let mut seed = seed;
        let mut noise = || {
            // Twelve uniform numbers make a normal one, near enough.
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
        // Farther off than is looked for.
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
