//! All sensors of the flight computer, polled once a tick.

use kf_core::guard::Guard;
use kf_core::input::{Columns, Signals, TickInput};

use crate::error::SensorError;
use crate::sensor::{AltitudeLink, Barometer, InertialUnit, LaunchDiscrete, SatelliteReceiver, VehicleLink};

/// A sensor of the suite, in the order in which they are polled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Device {
    /// The umbilical discrete.
    Launch,
    /// The reference.
    Receiver,
    /// The barometer.
    Barometer,
    /// The inertial unit.
    InertialUnit,
    /// The link to the mother ship's inertial altitude.
    Master,
    /// The link to a unit that computes the UAV's inertial altitude.
    Slave,
    /// The vehicle's other equipment.
    Vehicle,
}

/// All sensors of a flight computer, of any kind.
pub trait Sensors {
    /// Polls every sensor once, and calls `polled` after each, for measuring their cost.
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput;

    /// The faults so far.
    fn faults(&self) -> Faults;

    /// Whether the umbilical's wire was open at the last poll; `None` if it could not be read.
    fn wire(&self) -> Option<bool>;

    /// Passes on the decision made on the last poll: whether the vehicle has left. Until then the mother
    /// ship's link is read: an open wire alone may be broken, and only her messages can show that.
    fn decided(&mut self, has_left: bool);

    /// Polls every sensor once.
    fn poll(&mut self, now_us: u64) -> TickInput {
        self.poll_each(now_us, &mut |_| ())
    }
}

impl<Suite: Sensors> Sensors for &mut Suite {
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput {
        (**self).poll_each(now_us, polled)
    }

    fn faults(&self) -> Faults {
        (**self).faults()
    }

    fn wire(&self) -> Option<bool> {
        (**self).wire()
    }

    fn decided(&mut self, has_left: bool) {
        (**self).decided(has_left);
    }
}

/// Counts of failed polls. A failed poll never stops the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Failed polls of all sensors.
    pub count: u32,
    /// Error of the last one.
    pub last: Option<SensorError>,
}

/// The sensors of a flight computer.
#[derive(Clone, Debug)]
pub struct Suite<Receiver, Baro, Imu, Master, Slave, Vehicle, Launch> {
    /// The reference.
    pub receiver: Receiver,
    /// The barometer.
    pub barometer: Baro,
    /// The inertial unit.
    pub imu: Imu,
    /// The mother ship's inertial altitude.
    pub imu_master: Master,
    /// The UAV's inertial altitude.
    pub imu_slave: Slave,
    /// The vehicle's other equipment.
    pub vehicle: Vehicle,
    /// The umbilical discrete.
    pub launch: Launch,
    launched: bool,
    wire: Option<bool>,
    was_expensive: bool,
    faults: Faults,
}

impl<Receiver, Baro, Imu, Master, Slave, Vehicle, Launch>
    Suite<Receiver, Baro, Imu, Master, Slave, Vehicle, Launch>
where
    Receiver: SatelliteReceiver,
    Baro: Barometer,
    Imu: InertialUnit,
    Master: AltitudeLink,
    Slave: AltitudeLink,
    Vehicle: VehicleLink,
    Launch: LaunchDiscrete,
{
    /// A suite attached to the mother ship, without a fault.
    pub const fn new(
        receiver: Receiver,
        barometer: Baro,
        imu: Imu,
        imu_master: Master,
        imu_slave: Slave,
        vehicle: Vehicle,
        launch: Launch,
    ) -> Self {
        Self {
            receiver,
            barometer,
            imu,
            imu_master,
            imu_slave,
            vehicle,
            launch,
            launched: false,
            wire: None,
            was_expensive: false,
            faults: Faults { count: 0, last: None },
        }
    }
}

impl<Receiver, Baro, Imu, Master, Slave, Vehicle, Launch> Sensors
    for Suite<Receiver, Baro, Imu, Master, Slave, Vehicle, Launch>
where
    Receiver: SatelliteReceiver,
    Baro: Barometer,
    Imu: InertialUnit,
    Master: AltitudeLink,
    Slave: AltitudeLink,
    Vehicle: VehicleLink,
    Launch: LaunchDiscrete,
{
    /// A failed poll counts as a fault and as no sample. While the umbilical cannot be read, its last state
    /// is kept.
    ///
    /// Ticks with a fix or a pressure are the most expensive, so the mother ship's messages wait for the next
    /// tick. Her altitude is then delivered a tick (5 ms) later, and the launch decision notices her silence
    /// that much later. They do not wait if the last tick was expensive too: with a source that delivers at
    /// every tick there is no better tick to wait for.
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput {
        self.wire = self.faults.note(self.launch.poll(now_us).map(Some));
        self.launched = self.wire.unwrap_or(self.launched);
        polled(Device::Launch);
        let gps = self.faults.note(self.receiver.poll(now_us));
        polled(Device::Receiver);
        let baro = self.faults.note(self.barometer.poll(now_us)).unwrap_or_default();
        polled(Device::Barometer);
        let imu = self.faults.note(self.imu.poll(now_us));
        polled(Device::InertialUnit);
        if !Guard::ListenUntilDecided.stands() {
            self.imu_master.set_attached(!self.launched);
        }
        let is_expensive = gps.is_some() || baro.reading.is_some();
        let waits = is_expensive
            && !self.was_expensive
            && self.faults.note(self.imu_master.put_off().map(Some)).unwrap_or(false);
        self.was_expensive = is_expensive;
        let imu_master_altitude_m = if waits { None } else { self.faults.note(self.imu_master.poll(now_us)) };
        polled(Device::Master);
        let imu_slave_altitude_m = self.faults.note(self.imu_slave.poll(now_us));
        polled(Device::Slave);
        let vehicle = self.faults.note(self.vehicle.poll(now_us)).unwrap_or_default();
        polled(Device::Vehicle);
        TickInput {
            time_us: now_us,
            launch: self.launched,
            launch_doubt: self.launch.doubt(),
            gps,
            baro: baro.reading,
            imu_master_altitude_m,
            imu_slave_altitude_m,
            imu,
            signals: Signals {
                true_airspeed_mps: vehicle.true_airspeed_mps,
                angle_of_attack_rad: vehicle.angle_of_attack_rad,
                sideslip_rad: vehicle.sideslip_rad,
                throttle: vehicle.throttle,
                outside_air_temperature_c: vehicle.outside_air_temperature_c,
                baro_temperature_c: baro.temperature_c,
                attitude_rad: vehicle.attitude_rad,
            },
            columns: Columns::default(),
        }
    }

    fn faults(&self) -> Faults {
        self.faults
    }

    fn wire(&self) -> Option<bool> {
        self.wire
    }

    fn decided(&mut self, has_left: bool) {
        if Guard::ListenUntilDecided.stands() {
            self.imu_master.set_attached(!has_left);
        }
    }
}

impl Faults {
    fn note<T>(&mut self, polled: Result<Option<T>, SensorError>) -> Option<T> {
        polled.unwrap_or_else(|error| {
            self.count = self.count.saturating_add(1);
            self.last = Some(error);
            None
        })
    }
}

#[cfg(test)]
mod tests {
    use kf_core::input::{GpsFix, ImuSample, LaunchDoubt};

    use super::*;
    use crate::replay::{Replay, ReplayUmbilical};
    use crate::sensor::{BarometerSample, VehicleState};

    /// A sensor that fails every second poll.
    struct Flaky {
        polls: u32,
    }

    impl Flaky {
        fn fails(&mut self) -> Result<(), SensorError> {
            self.polls += 1;
            if self.polls.is_multiple_of(2) { Err(SensorError::Bus) } else { Ok(()) }
        }
    }

    impl LaunchDiscrete for Flaky {
        fn poll(&mut self, _now_us: u64) -> Result<bool, SensorError> {
            self.fails().map(|()| true)
        }
    }

    impl AltitudeLink for Flaky {
        fn poll(&mut self, _now_us: u64) -> Result<Option<f32>, SensorError> {
            self.fails().map(|()| Some(5.0))
        }
    }

    #[test]
    fn a_fault_is_counted_and_hides_nothing_else() {
        let mut suite = Suite::new(
            Replay::<GpsFix>::new(),
            Replay::<BarometerSample>::new(),
            Replay::<ImuSample>::new(),
            Replay::<f32>::new(),
            Flaky { polls: 0 },
            Replay::<VehicleState>::new(),
            Flaky { polls: 0 },
        );
        let good = suite.poll(1);
        assert_eq!((good.launch, good.imu_slave_altitude_m), (true, Some(5.0)));
        assert_eq!(suite.faults(), Faults::default());
        let faulty = suite.poll(2);
        assert_eq!((faulty.launch, faulty.imu_slave_altitude_m), (true, None), "the umbilical holds");
        assert_eq!(suite.faults(), Faults { count: 2, last: Some(SensorError::Bus) });
    }

    /// A link whose unit always has an altitude while it is read.
    struct Attached(bool);

    impl AltitudeLink for Attached {
        fn poll(&mut self, _now_us: u64) -> Result<Option<f32>, SensorError> {
            Ok(self.0.then_some(2_000.0))
        }

        fn set_attached(&mut self, attached: bool) {
            self.0 = attached;
        }
    }

    /// An open wire may be broken: the mother ship's link is read until it is decided that the vehicle has
    /// left, and again when that decision is withdrawn.
    #[test]
    fn an_open_wire_alone_does_not_silence_the_mother_ship() {
        let mut suite = Suite::new(
            Replay::<GpsFix>::new(),
            Replay::<BarometerSample>::new(),
            Replay::<ImuSample>::new(),
            Attached(true),
            Replay::<f32>::new(),
            Replay::<VehicleState>::new(),
            ReplayUmbilical::new(),
        );
        for (time_us, wire_is_open, has_left, altitude_m) in [
            (1, false, false, Some(2_000.0)),
            (2, true, false, Some(2_000.0)),
            (3, true, false, Some(2_000.0)),
            (4, true, true, None),
            (5, false, true, None),
            (6, false, false, Some(2_000.0)),
        ] {
            suite.launch.set(wire_is_open, LaunchDoubt::None);
            suite.decided(has_left);
            assert_eq!(suite.poll(time_us).imu_master_altitude_m, altitude_m, "{time_us}");
            assert_eq!(suite.wire(), Some(wire_is_open));
        }
    }
}
