//! Finds wild cells: values that no aircraft can reach from those before and leave for those after.
//!
//! In a flight computer the gates reject them. A diagnosis estimates coefficients from every cell, so a
//! hundred impossible airspeeds among ten thousand look like an effect. It therefore leaves cells out and
//! reports them ([`WildCells::sentence`]), by physics alone:
//!
//! - A value is a *jump* from another if it is further away than the quantity's largest rate allows in the
//!   time between, and than [`NOISE_SIGMAS`] of the column's own noise. No aircraft reaches these rates:
//!   400 m/s up or down, 10 g, 12 rad/s (two turns a second), 10 K/s.
//! - Cells between two jumps, at most a hundredth of the column's, are wild. More are a shifted level, which
//!   is for the diagnosis to explain.
//! - One or two altitudes beyond both neighbours are wild, if they are further away than an acceleration of
//!   10 g and the noise explain, and than the distances to the two neighbours differ.
//!
//! Quantities without a largest rate (specific force, rates of turn, throttle, satellites) are left as they
//! are.

use std::sync::Arc;

use flight_data::{Channel, Column, Flight};
use statistics::RobustSpread;

/// Largest deviation that a column's noise explains: for Student's t with three degrees of freedom, 4 of
/// 10,000 values are beyond.
const NOISE_SIGMAS: f64 = 12.0;
/// Limit on wild cells between two jumps: a share of the column's cells, and a number that is always allowed.
const MOST_SHARE: f64 = 0.01;
const MOST_ALWAYS: usize = 3;
/// 10 g, m/s^2.
const ACCELERATION_MPS2: f64 = 100.0;

/// Kinds of quantity, by how they may move.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    /// Metres.
    Altitude,
    /// Pascals, converted to metres of altitude.
    Pressure,
    /// Metres a second.
    Speed,
    /// Radians.
    Angle,
    /// Radians that wrap around after a turn.
    Heading,
    /// Kelvin.
    Temperature,
}

impl Kind {
    const fn of(channel: Channel) -> Option<Self> {
        Some(match channel {
            Channel::GpsAltM | Channel::BaroAltM | Channel::ImuMasterAltM | Channel::ImuSlaveAltM => {
                Self::Altitude
            }
            Channel::BaroPa => Self::Pressure,
            Channel::GpsVnMps | Channel::GpsVeMps | Channel::GpsVdMps | Channel::TasMps => Self::Speed,
            Channel::PitchRad | Channel::AoaRad | Channel::SideslipRad => Self::Angle,
            Channel::RollRad | Channel::YawRad => Self::Heading,
            Channel::BaroTempC | Channel::OatC => Self::Temperature,
            _ => return None,
        })
    }

    /// Largest change a second.
    const fn rate(self) -> f64 {
        match self {
            Self::Altitude | Self::Pressure => 400.0,
            Self::Speed => ACCELERATION_MPS2,
            Self::Angle | Self::Heading => 12.0,
            Self::Temperature => 10.0,
        }
    }

    /// A cell in the unit of [`Self::rate`]; `None` for one that is not finite, which the estimator itself
    /// refuses.
    fn value(self, cell: f32) -> Option<f64> {
        let cell = f64::from(cell);
        let value = match self {
            // Metres in the lower kilometres of a standard atmosphere.
            Self::Pressure => -8_000.0 * libm::log(cell),
            _ => cell,
        };
        value.is_finite().then_some(value)
    }

    fn difference(self, to: f64, from: f64) -> f64 {
        let difference = to - from;
        match self {
            Self::Heading => libm::remainder(difference, core::f64::consts::TAU),
            _ => difference,
        }
    }
}

/// A column's wild cells.
#[derive(Clone, Debug, PartialEq)]
pub struct WildCells {
    /// The column.
    pub channel: Channel,
    /// How many there are.
    pub count: usize,
    /// Time of the first one, seconds of the flight's own clock.
    pub first_s: f64,
    /// Value of the first one, in the column's unit.
    pub first_value: f32,
}

impl WildCells {
    /// One line for the user.
    #[must_use]
    pub fn sentence(&self) -> String {
        let Self { channel, count, first_s, first_value } = self;
        let name = channel.name();
        if *count == 1 {
            format!("{name} is {first_value} at {first_s:.1} s, which is implausible; left out")
        } else {
            format!(
                "{count} cells of {name} are implausible ({first_value} at {first_s:.1} s is the first); left out"
            )
        }
    }
}

/// A value with its row and time.
#[derive(Clone, Copy, Debug)]
struct Sample {
    row: usize,
    time_s: f64,
    value: f64,
}

/// The columns that have wild cells, without those cells, and a list of what was taken out.
pub(super) fn tamed(flight: &Flight) -> (Vec<(Channel, Arc<Column>)>, Vec<WildCells>) {
    let mut columns = Vec::new();
    let mut wild = Vec::new();
    for (channel, column) in &flight.channels {
        let Some(kind) = Kind::of(*channel) else { continue };
        let rows = wild_rows(kind, column, &flight.time_s);
        let first = rows.iter().min().copied();
        let Some((first, first_value)) = first.and_then(|row| Some((row, column.get(row)?))) else {
            continue;
        };
        let mut column = column.clone();
        for row in &rows {
            column.set(*row, None);
        }
        columns.push((*channel, Arc::new(column)));
        let first_s = flight.time_s.get(first).copied().unwrap_or_default();
        wild.push(WildCells { channel: *channel, count: rows.len(), first_s, first_value });
    }
    (columns, wild)
}

fn wild_rows(kind: Kind, column: &Column, time_s: &[f64]) -> Vec<usize> {
    let mut samples: Vec<Sample> = Vec::new();
    for (row, cell) in column.samples() {
        let (Some(value), Some(time_s)) = (kind.value(cell), time_s.get(row).copied()) else { continue };
        // A replay ignores rows whose time does not increase.
        if samples.last().is_none_or(|last| time_s > last.time_s) {
            samples.push(Sample { row, time_s, value });
        }
    }
    let noise = NOISE_SIGMAS * noise(kind, &samples);
    let mut rows = between_jumps(kind, &mut samples, noise);
    if matches!(kind, Kind::Altitude | Kind::Pressure) {
        rows.extend(beyond_neighbours(&samples, noise));
    }
    rows
}

/// Standard deviation of a value about the mean of its neighbours, robust to outliers.
fn noise(kind: Kind, samples: &[Sample]) -> f64 {
    let mut apart = RobustSpread::default();
    for window in samples.windows(3) {
        if let [before, value, after] = window {
            let both = kind.difference(value.value, before.value) - kind.difference(after.value, value.value);
            apart.push(0.5 * both);
        }
    }
    // The difference from the mean of two neighbours has one and a half times a value's variance.
    apart.sigma().unwrap_or(0.0) / 1.5_f64.sqrt()
}

/// Removes short segments between jumps from the samples, and returns their rows.
fn between_jumps(kind: Kind, samples: &mut Vec<Sample>, noise: f64) -> Vec<usize> {
    let is_jump = |from: &Sample, to: &Sample| {
        kind.difference(to.value, from.value).abs() > (kind.rate() * (to.time_s - from.time_s)).max(noise)
    };
    let segments: Vec<&[Sample]> = samples.chunk_by(|from, to| !is_jump(from, to)).collect();
    if segments.len() < 2 {
        return Vec::new();
    }
    let most = ((MOST_SHARE * samples.len() as f64) as usize).max(MOST_ALWAYS);
    // The longest segment is taken as right. From there in both directions, a segment is right if it
    // continues from the last right one, or is long itself.
    let longest =
        (0..segments.len()).rev().max_by_key(|k| segments.get(*k).map_or(0, |segment| segment.len()));
    let (earlier, later) = segments.split_at(longest.unwrap_or_default());
    let mut is_right = vec![true; segments.len()];
    let mut last = None;
    for (right, segment) in is_right.iter_mut().skip(earlier.len()).zip(later) {
        let goes_on = last.zip(segment.first()).is_none_or(|(last, first)| !is_jump(last, first));
        *right = goes_on || segment.len() > most;
        last = if *right { segment.last() } else { last };
    }
    let mut next = later.first().and_then(|segment| segment.first());
    for (right, segment) in is_right.iter_mut().zip(earlier).rev() {
        let goes_on = segment.last().zip(next).is_none_or(|(last, next)| !is_jump(last, next));
        *right = goes_on || segment.len() > most;
        next = if *right { segment.first() } else { next };
    }
    let mut rows = Vec::new();
    let mut good: Vec<Sample> = Vec::with_capacity(samples.len());
    for (right, segment) in is_right.into_iter().zip(segments) {
        if right {
            good.extend_from_slice(segment);
        } else {
            rows.extend(segment.iter().map(|sample| sample.row));
        }
    }
    // A column that consists of jumps has no level to depart from.
    if good.len() * 2 < samples.len() {
        return Vec::new();
    }
    *samples = good;
    rows
}

/// Rows of altitudes, single or two in a row, that are further beyond both neighbours than an aircraft's
/// acceleration allows.
fn beyond_neighbours(samples: &[Sample], noise: f64) -> Vec<usize> {
    let is_beyond = |before: &Sample, value: &Sample, after: &Sample| {
        let (up, down) = (value.value - before.value, value.value - after.value);
        let (since_s, until_s) = (value.time_s - before.time_s, after.time_s - value.time_s);
        let limit = (0.5 * ACCELERATION_MPS2 * since_s * until_s).max(noise);
        // Also by more than the two distances differ, or it is the corner of a shifting level.
        up * down > 0.0 && up.abs().min(down.abs()) > limit.max((up - down).abs())
    };
    let mut rows = Vec::new();
    for window in samples.windows(3) {
        if let [before, value, after] = window
            && is_beyond(before, value, after)
        {
            rows.push(value.row);
        }
    }
    for window in samples.windows(4) {
        if let [before, first, second, after] = window
            && is_beyond(before, first, after)
            && is_beyond(before, second, after)
        {
            rows.extend([first.row, second.row]);
        }
    }
    rows.sort_unstable();
    rows.dedup();
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.04;

    /// Heavy-tailed noise: Student's t with three degrees of freedom, from a generator of Numerical Recipes.
    fn heavy(seed: &mut u32) -> f64 {
        let mut normal = || {
            (0..12).fold(-6.0, |sum, _| {
                *seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum + f64::from(*seed >> 8) / f64::from(1_u32 << 24)
            })
        };
        let (top, squares) = (normal(), (0..3).map(|_| normal().powi(2)).sum::<f64>());
        top / (squares / 3.0).sqrt()
    }

    /// A flight with one column, a cell in each row.
    fn flight(channel: Channel, step_s: f64, cells: &[f32]) -> Flight {
        let mut column = Column::with_capacity(cells.len());
        cells.iter().for_each(|cell| column.push(Some(*cell)));
        let time_s = (0..cells.len()).map(|row| row as f64 * step_s).collect();
        Flight { time_s, channels: vec![(channel, column)], ..Flight::default() }
    }

    fn rows(channel: Channel, step_s: f64, cells: &[f32]) -> Vec<usize> {
        let flight = flight(channel, step_s, cells);
        let (tamed, _) = tamed(&flight);
        let Some((_, column)) = tamed.first() else { return Vec::new() };
        (0..cells.len()).filter(|row| column.get(*row).is_none()).collect()
    }

    /// An airspeed that rises, gusts and has a heavy tail, a dive at 10 g, and a receiver's steps are all
    /// possible for an aircraft.
    #[test]
    fn what_an_aircraft_does_is_left_alone() {
        let mut seed = 3;
        let speed: Vec<f32> = (0..20_000)
            .map(|row| {
                let time_s = f64::from(row) * STEP_S;
                (40.0 + 25.0 * (0.7 * time_s).sin() + 0.4 * heavy(&mut seed)) as f32
            })
            .collect();
        // The white part is 0.4 m/s, and 12 sigmas are 4.8 m/s: of 20,000 heavy-tailed values some ten are
        // beyond.
        let left_out = rows(Channel::TasMps, STEP_S, &speed).len();
        assert!(left_out < 30, "{left_out}");
        let altitude =
            |time_s: f64| 3_000.0 - 500.0 * (0.4 * time_s).sin() + if time_s > 300.0 { 40.0 } else { 0.0 };
        let dives: Vec<f32> = (0..20_000).map(|row| altitude(f64::from(row) * STEP_S) as f32).collect();
        assert_eq!(rows(Channel::BaroAltM, STEP_S, &dives), Vec::<usize>::new());
        let slowly: Vec<f32> = (0..800).map(|row| altitude(f64::from(row)) as f32).collect();
        assert_eq!(rows(Channel::GpsAltM, 1.0, &slowly), Vec::<usize>::new());
        let spinning: Vec<f32> = (0..5_000)
            .map(|row| libm::remainder(f64::from(row) * 0.4, core::f64::consts::TAU) as f32)
            .collect();
        assert_eq!(rows(Channel::YawRad, STEP_S, &spinning), Vec::<usize>::new());
    }

    #[test]
    fn wild_cells_are_found_wherever_they_are_and_in_bursts() {
        let mut seed = 5;
        let speed: Vec<f32> = (0..10_000).map(|_| (28.0 + 0.3 * heavy(&mut seed)) as f32).collect();
        let usual = rows(Channel::TasMps, STEP_S, &speed);
        // At the beginning; alone; two of different values; a burst of a hundredth; at the end.
        let wild: Vec<usize> =
            [0, 50, 777, 2_000, 2_001].into_iter().chain(5_000..5_100).chain([9_999]).collect();
        for value in [300.0, 1_000.0, -80.0] {
            let mut cells = speed.clone();
            wild.iter().for_each(|row| cells[*row] = value);
            cells[2_001] = value + 500.0;
            let mut expected = usual.clone();
            expected.extend(&wild);
            expected.sort_unstable();
            expected.dedup();
            assert_eq!(rows(Channel::TasMps, STEP_S, &cells), expected, "{value}");
        }
        // A longer one is a shifted level.
        let mut shifted = speed;
        shifted[5_000..5_300].iter_mut().for_each(|cell| *cell += 200.0);
        assert_eq!(rows(Channel::TasMps, STEP_S, &shifted), usual);
    }

    /// 150 m off for a second or two, which is no jump for a vehicle that might climb at 400 m/s; and
    /// pressures.
    #[test]
    fn altitudes_that_leave_and_come_back_at_once_are_found() {
        let mut cells: Vec<f32> = (0..3_000_u16).map(|row| 1_000.0 + 3.0 * f32::from(row % 200)).collect();
        for row in [1_050, 2_010, 2_011] {
            cells[row] += 150.0;
        }
        // 600 m back at every two-hundredth row are a sawtooth: 400 m/s is exceeded there, and a level
        // continues each time.
        assert_eq!(rows(Channel::GpsAltM, 1.0, &cells), [1_050, 2_010, 2_011]);
        let mut pressures: Vec<f32> = (0..3_000_u16).map(|row| 90_000.0 + f32::from(row % 7)).collect();
        pressures[1_500] = 60_000.0;
        pressures[1_600] = 0.0;
        assert_eq!(rows(Channel::BaroPa, 1.0, &pressures), [1_500]);
    }

    #[test]
    fn what_was_left_out_is_said() {
        let mut cells = vec![20.0_f32; 1_000];
        cells[250] = 300.0;
        let (_, wild) = tamed(&flight(Channel::TasMps, STEP_S, &cells));
        assert_eq!(wild[0].sentence(), "tas_mps is 300 at 10.0 s, which is implausible; left out");
        cells[251] = 400.0;
        let (_, wild) = tamed(&flight(Channel::TasMps, STEP_S, &cells));
        assert_eq!(
            wild[0].sentence(),
            "2 cells of tas_mps are implausible (300 at 10.0 s is the first); left out"
        );
    }

    #[test]
    fn a_column_of_nothing_but_jumps_or_of_nothing_is_left_alone() {
        let jumping: Vec<f32> = (0..1_000_u16).map(|row| f32::from(row % 5) * 1_000.0).collect();
        assert_eq!(rows(Channel::TasMps, STEP_S, &jumping), Vec::<usize>::new());
        assert_eq!(rows(Channel::TasMps, STEP_S, &[]), Vec::<usize>::new());
        assert_eq!(rows(Channel::TasMps, STEP_S, &[f32::NAN, 3.0, f32::INFINITY]), Vec::<usize>::new());
    }

    /// Noise of a known size: the sum of twelve uniform numbers has a standard deviation of one, and with
    /// 4,000 of them the spread is known to within a few per cent.
    fn white(count: usize, sigma: f64) -> Vec<Sample> {
        let mut seed = 11_u32;
        let mut normal = || {
            (0..12).fold(-6.0, |sum, _| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                sum + f64::from(seed >> 8) / f64::from(1_u32 << 24)
            })
        };
        (0..count).map(|row| Sample { row, time_s: row as f64, value: 50.0 + sigma * normal() }).collect()
    }

    /// The estimated noise of a column is its standard deviation, whatever its size and however steeply the
    /// column rises.
    #[test]
    fn noise_is_the_standard_deviation_of_a_value() {
        for sigma in [0.1, 1.0, 7.0] {
            let mut samples = white(4_000, sigma);
            let flat = noise(Kind::Altitude, &samples);
            assert!((flat / sigma - 1.0).abs() < 0.06, "{sigma} {flat}");
            samples.iter_mut().for_each(|sample| sample.value += 30.0 * sample.time_s);
            assert!((noise(Kind::Altitude, &samples) / flat - 1.0).abs() < 1e-6);
        }
        assert_eq!(noise(Kind::Altitude, &white(2, 1.0)), 0.0);
    }

    /// A jump is more than the largest rate allows in the time between, and more than twelve sigmas: an
    /// airspeed with a noise of a centimetre a second that changes by 6 m/s within 40 ms needs 15 g.
    #[test]
    fn small_leaps_of_a_quiet_column_are_jumps_too() {
        let mut cells: Vec<f32> = (0..2_000_u16).map(|row| 30.0 + 0.01 * f32::from(row % 3)).collect();
        cells[900] += 6.0;
        cells[1_200] += 50.0;
        cells[1_500] += 3.0;
        assert_eq!(rows(Channel::TasMps, STEP_S, &cells), [900, 1_200]);
        // The last one alone.
        let mut last: Vec<f32> = vec![30.0; 500];
        last[499] = 90.0;
        assert_eq!(rows(Channel::TasMps, STEP_S, &last), [499]);
    }

    /// Up to a hundredth of the column's cells are wild, before or after the longest stretch; one more is a
    /// level.
    #[test]
    fn a_hundredth_of_a_column_is_wild_on_either_side() {
        for from in [500, 8_500] {
            for (count, found) in [(100, 100), (101, 0)] {
                let mut cells = vec![30.0_f32; 10_000];
                cells[from..from + count].iter_mut().for_each(|cell| *cell = 300.0);
                assert_eq!(rows(Channel::TasMps, STEP_S, &cells).len(), found, "{from} {count}");
            }
        }
    }

    /// A heading that continues past half a turn wraps around there, which is no jump, however few cells are
    /// left after it.
    #[test]
    fn a_heading_that_passes_the_turn_does_not_jump() {
        let heading = |row: u16| libm::remainder(2.9 + 0.001 * f64::from(row), core::f64::consts::TAU) as f32;
        let turning: Vec<f32> = (0..244).map(heading).collect();
        assert!(turning[0] > 2.8 && turning[243] < -3.1, "it passes half a turn near its end");
        assert_eq!(rows(Channel::YawRad, STEP_S, &turning), Vec::<usize>::new());
    }

    /// A row whose time does not increase is no sample: it cannot be wild.
    #[test]
    fn a_repeated_time_is_no_jump() {
        let mut flight = flight(Channel::TasMps, STEP_S, &[20.0; 100]);
        flight.time_s[50] = flight.time_s[49];
        flight.channels[0].1.set(50, Some(300.0));
        assert_eq!(tamed(&flight).1, []);
    }

    /// An altitude that is beyond both neighbours is wild if 10 g do not explain it: half of that times the
    /// one time and the other. 2 s each give 200 m, above or below, on any clock. Two in a row are as wild as
    /// one.
    #[test]
    fn ten_g_bound_what_is_beyond_both_neighbours() {
        let found = |heights_m: &[f64], step_s: f64, noise: f64| {
            let sample = |(row, value): (usize, &f64)| Sample {
                row,
                time_s: 1_000.0 + step_s * row as f64,
                value: 700.0 + value,
            };
            let samples: Vec<Sample> = heights_m.iter().enumerate().map(sample).collect();
            beyond_neighbours(&samples, noise)
        };
        for sign in [1.0, -1.0] {
            assert_eq!(found(&[0.0, 0.0, sign * 250.0, 0.0, 0.0], 2.0, 0.0), [2]);
            assert_eq!(found(&[0.0, 0.0, sign * 190.0, 0.0, 0.0], 2.0, 0.0), [0; 0]);
            assert_eq!(found(&[0.0, 0.0, sign * 250.0, 0.0, 0.0], 2.0, 300.0), [0; 0], "within the noise");
            assert_eq!(found(&[0.0, 0.0, sign * 900.0, sign * 850.0, 0.0, 0.0], 2.0, 0.0), [2, 3]);
            // The corner of a shifting level: 300 m beyond one neighbour, 1,000 m beyond the other.
            assert_eq!(found(&[0.0, 0.0, sign * 1_000.0, sign * 700.0, sign * 700.0], 2.0, 0.0), [0; 0]);
        }
        assert_eq!(found(&[0.0, 0.0, 200.0, 0.0, 0.0], 2.0, 0.0), [0; 0], "just what 10 g make");
        assert_eq!(found(&[0.0, 0.0, 20.0, 0.0, 0.0], 0.5, 0.0), [2]);
        assert_eq!(found(&[0.0, 0.0, 12.0, 0.0, 0.0], 0.5, 0.0), [0; 0]);
    }
}
