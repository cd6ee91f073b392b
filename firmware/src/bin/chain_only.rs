//! The smallest image that contains the whole chain of a tick: the drivers of every chip, on buses of which
//! the compiler knows nothing, and the mission.
//!
//! It is never run. `budgets.toml` lists the symbols that it must not contain: what is linked here is what a
//! tick needs, including any panic that a driver can reach. The receiver's driver is left out: the crate
//! `ublox` (0.10, its `parser/buffer.rs` and the fields of `nav_pvt/proto27.rs`) checks bounds that hold but
//! that the compiler cannot prove.
#![no_std]
#![no_main]

use core::convert::Infallible;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use drivers::bmp390::Bmp390;
use drivers::icm42688p::{AccelRange, GyroRange, Icm42688p, Mounting};
use drivers::ms5611::Ms5611;
use drivers::umbilical::{Sender, Umbilical};
use drivers::{Barometer, Replay, ReplayUmbilical, Sensors as _, Suite, VehicleState};
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use embedded_io::{Read, ReadReady};
use flight_computer::{FlightComputer, Onboard};
use kf_core::input::{GpsFix, LaunchDoubt};
use kf_core::launch::LaunchConfig;
use kf_core::strapdown;
// The vector table needs every interrupt of the chip.
use stm32f4xx_hal as _;

/// A bus whose data the compiler cannot foresee.
struct Unknown;

impl ErrorType for Unknown {
    type Error = Infallible;
}

impl SpiDevice for Unknown {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        black_box(operations);
        Ok(())
    }
}

impl embedded_io::ErrorType for Unknown {
    type Error = Infallible;
}

impl ReadReady for Unknown {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(black_box(true))
    }
}

impl Read for Unknown {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let length = buffer.len();
        black_box(buffer);
        // Every port guarantees this.
        Ok(black_box(1_usize).min(length))
    }
}

/// Ticks with this barometer.
fn fly(barometer: impl Barometer) {
    let mut place = MaybeUninit::uninit();
    let Ok(mission) = flown_mission::mission(&mut place) else { return };
    let imu_config = drivers::icm42688p::Config {
        accel_range: black_box(AccelRange::G16),
        gyro_range: black_box(GyroRange::Dps2000),
        mounting: black_box(Mounting::ALIGNED),
    };
    let suite = Suite::new(
        Replay::<GpsFix>::new(),
        barometer,
        Icm42688p::new(Unknown, imu_config),
        Umbilical::new(Unknown, Sender::FIRST_AUTOPILOT),
        Replay::<f32>::new(),
        Replay::<VehicleState>::new(),
        ReplayUmbilical::new(),
    );
    let Ok(onboard) = Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS) else { return };
    let mut computer = FlightComputer::on_board(suite, flown_mission::Flown(mission), onboard);
    while black_box(true) {
        computer.sensors.launch.set(black_box(false), black_box(LaunchDoubt::None));
        computer.sensors.receiver.load(black_box(None));
        black_box(computer.tick(black_box(0)));
        black_box(computer.sensors.faults());
        black_box(computer.mission.0.latch());
    }
}

#[entry]
fn main() -> ! {
    loop {
        fly(Ms5611::new(Unknown));
        fly(Bmp390::new(Unknown));
    }
}

#[panic_handler]
fn panicked(_: &PanicInfo) -> ! {
    loop {}
}
