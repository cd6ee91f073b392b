//! A flight's rows on the flight computer's own grid of ticks.
//!
//! Chips do not wait for a logger: the flight computer polls them 200 times a second, whatever the times of
//! the flight's rows. A row's samples are available at the first tick that is not before the row, and there
//! are ticks between rows. Rows and samples that share a tick are counted.

use std::iter::Peekable;

use kf_core::input::{LaunchDoubt, Signals, TickInput};

use super::error::FlyError;

/// From one tick to the next, microseconds: 200 a second.
pub const TICK_US: u64 = 5_000;
/// Longest gap between two rows that is flown, microseconds.
const LONGEST_GAP_US: u64 = 3_600_000_000;

/// What became of a flight's rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GridReport {
    /// Rows of the flight.
    pub rows: u64,
    /// Ticks they were put on, including those without a row.
    pub ticks: u64,
    /// Rows that share a tick with the row before.
    pub shared: u64,
    /// Samples replaced by a later one at the same tick: they were not flown.
    pub superseded_samples: u64,
    /// Rows earlier than the row before them: they have no place and were not flown.
    pub late_rows: u64,
}

impl GridReport {
    /// Walks over the rows and counts them.
    ///
    /// # Errors
    /// [`FlyError::Gap`] for a gap of more than an hour, or a time near the end of the clock.
    pub(super) fn of(rows: impl Iterator<Item = TickInput> + Clone) -> Result<Self, FlyError> {
        let mut last_us: Option<u64> = None;
        for row in rows.clone() {
            let last = last_us.unwrap_or(row.time_us);
            let gap_us = row.time_us.saturating_sub(last);
            if gap_us > LONGEST_GAP_US || row.time_us > u64::MAX / 2 {
                return Err(FlyError::Gap { gap_s: gap_us as f64 * 1e-6, after_s: last as f64 * 1e-6 });
            }
            last_us = Some(last.max(row.time_us));
        }
        let mut ticks = OnGrid::new(rows);
        while ticks.next().is_some() {}
        Ok(ticks.report)
    }
}

/// The ticks of a flight.
#[derive(Clone, Debug)]
pub(super) struct OnGrid<Rows: Iterator<Item = TickInput>> {
    rows: Peekable<Rows>,
    tick: Option<u64>,
    last_row_us: u64,
    launch: (bool, LaunchDoubt),
    report: GridReport,
}

impl<Rows: Iterator<Item = TickInput>> OnGrid<Rows> {
    pub(super) fn new(rows: Rows) -> Self {
        Self {
            rows: rows.peekable(),
            tick: None,
            last_row_us: 0,
            launch: (false, LaunchDoubt::None),
            report: GridReport::default(),
        }
    }
}

impl<Rows: Iterator<Item = TickInput>> Iterator for OnGrid<Rows> {
    type Item = TickInput;

    fn next(&mut self) -> Option<TickInput> {
        let first_us = self.rows.peek()?.time_us;
        let tick = self.tick.map_or_else(|| first_us.div_ceil(TICK_US), |tick| tick + 1);
        self.tick = Some(tick);
        let time_us = tick * TICK_US;
        let (launch, launch_doubt) = self.launch;
        let mut input = TickInput { time_us, launch, launch_doubt, ..TickInput::default() };
        let mut has_row = false;
        while let Some(row) = self.rows.next_if(|row| row.time_us <= time_us) {
            self.report.rows += 1;
            if row.time_us < self.last_row_us {
                self.report.late_rows += 1;
                continue;
            }
            self.last_row_us = row.time_us;
            self.launch = (row.launch, row.launch_doubt);
            self.report.shared += u64::from(has_row);
            has_row = true;
            self.report.superseded_samples += merge(&mut input, row);
        }
        self.report.ticks += 1;
        Some(input)
    }
}

/// Adds a row to a tick and returns how many samples it replaced. The patterns name every field, so that a
/// new one cannot be forgotten here.
fn merge(tick: &mut TickInput, row: TickInput) -> u64 {
    let TickInput {
        time_us: _,
        launch,
        launch_doubt,
        gps,
        baro,
        imu_master_altitude_m,
        imu_slave_altitude_m,
        imu,
        signals,
        // A flight computer has none.
        columns: _,
    } = row;
    let Signals {
        true_airspeed_mps,
        angle_of_attack_rad,
        sideslip_rad,
        throttle,
        outside_air_temperature_c,
        baro_temperature_c,
        attitude_rad,
    } = signals;
    (tick.launch, tick.launch_doubt) = (launch, launch_doubt);
    [
        put(&mut tick.gps, gps),
        put(&mut tick.baro, baro),
        put(&mut tick.imu_master_altitude_m, imu_master_altitude_m),
        put(&mut tick.imu_slave_altitude_m, imu_slave_altitude_m),
        put(&mut tick.imu, imu),
        put(&mut tick.signals.true_airspeed_mps, true_airspeed_mps),
        put(&mut tick.signals.angle_of_attack_rad, angle_of_attack_rad),
        put(&mut tick.signals.sideslip_rad, sideslip_rad),
        put(&mut tick.signals.throttle, throttle),
        put(&mut tick.signals.outside_air_temperature_c, outside_air_temperature_c),
        put(&mut tick.signals.baro_temperature_c, baro_temperature_c),
        put(&mut tick.signals.attitude_rad, attitude_rad),
    ]
    .into_iter()
    .map(u64::from)
    .sum()
}

/// Stores a new sample and returns whether it replaced one.
fn put<T>(place: &mut Option<T>, new: Option<T>) -> bool {
    new.is_some_and(|new| place.replace(new).is_some())
}

#[cfg(test)]
mod tests {
    use kf_core::input::BaroReading;

    use super::*;

    fn row(time_us: u64, pressure_pa: f32) -> TickInput {
        TickInput { time_us, baro: Some(BaroReading::PressurePa(pressure_pa)), ..TickInput::default() }
    }

    fn ticks(rows: &[TickInput]) -> Vec<TickInput> {
        OnGrid::new(rows.iter().copied()).collect()
    }

    fn pressures(rows: &[TickInput]) -> Vec<(u64, Option<BaroReading>)> {
        ticks(rows).iter().map(|tick| (tick.time_us, tick.baro)).collect()
    }

    #[test]
    fn a_row_is_at_the_first_tick_that_is_not_before_it() {
        let pa = |value| Some(BaroReading::PressurePa(value));
        let rows = [row(5_000, 1.0), row(5_001, 2.0), row(20_000, 3.0)];
        assert_eq!(
            pressures(&rows),
            [(5_000, pa(1.0)), (10_000, pa(2.0)), (15_000, None), (20_000, pa(3.0))]
        );
    }

    #[test]
    fn what_shares_a_tick_and_what_comes_late_is_counted() {
        let mut launched = TickInput { time_us: 9_000, launch: true, ..TickInput::default() };
        launched.imu_slave_altitude_m = Some(7.0);
        let rows =
            [row(1, 1.0), row(5_001, 2.0), launched, row(9_500, 3.0), row(9_400, 4.0), row(30_000, 5.0)];
        let report = GridReport::of(rows.iter().copied()).unwrap();
        assert_eq!(report, GridReport { rows: 6, ticks: 6, shared: 2, superseded_samples: 1, late_rows: 1 });
        let ticks = ticks(&rows);
        assert_eq!(ticks[1].baro, Some(BaroReading::PressurePa(3.0)));
        assert_eq!(ticks[1].imu_slave_altitude_m, Some(7.0));
        // The row of 9.5 ms has no launch, and it is the later one.
        assert!(!ticks[1].launch);
    }

    #[test]
    fn launch_holds_between_rows() {
        let rows = [
            row(0, 1.0),
            TickInput { launch: true, ..row(4_000, 1.0) },
            TickInput { launch: true, ..row(20_000, 1.0) },
        ];
        let launched: Vec<bool> = ticks(&rows).iter().map(|tick| tick.launch).collect();
        assert_eq!(launched, [false, true, true, true, true]);
    }

    #[test]
    fn a_gap_of_more_than_an_hour_is_refused_by_name() {
        let error = GridReport::of([row(0, 1.0), row(4_000_000_000, 1.0)].into_iter()).unwrap_err();
        assert!(error.to_string().starts_with("the flight has a gap of 4000 s after 0.000 s"), "{error}");
        assert!(GridReport::of([row(u64::MAX, 1.0)].into_iter()).is_err());
    }
}
