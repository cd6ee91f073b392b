//! The sensors of this board.

use drivers::Suite;
use drivers::icm42688p::{self, AccelRange, GyroRange, Icm42688p, Mounting};
use drivers::ms5611::Ms5611;
use drivers::ublox::{self, Datum, Ublox};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Rcc;
use stm32f4xx_hal::serial::config::{Config, DmaConfig, InvalidConfig};

use super::absent::Absent;
use super::break_wire::BreakWire;
use super::spi::{BaroDevice, ImuDevice};
use super::uart::{LineCounts, Port, Ring, ring};
use super::watched::{Teller, Watch, Watched};
use super::wiring::{
    RECEIVER_BAUD, RECEIVER_CHANNEL, RECEIVER_PERIOD_MS, ReceiverRx, ReceiverStream, ReceiverTx, ReceiverUart,
};

/// Ranges, and how the chip sits in the vehicle. 16 g: an ejector's push, and what a parted lanyard gives.
const IMU: icm42688p::Config = icm42688p::Config {
    accel_range: AccelRange::G16,
    gyro_range: GyroRange::Dps2000,
    mounting: Mounting::ALIGNED,
};
/// The flight's datum is mean sea level: what the mother ship sends over the umbilical has it too.
const RECEIVER: ublox::Config = ublox::Config { datum: Datum::MeanSeaLevel, period_ms: RECEIVER_PERIOD_MS };

/// The line to the satellite receiver.
pub type ReceiverPort = Port<ReceiverUart, ReceiverStream>;

/// All of them.
pub type Sensors = Suite<
    Watched<Ublox<ReceiverPort>>,
    Watched<Ms5611<BaroDevice>>,
    Watched<Icm42688p<ImuDevice>>,
    Absent,
    Absent,
    Absent,
    Watched<BreakWire>,
>;

/// What they need in static memory.
pub struct SensorStorage {
    receiver_ring: Ring,
    receiver_line: LineCounts,
    receiver: Watch,
    barometer: Watch,
    imu: Watch,
    umbilical: Watch,
}

impl SensorStorage {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self {
            receiver_ring: ring(),
            receiver_line: LineCounts::new(),
            receiver: Watch::new("satellite receiver"),
            barometer: Watch::new("barometer"),
            imu: Watch::new("inertial unit"),
            umbilical: Watch::new("break-wire"),
        }
    }

    /// What writes their outcomes to the log.
    pub fn teller(&'static self) -> Teller<4, 1> {
        Teller::new(
            [&self.receiver, &self.barometer, &self.imu, &self.umbilical],
            [("satellite receiver", &self.receiver_line)],
        )
    }
}

/// Starts the satellite receiver's line.
pub fn receiver_port(
    uart: ReceiverUart,
    pins: (ReceiverTx, ReceiverRx),
    stream: ReceiverStream,
    storage: &'static SensorStorage,
    rcc: &mut Rcc,
) -> Result<ReceiverPort, InvalidConfig> {
    let config = Config::default().baudrate(RECEIVER_BAUD.bps()).dma(DmaConfig::Rx);
    let serial = uart.serial(pins, config, rcc)?;
    let SensorStorage { receiver_ring: ring, receiver_line: counts, .. } = storage;
    Ok(Port::start::<RECEIVER_CHANNEL>(serial, stream, ring, counts, RECEIVER_BAUD))
}

/// Gives every device its driver.
pub fn suite(
    storage: &'static SensorStorage,
    receiver: ReceiverPort,
    barometer: BaroDevice,
    imu: ImuDevice,
    umbilical: BreakWire,
) -> Sensors {
    Suite::new(
        Watched::new(Ublox::new(receiver, RECEIVER), &storage.receiver),
        Watched::new(Ms5611::new(barometer), &storage.barometer),
        Watched::new(Icm42688p::new(imu, IMU), &storage.imu),
        Absent,
        Absent,
        Absent,
        Watched::new(umbilical, &storage.umbilical),
    )
}
