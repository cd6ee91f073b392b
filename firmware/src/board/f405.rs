//! The flight computer: an STM32F405RG at 168 MHz from an 8 MHz crystal.
//!
//! The drivers of its chips come with their own issue; until then every sensor of this board says that
//! there is no such device, and the mission runs without samples.

use cortex_m::peripheral::{DCB, DWT, SCB};
use defmt_rtt as _;
use drivers::{
    AltitudeLink, Barometer, BarometerSample, InertialUnit, LaunchDiscrete, SatelliteReceiver, SensorError,
    Suite, VehicleLink, VehicleState,
};
use flight_record::{CostUnit, Encoder, ExitStatus, Header, MAX_STUFFED, Payload, Stream, Summary};
use kf_core::input::{GpsFix, ImuSample};
use stm32f4xx_hal::nb;
use stm32f4xx_hal::pac::{Peripherals, RCC, TIM5, USART1};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::{self, Tx};

use super::{Board, Next};
use crate::flown_model::FINGERPRINT;
use crate::tick_timer::TickTimer;

/// The board's name.
pub const NAME: &str = "f405";
/// The crystal, MHz.
const CRYSTAL_MHZ: u32 = 8;
/// The core's clock, MHz.
const CORE_MHZ: u32 = 168;
/// The timers' clock: APB1 runs at a quarter of the core's, its timers at twice that.
const TIMER_MHZ: u16 = 84;
const TIMER_HZ: u32 = TIMER_MHZ as u32 * 1_000_000;
/// The telemetry's line rate, baud: a tick's result is about 150 bytes, so 200 Hz fill a third of it.
const TELEMETRY_BAUD: u32 = 921_600;

/// The sensors of this board.
pub type Sensors = Suite<Absent, Absent, Absent, Absent, Absent, Absent, Absent>;

/// What the board needs in static memory: nothing.
pub struct Storage;

impl Storage {
    /// Empty.
    pub const fn new() -> Self {
        Self
    }
}

/// Starts the board.
pub fn start(
    device: Peripherals,
    core: cortex_m::Peripherals,
    _storage: &'static mut Storage,
) -> Result<Board, ExitStatus> {
    let clocks = Config::hse(CRYSTAL_MHZ.MHz()).sysclk(CORE_MHZ.MHz()).require_pll48clk();
    let mut rcc = device.RCC.freeze(clocks);
    if rcc.clocks.timclk1().raw() != TIMER_HZ {
        return Err(ExitStatus::Configuration);
    }
    let port_a = device.GPIOA.split(&mut rcc);
    let line = serial::Config::default().baudrate(TELEMETRY_BAUD.bps());
    let telemetry = device.USART1.tx(port_a.pa9, line, &mut rcc).map_err(|_| ExitStatus::NoOutput)?;
    CostClock::start(core.DCB, core.DWT);
    Ok(Board {
        source: Source::start(device.TIM5, &rcc),
        feeder: Feeder,
        sensors: Suite::new(Absent, Absent, Absent, Absent, Absent, Absent, Absent),
        sink: Sink::start(telemetry),
        timer: TickTimer::start(device.TIM2, &rcc, TIMER_HZ),
    })
}

/// Starts again: a flight computer does not stop.
pub fn exit(_status: ExitStatus) -> ! {
    SCB::sys_reset()
}

/// Counts the core's cycles.
#[derive(Clone, Copy)]
pub struct CostClock;

impl CostClock {
    /// What it counts.
    pub const UNIT: CostUnit = CostUnit::Cycles;

    fn start(mut dcb: DCB, mut dwt: DWT) {
        dcb.enable_trace();
        dwt.enable_cycle_counter();
    }

    /// Now, wrapping.
    pub fn now() -> u32 {
        DWT::cycle_count()
    }
}

/// The clock of the mission: TIM5 in microseconds, carried beyond its 32 bits (71 minutes) by looking at
/// it at every tick.
pub struct Source {
    tim5: TIM5,
    now_us: u64,
}

impl Source {
    fn start(tim5: TIM5, rcc: &RCC) -> Self {
        rcc.apb1enr().modify(|_, w| w.tim5en().enabled());
        tim5.psc().write(|w| w.psc().set(TIMER_MHZ - 1));
        tim5.arr().write(|w| w.arr().set(u32::MAX));
        tim5.egr().write(|w| w.ug().set_bit());
        tim5.cr1().modify(|_, w| w.cen().enabled());
        Self { tim5, now_us: 0 }
    }

    /// Every tick runs the mission; a flight cannot wait.
    pub fn next(&mut self, _sensors: &mut Sensors, _room: bool) -> Next {
        let elapsed_us = self.tim5.cnt().read().bits().wrapping_sub(self.now_us as u32);
        self.now_us += u64::from(elapsed_us);
        Next::Tick(self.now_us)
    }
}

/// The chips feed themselves.
pub struct Feeder;

impl Feeder {
    /// Nothing to do.
    pub fn feed(&mut self) {}

    /// Nothing to add.
    pub fn summarise(&self, summary: Summary) -> Summary {
        summary
    }
}

/// Telemetry by USART1.
pub struct Sink {
    line: Tx<USART1>,
    encoder: Encoder,
    failed: bool,
}

impl Sink {
    fn start(line: Tx<USART1>) -> Self {
        let mut sink = Self { line, encoder: Encoder::new(), failed: false };
        sink.write(&Header::new(Stream::Outputs, FINGERPRINT));
        sink
    }

    /// Sends one result; waits for the line, which the ticks preempt. A failure shows in
    /// [`Self::status`].
    pub fn write<P: Payload>(&mut self, payload: &P) {
        let mut buffer = [0; MAX_STUFFED];
        let sent = match self.encoder.encode(payload, &mut buffer) {
            Ok(bytes) => self.send(bytes),
            Err(_) => false,
        };
        self.failed |= !sent;
    }

    /// Byte by byte: the HAL's `embedded_io::Write` says "wrote nothing" when the line is busy, on which
    /// its `write_all` panics.
    fn send(&mut self, bytes: &[u8]) -> bool {
        bytes.iter().all(|&byte| nb::block!(self.line.write(byte)).is_ok())
    }

    /// How the flight ended.
    pub const fn status(&self) -> ExitStatus {
        if self.failed { ExitStatus::NoOutput } else { ExitStatus::Finished }
    }
}

/// A sensor that is not there.
pub struct Absent;

impl SatelliteReceiver for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl Barometer for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl InertialUnit for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl AltitudeLink for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<f32>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl VehicleLink for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<Option<VehicleState>, SensorError> {
        Err(SensorError::NoDevice)
    }
}

impl LaunchDiscrete for Absent {
    fn poll(&mut self, _now_us: u64) -> Result<bool, SensorError> {
        Err(SensorError::NoDevice)
    }
}
