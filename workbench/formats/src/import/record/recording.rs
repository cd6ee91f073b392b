//! Groups a line's events into flights: which ticks belong together, and what the flight computer made of
//! them.

use flight_record::{Header, SensorSource, Stream, Summary};
use kf_core::input::{BaroReading, LaunchDoubt, TickInput};
use kf_core::latch::LatchRecord;
use kf_core::output::{TickOutput, Trust};
use kf_core::sensor::SENSORS;
use survival::{RestartReport, Start};

use super::frames::Event;
use flight_data::{Channel, Column, MAX_TIME_S};

/// The channels that a tick fills, in the order of [`cells`].
pub const CHANNELS: [Channel; 26] = [
    Channel::GpsAltM,
    Channel::GpsVnMps,
    Channel::GpsVeMps,
    Channel::GpsVdMps,
    Channel::GpsVaccM,
    Channel::GpsSats,
    Channel::BaroPa,
    Channel::BaroAltM,
    Channel::BaroTempC,
    Channel::ImuMasterAltM,
    Channel::ImuSlaveAltM,
    Channel::AccelXMps2,
    Channel::AccelYMps2,
    Channel::AccelZMps2,
    Channel::GyroXRadps,
    Channel::GyroYRadps,
    Channel::GyroZRadps,
    Channel::RollRad,
    Channel::PitchRad,
    Channel::YawRad,
    Channel::TasMps,
    Channel::AoaRad,
    Channel::SideslipRad,
    Channel::Throttle,
    Channel::OatC,
    Channel::GpsTimeS,
];

/// Largest time of a fix, seconds: receiver times are kept as `f32`, which resolves the 0.05 s between two
/// fixes up to here; the flight's file refuses larger ones.
const MAX_FIX_TIME_S: f64 = 1_048_576.0;

/// A start of the flight computer within a flight, or at its beginning.
#[derive(Clone, Debug, PartialEq)]
pub struct Started {
    /// The first row after it.
    pub row: usize,
    /// The flight computer's report of it; `None` if it was lost.
    pub report: Option<RestartReport>,
}

/// The flight computer's own results of a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AsFlown {
    /// The latched calibration.
    pub latch: Option<LatchRecord>,
    /// The first tick of free flight, at which the launch is decided.
    pub launch: Option<TickOutput>,
    /// Time at which each sensor first was doubtful or worse, microseconds.
    pub doubtful_us: [Option<u64>; SENSORS],
    /// Time at which it first was untrustworthy, microseconds.
    pub untrustworthy_us: [Option<u64>; SENSORS],
}

/// One flight of a line.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// The first header.
    pub header: Option<Header>,
    /// Time of each tick, microseconds.
    pub time_us: Vec<u64>,
    /// One column for each of [`CHANNELS`].
    pub columns: Vec<Column>,
    /// The launch discrete, at its changes.
    pub launch: Column,
    /// The doubt about it, at its changes.
    pub doubt: Column,
    /// Whether there ever was a doubt.
    pub has_doubt: bool,
    /// Starts of the flight computer.
    pub starts: Vec<Started>,
    /// The flight computer's own results.
    pub as_flown: AsFlown,
    /// Ticks with results; the others are inputs only.
    pub outputs: usize,
    /// Faults of chips planned for the flight of these inputs.
    pub chip_faults: usize,
    /// Number of inputs given at the end of the stream.
    pub promised_inputs: Option<u32>,
    /// The counters at the end.
    pub summary: Option<Box<Summary>>,
    /// Number of fixes whose time a flight's file cannot hold.
    pub fix_times_left_out: usize,
    first_fix_us: Option<u64>,
    last: Option<(bool, LaunchDoubt)>,
}

/// The number for a doubt in a flight's file.
pub const fn doubt_number(doubt: LaunchDoubt) -> f32 {
    match doubt {
        LaunchDoubt::None => 0.0,
        LaunchDoubt::Suspected => 1.0,
        LaunchDoubt::Unconfirmed => 2.0,
    }
}

/// Every cell of a tick except the time of its fix. The patterns name every field, so that a new one cannot
/// be forgotten here.
fn cells(input: &TickInput) -> [Option<f32>; CHANNELS.len() - 1] {
    let TickInput {
        time_us: _,
        launch: _,
        launch_doubt: _,
        gps,
        baro,
        imu_master_altitude_m,
        imu_slave_altitude_m,
        imu,
        signals,
        // A flight computer has none.
        columns: _,
    } = input;
    let kf_core::input::Signals {
        true_airspeed_mps,
        angle_of_attack_rad,
        sideslip_rad,
        throttle,
        outside_air_temperature_c,
        baro_temperature_c,
        attitude_rad,
    } = *signals;
    let (pressure_pa, pressure_altitude_m) = match *baro {
        Some(BaroReading::PressurePa(pressure_pa)) => (Some(pressure_pa), None),
        Some(BaroReading::AltitudeM(altitude_m)) => (None, Some(altitude_m)),
        None => (None, None),
    };
    let axes = |values: Option<[f32; 3]>| match values {
        Some([x, y, z]) => [Some(x), Some(y), Some(z)],
        None => [None; 3],
    };
    let [accel_x, accel_y, accel_z] = axes(imu.map(|sample| sample.accel_mps2));
    let [gyro_x, gyro_y, gyro_z] = axes(imu.map(|sample| sample.gyro_radps));
    let [roll, pitch, yaw] = axes(attitude_rad);
    [
        gps.map(|fix| fix.altitude_m),
        gps.and_then(|fix| fix.velocity_north_mps),
        gps.and_then(|fix| fix.velocity_east_mps),
        gps.and_then(|fix| fix.velocity_down_mps),
        gps.and_then(|fix| fix.vertical_accuracy_m),
        gps.and_then(|fix| fix.satellites).map(f32::from),
        pressure_pa,
        pressure_altitude_m,
        baro_temperature_c,
        *imu_master_altitude_m,
        *imu_slave_altitude_m,
        accel_x,
        accel_y,
        accel_z,
        gyro_x,
        gyro_y,
        gyro_z,
        roll,
        pitch,
        yaw,
        true_airspeed_mps,
        angle_of_attack_rad,
        sideslip_rad,
        throttle,
        outside_air_temperature_c,
    ]
}

impl Recording {
    fn new(header: Option<Header>) -> Self {
        Self { header, columns: vec![Column::default(); CHANNELS.len()], ..Self::default() }
    }

    /// Whether its readings passed through chips and drivers: a board's, or models of them.
    pub fn is_on_chips(&self) -> bool {
        self.header.is_some_and(|header| header.sensors == SensorSource::Chips)
    }

    /// Whether it is the input of a flight computer, and not what one has flown.
    pub fn is_inputs(&self) -> bool {
        self.header.map_or(self.outputs == 0, |header| header.stream == Stream::Inputs)
    }

    fn take(&mut self, input: &TickInput) {
        self.time_us.push(input.time_us);
        let fix_time_s = self.fix_time_s(input);
        let cells = cells(input).into_iter().chain([fix_time_s]);
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            column.push(cell);
        }
        let (launch, doubt) = (input.launch, input.launch_doubt);
        let last = self.last.replace((launch, doubt));
        self.launch.push((last.map(|last| last.0) != Some(launch)).then_some(f32::from(u8::from(launch))));
        self.doubt.push((last.map(|last| last.1) != Some(doubt)).then_some(doubt_number(doubt)));
        self.has_doubt |= doubt != LaunchDoubt::None;
    }

    /// Seconds from the first fix to this one, by the receiver's clock.
    fn fix_time_s(&mut self, input: &TickInput) -> Option<f32> {
        let time_us = input.gps?.fix_time_us?;
        let first_us = *self.first_fix_us.get_or_insert(time_us);
        let since_s = time_us.wrapping_sub(first_us) as i64 as f64 / 1e6;
        let fits = since_s.abs() < MAX_FIX_TIME_S;
        self.fix_times_left_out += usize::from(!fits);
        fits.then_some(since_s as f32)
    }

    fn take_output(&mut self, output: &TickOutput) {
        self.outputs += 1;
        if output.out_of_order {
            return;
        }
        let as_flown = &mut self.as_flown;
        if output.latched_now && as_flown.launch.is_none() {
            as_flown.launch = Some(output.clone());
        }
        let firsts = as_flown.doubtful_us.iter_mut().zip(&mut as_flown.untrustworthy_us);
        for (sensor, (doubtful_us, untrustworthy_us)) in output.sensors.iter().zip(firsts) {
            if matches!(sensor.trust, Trust::Doubtful | Trust::Untrustworthy) {
                doubtful_us.get_or_insert(output.time_us);
            }
            if sensor.trust == Trust::Untrustworthy {
                untrustworthy_us.get_or_insert(output.time_us);
            }
        }
    }
}

/// The flights of a line: a start of the flight computer that continues with the same clock continues the
/// flight.
#[derive(Debug, Default)]
pub struct Recordings {
    current: Recording,
    /// A header, or a restart's report, since the last tick.
    begun: Option<Begun>,
    longest: Option<Recording>,
    /// Number of flights.
    pub flights: usize,
    ticks: usize,
    /// Ticks whose time a flight's file cannot hold.
    pub impossible_times: usize,
}

#[derive(Debug, Default)]
struct Begun {
    header: Option<Header>,
    reports: Vec<RestartReport>,
}

impl Recordings {
    /// Adds the next event.
    pub fn take(&mut self, event: Event) {
        match event {
            Event::Header(header) => self.begun.get_or_insert_default().header = Some(header),
            Event::HeaderLost => {
                self.begun.get_or_insert_default();
            }
            Event::Restart(report) => self.begun.get_or_insert_default().reports.push(*report),
            Event::Tick(record) => {
                if self.take_input(&record.input) {
                    self.current.take_output(&record.output);
                }
            }
            Event::Input(input) => {
                self.take_input(&input);
            }
            Event::Latch(latch) => {
                self.current.as_flown.latch.get_or_insert(*latch);
            }
            Event::ChipFault => self.current.chip_faults += 1,
            Event::End(inputs) => self.current.promised_inputs = Some(inputs),
            Event::Summary(summary) => self.current.summary = Some(summary),
        }
    }

    fn take_input(&mut self, input: &TickInput) -> bool {
        if input.time_us as f64 * 1e-6 > MAX_TIME_S {
            self.impossible_times += 1;
            return false;
        }
        if let Some(begun) = self.begun.take() {
            self.begin(begun, input.time_us);
        } else if self.current.columns.is_empty() {
            self.current = Recording::new(None);
        }
        self.current.take(input);
        true
    }

    /// Begins after a start, with the first tick at this time.
    fn begin(&mut self, begun: Begun, time_us: u64) {
        let is_cold = begun.reports.iter().any(|report| report.start == Start::Cold);
        let model = |header: &Option<Header>| header.map(|header| header.model);
        let is_other = begun.header.is_some()
            && self.current.header.is_some()
            && model(&begun.header) != model(&self.current.header);
        let last_us = self.current.time_us.last().copied();
        let goes_on = !is_cold && !is_other && last_us.is_some_and(|last_us| time_us > last_us);
        if !goes_on {
            let chip_faults = if last_us.is_none() { self.current.chip_faults } else { 0 };
            self.finish();
            self.current = Recording { chip_faults, ..Recording::new(begun.header) };
        }
        self.started(begun.reports, goes_on);
    }

    fn started(&mut self, reports: Vec<RestartReport>, goes_on: bool) {
        let row = self.current.time_us.len();
        let starts = &mut self.current.starts;
        if reports.is_empty() && goes_on {
            starts.push(Started { row, report: None });
        }
        starts.extend(reports.into_iter().map(|report| Started { row, report: Some(report) }));
    }

    fn finish(&mut self) {
        let flown = std::mem::take(&mut self.current);
        let rows = flown.time_us.len();
        if rows == 0 {
            return;
        }
        self.flights += 1;
        self.ticks += rows;
        if self.longest.as_ref().is_none_or(|longest| rows > longest.time_us.len()) {
            self.longest = Some(flown);
        }
    }

    /// The longest flight, and what was left out.
    pub fn longest(mut self) -> Result<(Recording, Left), Box<Begins>> {
        if let Some(begun) = self.begun.take() {
            if self.current.time_us.is_empty() && self.flights == 0 {
                return Err(Box::new(Begins { header: begun.header, reports: begun.reports }));
            }
            // It started and no tick followed: standby.
            self.started(begun.reports, false);
        }
        self.finish();
        let Some(longest) = self.longest else { return Err(Box::default()) };
        let left = Left {
            flights: self.flights - 1,
            ticks: self.ticks - longest.time_us.len(),
            impossible_times: self.impossible_times,
        };
        Ok((longest, left))
    }
}

/// What is not part of the longest flight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Left {
    /// Number of other flights.
    pub flights: usize,
    /// Their ticks.
    pub ticks: usize,
    /// Ticks whose time a flight's file cannot hold.
    pub impossible_times: usize,
}

/// A line without a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Begins {
    /// Its header, if it has one.
    pub header: Option<Header>,
    /// The flight computer's reports at its start.
    pub reports: Vec<RestartReport>,
}
