//! Finds where a flight that does not record its launch can be calibrated: on the ground before its take-off,
//! or in its first stretch of level flight at constant speed. The caller's bounds keep it from being after
//! the landing.
//!
//! The flight is cut into blocks of a sixth of the shortest calibration (longer where fixes are rare). A
//! stretch is quiet while the blocks' median altitudes stay within half of the model's
//! `quality.trimmed_altitude_m`, their median speeds (airspeed, else speed over ground) within twice its
//! `quality.trimmed_airspeed_mps`, and their median climb rates within 0.5 m/s of zero. Medians are used so
//! that single wild fixes do not matter. Every block needs fixes and samples of an altitude sensor.

use std::fmt;

use kf_core::config::QualityConfig;

use super::error::ReplayError;
use super::window::CalibrationWindow;
use flight_data::{Channel, Column, Flight};

/// Blocks in the shortest calibration.
const BLOCKS: usize = 6;
/// Shortest calibration, whatever the model demands, seconds.
const SHORTEST_S: f32 = 12.0;
/// Least number of fixes in a block, for loggers with few fixes.
const FIXES_A_BLOCK: f64 = 2.5;
/// Longest stretch, seconds: otherwise a parked aircraft would be calibrated for hours.
const LONGEST_S: f64 = 300.0;
/// Largest median climb rate of a quiet block, m/s.
const CLIMB_RATE_MPS: f32 = 0.5;

/// A quiet stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuietStretch {
    /// Its start and end.
    pub window: CalibrationWindow,
    /// Range of its blocks' median altitudes, metres.
    pub altitude_range_m: f32,
    /// Median speed in it, m/s, if the flight has a speed.
    pub speed_mps: Option<f32>,
    /// Where the vehicle was.
    pub place: Place,
}

/// Where a stretch is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// On the ground before the take-off.
    Ground,
    /// Under a carrier, before the drop.
    Captive,
    /// In flight.
    Flight,
}

impl fmt::Display for QuietStretch {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CalibrationWindow { start_s, end_s } = self.window;
        let place = match self.place {
            Place::Ground => "ground before the take-off",
            Place::Captive => "quiet flight under the carrier before the drop",
            Place::Flight => "first quiet stretch",
        };
        write!(
            formatter,
            "the {place}, {start_s:.1}..{end_s:.1} s (altitude within {:.1} m",
            self.altitude_range_m
        )?;
        match self.speed_mps {
            Some(speed) => write!(formatter, ", speed about {speed:.0} m/s)"),
            None => write!(formatter, ")"),
        }
    }
}

/// The stretch with the least change of altitude, for a flight without a quiet one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calmest {
    /// Its start and end.
    pub window: CalibrationWindow,
    /// Range of its blocks' median altitudes, metres.
    pub altitude_range_m: f32,
    /// Range of its blocks' median speeds, m/s.
    pub speed_range_mps: f32,
}

/// A block that had fixes and sensor samples.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Block {
    index: u64,
    altitude_m: f32,
    climb_rate_mps: Option<f32>,
    speed_mps: Option<f32>,
}

/// The first quiet stretch between two times of the flight, seconds.
///
/// # Errors
/// [`ReplayError::NoQuietStretch`] with the calmest stretch, if any; [`ReplayError::TooShort`].
pub fn find(
    flight: &Flight,
    quality: &QualityConfig,
    (origin_s, last_s): (f64, f64),
) -> Result<QuietStretch, ReplayError> {
    let length_s = block_s(flight, quality);
    // Half of a short flight is left for monitoring.
    let longest_s = (0.5 * (last_s - origin_s)).min(LONGEST_S);
    let longest = ((longest_s / length_s) as usize).max(BLOCKS);
    let blocks = blocks(flight, (origin_s, last_s), length_s);
    let window = |first: &Block, blocks: usize| {
        let start_s = origin_s + first.index as f64 * length_s;
        CalibrationWindow { start_s, end_s: start_s + blocks as f64 * length_s }
    };

    let mut calmest: Option<Calmest> = None;
    // Part of the flight should be left for monitoring: a stretch in the second half is used only if there is
    // none in the first.
    let is_late = |window: CalibrationWindow| window.end_s > 0.5 * (origin_s + last_s);
    let is_calmer = |calmest: Calmest, window: CalibrationWindow, range_m: f32| {
        (is_late(window), range_m) < (is_late(calmest.window), calmest.altitude_range_m)
    };
    for start in 0..blocks.len() {
        let Some(candidates) = blocks.get(start..) else { break };
        let Some(first) = candidates.first() else { break };
        if let Some(shortest) = candidates.get(..BLOCKS).filter(|shortest| is_gapless(shortest)) {
            let range_m = range(shortest.iter().map(|block| block.altitude_m));
            let found = window(first, BLOCKS);
            if found.end_s <= last_s && calmest.is_none_or(|calmest| is_calmer(calmest, found, range_m)) {
                let speed_range_mps = range(shortest.iter().filter_map(|block| block.speed_mps));
                calmest = Some(Calmest { window: found, altitude_range_m: range_m, speed_range_mps });
            }
        }
        let mut count = quiet_blocks(candidates, quality);
        // The last block before a manoeuvre may contain its beginning.
        if count < candidates.len() {
            count = count.saturating_sub(1);
        }
        count = count.min(longest);
        let Some(stretch) = candidates.get(..count).filter(|stretch| stretch.len() >= BLOCKS) else {
            continue;
        };
        let found = window(first, count);
        if found.end_s > last_s {
            continue;
        }
        let mut speeds: Vec<f32> = stretch.iter().filter_map(|block| block.speed_mps).collect();
        return Ok(QuietStretch {
            window: found,
            altitude_range_m: range(stretch.iter().map(|block| block.altitude_m)),
            speed_mps: median(&mut speeds),
            place: Place::Flight,
        });
    }
    let (found_s, wanted_s) = (last_s - origin_s, BLOCKS as f64 * length_s);
    Err(if found_s < wanted_s {
        ReplayError::TooShort { found_s, wanted_s }
    } else {
        ReplayError::NoQuietStretch { wanted_s, calmest }
    })
}

/// The last quiet stretch between two times, seconds, the second of which is the take-off or the drop: a
/// receiver's altitude has settled by then, and the air has not changed yet. `None` where the vehicle was
/// quiet for too short a time.
#[must_use]
pub fn find_before(
    flight: &Flight,
    quality: &QualityConfig,
    (from_s, take_off_s): (f64, f64),
    place: Place,
) -> Option<QuietStretch> {
    let length_s = block_s(flight, quality);
    // Blocks are aligned to end at the take-off.
    let count = ((take_off_s - from_s) / length_s).floor();
    let origin_s = take_off_s - count * length_s;
    let mut blocks = blocks(flight, (origin_s, take_off_s), length_s);
    // A row exactly at the take-off begins one more.
    blocks.retain(|block| (block.index as f64) < count);
    blocks.reverse();
    let longest = (LONGEST_S / length_s) as usize;
    // The last blocks may contain a taxi.
    (0..blocks.len()).find_map(|skipped| {
        let candidates = blocks.get(skipped..)?;
        let count = quiet_blocks(candidates, quality).min(longest.max(BLOCKS));
        let stretch = candidates.get(..count).filter(|stretch| stretch.len() >= BLOCKS)?;
        let (last, first) = (stretch.first()?, stretch.last()?);
        let time_s = |index: u64| origin_s + index as f64 * length_s;
        let mut speeds: Vec<f32> = stretch.iter().filter_map(|block| block.speed_mps).collect();
        Some(QuietStretch {
            window: CalibrationWindow { start_s: time_s(first.index), end_s: time_s(last.index + 1) },
            altitude_range_m: range(stretch.iter().map(|block| block.altitude_m)),
            speed_mps: median(&mut speeds),
            place,
        })
    })
}

/// Length of a block, seconds.
fn block_s(flight: &Flight, quality: &QualityConfig) -> f64 {
    let wanted_s = quality.minimum_duration_s.max(SHORTEST_S);
    (f64::from(wanted_s) / BLOCKS as f64).max(FIXES_A_BLOCK * fix_interval_s(flight))
}

/// Median time between fixes, seconds.
fn fix_interval_s(flight: &Flight) -> f64 {
    let altitude = flight.channel(Channel::GpsAltM);
    let times: Vec<f64> = altitude
        .into_iter()
        .flat_map(Column::samples)
        .filter_map(|(row, _)| flight.time_s.get(row).copied())
        .collect();
    let mut intervals: Vec<f32> =
        times.iter().zip(times.iter().skip(1)).map(|(time, next)| (next - time) as f32).collect();
    f64::from(median(&mut intervals).unwrap_or(0.0)).max(0.0)
}

fn is_gapless(blocks: &[Block]) -> bool {
    blocks.iter().zip(blocks.iter().skip(1)).all(|(block, next)| next.index == block.index + 1)
}

/// Number of blocks, from the first one on, that are quiet together.
fn quiet_blocks(blocks: &[Block], quality: &QualityConfig) -> usize {
    let mut altitude = Span::default();
    let mut speed = Span::default();
    let mut last: Option<&Block> = None;
    blocks
        .iter()
        .take_while(|block| {
            let follows = last.is_none_or(|last| block.index.abs_diff(last.index) == 1);
            last = Some(block);
            altitude.take(block.altitude_m);
            if let Some(value) = block.speed_mps {
                speed.take(value);
            }
            follows
                && block.climb_rate_mps.is_none_or(|rate| rate.abs() <= CLIMB_RATE_MPS)
                && altitude.width() <= 0.5 * quality.trimmed_altitude_m
                && speed.width() <= 2.0 * quality.trimmed_airspeed_mps
        })
        .count()
}

/// Minimum and maximum of some values.
#[derive(Clone, Copy, Debug, Default)]
struct Span(Option<(f32, f32)>);

impl Span {
    fn take(&mut self, value: f32) {
        self.0 =
            Some(self.0.map_or((value, value), |(least, greatest)| (least.min(value), greatest.max(value))));
    }

    fn width(self) -> f32 {
        self.0.map_or(0.0, |(least, greatest)| greatest - least)
    }
}

fn range(values: impl Iterator<Item = f32>) -> f32 {
    let mut span = Span::default();
    values.for_each(|value| span.take(value));
    span.width()
}

fn median(values: &mut [f32]) -> Option<f32> {
    let middle = values.len().checked_sub(1)? / 2;
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// The blocks between two times that have fixes and sensor samples, in time order. Rows that run back in time
/// are left out, as in the estimator.
fn blocks(flight: &Flight, (origin_s, last_s): (f64, f64), length_s: f64) -> Vec<Block> {
    use Channel::{
        AccelZMps2, BaroAltM, BaroPa, GpsAltM, GpsVdMps, GpsVeMps, GpsVnMps, ImuMasterAltM, ImuSlaveAltM,
        TasMps,
    };
    let finite = |column: Option<&Column>, row: usize| {
        column.and_then(|column| column.get(row)).filter(|value| value.is_finite())
    };
    let sensors =
        [BaroPa, BaroAltM, ImuSlaveAltM, ImuMasterAltM, AccelZMps2].map(|channel| flight.channel(channel));
    let [altitude, north, east, down, airspeed] =
        [GpsAltM, GpsVnMps, GpsVeMps, GpsVdMps, TasMps].map(|channel| flight.channel(channel));
    // An airspeed column without a measured value does not hide the speed over ground.
    let airspeed = airspeed.filter(|column| column.samples().any(|(_, value)| value.is_finite()));

    let mut blocks = Vec::new();
    let mut pending = Pending::default();
    let mut latest_s = f64::NEG_INFINITY;
    for (row, time_s) in flight.time_s.iter().copied().enumerate() {
        if time_s <= latest_s {
            continue;
        }
        latest_s = time_s;
        if time_s < origin_s || time_s > last_s {
            continue;
        }
        let index = ((time_s - origin_s) / length_s) as u64;
        if index != pending.index {
            blocks.extend(pending.finish());
            pending = Pending { index, ..Pending::default() };
        }
        pending.has_sensor |= sensors.iter().any(|column| finite(*column, row).is_some());
        pending.altitudes.extend(finite(altitude, row));
        pending.climb_rates.extend(finite(down, row).map(|down| -down));
        let ground_speed = || Some(libm::hypotf(finite(north, row)?, finite(east, row)?));
        pending.speeds.extend(if airspeed.is_some() { finite(airspeed, row) } else { ground_speed() });
    }
    blocks.extend(pending.finish());
    blocks
}

#[derive(Default)]
struct Pending {
    index: u64,
    has_sensor: bool,
    altitudes: Vec<f32>,
    climb_rates: Vec<f32>,
    speeds: Vec<f32>,
}

impl Pending {
    fn finish(&mut self) -> Option<Block> {
        let altitude_m = median(&mut self.altitudes).filter(|_| self.has_sensor)?;
        Some(Block {
            index: self.index,
            altitude_m,
            climb_rate_mps: median(&mut self.climb_rates),
            speed_mps: median(&mut self.speeds),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One row a second, each with an altitude and a northward speed over ground.
    fn flight(rows: impl Iterator<Item = (f32, f32)>) -> Flight {
        let mut flight = Flight::default();
        let mut columns = [Channel::GpsAltM, Channel::GpsVnMps, Channel::GpsVeMps, Channel::BaroAltM]
            .map(|channel| (channel, Column::default()));
        for (row, (altitude_m, speed_mps)) in rows.enumerate() {
            flight.time_s.push(100.0 + row as f64);
            for ((_, column), value) in
                columns.iter_mut().zip([altitude_m, speed_mps, 0.0, altitude_m + 50.0])
            {
                column.push(Some(value));
            }
        }
        flight.channels = columns.into();
        flight
    }

    fn find_default(flight: &Flight) -> Result<QuietStretch, ReplayError> {
        let last_s = flight.time_s.last().copied().unwrap_or(0.0);
        let first_s = flight.time_s.first().copied().unwrap_or(0.0);
        find(flight, &model::Model::default().quality, (first_s, last_s))
    }

    /// Climbs at 3 m/s, flies level for `level` seconds, then dives at 10 m/s.
    fn climb_level_dive(level: u16) -> Flight {
        flight((0..100 + level + 60).map(|row| {
            let climbed = 3.0 * f32::from(row.min(100));
            let dived = 10.0 * f32::from(row.saturating_sub(100 + level));
            // A reference that wanders by some decimetres.
            (1000.0 + climbed - dived + 0.3 * f32::from(row % 7), 30.0)
        }))
    }

    #[test]
    fn finds_the_level_stretch_between_manoeuvres() {
        let stretch = find_default(&climb_level_dive(60)).unwrap();
        let CalibrationWindow { start_s, end_s } = stretch.window;
        // Level from 200 s to 260 s.
        assert!((195.0..=210.0).contains(&start_s), "{stretch}");
        assert!((240.0..=255.0).contains(&end_s), "{stretch}");
        assert!(stretch.altitude_range_m < 5.0);
        assert_eq!(stretch.speed_mps, Some(30.0));
        assert!(stretch.to_string().starts_with("the first quiet stretch, 2"));
    }

    #[test]
    fn says_where_it_was_calmest_when_nothing_is_quiet() {
        let error = find_default(&climb_level_dive(12)).unwrap_err().to_string();
        assert!(
            error.starts_with(
                "no launch column and no quiet stretch of 30 s to calibrate on (the calmest is "
            )
        );
        assert!(error.ends_with("give one by --calibrate START..END (seconds)"), "{error}");
        // Without a sensor there is no calmest stretch either.
        let mut blind = climb_level_dive(12);
        let rows = blind.rows();
        blind.set_channel(Channel::BaroAltM, Column::empty(rows));
        let without = find_default(&blind).unwrap_err().to_string();
        assert!(without.starts_with("no launch column and no quiet stretch of 30 s to calibrate on; give"));
    }

    #[test]
    fn a_log_of_some_seconds_is_too_short_and_not_unquiet() {
        let told = |rows: u16| {
            find_default(&flight((0..rows).map(|_| (500.0, 0.0)))).map_err(|error| error.to_string())
        };
        let words =
            "too short to be used: 29 s of flight, expected at least 30 s, to calibrate the sensors' biases";
        assert_eq!(told(30).unwrap_err(), words);
        assert!(told(32).is_ok());
    }

    #[test]
    fn single_wild_fixes_do_not_matter() {
        let mut wild = climb_level_dive(60);
        let altitude = &mut wild.channels[0].1;
        for row in (0..altitude.len()).step_by(9) {
            altitude.set(row, Some(if row % 2 == 0 { f32::NAN } else { 9000.0 }));
        }
        let stretch = find_default(&wild).unwrap();
        assert!((195.0..=210.0).contains(&stretch.window.start_s), "{stretch}");
    }

    #[test]
    fn changing_speed_is_not_quiet() {
        let speeding = flight((0..200).map(|row| (500.0, if row < 90 { row as f32 } else { 90.0 })));
        let stretch = find_default(&speeding).unwrap();
        assert!(stretch.window.start_s >= 185.0, "{stretch}");
    }

    #[test]
    fn a_slow_drift_ends_the_stretch_and_long_ones_are_cut() {
        // 0.1 m/s: 5 m within 50 s.
        let balloon = find_default(&flight((0..2000).map(|row| (0.1 * row as f32, 3.0)))).unwrap();
        let seconds = balloon.window.end_s - balloon.window.start_s;
        assert!((35.0..=50.0).contains(&seconds), "{balloon}");
        let parked = find_default(&flight((0..2000).map(|_| (500.0, 0.0)))).unwrap();
        assert_eq!(parked.window, CalibrationWindow { start_s: 100.0, end_s: 400.0 });
        let short = find_default(&flight((0..101).map(|_| (500.0, 0.0)))).unwrap();
        assert_eq!(short.window, CalibrationWindow { start_s: 100.0, end_s: 150.0 });
    }

    #[test]
    fn every_block_needs_an_altitude_sensor() {
        let mut blind = climb_level_dive(60);
        let rows = blind.rows();
        blind.set_channel(Channel::BaroAltM, Column::empty(rows));
        assert!(find_default(&blind).is_err());
    }

    #[test]
    fn rare_fixes_make_longer_blocks() {
        let mut slow = flight((0..100).map(|_| (500.0, 20.0)));
        slow.time_s = (0..100).map(|row| f64::from(row) * 8.0).collect();
        let stretch = find_default(&slow).unwrap();
        assert!(stretch.window.end_s - stretch.window.start_s >= 120.0, "{stretch}");
    }

    /// Limits that differ from each other and from their sums: blocks of 5 s, heights within 10 m, speeds
    /// within 8 m/s.
    fn quality() -> QualityConfig {
        QualityConfig {
            minimum_duration_s: 30.0,
            trimmed_altitude_m: 20.0,
            trimmed_airspeed_mps: 4.0,
            ..model::Model::default().quality
        }
    }

    fn before(flight: &Flight, from_s: f64, take_off_s: f64) -> Option<(f64, f64)> {
        let stretch = find_before(flight, &quality(), (from_s, take_off_s), Place::Ground)?;
        Some((stretch.window.start_s, stretch.window.end_s))
    }

    /// The stretch before a take-off is the last quiet one: it ends at the take-off, lasts five minutes at
    /// most, and begins after the given start.
    #[test]
    fn the_stretch_before_a_take_off_ends_there_and_begins_no_earlier_than_it_may() {
        let parked = flight((0..1_000).map(|_| (500.0, 0.0)));
        assert_eq!(before(&parked, 100.0, 1_000.0), Some((700.0, 1_000.0)));
        assert_eq!(before(&parked, 800.0, 1_000.0), Some((800.0, 1_000.0)));
        // 62 s are twelve blocks and 2 s.
        assert_eq!(before(&parked, 938.0, 1_000.0), Some((940.0, 1_000.0)));
        assert_eq!(before(&parked, 971.0, 1_000.0), None, "29 s");
        // A taxi of 20 s before the take-off is not quiet.
        let taxi = flight((0..1_000).map(|row| (500.0, if row >= 880 { 15.0 } else { 0.0 })));
        assert_eq!(before(&taxi, 850.0, 1_000.0), Some((850.0, 980.0)));
        let rough = flight((0..1_000).map(|row| (500.0 + 30.0 * (row % 40) as f32, 0.0)));
        assert_eq!(before(&rough, 100.0, 1_000.0), None);
    }

    /// Heights stay within half of the altitude's limit and speeds within twice the speed's: 10 m and 8 m/s
    /// here.
    #[test]
    fn quiet_is_half_the_altitudes_limit_and_twice_the_speeds() {
        let steps = |height_m: f32, speed_mps: f32| {
            let second =
                |row: u16| if row < 20 { (500.0, 20.0) } else { (500.0 + height_m, 20.0 + speed_mps) };
            find(&flight((0..40).map(second)), &quality(), (100.0, 139.0))
        };
        let stretch = steps(9.5, 7.5).unwrap();
        assert_eq!((stretch.altitude_range_m, stretch.speed_mps), (9.5, Some(20.0)));
        assert!(steps(10.5, 0.0).is_err() && steps(0.0, 8.5).is_err());
    }

    /// Rows outside the two times do not count, on either side.
    #[test]
    fn rows_outside_the_two_times_do_not_count() {
        let level = |row: u16| if (60..160).contains(&row) { 500.0 } else { 900.0 - 3.0 * f32::from(row) };
        let flown = flight((0..260).map(|row| (level(row), 30.0)));
        let stretch = find(&flown, &quality(), (160.0, 259.0)).unwrap();
        // Half of 99 s, in whole blocks.
        assert_eq!(stretch.window, CalibrationWindow { start_s: 160.0, end_s: 205.0 });
        assert_eq!(stretch.altitude_range_m, 0.0);
        assert_eq!(before(&flown, 160.0, 260.0), Some((160.0, 260.0)));
    }

    /// Thirty seconds from the first row to the last are just enough, quiet or not; and so is a stretch that
    /// ends with the log's last fix.
    #[test]
    fn thirty_seconds_are_just_enough() {
        let still = find_default(&flight((0..31).map(|_| (500.0, 0.0)))).unwrap();
        assert_eq!(still.window, CalibrationWindow { start_s: 100.0, end_s: 130.0 });
        let climbing = find_default(&flight((0..31).map(|row| (500.0 + 5.0 * row as f32, 0.0))));
        assert!(matches!(climbing, Err(ReplayError::NoQuietStretch { .. })));
        let mut ends = flight((0..31).map(|_| (500.0, 0.0)));
        ends.channels[0].1.set(30, None);
        assert_eq!(find_default(&ends).unwrap().window, still.window);
    }

    /// If nothing is quiet, the calmest stretch is one of the first half, however much calmer the second is.
    /// Within a half it is the one with the least change of height, and of two equal ones the first. It has
    /// no gap.
    #[test]
    fn the_calmest_leaves_half_of_the_flight_to_be_watched() {
        let calmest = |flight: &Flight| match find(flight, &quality(), (100.0, 699.0)) {
            Err(ReplayError::NoQuietStretch { calmest: Some(calmest), .. }) => calmest,
            other => panic!("{other:?}"),
        };
        // Half a minute each of three slopes: 3 m/s, from 250 s to 310 s 1 m/s, from 550 s to 610 s 0.6 m/s.
        let slope = |row: u16| match row {
            150..210 => 1.0,
            450..510 => 0.6,
            _ => 3.0,
        };
        let heights: Vec<f32> = (0..600)
            .scan(0.0, |height_m, row| {
                *height_m += slope(row);
                Some(*height_m)
            })
            .collect();
        let mut flown = flight(heights.iter().map(|height_m| (*height_m, 30.0)));
        let found = calmest(&flown);
        // Medians of blocks of 5 s: six of them are five steps apart.
        assert!((found.altitude_range_m - 25.0).abs() < 0.01, "{found:?}");
        assert_eq!(found.window, CalibrationWindow { start_s: 250.0, end_s: 280.0 });
        assert_eq!(found.speed_range_mps, 0.0);
        // If ten seconds in its middle have no fix, no six consecutive blocks of it are left.
        for row in 175..185 {
            flown.channels[0].1.set(row, None);
        }
        let found = calmest(&flown);
        assert!(found.altitude_range_m > 25.1 && found.window.end_s <= 400.0, "{found:?}");
    }

    /// Blocks hold two and a half fixes: with fixes 8 s apart they last 20 s, and five minutes have fifteen.
    #[test]
    fn a_block_holds_two_and_a_half_fixes() {
        let mut slow = flight((0..100).map(|_| (500.0, 20.0)));
        slow.time_s = (0..100).map(|row| f64::from(row) * 8.0).collect();
        assert_eq!(block_s(&slow, &quality()), 20.0);
        assert_eq!(block_s(&flight((0..9).map(|_| (500.0, 20.0))), &quality()), 5.0);
        assert_eq!(median(&mut [5.0, 1.0, 3.0, 2.0, 4.0]), Some(3.0));
    }

    /// Consecutive blocks have no gap between them.
    #[test]
    fn a_missing_block_is_a_gap() {
        let of = |indices: &[u64]| {
            let block =
                |index: &u64| Block { index: *index, altitude_m: 0.0, climb_rate_mps: None, speed_mps: None };
            is_gapless(&indices.iter().map(block).collect::<Vec<_>>())
        };
        assert!(of(&[4, 5, 6]) && of(&[7]) && of(&[]));
        assert!(!of(&[4, 6, 7]) && !of(&[4, 5, 7]));
    }
}
