//! Finds lasting steps of one altitude: a barometer whose pressure setting is changed in flight, a receiver
//! that changes its satellites. None of them is an effect on the aircraft, and all of them are reported.
//!
//! Looked at is the difference between a sensor's altitude and the receiver's, in which the aircraft's motion
//! cancels, from fix to fix. A step is a change from one fix to the next that
//!
//! - is more than five sigmas of the usual change,
//! - lasts: the levels of the half minutes before and after differ by as much, and by more than
//!   five sigmas of what such levels usually differ by,
//! - is in one of the two altitudes alone: that one bends by the step, while the other moves on.
//!
//! A release ends the carrier's pressure field at once. Changes as near to a change of the `launch` column as
//! the half minute are therefore no steps.

use flight_data::{Channel, Flight, Note};

use crate::pairs::{Pair, SENSORS, bend_m, pairs, spread, usual};

/// Largest change that the noise explains. Of normal changes one in two million is beyond, fewer than one in ten
/// hours at 10 Hz; of heavier tails more are, but those few do not last.
const NOISE_SIGMAS: f64 = 5.0;
/// Length of the levels on either side, seconds: as long as a jump of a receiver that comes back.
const LEVEL_S: f64 = 30.0;
/// Least number of fixes in a level: its median then tolerates two wild ones.
const LEAST_FIXES: usize = 5;
/// Largest difference of two levels that wander explains: a median of many values is nearly normal, and ten
/// hours have 1,200 half minutes, of which one in a thousand flights has one beyond five sigmas.
const LEVEL_SIGMAS: f64 = 5.0;
/// How much the three measures of a step may differ, as a share of it. At the limits the level and the change
/// each have a noise of a fifth, together 28 %; half as large again, and all of them agree almost always.
const APART: f64 = 0.35;
/// A fix that comes later than this many usual intervals follows a gap, in which anything may happen.
const GAP_INTERVALS: f64 = 3.0;

/// A lasting step of one altitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The column that steps: a sensor's altitude or pressure, or the receiver's altitude.
    pub channel: Channel,
    /// Time of the first fix after it, seconds of the flight's own clock.
    pub time_s: f64,
    /// By how much the altitude steps, metres; positive up.
    pub step_m: f64,
}

/// The steps in a flight, by sensor (those of the receiver with the first sensor that shows them), in the
/// order of time.
#[must_use]
pub fn find(flight: &Flight) -> Vec<Step> {
    let launches_s = launches_s(flight);
    let mut steps: Vec<Step> = Vec::new();
    for channel in SENSORS {
        for step in of_sensor(channel, &pairs(flight, channel)) {
            let is_launch = launches_s.iter().any(|at_s| (step.time_s - at_s).abs() <= LEVEL_S);
            let is_known = steps
                .iter()
                .any(|known| known.channel == step.channel && (known.time_s - step.time_s).abs() <= LEVEL_S);
            if !is_launch && !is_known {
                steps.push(step);
            }
        }
    }
    steps
}

/// Times at which the `launch` column changes, seconds.
fn launches_s(flight: &Flight) -> Vec<f64> {
    let Some(launch) = flight.channel(Channel::Launch) else { return Vec::new() };
    let changes = launch.samples().zip(launch.samples().skip(1)).filter(|(one, next)| one.1 != next.1);
    changes.filter_map(|(_, (row, _))| flight.time_s.get(row).copied()).collect()
}

fn of_sensor(channel: Channel, pairs: &[Pair]) -> Vec<Step> {
    let Some(interval_s) = usual(pairs.windows(2).map(|two| two[1].time_s - two[0].time_s)) else {
        return Vec::new();
    };
    let level = (libm::ceil(LEVEL_S / interval_s) as usize).max(LEAST_FIXES);
    let changes: Vec<f64> = pairs.windows(2).map(|two| two[1].apart_m() - two[0].apart_m()).collect();
    let change_sigma_m = spread(changes.iter().copied()).max(rounding_m(pairs));
    // How the level changes at the fix `k + 1`.
    let level_change_m = |k: usize| -> Option<f64> {
        let before = pairs.get((k + 1).checked_sub(level)?..=k)?;
        let after = pairs.get(k + 1..k + 1 + level)?;
        let median = |pairs: &[Pair]| usual(pairs.iter().map(Pair::apart_m));
        Some(median(after)? - median(before)?)
    };
    let level_sigma_m = spread((0..changes.len()).step_by(level.div_ceil(2)).filter_map(level_change_m))
        .max(rounding_m(pairs));
    let mut steps: Vec<Step> = Vec::new();
    for (k, change_m) in changes.iter().enumerate() {
        let near = |metres: f64| (metres - change_m).abs() <= APART * change_m.abs();
        if change_m.abs() <= NOISE_SIGMAS * change_sigma_m {
            continue;
        }
        let (Some(level_m), Some(around)) =
            (level_change_m(k), k.checked_sub(1).and_then(|first| pairs.get(first..first + 4)))
        else {
            continue;
        };
        let is_gapless =
            around.windows(2).all(|two| two[1].time_s - two[0].time_s <= GAP_INTERVALS * interval_s);
        if !is_gapless || !near(level_m) || level_m.abs() <= LEVEL_SIGMAS * level_sigma_m {
            continue;
        }
        let [sensor_m, receiver_m] = [|pair: &Pair| pair.sensor_m, |pair: &Pair| pair.receiver_m]
            .map(|altitude_m: fn(&Pair) -> f64| bend_m(around, altitude_m));
        let still_m = APART * change_m.abs();
        let time_s = around[2].time_s;
        if near(sensor_m) && receiver_m.abs() <= still_m {
            steps.push(Step { channel, time_s, step_m: level_m });
        } else if near(-receiver_m) && sensor_m.abs() <= still_m {
            steps.push(Step { channel: Channel::GpsAltM, time_s, step_m: -level_m });
        }
    }
    steps
}

/// Standard deviation of a change that comes from the rounding of both altitudes, metres: a value rounded to
/// whole steps has a variance of a twelfth of the step squared. The robust spread of changes that are mostly
/// zero is zero.
fn rounding_m(pairs: &[Pair]) -> f64 {
    let step_m = |altitude_m: fn(&Pair) -> f64| {
        let steps = pairs.windows(2).map(|two| (altitude_m(&two[1]) - altitude_m(&two[0])).abs());
        let least = steps.filter(|step| *step > 1e-3).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.0 }
    };
    let [sensor_m, receiver_m] = [step_m(|pair| pair.sensor_m), step_m(|pair| pair.receiver_m)];
    libm::sqrt((sensor_m * sensor_m + receiver_m * receiver_m) / 6.0)
}

impl Step {
    /// The altitude that steps, and what such a step mostly is.
    const fn words(channel: Channel) -> (&'static str, &'static str) {
        match channel {
            Channel::GpsAltM => ("the receiver's altitude", "its satellites change"),
            Channel::BaroPa | Channel::BaroAltM => {
                ("the barometer's altitude", "its pressure setting is changed, or the source of its pressure")
            }
            _ => ("an inertial altitude", "it is reset"),
        }
    }
}

/// The notes on the steps of a flight: one for each column that has any.
#[must_use]
pub fn notes(flight: &Flight) -> Vec<Note> {
    let steps = find(flight);
    let mut notes = Vec::new();
    for (at, first) in steps.iter().enumerate() {
        let Step { channel, time_s, step_m } = *first;
        if steps.iter().take(at).any(|step| step.channel == channel) {
            continue;
        }
        let (altitude, cause) = Step::words(channel);
        let name = channel.name();
        let count = steps.iter().filter(|step| step.channel == channel).count();
        let times = if count == 1 { String::new() } else { format!(", and {count} times in all") };
        notes.push(Note::new(format!(
            "{altitude} ({name}) steps by {step_m:+.0} m at {time_s:.1} s{times}, as when {cause}; it is not corrected"
        )));
    }
    notes
}

#[cfg(test)]
mod tests {
    use flight_data::Column;

    use super::*;

    /// Forty minutes at 1 Hz with a metre of noise in either altitude, by what is added to them, metres.
    fn flight(baro_m: impl Fn(f64) -> f64, receiver_m: impl Fn(f64) -> f64) -> Flight {
        let mut seed = 7_u32;
        let mut normal = || {
            (0..12).fold(-6.0, |sum, _| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum + f64::from(seed >> 8) / f64::from(1_u32 << 24)
            })
        };
        let mut flight = Flight::default();
        let (mut receiver, mut baro) = (Column::default(), Column::default());
        for second in 0..2400 {
            let time_s = f64::from(second);
            let altitude_m = 900.0 + 300.0 * libm::sin(time_s / 90.0);
            flight.time_s.push(time_s);
            receiver.push(Some((altitude_m + normal() + receiver_m(time_s)) as f32));
            baro.push(Some((altitude_m + normal() + baro_m(time_s)) as f32));
        }
        flight.set_channel(Channel::GpsAltM, receiver);
        flight.set_channel(Channel::BaroAltM, baro);
        flight
    }

    #[test]
    fn a_step_is_found_in_the_altitude_that_steps() {
        let step = |time_s: f64| if time_s >= 1000.0 { -16.0 } else { 0.0 };
        for (flight, channel) in
            [(flight(step, |_| 0.0), Channel::BaroAltM), (flight(|_| 0.0, step), Channel::GpsAltM)]
        {
            let found = find(&flight);
            assert_eq!(
                found.iter().map(|step| (step.channel, step.time_s)).collect::<Vec<_>>(),
                [(channel, 1000.0)]
            );
            assert!((found[0].step_m + 16.0).abs() < 1.5, "{found:?}");
            assert!(notes(&flight)[0].text().contains(" steps by -1"));
        }
    }

    /// What comes back, what takes its time, what a gap hides, and what a launch does.
    #[test]
    fn what_does_not_last_or_is_not_sudden_is_no_step() {
        let none = |flight: &Flight| assert_eq!(find(flight), []);
        none(&flight(|_| 0.0, |_| 0.0));
        none(&flight(|time_s| if (1000.0..1010.0).contains(&time_s) { 40.0 } else { 0.0 }, |_| 0.0));
        none(&flight(|time_s| (time_s - 1000.0).clamp(0.0, 40.0), |_| 0.0));
        let step = |time_s: f64| if time_s >= 1000.0 { 40.0 } else { 0.0 };
        let mut gap = flight(step, |_| 0.0);
        for row in 990..1000 {
            gap.channels.iter_mut().for_each(|(_, column)| {
                column.set(row, None);
            });
        }
        none(&gap);
        let mut launched = flight(step, |_| 0.0);
        let mut launch = Column::default();
        (0..2400).for_each(|row| launch.push(Some(if row >= 1000 { 1.0 } else { 0.0 })));
        launched.set_channel(Channel::Launch, launch);
        none(&launched);
    }
}
