//! Detects a rocket launch: from standing, it rises faster than anything that flies by wings or propellers.
//!
//! Within [`RISE_S`] of the launch a rocket with the least thrust that clubs permit, three times its weight
//! (Tripoli Rocketry Association, "Safety Code for High Power Rocketry", 2024), rises by 39 m: half of two g
//! times four seconds squared. A multicopter whose thrust is twice its weight, which few have, rises by 20 m.
//! The limit is their geometric mean. An aircraft that pulls up rises as fast, but is already fast before.

use flight_data::{Channel, Column, Flight};

use super::blocks::{Heights, altitudes, median_interval_s};

/// Duration over which the rise is measured, seconds.
const RISE_S: f64 = 2.0;
/// Least rise of a launch, metres.
const LEAST_RISE_M: f64 = 28.0;
/// Least ratio of the rise in the second half to that in the first: three for a steady acceleration from
/// standing, one for a steady climb. With this ratio and that rise the acceleration is 1.2 g or more, which a
/// multicopter that is already climbing cannot reach.
const LEAST_RATIO: f64 = 2.5;
/// The vehicle stands as long as it is within this of the height where the rise begins, metres.
const STANDING_M: f64 = 1.0;
/// Heights at either end of the rise are medians over this time before and after, seconds, so that single
/// wild samples do not matter.
const AROUND_S: f64 = 0.15;
/// Longest time between samples, seconds: a slower barometer does not show when a boost begins.
const SLOWEST_S: f64 = 0.1;
/// Largest speed over ground of a standing vehicle, m/s: on the rail a receiver shows the wind's swaying and
/// its own noise.
const STANDING_MPS: f64 = 10.0;
/// Speeds are taken within this time of the launch, seconds.
const NEAR_S: f64 = 1.5;

/// A launch by a rocket motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boost {
    /// When it began, seconds of the flight's own clock.
    pub from_s: f64,
    /// Its rise in the two seconds after that, metres.
    pub rise_m: f64,
}

/// The first rocket launch, if a barometer with at least ten samples a second shows one.
#[must_use]
pub fn boost(flight: &Flight) -> Option<Boost> {
    let (samples, heights) = altitudes(flight)?;
    let mut heights_m: Vec<(f64, f64)> = Vec::with_capacity(samples.len());
    for (_, time_s, metres) in samples {
        // Rows that run back in time are left out, as in the estimator.
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
        // A strong motor's rise is large enough before all of its two seconds have passed.
        let during = heights_m.iter().map(|(time_s, _)| *time_s).skip_while(|time_s| time_s < from_s);
        let during = during.take_while(|time_s| *time_s <= from_s + RISE_S);
        let lit_s =
            during.filter(|time_s| around(*time_s).is_some_and(|metres| metres <= first + STANDING_M)).last();
        let lit_s = lit_s.unwrap_or(*from_s);
        let rise_m = around(lit_s + RISE_S).unwrap_or(last) - first;
        Some(Boost { from_s: lit_s, rise_m })
    })
}

/// Whether no recorded speed shows that it moved over ground at that time.
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

    /// Barometer at 20 Hz and receiver's speed at 1 Hz, from height and speed over time.
    fn flown(height_m: impl Fn(f64) -> f64, speed_mps: impl Fn(f64) -> f64) -> Flight {
        let mut flight = Flight::default();
        let [mut baro, mut north, mut east] = [Column::default(), Column::default(), Column::default()];
        for row in 0..600_u32 {
            let time_s = f64::from(row) / 20.0;
            flight.time_s.push(time_s);
            // A decimetre of noise whose period is unrelated to the sample time.
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

    /// Stands for 10 s, accelerates upward for 3 s, then coasts.
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
        // The pull-up of a glider that was already fast.
        assert_eq!(boost(&flown(accelerated(25.0), |time_s| if time_s < 12.0 { 70.0 } else { 5.0 })), None);
        let wild = |time_s: f64| if (time_s - 12.0).abs() < 0.01 { 500.0 } else { 100.0 };
        assert_eq!(boost(&flown(wild, |_| 0.0)), None);
    }

    /// The boost begins where the height exceeds a metre above the stand: with 19.6 m/s2 after 0.32 s. Within
    /// the next two seconds the rocket rises to half of that times 2.32 s squared, 52.7 m. A sample is 50 ms,
    /// in which it rises by 2.3 m at the end.
    #[test]
    fn beginning_and_rise_are_those_of_a_steady_acceleration() {
        let found = boost(&flown(accelerated(19.6), |_| 0.5)).unwrap();
        assert!((found.from_s - 10.32).abs() <= 0.1, "{found:?}");
        assert!((found.rise_m - 52.7).abs() <= 2.0 * 2.3, "{found:?}");
    }

    /// A vehicle that returns to the ground stands there again, which is no second beginning. Neither is a
    /// drive to the rail, seconds before.
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

    /// A row whose time does not increase is left out, whatever its content.
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

    /// A receiver's heights, or a barometer with five samples a second, show no beginning.
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
