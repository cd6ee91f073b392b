//! The launch of a rocket: from standing it rises faster than anything that flies by its wings or propellers.
//!
//! Within [`RISE_S`] of the launch a rocket with the least thrust that clubs let fly, three times its weight
//! (Tripoli Rocketry Association, "Safety Code for High Power Rocketry", 2024), rises by 39 m: half of two g
//! times four seconds squared. A multicopter with twice its weight of thrust, which few have, rises by 20 m.
//! The limit is their geometric middle. An aircraft that pulls up rises as fast, but is fast before it does.

use flight_data::{Channel, Column, Flight};

use super::blocks::{Heights, altitudes, median_interval_s};

/// How long the rise is looked at, seconds.
const RISE_S: f64 = 2.0;
/// What it must come to, metres.
const LEAST_RISE_M: f64 = 28.0;
/// From standing, the second half of a steady acceleration has three times the rise of the first, and a
/// steady climb the same. With this ratio and that rise the acceleration is 1.2 g or more: what a multicopter
/// does not have that is climbing already.
const LEAST_RATIO: f64 = 2.5;
/// It stands as long as it is within this of where the rise begins, metres.
const STANDING_M: f64 = 1.0;
/// Heights at either end of the rise are medians over this much around, seconds: single wild ones are none.
const AROUND_S: f64 = 0.15;
/// Of a barometer that is slower than this the beginning of a boost cannot be seen, seconds between samples.
const SLOWEST_S: f64 = 0.1;
/// Faster over ground than this it did not stand, m/s: the receiver of a vehicle on its rail shows the wind's
/// swaying and its noise.
const STANDING_MPS: f64 = 10.0;
/// The speed that is asked for is at most so far from the launch, seconds.
const NEAR_S: f64 = 1.5;

/// A launch by a rocket motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boost {
    /// When it began, seconds of the flight's own clock.
    pub from_s: f64,
    /// How far it rose in the two seconds after, metres.
    pub rise_m: f64,
}

/// The first launch by a rocket motor, if there is one that a barometer with ten samples a second or more
/// shows.
#[must_use]
pub fn boost(flight: &Flight) -> Option<Boost> {
    let (samples, heights) = altitudes(flight)?;
    let mut heights_m: Vec<(f64, f64)> = Vec::with_capacity(samples.len());
    for (_, time_s, metres) in samples {
        // Rows that run back in time are left out, as the estimator does.
        if heights_m.last().is_none_or(|(before_s, _)| time_s > *before_s) {
            heights_m.push((time_s, metres));
        }
    }
    let interval_s = median_interval_s(heights_m.iter().map(|(time_s, _)| *time_s).collect());
    if heights != Heights::Barometer || interval_s > SLOWEST_S {
        return None;
    }
    let around = |at_s: f64| {
        let first = heights_m.partition_point(|(time_s, _)| *time_s < at_s - AROUND_S);
        let inside = heights_m.get(first..)?.iter().take_while(|(time_s, _)| *time_s <= at_s + AROUND_S);
        super::blocks::median(&mut inside.map(|(_, metres)| *metres).collect::<Vec<f64>>())
    };
    heights_m.iter().find_map(|(from_s, _)| {
        let (first, middle, last) =
            (around(*from_s)?, around(from_s + RISE_S / 2.0)?, around(from_s + RISE_S)?);
        let is_boost =
            last - first >= LEAST_RISE_M && last - middle >= LEAST_RATIO * (middle - first).max(0.0);
        if !is_boost || !stands(flight, *from_s) {
            return None;
        }
        // The rise of a strong motor is enough before all of its two seconds have passed.
        let during = heights_m.iter().map(|(time_s, _)| *time_s).skip_while(|time_s| time_s < from_s);
        let during = during.take_while(|time_s| *time_s <= from_s + RISE_S);
        let lit_s =
            during.filter(|time_s| around(*time_s).is_some_and(|metres| metres <= first + STANDING_M)).last();
        let lit_s = lit_s.unwrap_or(*from_s);
        let rise_m = around(lit_s + RISE_S).unwrap_or(last) - first;
        Some(Boost { from_s: lit_s, rise_m })
    })
}

/// Whether nothing says that it moved over ground at a time.
fn stands(flight: &Flight, at_s: f64) -> bool {
    let column = |channel| flight.channel(channel).into_iter().flat_map(Column::samples);
    let is_near = |row: &usize| flight.time_s.get(*row).is_some_and(|time_s| (time_s - at_s).abs() <= NEAR_S);
    let mut speeds: Vec<f64> = column(Channel::GpsVnMps)
        .filter(|(row, north)| is_near(row) && north.is_finite())
        .filter_map(|(row, north)| {
            let east = flight.channel(Channel::GpsVeMps)?.get(row).filter(|east| east.is_finite())?;
            Some(libm::hypot(f64::from(north), f64::from(east)))
        })
        .collect();
    super::blocks::median(&mut speeds).is_none_or(|speed| speed <= STANDING_MPS)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Barometer at 20 Hz, receiver's speed at 1 Hz, by height and speed over time.
    fn flown(height_m: impl Fn(f64) -> f64, speed_mps: impl Fn(f64) -> f64) -> Flight {
        let mut flight = Flight::default();
        let [mut baro, mut north, mut east] = [Column::default(), Column::default(), Column::default()];
        for row in 0..600_u32 {
            let time_s = f64::from(row) / 20.0;
            flight.time_s.push(time_s);
            // A decimetre of noise that repeats with nothing.
            let noise_m = 0.1 * libm::sin(f64::from(row) * 2.3);
            baro.push(Some((height_m(time_s) + noise_m) as f32));
            let fix = row.is_multiple_of(20);
            north.push(fix.then_some(speed_mps(time_s) as f32));
            east.push(fix.then_some(0.0));
        }
        flight.channels =
            vec![(Channel::BaroAltM, baro), (Channel::GpsVnMps, north), (Channel::GpsVeMps, east)];
        flight
    }

    /// Stands for 10 s, then accelerates upward for 3 s and coasts.
    fn accelerated(upward_mps2: f64) -> impl Fn(f64) -> f64 {
        move |time_s: f64| {
            let (burnt, since) = ((time_s - 10.0).clamp(0.0, 3.0), (time_s - 13.0).max(0.0));
            100.0 + 0.5 * upward_mps2 * burnt * burnt + 3.0 * upward_mps2 * since - 4.9 * since * since
        }
    }

    #[test]
    fn the_weakest_rocket_that_may_fly_is_found_within_a_second_and_a_strong_multicopter_is_none() {
        let found = boost(&flown(accelerated(19.6), |_| 0.5)).unwrap();
        assert!((found.from_s - 10.0).abs() <= 1.0 && found.rise_m >= 28.0, "{found:?}");
        let strong = boost(&flown(accelerated(80.0), |_| 0.5)).unwrap();
        assert!((strong.from_s - 10.0).abs() <= 1.0, "{strong:?}");
        assert_eq!(boost(&flown(accelerated(9.8), |_| 0.5)), None);
    }

    #[test]
    fn a_log_that_begins_at_the_launch_has_it_at_its_beginning() {
        let rising = accelerated(50.0);
        let found = boost(&flown(move |time_s| rising(time_s + 9.9), |_| 0.5)).unwrap();
        assert!(found.from_s <= 0.5, "{found:?}");
    }

    #[test]
    fn a_fast_climb_a_pull_up_and_a_wild_sample_are_no_launch() {
        assert_eq!(boost(&flown(|time_s| 25.0 * time_s, |_| 60.0)), None);
        assert_eq!(boost(&flown(|time_s| 25.0 * time_s, |_| 3.0)), None);
        // The pull-up of a glider that was fast.
        assert_eq!(boost(&flown(accelerated(25.0), |time_s| if time_s < 12.0 { 70.0 } else { 5.0 })), None);
        let wild = |time_s: f64| if (time_s - 12.0).abs() < 0.01 { 500.0 } else { 100.0 };
        assert_eq!(boost(&flown(wild, |_| 0.0)), None);
    }

    /// The boost begins where the height leaves a metre above the stand: by 19.6 m/s2 after 0.32 s. From
    /// there to two seconds later the rocket rises to half of that times 2.32 s squared, 52.7 m; a sample is
    /// 50 ms, in which it rises by 2.3 m at the end.
    #[test]
    fn beginning_and_rise_are_those_of_a_steady_acceleration() {
        let found = boost(&flown(accelerated(19.6), |_| 0.5)).unwrap();
        assert!((found.from_s - 10.32).abs() <= 0.1, "{found:?}");
        assert!((found.rise_m - 52.7).abs() <= 2.0 * 2.3, "{found:?}");
    }

    /// What comes back to the ground stands there again, which is no second beginning; nor is a drive to the
    /// rail, seconds before.
    #[test]
    fn neither_a_landing_nor_a_drive_to_the_rail_moves_the_launch() {
        // Two seconds of thrust at the log's middle: 39 m at 39 m/s, back on the ground 9 s later.
        let small = |time_s: f64| {
            let (burnt, since) = ((time_s - 13.0).clamp(0.0, 2.0), (time_s - 15.0).max(0.0));
            (100.0 + 9.8 * burnt * burnt + 39.2 * since - 4.9 * since * since).max(100.0)
        };
        let found = boost(&flown(small, |time_s| if time_s < 11.0 { 20.0 } else { 0.5 })).unwrap();
        assert!((found.from_s - 13.32).abs() <= 0.1, "{found:?}");
    }

    /// A row whose time does not go on from the one before is left out, whatever it says.
    #[test]
    fn rows_that_repeat_a_time_are_left_out() {
        let once = flown(accelerated(19.6), |_| 0.5);
        let mut thrice = Flight::default();
        let mut baro = Column::default();
        for (row, time_s) in once.time_s.iter().enumerate() {
            let own = once.channels[0].1.get(row);
            for cell in [own, Some(0.0), Some(0.0)] {
                thrice.time_s.push(*time_s);
                baro.push(cell);
            }
        }
        thrice.channels = vec![(Channel::BaroAltM, baro)];
        assert_eq!(boost(&thrice), boost(&once));
    }

    /// By a receiver's heights, or by a barometer with five samples a second, no beginning is told.
    #[test]
    fn only_a_fast_barometer_shows_a_launch() {
        let mut receiver = flown(accelerated(40.0), |_| 0.5);
        receiver.channels[0].0 = Channel::GpsAltM;
        assert_eq!(boost(&receiver), None);
        let mut slow = flown(accelerated(40.0), |_| 0.5);
        for row in (0..600).filter(|row| row % 4 != 0) {
            slow.channels[0].1.set(row, None);
        }
        assert_eq!(boost(&slow), None);
    }
}
