//! What the aircraft did, as signals that an unexplained residual may follow.

use kf_core::input::TickInput;

use flight_data::Column;

/// The names of the signals, in [`SignalMeans`]' order; the flight's unknown columns come after them.
pub const NAMES: [&str; 21] = [
    "tas_mps",
    "climb rate",
    "altitude",
    "load factor",
    "roll_rad",
    "pitch_rad",
    "heading (sine)",
    "heading (cosine)",
    "aoa_rad",
    "sideslip_rad",
    "throttle",
    "accel_x_mps2",
    "accel_y_mps2",
    "gyro_x_radps",
    "gyro_y_radps",
    "gyro_z_radps",
    "baro_temp_c",
    "oat_c",
    "ground speed",
    "ground velocity north",
    "ground velocity east",
];

/// A flight's unknown columns that an unexplained residual may follow. These exclude what an autopilot
/// estimated (`autopilot_*`) and what another barometer read (`baro_N_pa`): they contain the sensors' errors
/// and the path itself, as the residual does, so each would seem to follow the other.
pub fn offered(extra: &[(String, Column)]) -> impl Iterator<Item = &(String, Column)> {
    let is_path =
        |name: &str| name.starts_with("autopilot_") || (name.starts_with("baro_") && name.ends_with("_pa"));
    extra.iter().filter(move |(name, _)| !is_path(name))
}

/// Index among the signals of the altitude that the climb rate integrates to.
pub const CLIMBED: usize = 2;
/// Indices among the signals of the velocity over ground: north, east.
pub const GROUND_VELOCITY: [usize; 2] = [19, 20];

/// Means of the signals over the block that is being filled; a signal without a sample keeps its last mean.
#[derive(Clone, Debug)]
pub struct SignalMeans {
    sum: Vec<f64>,
    count: Vec<u32>,
    last: Vec<f64>,
}

impl SignalMeans {
    /// For the known signals and this many unknown columns.
    #[must_use]
    pub fn new(extra: usize) -> Self {
        let n = NAMES.len() + extra;
        Self { sum: vec![0.0; n], count: vec![0; n], last: vec![f64::NAN; n] }
    }

    /// Processes a tick.
    ///
    /// `climbed_m` is the altitude that the climb rate integrates to. The fixes' own altitude contains the
    /// reference's error, which the residual contains as well, so each would seem to follow the other.
    pub fn take(
        &mut self,
        input: &TickInput,
        climbed_m: Option<f32>,
        row: usize,
        extra: &[(String, Column)],
    ) {
        let signals = &input.signals;
        let (roll, pitch, yaw) = match signals.attitude_rad {
            Some([roll, pitch, yaw]) => (Some(roll), Some(pitch), Some(yaw)),
            None => (None, None, None),
        };
        let accel = |axis: usize| input.imu.map(|imu| imu.accel_mps2[axis]);
        let gyro = |axis: usize| input.imu.map(|imu| imu.gyro_radps[axis]);
        let gps = input.gps;
        let velocity = |get: fn(&kf_core::input::GpsFix) -> Option<f32>| gps.as_ref().and_then(get);
        let north = velocity(|fix| fix.velocity_north_mps);
        let east = velocity(|fix| fix.velocity_east_mps);
        let values = [
            signals.true_airspeed_mps,
            velocity(|fix| fix.velocity_down_mps).map(|down| -down),
            gps.and(climbed_m),
            accel(2).map(|down| -down / 9.80665),
            roll,
            pitch,
            yaw.map(libm::sinf),
            yaw.map(libm::cosf),
            signals.angle_of_attack_rad,
            signals.sideslip_rad,
            signals.throttle,
            accel(0),
            accel(1),
            gyro(0),
            gyro(1),
            gyro(2),
            signals.baro_temperature_c,
            signals.outside_air_temperature_c,
            north.zip(east).map(|(north, east)| libm::hypotf(north, east)),
            north,
            east,
        ];
        let extra = offered(extra).map(|(_, column)| column.get(row));
        for (k, value) in values.into_iter().chain(extra).enumerate() {
            if let Some(value) = value.filter(|value| value.is_finite()) {
                self.sum[k] += f64::from(value);
                self.count[k] += 1;
            }
        }
    }

    /// Returns the means of the block and starts the next.
    pub fn close(&mut self) -> Vec<f64> {
        for k in 0..self.sum.len() {
            if self.count[k] > 0 {
                self.last[k] = self.sum[k] / f64::from(self.count[k]);
            }
            self.sum[k] = 0.0;
            self.count[k] = 0;
        }
        self.last.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_the_path_in_it_is_not_offered_as_a_cause() {
        let named = |name: &str| (name.to_owned(), Column::default());
        let extra = ["flap", "autopilot_down_m", "baro_2_pa", "baro_2_temp_c", "output_1_us"].map(named);
        let names: Vec<&str> = offered(&extra).map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["flap", "baro_2_temp_c", "output_1_us"]);
    }
}
