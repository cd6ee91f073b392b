//! A driver on its chip's model, polled tick by tick.
// Every test file uses only a part of this.
#![allow(dead_code, clippy::panic, clippy::unwrap_used)]

use std::fmt::Debug;

use chip_models::bus::{ChipOnBus, SpiChip};
use drivers::{BarometerSample, SensorError};
use kf_core::input::BaroReading;

pub const TICK_US: u64 = 5_000;

/// A driver of a chip on SPI.
pub trait Driver {
    /// Its chip's model.
    type Chip: SpiChip;
    /// The sample that it delivers.
    type Sample: Copy + Debug;
    /// Largest number of bytes that one poll may move.
    const MAX_POLL_BYTES: usize;

    fn bus(&mut self) -> &mut ChipOnBus<Self::Chip>;
    fn poll(&mut self, now_us: u64) -> Result<Option<Self::Sample>, SensorError>;
}

/// The driver, its chip and the time.
pub struct Bench<Of> {
    pub driver: Of,
    /// Bytes moved by the largest poll so far.
    pub most_moved: usize,
    now_us: u64,
}

impl<Of: Driver> Bench<Of> {
    /// A bench at that time, before the first poll.
    pub fn at(now_us: u64, driver: Of) -> Self {
        Self { driver, most_moved: 0, now_us }
    }

    /// One tick. Checks that the poll moves no more than its bytes.
    pub fn poll(&mut self) -> Result<Option<Of::Sample>, SensorError> {
        self.now_us += TICK_US;
        self.driver.bus().set_time(self.now_us);
        let before = self.driver.bus().traffic().bytes;
        let outcome = self.driver.poll(self.now_us);
        let moved = (self.driver.bus().traffic().bytes - before) as usize;
        assert!(moved <= Of::MAX_POLL_BYTES, "{moved} bytes in one poll");
        self.most_moved = self.most_moved.max(moved);
        outcome
    }

    /// The first sample or error within this many ticks.
    pub fn next(&mut self, ticks: u32) -> Result<Of::Sample, SensorError> {
        for _ in 0..ticks {
            if let Some(sample) = self.poll()? {
                return Ok(sample);
            }
        }
        panic!("neither a sample nor an error in {ticks} ticks")
    }

    /// The first error within this many ticks.
    pub fn next_error(&mut self, ticks: u32) -> SensorError {
        (0..ticks).find_map(|_| self.poll().err()).unwrap()
    }

    /// Repairs the wires and runs for a quarter of a second, ignoring errors.
    pub fn mend(&mut self) {
        self.driver.bus().fault = None;
        for _ in 0..50 {
            let _ = self.poll();
        }
    }
}

/// Pascals and degrees of a barometer that measures both.
pub fn pressure_and_temperature(sample: BarometerSample) -> (f32, f32) {
    let Some(BaroReading::PressurePa(pressure)) = sample.reading else { panic!("{sample:?}") };
    (pressure, sample.temperature_c.unwrap())
}
