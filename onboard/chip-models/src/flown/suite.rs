//! The board's chips and drivers.

use drivers::icm42688p::{AccelRange, GyroRange, Icm42688p, Mounting};
use drivers::ms5611::Ms5611;
use drivers::ublox::{Datum, Ublox};
use drivers::umbilical::{Sender, Umbilical};
use drivers::{Device, Faults, Replay, Sensors, Suite, VehicleState};
use kf_core::input::{GpsFix, TickInput};
use kf_core::reading::is_held;

use super::fault::{Chip, ChipFault, Fault};
use super::fitted::Fitted;
use super::truth::{self, ASSUMED_TEMPERATURE_C, TruthCounts, count};
use super::wire::ModelledWire;
use crate::bus::{ChipOnBus, SpiChip};
use crate::icm42688p::Icm42688pModel;
use crate::metered::{Metered, MeteredUart, WorkObserver};
use crate::mother_ship::{MotherShipFault, MotherShipModel};
use crate::ms5611::{EXAMPLE_CALIBRATION, Ms5611Model};
use crate::source::{Air, Held, Motion, Source};
use crate::ublox::{self, ColdStart, ReceiverModel, Solution, TIME_OF_WEEK_MS};

/// Speed of the receiver's line, baud. A flight may have more fixes a second than any receiver delivers, and
/// 200 of them take 200 kbaud.
pub const RECEIVER_BAUD: u32 = 460_800;
/// Speed of the umbilical's line, baud.
pub const UMBILICAL_BAUD: u32 = 115_200;

/// The board's configuration of its inertial unit.
const IMU_CONFIG: drivers::icm42688p::Config = drivers::icm42688p::Config {
    accel_range: AccelRange::G16,
    gyro_range: GyroRange::Dps2000,
    mounting: Mounting::ALIGNED,
};
/// The board's configuration of its receiver.
const GPS_CONFIG: drivers::ublox::Config =
    drivers::ublox::Config { datum: Datum::MeanSeaLevel, period_ms: PERIOD_MS, baud: RECEIVER_BAUD };
/// Period that the receiver is configured for, milliseconds. The flight's fixes come at their own times.
const PERIOD_MS: u16 = 100;
/// Generation of the receiver.
const GENERATION: u8 = 9;
/// Latest time at which the chips' sums of times do not overflow, microseconds: 9,000 years.
const LATEST_US: u64 = 1 << 58;
/// The mother ship's MAVLink address.
const MOTHER_SHIP: Sender = Sender::FIRST_AUTOPILOT;

/// A source without solutions: the receiver has no navigation epochs of its own.
#[derive(Clone, Copy, Debug)]
pub struct NoEpochs;

impl Source<Option<Solution>> for NoEpochs {
    fn at(&mut self, _time_us: u64) -> Option<Solution> {
        None
    }
}

type Spi<Model, Observer> = Metered<ChipOnBus<Model>, Observer>;
type Baro<Observer> = Ms5611<Spi<Ms5611Model<Held<Air>>, Observer>>;
type Imu<Observer> = Icm42688p<Spi<Icm42688pModel<Held<Motion>>, Observer>>;
type Receiver<Observer> = Ublox<MeteredUart<ReceiverModel<NoEpochs>, Observer>>;
type Master<Observer> = Umbilical<MeteredUart<MotherShipModel, Observer>>;
type Board<Observer> = Suite<
    Fitted<Receiver<Observer>>,
    Fitted<Baro<Observer>>,
    Fitted<Imu<Observer>>,
    Fitted<Master<Observer>>,
    Replay<f32>,
    Replay<VehicleState>,
    ModelledWire,
>;

/// The board on models of its chips, for replaying a flight tick by tick.
pub struct ModelledSuite<Observer> {
    board: Board<Observer>,
    now_us: u64,
    last_fix: Option<GpsFix>,
    temperature_c: Option<f32>,
    counts: TruthCounts,
}

impl<Observer: WorkObserver + Clone> ModelledSuite<Observer> {
    /// A board without a chip on it. `observer` is notified when the models work.
    pub fn new(observer: &Observer) -> Self {
        let still =
            Motion { accel_mps2: [0.0; 3], gyro_radps: [0.0; 3], temperature_c: ASSUMED_TEMPERATURE_C };
        let vacuum = Air { pressure_pa: 0.0, temperature_c: ASSUMED_TEMPERATURE_C };
        let baro = Ms5611Model::new(EXAMPLE_CALIBRATION, Held(vacuum));
        let mut receiver = ReceiverModel::new(GENERATION, RECEIVER_BAUD, NoEpochs);
        // A flight records a fix at the time of its arrival.
        receiver.latency_us = 0;
        let mother_ship = MotherShipModel::new(MOTHER_SHIP.system, UMBILICAL_BAUD);
        Self {
            board: Suite::new(
                Fitted::absent(Ublox::new(MeteredUart::new(receiver, observer.clone()), GPS_CONFIG)),
                Fitted::absent(Ms5611::new(Metered::new(ChipOnBus::new(baro), observer.clone()))),
                Fitted::absent(Icm42688p::new(
                    Metered::new(ChipOnBus::new(Icm42688pModel::new(Held(still))), observer.clone()),
                    IMU_CONFIG,
                )),
                Fitted::absent(Umbilical::new(MeteredUart::new(mother_ship, observer.clone()), MOTHER_SHIP)),
                Replay::new(),
                Replay::new(),
                ModelledWire::new(),
            ),
            now_us: 0,
            last_fix: None,
            temperature_c: None,
            counts: TruthCounts::default(),
        }
    }
}

impl<Observer: WorkObserver + Clone> ModelledSuite<Observer> {
    /// Models a reset of the flight computer alone. The chips keep their state and their faults; new drivers
    /// start without knowing that state.
    #[inline(never)]
    pub fn restart(&mut self) {
        let old = &mut self.board;
        let receiver = Ublox::new(old.receiver.driver.port_mut().clone(), GPS_CONFIG);
        let barometer = Ms5611::new(old.barometer.driver.bus_mut().clone());
        let imu = Icm42688p::new(old.imu.driver.bus_mut().clone(), IMU_CONFIG);
        let imu_master = Umbilical::new(old.imu_master.driver.port_mut().clone(), MOTHER_SHIP);
        *old = Suite::new(
            old.receiver.with(receiver),
            old.barometer.with(barometer),
            old.imu.with(imu),
            old.imu_master.with(imu_master),
            Replay::new(),
            Replay::new(),
            old.launch,
        );
    }
}

impl<Observer: WorkObserver> ModelledSuite<Observer> {
    /// Values that could not go through the chips unchanged.
    pub fn counts(&self) -> TruthCounts {
        self.counts
    }

    /// Solutions that the receiver did not send: it was not configured yet, or too many came at a time.
    pub fn unsent_solutions(&mut self) -> u32 {
        self.board.receiver.driver.port_mut().0.port.unsent_solutions
    }

    /// Lets time pass up to a tick, and gives the chips the tick's new values as their surroundings.
    pub fn load(&mut self, record: &TickInput) {
        if (self.now_us..=LATEST_US).contains(&record.time_us) {
            self.now_us = record.time_us;
        } else {
            count(&mut self.counts.impossible_times);
        }
        let now_us = self.now_us;
        self.board.launch.set(record.launch, record.launch_doubt);
        self.board.imu_slave.load(record.imu_slave_altitude_m);
        self.board.vehicle.load(Some(VehicleState::from(&record.signals)));
        self.load_barometer(record, now_us);
        self.load_inertial_unit(record, now_us);
        self.load_receiver(record, now_us);
        self.load_mother_ship(record, now_us);
    }

    fn load_barometer(&mut self, record: &TickInput, now_us: u64) {
        if let Some(temperature_c) = record.signals.baro_temperature_c {
            if temperature_c.is_finite() {
                self.temperature_c = Some(temperature_c);
            } else {
                count(&mut self.counts.not_finite);
            }
        }
        let air = record.baro.and_then(|reading| truth::air(reading, self.temperature_c, &mut self.counts));
        let baro = &mut self.board.barometer;
        if let Some(air) = air {
            let is_new = baro.fit();
            let bus = &mut baro.driver.bus_mut().port;
            bus.chip.air.0 = air;
            power(bus, is_new, now_us);
        } else if let (Some(driver), Some(temperature_c)) = (baro.fitted(), self.temperature_c) {
            driver.bus_mut().port.chip.air.0.temperature_c = temperature_c;
        }
        if let Some(driver) = baro.fitted() {
            driver.bus_mut().port.set_time(now_us);
        }
    }

    fn load_inertial_unit(&mut self, record: &TickInput, now_us: u64) {
        let motion = record.imu.and_then(|sample| truth::motion(&sample, &mut self.counts));
        let imu = &mut self.board.imu;
        if let Some(motion) = motion {
            let is_new = imu.fit();
            let bus = &mut imu.driver.bus_mut().port;
            bus.chip.motion.0 = motion;
            power(bus, is_new, now_us);
        }
        if let Some(driver) = imu.fitted() {
            driver.bus_mut().port.set_time(now_us);
        }
    }

    fn load_receiver(&mut self, record: &TickInput, now_us: u64) {
        let mut fix = record.gps;
        if let (Some(new), Some(last)) = (&fix, &self.last_fix)
            && is_held(new, last)
        {
            count(&mut self.counts.held_fixes);
            fix = None;
        }
        self.last_fix = record.gps.or(self.last_fix);
        let solution = fix.and_then(|fix| truth::solution(&fix, &mut self.counts));
        let receiver = &mut self.board.receiver;
        if solution.is_some() && receiver.fit() {
            receiver.driver.port_mut().0.port.power_on(now_us);
        }
        if let Some(driver) = receiver.fitted() {
            let model = &mut driver.port_mut().0.port;
            model.set_time(now_us);
            if let Some(solution) = solution {
                model.solve(solution);
            }
        }
    }

    fn load_mother_ship(&mut self, record: &TickInput, now_us: u64) {
        let mut altitude_m = record.imu_master_altitude_m;
        if record.launch && altitude_m.take().is_some() {
            count(&mut self.counts.after_launch);
        }
        if altitude_m.is_some_and(|altitude_m| !altitude_m.is_finite()) {
            count(&mut self.counts.not_finite);
            altitude_m = None;
        }
        let master = &mut self.board.imu_master;
        if altitude_m.is_some() && master.fit() {
            master.driver.port_mut().0.port.line.skip_until(now_us);
        }
        if let Some(driver) = master.fitted() {
            let model = &mut driver.port_mut().0.port;
            model.set_attached(!record.launch);
            model.set_time(now_us);
            if let Some(altitude_m) = altitude_m {
                model.navigate(altitude_m);
            }
        }
    }

    /// Sets how far the receiver's clock is ahead of the flight computer's, microseconds: one of the two has
    /// jumped, or the flight computer was off.
    pub fn set_receivers_lead(&mut self, lead_us: i64) {
        let model = &mut self.board.receiver.driver.port_mut().0.port;
        model.time_of_week_ms = TIME_OF_WEEK_MS.saturating_add_signed(lead_us / 1_000);
    }

    /// Starts or ends a fault.
    pub fn inject(&mut self, event: ChipFault) {
        let ChipFault { chip, fault } = event;
        if !chip.can(fault) {
            count(&mut self.counts.impossible_faults);
            return;
        }
        match chip {
            Chip::Baro => {
                let bus = &mut self.board.barometer.driver.bus_mut().port;
                bus.fault = fault.of_wires();
                bus.chip.disturbance = fault.of_results();
                bus.chip.slower_by_us = if let Fault::Slow { by_us } = fault { by_us.into() } else { 0 };
                bus.chip.stalled = fault == Fault::Stalled;
                bus.chip.lose_conversions =
                    if let Fault::LoseConversions { count } = fault { count } else { 0 };
                bus.chip.prom_flip = match fault {
                    Fault::FlipProm { byte, mask } => Some((byte, mask)),
                    _ => None,
                };
                if fault == Fault::Reset {
                    bus.power_dip();
                }
            }
            Chip::Imu => {
                let bus = &mut self.board.imu.driver.bus_mut().port;
                bus.fault = fault.of_wires();
                bus.chip.disturbance = fault.of_results();
                bus.chip.vibration = fault.of_airframe();
                bus.chip.stalled = fault == Fault::Stalled;
                match fault {
                    Fault::FlipRegister { address, mask } => *bus.chip.register_mut(address) ^= mask,
                    Fault::Reset => bus.power_dip(),
                    _ => {}
                }
            }
            Chip::Gps => {
                let model = &mut self.board.receiver.driver.port_mut().0.port;
                model.line.faults = fault.of_line();
                model.disturbance = fault.of_results();
                model.faults = ublox::Faults {
                    refuses: fault == Fault::Refuses,
                    silent: fault == Fault::Silent,
                    no_fix: fault == Fault::NoFix,
                    held: fault == Fault::Held,
                };
                model.cold_start = match fault {
                    Fault::ColdStart { error_mm, decay_s, is_honest } => Some(ColdStart {
                        error_m: error_mm as f32 * 1e-3,
                        decay_s: f32::from(decay_s),
                        is_honest,
                    }),
                    _ => None,
                };
                match fault {
                    Fault::FlipRegister { address, .. } => {
                        let _ = model.flip_setting(address);
                    }
                    Fault::Generation8 { baud } => model.exchange_for(8, baud),
                    Fault::Reset => model.power_dip(),
                    _ => {}
                }
            }
            Chip::Umbilical => {
                let model = &mut self.board.imu_master.driver.port_mut().0.port;
                model.line.faults = fault.of_line();
                model.fault = match fault {
                    Fault::Silent => MotherShipFault::Silent,
                    Fault::Stranger { system, component, altitude_m } => {
                        MotherShipFault::Stranger { system, component, altitude_m: altitude_m as f32 }
                    }
                    Fault::Lies { by_m } => MotherShipFault::Lies { by_m: by_m as f32 },
                    Fault::NotANumber => MotherShipFault::Lies { by_m: f32::NAN },
                    Fault::Holds => MotherShipFault::Holds,
                    _ => MotherShipFault::None,
                };
                self.board.launch.tear(fault == Fault::Torn);
            }
            Chip::Wire => self.board.launch.fail(fault),
        }
    }
}

/// Powers on a chip that is new.
fn power<Chip: SpiChip>(bus: &mut ChipOnBus<Chip>, is_new: bool, now_us: u64) {
    if is_new {
        bus.set_time(now_us);
        bus.power_dip();
    }
}

impl<Observer: WorkObserver> Sensors for ModelledSuite<Observer> {
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput {
        self.board.poll_each(now_us, polled)
    }

    fn faults(&self) -> Faults {
        self.board.faults()
    }

    fn wire(&self) -> Option<bool> {
        self.board.wire()
    }

    fn decided(&mut self, has_left: bool) {
        self.board.decided(has_left);
    }
}
