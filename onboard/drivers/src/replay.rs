//! Sensors that deliver a flight record's values.

use kf_core::input::{GpsFix, ImuSample, LaunchDoubt, Signals, TickInput};

use crate::error::SensorError;
use crate::sensor::{
    AltitudeLink, Barometer, BarometerSample, InertialUnit, LaunchDiscrete, SatelliteReceiver, VehicleLink,
    VehicleState,
};
use crate::suite::Suite;

/// A sensor that delivers its loaded sample once.
#[derive(Clone, Copy, Debug)]
pub struct Replay<Sample>(Option<Sample>);

impl<Sample> Replay<Sample> {
    /// A sensor with nothing to deliver.
    #[must_use]
    pub const fn new() -> Self {
        Self(None)
    }

    /// Loads the sample to deliver at the next poll.
    pub fn load(&mut self, sample: Option<Sample>) {
        self.0 = sample;
    }
}

impl<Sample> Default for Replay<Sample> {
    fn default() -> Self {
        Self::new()
    }
}

/// The part of a record's signals that comes over the vehicle's link.
impl From<&Signals> for VehicleState {
    fn from(signals: &Signals) -> Self {
        Self {
            true_airspeed_mps: signals.true_airspeed_mps,
            angle_of_attack_rad: signals.angle_of_attack_rad,
            sideslip_rad: signals.sideslip_rad,
            throttle: signals.throttle,
            outside_air_temperature_c: signals.outside_air_temperature_c,
            attitude_rad: signals.attitude_rad,
        }
    }
}

impl SatelliteReceiver for Replay<GpsFix> {
    fn poll(&mut self, _now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        Ok(self.0.take())
    }
}

impl Barometer for Replay<BarometerSample> {
    fn poll(&mut self, _now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        Ok(self.0.take())
    }
}

impl InertialUnit for Replay<ImuSample> {
    fn poll(&mut self, _now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        Ok(self.0.take())
    }
}

impl AltitudeLink for Replay<f32> {
    fn poll(&mut self, _now_us: u64) -> Result<Option<f32>, SensorError> {
        Ok(self.0.take())
    }
}

impl VehicleLink for Replay<VehicleState> {
    fn poll(&mut self, _now_us: u64) -> Result<Option<VehicleState>, SensorError> {
        Ok(self.0.take())
    }
}

/// The umbilical of a flight record.
#[derive(Clone, Copy, Debug, Default)]
pub struct ReplayUmbilical {
    open: bool,
    doubt: LaunchDoubt,
}

impl ReplayUmbilical {
    /// A closed umbilical.
    #[must_use]
    pub const fn new() -> Self {
        Self { open: false, doubt: LaunchDoubt::None }
    }

    /// Opens or closes it, and sets how certain the launch is.
    pub const fn set(&mut self, open: bool, doubt: LaunchDoubt) {
        self.open = open;
        self.doubt = doubt;
    }
}

impl LaunchDiscrete for ReplayUmbilical {
    fn poll(&mut self, _now_us: u64) -> Result<bool, SensorError> {
        Ok(self.open)
    }

    fn doubt(&self) -> LaunchDoubt {
        self.doubt
    }
}

/// A suite in which every sensor replays a flight record.
pub type ReplayedSuite = Suite<
    Replay<GpsFix>,
    Replay<BarometerSample>,
    Replay<ImuSample>,
    Replay<f32>,
    Replay<f32>,
    Replay<VehicleState>,
    ReplayUmbilical,
>;

impl ReplayedSuite {
    /// A suite with nothing to deliver, attached to the mother ship.
    #[must_use]
    pub const fn replayed() -> Self {
        Self::new(
            Replay::new(),
            Replay::new(),
            Replay::new(),
            Replay::new(),
            Replay::new(),
            Replay::new(),
            ReplayUmbilical::new(),
        )
    }

    /// Gives every sensor its part of a record, to deliver at the next poll.
    pub fn load(&mut self, record: &TickInput) {
        self.receiver.load(record.gps);
        let temperature_c = record.signals.baro_temperature_c;
        self.barometer.load(Some(BarometerSample { reading: record.baro, temperature_c }));
        self.imu.load(record.imu);
        self.imu_master.load(record.imu_master_altitude_m);
        self.imu_slave.load(record.imu_slave_altitude_m);
        self.vehicle.load(Some(VehicleState::from(&record.signals)));
        self.launch.set(record.launch, record.launch_doubt);
    }
}

#[cfg(test)]
mod tests {
    use kf_core::input::BaroReading;
    use proptest::prelude::*;

    use super::*;
    use crate::suite::Sensors;

    /// A number, or none: two inputs differ only in how many of these there are.
    fn cell() -> impl Strategy<Value = Option<f32>> {
        proptest::option::of(-1e6f32..1e6)
    }

    prop_compose! {
        fn any_record()(
            (time_us, launch, doubt) in any::<(u64, bool, u8)>(),
            gps in cell(),
            baro in cell(),
            master in cell(),
            slave in cell(),
            imu in proptest::option::of(proptest::array::uniform6(-100f32..100.0)),
            signals in proptest::array::uniform6(cell()),
            attitude in proptest::option::of(proptest::array::uniform3(-4f32..4.0)),
        ) -> TickInput {
            let [tas, aoa, sideslip, throttle, oat, baro_temperature] = signals;
            TickInput {
                time_us,
                launch,
                launch_doubt: [LaunchDoubt::None, LaunchDoubt::Suspected, LaunchDoubt::Unconfirmed][usize::from(doubt % 3)],
                gps: gps.map(|altitude_m| GpsFix { altitude_m, ..GpsFix::default() }),
                baro: baro.map(BaroReading::AltitudeM),
                imu_master_altitude_m: master,
                imu_slave_altitude_m: slave,
                imu: imu.map(|[a, b, c, d, e, f]| ImuSample { accel_mps2: [a, b, c], gyro_radps: [d, e, f] }),
                signals: Signals {
                    true_airspeed_mps: tas,
                    angle_of_attack_rad: aoa,
                    sideslip_rad: sideslip,
                    throttle,
                    outside_air_temperature_c: oat,
                    baro_temperature_c: baro_temperature,
                    attitude_rad: attitude,
                },
                ..TickInput::default()
            }
        }
    }

    proptest! {
        #[test]
        fn what_is_loaded_is_polled_once(record in any_record()) {
            let mut suite = ReplayedSuite::replayed();
            suite.load(&record);
            prop_assert_eq!(suite.poll(record.time_us), record);
            let TickInput { launch, launch_doubt, .. } = record;
            let empty = TickInput { time_us: 7, launch, launch_doubt, ..TickInput::default() };
            prop_assert_eq!(suite.poll(7), empty);
            prop_assert_eq!(suite.faults().count, 0);
        }
    }
}
