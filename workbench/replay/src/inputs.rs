//! Makes ticks from the rows of a flight.

use kf_core::input::{
    BaroReading, Columns as UnknownColumns, GpsFix, ImuSample, LaunchDoubt, Signals, TickInput,
};
use kf_core::navigation::InertialAltitude;
use kf_core::strapdown::Config;
use std::sync::Arc;

use super::effect_columns;
use super::pass::count_pass;
use super::window::CalibrationWindow;
use flight_data::{Channel, Column, Flight};

/// Counts of cells that no tick can carry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputCounters {
    /// Rows with cells of a fix but without its altitude; those cells were not used.
    pub fixes_without_altitude: u32,
    /// Satellite counts that are not a whole number from 0 to 255; the fix was used without one.
    pub satellites_not_a_count: u32,
    /// Rows with some of roll, pitch and yaw; those cells were not used.
    pub partial_attitudes: u32,
    /// Rows with some of the six inertial cells; those cells were not used.
    pub partial_imu_samples: u32,
}

/// The ticks of a flight, one a row, in row order.
///
/// Time is microseconds of the flight's own time axis, rounded. A fix is a row's `gps_` cells and needs
/// `gps_alt_m`. Of two barometer cells the pressure is used. Attitude and inertial samples are complete or
/// left out, except in a flight without any gyro (body rates of zero) or any heading (zero). The launch
/// discrete and its doubt hold their last values; with a window the discrete is 0 up to the window's end and
/// 1 from there on, without doubt.
#[derive(Clone, Debug)]
pub struct TickInputs<'a> {
    columns: Columns<'a>,
    window: Option<CalibrationWindow>,
    row: usize,
    /// The first row after the last tick.
    end: usize,
    skipped: usize,
    launch: bool,
    launch_doubt: LaunchDoubt,
    counters: InputCounters,
    /// The flight's columns that only formulas read, by their numbers in the model.
    unknown: Vec<(Option<&'a Column>, model::formula::Column)>,
    /// Set where the flight computer makes the UAV's inertial altitude itself.
    inertial_altitude: Option<InertialAltitude>,
}

#[derive(Clone, Debug)]
struct Columns<'a> {
    time_s: &'a [f64],
    launch: Cells<'a>,
    launch_doubt: Cells<'a>,
    gps_altitude: Cells<'a>,
    gps_velocity: [Cells<'a>; 3],
    gps_accuracy: Cells<'a>,
    gps_satellites: Cells<'a>,
    gps_time: Cells<'a>,
    baro_pressure: Cells<'a>,
    baro_altitude: Cells<'a>,
    baro_temperature: Cells<'a>,
    imu_master: Cells<'a>,
    imu_slave: Cells<'a>,
    accel: [Cells<'a>; 3],
    gyro: [Cells<'a>; 3],
    attitude: [Cells<'a>; 3],
    airspeed: Cells<'a>,
    angle_of_attack: Cells<'a>,
    sideslip: Cells<'a>,
    throttle: Cells<'a>,
    air_temperature: Cells<'a>,
}

/// A column that may be missing.
#[derive(Clone, Debug)]
enum Cells<'a> {
    None,
    Own(&'a Column),
    /// A copy without the cells that a diagnosis leaves out.
    Tamed(Arc<Column>),
}

impl Cells<'_> {
    fn column(&self) -> Option<&Column> {
        match self {
            Self::None => None,
            Self::Own(column) => Some(column),
            Self::Tamed(column) => Some(column),
        }
    }

    #[inline]
    fn get(&self, row: usize) -> Option<f32> {
        self.column().and_then(|column| column.get(row))
    }
}

/// All three cells, and whether only some of them were there.
#[inline]
fn triple(cells: &[Cells<'_>; 3], row: usize) -> (Option<[f32; 3]>, bool) {
    match cells.each_ref().map(|cell| cell.get(row)) {
        [Some(x), Some(y), Some(z)] => (Some([x, y, z]), false),
        [None, None, None] => (None, false),
        _ => (None, true),
    }
}

/// Least rate of inertial samples that follows an aircraft's rotation, Hz.
const LEAST_INERTIAL_RATE_HZ: f64 = 50.0;

impl Columns<'_> {
    fn makes_inertial_altitude(&self) -> bool {
        let count = |cells: &Cells<'_>| cells.column().map_or(0, |column| column.samples().count());
        let samples = self.accel.iter().chain(&self.gyro).map(count).min().unwrap_or(0);
        let (first, last) = (self.time_s.first().copied(), self.time_s.last().copied());
        let duration_s = last.unwrap_or(0.0) - first.unwrap_or(0.0);
        // There is one more sample than intervals, and the times of a log are rounded.
        count(&self.imu_slave) == 0
            && duration_s > 0.0
            && samples as f64 + 1.0 >= LEAST_INERTIAL_RATE_HZ * duration_s
    }
}

/// The doubt in a cell whose value the reader has checked.
#[inline]
fn doubt(value: f32) -> LaunchDoubt {
    if value == 1.0 {
        LaunchDoubt::Suspected
    } else if value == 2.0 {
        LaunchDoubt::Unconfirmed
    } else {
        LaunchDoubt::None
    }
}

/// Microseconds of a time whose value the reader has checked.
#[inline]
fn microseconds(time_s: f64) -> u64 {
    (time_s * 1e6).round() as u64
}

impl<'a> TickInputs<'a> {
    /// `tamed` are columns that replace the flight's own; `has_barometer` is whether the barometer's columns
    /// are used.
    pub(super) fn new(
        flight: &'a Flight,
        tamed: &[(Channel, Arc<Column>)],
        window: Option<CalibrationWindow>,
        end: usize,
        has_barometer: bool,
        unknown: &model::formula::Columns,
    ) -> Self {
        use Channel::{
            AccelXMps2, AccelYMps2, AccelZMps2, AoaRad, BaroAltM, BaroPa, BaroTempC, GpsAltM, GpsSats,
            GpsTimeS, GpsVaccM, GpsVdMps, GpsVeMps, GpsVnMps, GyroXRadps, GyroYRadps, GyroZRadps,
            ImuMasterAltM, ImuSlaveAltM, Launch, LaunchDoubt as DoubtOfLaunch, OatC, PitchRad, RollRad,
            SideslipRad, TasMps, Throttle, YawRad,
        };
        let cells = |channel| {
            let is_barometers = matches!(channel, BaroPa | BaroAltM);
            let own = flight.channel(channel).filter(|_| has_barometer || !is_barometers);
            match (own, tamed.iter().find(|(name, _)| *name == channel)) {
                (None, _) => Cells::None,
                (Some(column), None) => Cells::Own(column),
                (Some(_), Some((_, column))) => Cells::Tamed(Arc::clone(column)),
            }
        };
        let columns = Columns {
            time_s: &flight.time_s,
            launch: cells(Launch),
            launch_doubt: cells(DoubtOfLaunch),
            gps_altitude: cells(GpsAltM),
            gps_velocity: [GpsVnMps, GpsVeMps, GpsVdMps].map(cells),
            gps_accuracy: cells(GpsVaccM),
            gps_satellites: cells(GpsSats),
            gps_time: cells(GpsTimeS),
            baro_pressure: cells(BaroPa),
            baro_altitude: cells(BaroAltM),
            baro_temperature: cells(BaroTempC),
            imu_master: cells(ImuMasterAltM),
            imu_slave: cells(ImuSlaveAltM),
            accel: [AccelXMps2, AccelYMps2, AccelZMps2].map(cells),
            gyro: [GyroXRadps, GyroYRadps, GyroZRadps].map(cells),
            attitude: [RollRad, PitchRad, YawRad].map(cells),
            airspeed: cells(TasMps),
            angle_of_attack: cells(AoaRad),
            sideslip: cells(SideslipRad),
            throttle: cells(Throttle),
            air_temperature: cells(OatC),
        };
        let start_s = window.map_or(0.0, |window| window.start_s);
        let skipped = flight.time_s.iter().position(|time| *time >= start_s).unwrap_or(flight.rows());
        Self {
            columns,
            window,
            row: skipped,
            end,
            skipped,
            launch: false,
            launch_doubt: LaunchDoubt::None,
            counters: InputCounters::default(),
            unknown: unknown
                .iter()
                .map(|said| (effect_columns::column(flight, said.name()), said.clone()))
                .collect(),
            inertial_altitude: None,
        }
    }

    /// Makes `imu_slave` the strapdown channel's altitude, if the flight has enough inertial samples and no
    /// altitude of that sensor.
    pub(super) fn with_inertial_altitude(mut self) -> Self {
        if self.columns.makes_inertial_altitude() {
            self.inertial_altitude = Some(InertialAltitude::new(Config::MEMS));
        }
        self
    }

    /// The strapdown channel, where it is in use.
    #[must_use]
    pub const fn inertial_altitude(&self) -> Option<&InertialAltitude> {
        self.inertial_altitude.as_ref()
    }

    /// What could not be made into ticks so far.
    #[must_use]
    pub const fn counters(&self) -> &InputCounters {
        &self.counters
    }

    /// Number of rows before the window, for which there is no tick.
    #[must_use]
    pub const fn skipped_rows(&self) -> usize {
        self.skipped
    }

    /// The row of the next tick.
    #[must_use]
    pub const fn next_row(&self) -> usize {
        self.row
    }

    #[inline]
    fn gps(&mut self, row: usize) -> Option<GpsFix> {
        let columns = &self.columns;
        let velocity = columns.gps_velocity.each_ref().map(|cells| cells.get(row));
        let accuracy = columns.gps_accuracy.get(row);
        let satellites = columns.gps_satellites.get(row);
        let time_s = columns.gps_time.get(row);
        let Some(altitude_m) = columns.gps_altitude.get(row) else {
            let some = accuracy.or(satellites).or(time_s).is_some() || velocity.iter().any(Option::is_some);
            self.counters.fixes_without_altitude += u32::from(some);
            return None;
        };
        let count = satellites.filter(|count| (0.0..=255.0).contains(count)).map(|count| count as u8);
        self.counters.satellites_not_a_count += u32::from(satellites.is_some() && count.is_none());
        let [velocity_north_mps, velocity_east_mps, velocity_down_mps] = velocity;
        Some(GpsFix {
            altitude_m,
            velocity_north_mps,
            velocity_east_mps,
            velocity_down_mps,
            vertical_accuracy_m: accuracy,
            satellites: count,
            // Only compared for equality, so a negative time may wrap.
            fix_time_us: time_s
                .filter(|time| time.is_finite())
                .map(|time| (f64::from(time) * 1e6).round() as i64 as u64),
        })
    }

    #[inline]
    fn imu(&mut self, row: usize) -> Option<ImuSample> {
        let (accel, some_accel) = triple(&self.columns.accel, row);
        let (mut gyro, some_gyro) = triple(&self.columns.gyro, row);
        // Without a gyro the accelerometer still gives the load factor; attitudes are then held from one to
        // the next.
        if accel.is_some() && self.columns.gyro.iter().all(|cells| cells.column().is_none()) {
            gyro = Some([0.0; 3]);
        }
        if let (Some(accel_mps2), Some(gyro_radps)) = (accel, gyro) {
            return Some(ImuSample { accel_mps2, gyro_radps });
        }
        let some = some_accel || some_gyro || accel.is_some() || gyro.is_some();
        self.counters.partial_imu_samples += u32::from(some);
        None
    }

    /// Columns that only formulas read.
    #[inline]
    fn unknown(&self, row: usize) -> UnknownColumns {
        let mut columns = UnknownColumns::default();
        for (number, (column, said)) in self.unknown.iter().enumerate() {
            if let Some(cell) = column.and_then(|column| column.get(row)) {
                columns.set(number, said.si(cell));
            }
        }
        columns
    }

    #[inline]
    fn signals(&mut self, row: usize) -> Signals {
        let columns = &self.columns;
        let (mut attitude_rad, mut some) = triple(&columns.attitude, row);
        // Nothing that is derived from an attitude needs the heading of a flight that has none.
        let [roll, pitch, yaw] = &columns.attitude;
        if let (None, Some(roll), Some(pitch)) = (yaw.column(), roll.get(row), pitch.get(row)) {
            (attitude_rad, some) = (Some([roll, pitch, 0.0]), false);
        }
        self.counters.partial_attitudes += u32::from(some);
        Signals {
            true_airspeed_mps: columns.airspeed.get(row),
            angle_of_attack_rad: columns.angle_of_attack.get(row),
            sideslip_rad: columns.sideslip.get(row),
            throttle: columns.throttle.get(row),
            outside_air_temperature_c: columns.air_temperature.get(row),
            baro_temperature_c: columns.baro_temperature.get(row),
            attitude_rad,
        }
    }
}

impl Iterator for TickInputs<'_> {
    type Item = TickInput;

    #[inline]
    fn next(&mut self) -> Option<TickInput> {
        let row = self.row;
        if row >= self.end {
            return None;
        }
        let time_s = *self.columns.time_s.get(row)?;
        if row == self.skipped {
            count_pass();
        }
        self.row += 1;
        match self.window {
            Some(window) => self.launch |= time_s >= window.end_s,
            None => {
                if let Some(value) = self.columns.launch.get(row) {
                    self.launch = value != 0.0;
                }
                if let Some(value) = self.columns.launch_doubt.get(row) {
                    self.launch_doubt = doubt(value);
                }
            }
        }
        let columns = &self.columns;
        let baro = match (columns.baro_pressure.get(row), columns.baro_altitude.get(row)) {
            (Some(pressure_pa), _) => Some(BaroReading::PressurePa(pressure_pa)),
            (None, altitude) => altitude.map(BaroReading::AltitudeM),
        };
        let (imu_master_altitude_m, imu_slave_altitude_m) =
            (columns.imu_master.get(row), columns.imu_slave.get(row));
        let mut input = TickInput {
            time_us: microseconds(time_s),
            launch: self.launch,
            launch_doubt: self.launch_doubt,
            gps: self.gps(row),
            baro,
            imu_master_altitude_m,
            imu_slave_altitude_m,
            imu: self.imu(row),
            signals: self.signals(row),
            columns: self.unknown(row),
        };
        if let Some(inertial_altitude) = &mut self.inertial_altitude {
            inertial_altitude.tick(&mut input);
        }
        Some(input)
    }
}
