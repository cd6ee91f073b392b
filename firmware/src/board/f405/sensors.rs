//! The sensors of this board.

use drivers::Suite;
#[cfg(feature = "baro-bmp390")]
pub use drivers::bmp390::{Bmp390 as BaroDriver, MAX_POLL_BYTES as BARO_POLL_BYTES};
use drivers::icm42688p::{self, AccelRange, GyroRange, Icm42688p, Mounting};
#[cfg(not(feature = "baro-bmp390"))]
pub use drivers::ms5611::{MAX_POLL_BYTES as BARO_POLL_BYTES, Ms5611 as BaroDriver};
use drivers::ublox::{self, Datum, Ublox};
use drivers::umbilical::Umbilical;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::config::{Config, DmaConfig, InvalidConfig};

use super::absent::Absent;
use super::break_wire::BreakWire;
use super::spi::{BaroDevice, ImuDevice};
use super::uart::{LineCounts, Port, Ring, ring};
use super::watched::{HealthLog, Watch, Watched};
use super::wiring::{
    MOTHER_SHIP, RECEIVER_BAUD, RECEIVER_CHANNEL, RECEIVER_PERIOD_MS, ReceiverRx, ReceiverStream, ReceiverTx,
    ReceiverUart, UMBILICAL_BAUD, UMBILICAL_CHANNEL, UmbilicalRx, UmbilicalStream, UmbilicalTx,
    UmbilicalUart,
};

/// Ranges, and the chip's orientation in the vehicle. 16 g: an ejector's push, and the jerk of a parting
/// lanyard.
const IMU: icm42688p::Config = icm42688p::Config {
    accel_range: AccelRange::G16,
    gyro_range: GyroRange::Dps2000,
    mounting: Mounting::ALIGNED,
};
/// The flight's datum is mean sea level; the altitude that the mother ship sends over the umbilical has the
/// same.
const RECEIVER: ublox::Config =
    ublox::Config { datum: Datum::MeanSeaLevel, period_ms: RECEIVER_PERIOD_MS, baud: RECEIVER_BAUD };

/// The line to the satellite receiver.
pub type ReceiverPort = Port<ReceiverUart, ReceiverStream>;

/// The line to the mother ship.
pub type UmbilicalPort = Port<UmbilicalUart, UmbilicalStream>;

/// All sensors.
pub type Sensors = Suite<
    Watched<Ublox<ReceiverPort>>,
    Watched<BaroDriver<BaroDevice>>,
    Watched<Icm42688p<ImuDevice>>,
    Watched<Umbilical<UmbilicalPort>>,
    Absent,
    Absent,
    Watched<BreakWire>,
>;

/// Number of devices in the log, and of lines.
const WATCHES: usize = 5;
const LINES: usize = 2;

/// Writes their outcomes to the log.
pub type SensorHealthLog = HealthLog<WATCHES, LINES>;

/// Name in the log of a device at the end of a line, and of that line.
const RECEIVER_NAME: &str = "satellite receiver";
const UMBILICAL_NAME: &str = "umbilical";

/// Static memory of a line.
struct LineStorage {
    ring: Ring,
    counts: LineCounts,
}

impl LineStorage {
    const fn new() -> Self {
        Self { ring: ring(), counts: LineCounts::new() }
    }
}

/// Static memory of the sensors.
pub struct SensorStorage {
    receiver_line: LineStorage,
    umbilical_line: LineStorage,
    receiver: Watch,
    barometer: Watch,
    imu: Watch,
    umbilical: Watch,
    break_wire: Watch,
}

impl SensorStorage {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            receiver_line: LineStorage::new(),
            umbilical_line: LineStorage::new(),
            receiver: Watch::new(),
            barometer: Watch::new(),
            imu: Watch::new(),
            umbilical: Watch::new(),
            break_wire: Watch::new(),
        }
    }

    /// The log of their outcomes.
    pub fn health_log(&'static self) -> SensorHealthLog {
        let Self { receiver, barometer, imu, umbilical, break_wire, .. } = self;
        HealthLog::new(
            [
                (RECEIVER_NAME, receiver),
                ("barometer", barometer),
                ("inertial unit", imu),
                (UMBILICAL_NAME, umbilical),
                ("break-wire", break_wire),
            ],
            [(RECEIVER_NAME, &self.receiver_line.counts), (UMBILICAL_NAME, &self.umbilical_line.counts)],
        )
    }
}

/// Starts the satellite receiver's line. It is pulled up, so a line with nothing at its other end is quiet.
pub fn receiver_port(
    uart: ReceiverUart,
    (tx, rx): (ReceiverTx, ReceiverRx),
    stream: ReceiverStream,
    storage: &'static SensorStorage,
    rcc: &mut Rcc,
) -> Result<ReceiverPort, InvalidConfig> {
    let config = Config::default().baudrate(RECEIVER_BAUD.bps()).dma(DmaConfig::Rx);
    let serial = uart.serial((tx, rx.into_pull_up_input()), config, rcc)?;
    let LineStorage { ring, counts } = &storage.receiver_line;
    Ok(Port::start::<RECEIVER_CHANNEL>(serial, stream, ring, counts, RECEIVER_BAUD))
}

/// Starts the line to the mother ship, in the same way.
pub fn umbilical_port(
    uart: UmbilicalUart,
    (tx, rx): (UmbilicalTx, UmbilicalRx),
    stream: UmbilicalStream,
    storage: &'static SensorStorage,
    rcc: &mut Rcc,
) -> Result<UmbilicalPort, InvalidConfig> {
    let config = Config::default().baudrate(UMBILICAL_BAUD.bps()).dma(DmaConfig::Rx);
    let serial = uart.serial((tx, rx.into_pull_up_input()), config, rcc)?;
    let LineStorage { ring, counts } = &storage.umbilical_line;
    Ok(Port::start::<UMBILICAL_CHANNEL>(serial, stream, ring, counts, UMBILICAL_BAUD))
}

/// Gives every device its driver.
pub fn suite(
    storage: &'static SensorStorage,
    receiver: ReceiverPort,
    barometer: BaroDevice,
    imu: ImuDevice,
    umbilical: UmbilicalPort,
    break_wire: BreakWire,
) -> Sensors {
    Suite::new(
        Watched::new(Ublox::new(receiver, RECEIVER), &storage.receiver),
        Watched::new(BaroDriver::new(barometer), &storage.barometer),
        Watched::new(Icm42688p::new(imu, IMU), &storage.imu),
        Watched::new(Umbilical::new(umbilical, MOTHER_SHIP), &storage.umbilical),
        Absent,
        Absent,
        Watched::new(break_wire, &storage.break_wire),
    )
}
