//! The pins, what is wired to them, and the rates of the lines. Nothing else in the image names a pin or a
//! rate of this board: another board with this chip needs only its own version of this file.
//!
//! The pins are those of the OMNIBUS F4 family, which many boards share (ArduPilot's `hwdef/omnibusf4pro`):
//! the inertial unit on SPI1, the barometer on SPI3, pads for the UARTs. `docs/bring-up.md` shows this as
//! tables, built from the first lines of these comments; `cargo test --package xtask` compares the two.

use drivers::umbilical::Sender;
use stm32f4xx_hal::dma::{Stream1, Stream2, Stream7};
use stm32f4xx_hal::gpio::{
    Debugger, Input, PA0, PA1, PA3, PA4, PA5, PA6, PA7, PA9, PB3, PB5, PB10, PB11, PC6, PC10, PC11, PC12,
};
use stm32f4xx_hal::gpio::{gpioa, gpiob, gpioc};
use stm32f4xx_hal::pac::{DMA1, DMA2, SPI1, SPI3, UART4, USART1, USART3, USART6};

/// The crystal, MHz.
pub const CRYSTAL_MHZ: u32 = 8;
/// The core's clock, MHz.
pub const CORE_MHZ: u32 = 168;

/// The inertial unit's bus.
pub type ImuSpi = SPI1;
/// SPI1_SCK: ICM-42688-P, SCLK
pub type ImuSck = PA5;
/// SPI1_MISO: ICM-42688-P, SDO
pub type ImuMiso = PA6;
/// SPI1_MOSI: ICM-42688-P, SDI
pub type ImuMosi = PA7;
/// output: ICM-42688-P, CS
pub type ImuSelect<Mode = Input> = PA4<Mode>;
/// Clock of the inertial unit's bus, Hz: the chip takes 24 MHz, and half a period must last the 39 ns from
/// its select to the first edge (DS-000347, table 6).
pub const IMU_SPI_HZ: u32 = 10_500_000;

/// The barometer's bus.
pub type BaroSpi = SPI3;
/// SPI3_SCK: MS5611, SCLK (BMP390: SCK)
pub type BaroSck = PC10;
/// SPI3_MISO: MS5611, SDO (BMP390: SDO)
pub type BaroMiso = PC11;
/// SPI3_MOSI: MS5611, SDI (BMP390: SDI)
pub type BaroMosi = PC12;
/// output: MS5611, CSB (its PS pin to ground: SPI; BMP390: CSB)
pub type BaroSelect<Mode = Debugger> = PB3<Mode>;
/// Clock of the barometer's bus, Hz: an MS5611 takes 20 MHz, a BMP390 10 MHz, which the bus can only halve
/// from 10.5.
pub const BARO_SPI_HZ: u32 = 5_250_000;

/// The satellite receiver's UART.
pub type ReceiverUart = USART3;
/// The DMA stream of its receiver, and that stream's channel (RM0090, table 42).
pub type ReceiverStream = Stream1<DMA1>;
/// See [`ReceiverStream`].
pub const RECEIVER_CHANNEL: u8 = 4;
/// USART3_TX: u-blox receiver, RXD
pub type ReceiverTx = PB10;
/// USART3_RX: u-blox receiver, TXD
pub type ReceiverRx = PB11;
/// Rate of the satellite receiver's line, baud: where u-blox generations 9 and 10 start.
pub const RECEIVER_BAUD: u32 = 38_400;
/// Time from one fix to the next, ms: 10 fixes of 100 bytes a second fill a quarter of the line.
pub const RECEIVER_PERIOD_MS: u16 = 100;

/// The umbilical's UART.
pub type UmbilicalUart = UART4;
/// The DMA stream of its receiver, and that stream's channel (RM0090, table 42).
pub type UmbilicalStream = Stream2<DMA1>;
/// See [`UmbilicalStream`].
pub const UMBILICAL_CHANNEL: u8 = 4;
/// UART4_TX: nothing: the UAV sends nothing to the mother ship
pub type UmbilicalTx = PA0;
/// UART4_RX: mother ship's MAVLink output, TX
pub type UmbilicalRx = PA1;
/// Rate of the umbilical's line, baud: an altitude is 44 bytes, and other messages share the line.
pub const UMBILICAL_BAUD: u32 = 115_200;
/// Whose altitudes on it are the mother ship's.
pub const MOTHER_SHIP: Sender = Sender::FIRST_AUTOPILOT;

/// input, pulled up: umbilical's break-wire, whose other end is ground on the mother ship; an open wire means
/// launched
pub type BreakWirePin<Mode = Input> = PA3<Mode>;

/// The telemetry's UART.
pub type TelemetryUart = USART1;
/// The DMA stream of its transmitter, and that stream's channel (RM0090, table 43).
pub type TelemetryStream = Stream7<DMA2>;
/// See [`TelemetryStream`].
pub const TELEMETRY_CHANNEL: u8 = 4;
/// USART1_TX: the ground's radio or recorder, RX
pub type TelemetryTx = PA9;

/// The results' UART.
pub type ResultsUart = USART6;
/// USART6_TX: the results' reader, RX
pub type ResultsTx = PC6;
/// Rate of the results' line, baud: a tick's result is about 150 bytes, so 200 Hz fill a third of it.
pub const RESULTS_BAUD: u32 = 921_600;

/// output: the board's LED
pub type Led<Mode = Input> = PB5<Mode>;

/// The pins that are in use.
pub struct Pins {
    /// SCK, MISO, MOSI of the inertial unit.
    pub imu: (ImuSck, ImuMiso, ImuMosi),
    /// Its select.
    pub imu_select: ImuSelect,
    /// SCK, MISO, MOSI of the barometer.
    pub baro: (BaroSck, BaroMiso, BaroMosi),
    /// Its select.
    pub baro_select: BaroSelect,
    /// TX, RX of the satellite receiver's UART.
    pub receiver: (ReceiverTx, ReceiverRx),
    /// TX, RX of the umbilical's UART.
    pub umbilical: (UmbilicalTx, UmbilicalRx),
    /// The break-wire.
    pub break_wire: BreakWirePin,
    /// TX of the telemetry's UART.
    pub telemetry: TelemetryTx,
    /// TX of the results' UART.
    pub results: ResultsTx,
    /// The LED.
    pub led: Led,
}

impl Pins {
    /// Takes them from their ports.
    pub fn take(port_a: gpioa::Parts, port_b: gpiob::Parts, port_c: gpioc::Parts) -> Self {
        Self {
            imu: (port_a.pa5, port_a.pa6, port_a.pa7),
            imu_select: port_a.pa4,
            baro: (port_c.pc10, port_c.pc11, port_c.pc12),
            baro_select: port_b.pb3,
            receiver: (port_b.pb10, port_b.pb11),
            umbilical: (port_a.pa0, port_a.pa1),
            break_wire: port_a.pa3,
            telemetry: port_a.pa9,
            results: port_c.pc6,
            led: port_b.pb5,
        }
    }
}
