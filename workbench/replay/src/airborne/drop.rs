//! Detects the drop from a carrier: out of steady flight the vehicle falls as nothing does that flies on its
//! own wings or propellers.
//!
//! Within [`FALL_S`] a body in free fall ends 19.6 m below the continuation of its path, half of g times two
//! seconds squared; an aircraft that is pushed over to half a g ends 9.8 m below. The limit is their
//! geometric mean. A rocket that coasts over its apogee falls as freely, but did so before. A multicopter
//! whose motors fail does too, so motors must be off, where that is recorded. An aerobatic aircraft that is
//! pushed over to weightlessness looks the same.
//!
//! What this cannot find: a winged vehicle whose wings carry a third or more of its weight from the first
//! second on. It needs a `launch` column.

use flight_data::{Channel, Column, Flight};

use super::blocks::{Heights, altitudes, median, median_interval_s};

/// Duration over which the fall is measured, seconds.
const FALL_S: f64 = 2.0;
/// Least fall below the straight continuation of the flight, metres.
const LEAST_FALL_M: f64 = 14.0;
/// Largest fall, metres: free fall plus twice the deviation that steady flight may have. More is a sensor's
/// jump.
const MOST_FALL_M: f64 = 19.6 + 2.0 * STEADY_M;
/// Least ratio of the fall in the second half to that in the first: three for a free fall, one for a steady
/// descent.
const LEAST_RATIO: f64 = 2.5;
/// Duration of steady flight before the fall, seconds.
const STEADY_S: f64 = 5.0;
/// Steady flight stays within this of a straight line, metres: turbulence and a barometer's noise. An
/// apogee's parabola deviates by up to 15 m.
const STEADY_M: f64 = 2.0;
/// Depth below the line, metres, at which the fall has certainly begun. The beginning is put earlier by the
/// time that a fall at four fifths of g takes to get there.
const BEGUN_M: f64 = 1.0;
const BEGUN_S: f64 = 0.5;
/// As [`LEAST_RATIO`], from the beginning on. A descent that begins at once has at most 1.8 (its speed is at
/// most that of [`MOST_FALL_M`] in 1.5 s), a fall 3: the geometric mean.
const BEGUN_RATIO: f64 = 2.3;
/// Heights at either end of the fall are medians over this time before and after, seconds, so that single
/// wild samples do not matter.
const AROUND_S: f64 = 0.15;
/// Longest time between samples, seconds: a slower barometer does not show when a fall begins.
const SLOWEST_S: f64 = 0.1;
/// Largest throttle of a motor that idles: autopilots' arming speeds are up to a tenth.
const IDLE: f64 = 0.1;
/// Largest specific force during the fall's first second, m/s2, where it is measured: a third of g, which the
/// limit above leaves to wings and drag.
const MOST_CARRIED_MPS2: f64 = 0.34 * 9.806_65;

/// A drop from a carrier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drop {
    /// When it began, seconds of the flight's own clock.
    pub from_s: f64,
    /// Its fall in the two seconds after that, below the continuation of its path, metres.
    pub fall_m: f64,
}

/// Time, seconds, and height, metres, in order of time.
type Track = [(f64, f64)];

/// The first drop, if a barometer with at least ten samples a second shows one.
#[must_use]
pub fn drop(flight: &Flight) -> Option<Drop> {
    let (samples, heights) = altitudes(flight)?;
    if heights != Heights::Barometer {
        return None;
    }
    let mut track: Vec<(f64, f64)> = Vec::with_capacity(samples.len());
    for (_, time_s, metres) in samples {
        // Rows that run back in time are left out, as in the estimator.
        if track.last().is_none_or(|(before_s, _)| time_s > *before_s) {
            track.push((time_s, metres));
        }
    }
    let interval_s = median_interval_s(track.iter().map(|(time_s, _)| *time_s).collect());
    if interval_s > SLOWEST_S {
        return None;
    }
    let (mut before, mut after) = (0, 0);
    for (place, (at_s, metres)) in track.iter().enumerate() {
        while track.get(before + 1).is_some_and(|(time_s, _)| *time_s <= at_s - FALL_S) {
            before += 1;
        }
        while track.get(after).is_some_and(|(time_s, _)| *time_s < at_s + FALL_S) {
            after += 1;
        }
        // Three samples alone rule out nearly all of a flight; only the rest is examined further.
        let (Some((_, earlier_m)), Some((_, later_m))) = (track.get(before), track.get(after)) else { break };
        if (metres - later_m) - (earlier_m - metres) < LEAST_FALL_M - 2.0 * STEADY_M {
            continue;
        }
        let found = fall(&track, place).filter(|drop| is_free(flight, drop.from_s));
        if found.is_some() {
            return found;
        }
    }
    None
}

fn around(track: &Track, at_s: f64) -> Option<f64> {
    let first = track.partition_point(|(time_s, _)| *time_s < at_s - AROUND_S);
    let inside = track.get(first..)?.iter().take_while(|(time_s, _)| *time_s <= at_s + AROUND_S);
    median(&mut inside.map(|(_, metres)| *metres).collect::<Vec<f64>>())
}

/// The fall that begins at a sample or within two seconds after it.
fn fall(track: &Track, place: usize) -> Option<Drop> {
    let (at_s, _) = *track.get(place)?;
    let line = steady_line(track.get(..=place)?, at_s)?;
    let below_m = |time_s: f64| Some(line.0 + line.1 * (time_s - at_s) - around(track, time_s)?);
    let (middle_m, last_m) = (below_m(at_s + FALL_S / 2.0)?, below_m(at_s + FALL_S)?);
    if last_m < LEAST_FALL_M || last_m - middle_m < LEAST_RATIO * middle_m.max(0.0) {
        return None;
    }
    let during = track.get(place..)?.iter().map(|(time_s, _)| *time_s);
    let mut during = during.take_while(|time_s| *time_s <= at_s + FALL_S);
    let begun_s = during.find(|time_s| below_m(*time_s).is_some_and(|metres| metres > BEGUN_M))?;
    let from_s = (begun_s - BEGUN_S).max(at_s);
    // A descent that begins at once looks like a fall only from before its beginning, and anything faster
    // than a fall is not one.
    let (middle_m, fall_m) = (below_m(from_s + FALL_S / 2.0)?, below_m(from_s + FALL_S)?);
    let is_fall =
        (LEAST_FALL_M..=MOST_FALL_M).contains(&fall_m) && fall_m - middle_m >= BEGUN_RATIO * middle_m;
    is_fall.then_some(Drop { from_s, fall_m })
}

/// Height at the end and climb rate, m and m/s, of the straight line through the seconds before; `None` if
/// the flight was not steady.
fn steady_line(track: &Track, at_s: f64) -> Option<(f64, f64)> {
    let first = track.partition_point(|(time_s, _)| *time_s < at_s - STEADY_S);
    let before = track.get(first..)?;
    let reaches = before.first().is_some_and(|(time_s, _)| at_s - time_s > 0.9 * STEADY_S);
    let is_gapless =
        before.windows(2).all(|pair| matches!(pair, [one, next] if next.0 - one.0 < FALL_S / 2.0));
    if !reaches || !is_gapless {
        return None;
    }
    let count = before.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| before.iter().map(of).sum::<f64>() / count;
    let (mean_s, mean_m) = (mean(|sample| sample.0), mean(|sample| sample.1));
    let (mut squares, mut products) = (0.0, 0.0);
    for (time_s, metres) in before {
        squares += (time_s - mean_s) * (time_s - mean_s);
        products += (time_s - mean_s) * (metres - mean_m);
    }
    let climb_mps = products / squares;
    let straight_m = |time_s: f64| mean_m + climb_mps * (time_s - mean_s);
    let off =
        before.iter().filter(|(time_s, metres)| (metres - straight_m(*time_s)).abs() > STEADY_M).count();
    // Single wild samples do not matter.
    (off * 20 <= before.len()).then(|| (straight_m(at_s), climb_mps))
}

/// Whether nothing carried the vehicle, by throttle and accelerometer, where those are recorded.
fn is_free(flight: &Flight, from_s: f64) -> bool {
    let values = |channel: Channel, from_s: f64, to_s: f64| {
        let samples = flight.channel(channel).into_iter().flat_map(Column::samples);
        let is_inside =
            move |row: &usize| flight.time_s.get(*row).is_some_and(|time_s| (from_s..to_s).contains(time_s));
        samples.filter(move |(row, value)| is_inside(row) && value.is_finite())
    };
    let mut throttle: Vec<f64> =
        values(Channel::Throttle, from_s - FALL_S, from_s).map(|(_, value)| f64::from(value)).collect();
    let mut forces: Vec<f64> = values(Channel::AccelXMps2, from_s, from_s + FALL_S / 2.0)
        .filter_map(|(row, x)| {
            let other =
                |channel| flight.channel(channel)?.get(row).map(f64::from).filter(|value| value.is_finite());
            let (y, z) = (other(Channel::AccelYMps2)?, other(Channel::AccelZMps2)?);
            Some(libm::sqrt(f64::from(x) * f64::from(x) + y * y + z * z))
        })
        .collect();
    median(&mut throttle).is_none_or(|throttle| throttle <= IDLE)
        && median(&mut forces).is_none_or(|force| force <= MOST_CARRIED_MPS2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.806_65;

    /// Barometer at 20 Hz by height over time, with a decimetre of noise, and other columns.
    fn flown(height_m: impl Fn(f64) -> f64, others: &[(Channel, &dyn Fn(f64) -> f64)]) -> Flight {
        let mut flight = Flight::default();
        let mut baro = Column::default();
        let mut columns = vec![Column::default(); others.len()];
        for row in 0..800_u32 {
            let time_s = f64::from(row) / 20.0;
            flight.time_s.push(time_s);
            baro.push(Some((height_m(time_s) + 0.1 * libm::sin(f64::from(row) * 2.3)) as f32));
            for (column, (_, value)) in columns.iter_mut().zip(others) {
                column.push(Some(value(time_s) as f32));
            }
        }
        flight.channels = vec![(Channel::BaroAltM, baro)];
        flight.channels.extend(others.iter().map(|(channel, _)| *channel).zip(columns));
        flight
    }

    /// Carried at a climb rate until 20 s, then falls at a share of g until the pull-out at 24 s.
    fn dropped(climb_mps: f64, share: f64) -> impl Fn(f64) -> f64 {
        move |time_s: f64| {
            let since = (time_s - 20.0).clamp(0.0, 4.0);
            let after = (time_s - 24.0).max(0.0);
            let carried = 1_000.0 + climb_mps * time_s.min(24.0);
            carried - 0.5 * share * G * since * since + (climb_mps - 4.0 * share * G) * after
        }
    }

    #[test]
    fn a_drop_out_of_level_flight_and_from_a_rising_balloon_is_found_within_half_a_second() {
        for climb_mps in [0.0, 5.0, -2.0] {
            for share in [1.0, 0.8] {
                let found = drop(&flown(dropped(climb_mps, share), &[]));
                let Some(found) = found else { panic!("{climb_mps} {share}: none") };
                assert!((found.from_s - 20.0).abs() <= 0.5, "{climb_mps} {share} {found:?}");
                assert!((found.fall_m - 2.0 * share * G).abs() < 4.0, "{climb_mps} {share} {found:?}");
            }
        }
    }

    #[test]
    fn a_push_over_a_descent_an_apogee_and_a_wild_sample_are_none() {
        assert_eq!(drop(&flown(dropped(0.0, 0.5), &[])), None);
        for sink_mps in [8.0, 10.0, 14.0, 20.0] {
            assert_eq!(drop(&flown(|time_s| 1_000.0 - sink_mps * (time_s - 20.0).max(0.0), &[])), None);
        }
        assert_eq!(drop(&flown(|time_s| 3_000.0 - 0.5 * G * (time_s - 20.0) * (time_s - 20.0), &[])), None);
        let wild = |time_s: f64| if (time_s - 22.0).abs() < 0.01 { 900.0 } else { 1_000.0 };
        assert_eq!(drop(&flown(wild, &[])), None);
        // A sine, as in rough flight.
        assert_eq!(drop(&flown(|time_s| 1_000.0 + 8.0 * libm::sin(time_s), &[])), None);
    }

    #[test]
    fn motors_that_ran_and_a_force_that_carried_deny_it() {
        let falls = dropped(0.0, 1.0);
        let still: &dyn Fn(f64) -> f64 = &|_| 0.0;
        let hover: &dyn Fn(f64) -> f64 = &|time_s| if time_s < 20.0 { 0.4 } else { 0.0 };
        assert_eq!(drop(&flown(&falls, &[(Channel::Throttle, hover)])), None);
        assert!(drop(&flown(&falls, &[(Channel::Throttle, still)])).is_some());
        let hangs: &dyn Fn(f64) -> f64 = &|time_s| if time_s < 20.0 { -G } else { 0.0 };
        let carried: &dyn Fn(f64) -> f64 = &|_| -G;
        for (down, is_found) in [(hangs, true), (carried, false)] {
            let axes =
                [(Channel::AccelXMps2, still), (Channel::AccelYMps2, still), (Channel::AccelZMps2, down)];
            assert_eq!(drop(&flown(&falls, &axes)).is_some(), is_found);
        }
    }

    /// The same flight on a clock that begins at another time, and without what is before and after some
    /// seconds of it.
    fn by_another_clock(flight: &Flight, (from_s, to_s): (f64, f64), zero_s: f64) -> Flight {
        let channels = flight.channels.iter().map(|(channel, _)| (*channel, Column::default())).collect();
        let mut part = Flight { channels, ..Flight::default() };
        for (row, time_s) in
            flight.time_s.iter().enumerate().filter(|(_, time_s)| (from_s..to_s).contains(*time_s))
        {
            part.time_s.push(zero_s + time_s);
            for ((_, column), (_, own)) in part.channels.iter_mut().zip(&flight.channels) {
                column.push(own.get(row));
            }
        }
        part
    }

    /// A fall at g is a metre deep after 0.45 s, one at four fifths of g after 0.51 s. The beginning is put
    /// half a second before that: at 20 s, to within a sample and the noise. Within two seconds it falls by
    /// half of that times two seconds squared. Neither the clock's zero nor anything flown six seconds before
    /// or three seconds after changes that.
    #[test]
    fn beginning_and_depth_are_those_of_a_free_fall() {
        let climbing_first =
            |fall: fn(f64) -> f64| move |time_s: f64| fall(time_s) - 6.0 * (13.0 - time_s).max(0.0);
        for share in [1.0, 0.8] {
            for climb_mps in [0.0, 5.0, -2.0] {
                let flight = flown(dropped(climb_mps, share), &[]);
                for (part_s, zero_s) in [((0.0, 40.0), 0.0), ((0.0, 23.0), 1_000.0), ((14.0, 40.0), 5_000.0)]
                {
                    let found = drop(&by_another_clock(&flight, part_s, zero_s)).unwrap();
                    assert!((found.from_s - zero_s - 20.0).abs() <= 0.11, "{share} {climb_mps} {found:?}");
                    // 0.1 s more are 2 m.
                    assert!((found.fall_m - 2.0 * share * G).abs() < 2.3, "{share} {climb_mps} {found:?}");
                }
            }
        }
        let found = drop(&flown(climbing_first(|time_s| dropped(0.0, 1.0)(time_s)), &[])).unwrap();
        assert!((found.from_s - 20.0).abs() <= 0.11, "{found:?}");
    }

    /// Steady means five seconds without a gap of a second, within two metres of a line except for one sample
    /// in twenty.
    #[test]
    fn what_was_not_steady_before_drops_from_nothing() {
        let flight = flown(dropped(0.0, 1.0), &[]);
        assert_eq!(drop(&by_another_clock(&flight, (18.0, 40.0), 0.0)), None, "two seconds of flight before");
        let mut torn = flown(dropped(0.0, 1.0), &[]);
        for row in 340..370 {
            torn.channels[0].1.set(row, None);
        }
        assert_eq!(drop(&torn), None, "nothing from 17 s to 18.5 s");
        let rough = |time_s: f64| {
            let wave_m = if time_s < 20.0 { 4.0 * libm::sin(4.0 * time_s) } else { 0.0 };
            dropped(0.0, 1.0)(time_s) + wave_m
        };
        assert_eq!(drop(&flown(rough, &[])), None);
        let wild = |time_s: f64| {
            let wild_m = if (time_s * 20.0).round() as u32 % 25 == 7 { 40.0 } else { 0.0 };
            dropped(0.0, 1.0)(time_s) + wild_m
        };
        assert!(drop(&flown(wild, &[])).is_some(), "one wild sample in 25");
    }

    /// Rows whose time does not increase are left out, and five samples a second are too few.
    #[test]
    fn repeated_rows_are_left_out_and_a_slow_barometer_tells_nothing() {
        let once = flown(dropped(0.0, 1.0), &[]);
        let mut twice = Flight::default();
        let mut baro = Column::default();
        for (row, time_s) in once.time_s.iter().enumerate() {
            for cell in [once.channels[0].1.get(row), Some(0.0), Some(0.0)] {
                twice.time_s.push(*time_s);
                baro.push(cell);
            }
        }
        twice.channels = vec![(Channel::BaroAltM, baro)];
        assert_eq!(drop(&twice), drop(&once));
        let mut slow = flown(dropped(0.0, 1.0), &[]);
        for row in (0..800).filter(|row| row % 4 != 0) {
            slow.channels[0].1.set(row, None);
        }
        assert_eq!(drop(&slow), None);
    }

    /// Motors that stopped three seconds before carried nothing. A parachute that opens after the first
    /// second comes too late to rule out a fall. A drag of half a metre a second squared along every axis is
    /// within what a fall may have.
    #[test]
    fn only_what_carried_at_the_time_of_the_fall_denies_it() {
        let falls = dropped(0.0, 1.0);
        let stopped: &dyn Fn(f64) -> f64 = &|time_s| if time_s < 17.0 { 0.4 } else { 0.0 };
        assert!(drop(&flown(&falls, &[(Channel::Throttle, stopped)])).is_some());
        let with_force = |force: &dyn Fn(f64) -> [f64; 3]| {
            let axes: [(Channel, &dyn Fn(f64) -> f64); 3] = [
                (Channel::AccelXMps2, &|time_s| force(time_s)[0]),
                (Channel::AccelYMps2, &|time_s| force(time_s)[1]),
                (Channel::AccelZMps2, &|time_s| force(time_s)[2]),
            ];
            drop(&flown(&falls, &axes)).is_some()
        };
        assert!(with_force(&|time_s| if time_s < 21.2 { [0.0; 3] } else { [0.0, 0.0, -2.0 * G] }));
        assert!(with_force(&|_| [-0.5; 3]));
        for carried in
            [[G, 0.0, 0.0], [0.0, G, 0.0], [0.0, 0.0, -G], [0.8 * G, 0.8 * G, 0.0], [0.0, 0.8 * G, 0.8 * G]]
        {
            assert!(!with_force(&|_| carried), "{carried:?}");
        }
    }
}
