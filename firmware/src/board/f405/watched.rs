//! Logs the state of the board's devices: that one delivers, or why it does not, whenever this changes.

use core::cell::Cell;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::interrupt::{self, Mutex};
use drivers::{
    AltitudeLink, Barometer, BarometerSample, InertialUnit, LaunchDiscrete, SatelliteReceiver, SensorError,
};
use kf_core::input::{GpsFix, ImuSample, LaunchDoubt};

use super::break_wire::BreakWire;
use super::uart::LineCounts;
use crate::tick_timer::TICK_HZ;

/// Outcome of a device's last poll that had one. "None yet" is zero, whatever the layout of the others,
/// because data initialised to zeros takes no flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
enum Outcome {
    Silent = 0,
    Delivers,
    Fails(SensorError),
    /// The wire is closed; it has closed again this many times.
    Closed(u32),
    /// The wire has been open since this time, microseconds of the mission.
    Open(u64),
}

impl Outcome {
    const fn of<T>(polled: &Result<Option<T>, SensorError>) -> Option<Self> {
        match polled {
            Ok(Some(_)) => Some(Self::Delivers),
            Ok(None) => None,
            Err(error) => Some(Self::Fails(*error)),
        }
    }
}

/// A device whose outcomes are logged.
pub struct Watch(Mutex<Cell<Outcome>>);

impl Watch {
    /// A device that has not been polled.
    pub const fn new() -> Self {
        Self(Mutex::new(Cell::new(Outcome::Silent)))
    }

    fn note(&self, outcome: Option<Outcome>) {
        if let Some(outcome) = outcome {
            interrupt::free(|section| self.0.borrow(section).set(outcome));
        }
    }
}

/// A watched driver.
pub struct Watched<Driver> {
    driver: Driver,
    watch: &'static Watch,
}

impl<Driver> Watched<Driver> {
    /// Watches a driver.
    pub const fn new(driver: Driver, watch: &'static Watch) -> Self {
        Self { driver, watch }
    }

    fn noted<T>(&self, polled: Result<Option<T>, SensorError>) -> Result<Option<T>, SensorError> {
        self.watch.note(Outcome::of(&polled));
        polled
    }
}

impl<Driver: SatelliteReceiver> SatelliteReceiver for Watched<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        let polled = self.driver.poll(now_us);
        self.noted(polled)
    }
}

impl<Driver: Barometer> Barometer for Watched<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        let polled = self.driver.poll(now_us);
        self.noted(polled)
    }
}

impl<Driver: InertialUnit> InertialUnit for Watched<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        let polled = self.driver.poll(now_us);
        self.noted(polled)
    }
}

impl<Driver: AltitudeLink> AltitudeLink for Watched<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<f32>, SensorError> {
        let polled = self.driver.poll(now_us);
        self.noted(polled)
    }

    fn put_off(&mut self) -> Result<bool, SensorError> {
        let outcome = self.driver.put_off();
        if let Err(error) = outcome {
            self.watch.note(Some(Outcome::Fails(error)));
        }
        outcome
    }

    fn set_attached(&mut self, attached: bool) {
        self.driver.set_attached(attached);
    }
}

impl LaunchDiscrete for Watched<BreakWire> {
    fn poll(&mut self, now_us: u64) -> Result<bool, SensorError> {
        let polled = self.driver.poll(now_us);
        self.watch.note(Some(match polled {
            Ok(false) => Outcome::Closed(self.driver.closings()),
            Ok(true) => Outcome::Open(self.driver.opened_us().unwrap_or(now_us)),
            Err(error) => Outcome::Fails(error),
        }));
        polled
    }

    fn doubt(&self) -> LaunchDoubt {
        self.driver.doubt()
    }
}

/// A device, and the outcome last logged.
struct LoggedDevice {
    name: &'static str,
    watch: &'static Watch,
    outcome: Outcome,
    /// Ticks until it may be logged again: a device that changes at every tick is logged once a second.
    quiet_ticks: u32,
}

impl LoggedDevice {
    fn log_changes(&mut self) {
        self.quiet_ticks = self.quiet_ticks.saturating_sub(1);
        let outcome = interrupt::free(|section| self.watch.0.borrow(section).get());
        if self.quiet_ticks > 0 || outcome == self.outcome {
            return;
        }
        self.quiet_ticks = TICK_HZ;
        self.outcome = outcome;
        let name = self.name;
        match outcome {
            Outcome::Silent => {}
            Outcome::Delivers => defmt::info!("{=str}: delivers", name),
            Outcome::Fails(error) => defmt::warn!("{=str}: {}", name, error),
            Outcome::Closed(0) => defmt::info!("{=str}: closed", name),
            Outcome::Closed(times) => {
                defmt::warn!("{=str}: closed; it has been open {=u32} times", name, times);
            }
            Outcome::Open(since_us) => defmt::info!("{=str}: open since {=u64} us", name, since_us),
        }
    }
}

/// A line, and the error counts last logged.
struct LoggedLine {
    name: &'static str,
    counts: &'static LineCounts,
    logged: [u32; 3],
    quiet_ticks: u32,
}

impl LoggedLine {
    fn log_changes(&mut self) {
        self.quiet_ticks = self.quiet_ticks.saturating_sub(1);
        let LineCounts { broken, late, stopped } = self.counts;
        let counts = [broken, late, stopped].map(|counter: &AtomicU32| counter.load(Ordering::Relaxed));
        if self.quiet_ticks > 0 || counts == self.logged {
            return;
        }
        self.quiet_ticks = TICK_HZ;
        self.logged = counts;
        let [broken, late, stopped] = counts;
        defmt::warn!(
            "{=str}'s line: broken bytes {=u32} times, read too late {=u32} times, stopped {=u32} times",
            self.name,
            broken,
            late,
            stopped
        );
    }
}

/// Logs changes of devices and lines.
pub struct HealthLog<const DEVICES: usize, const LINES: usize> {
    devices: [LoggedDevice; DEVICES],
    lines: [LoggedLine; LINES],
}

impl<const DEVICES: usize, const LINES: usize> HealthLog<DEVICES, LINES> {
    /// A log with no entries yet.
    pub fn new(
        devices: [(&'static str, &'static Watch); DEVICES],
        lines: [(&'static str, &'static LineCounts); LINES],
    ) -> Self {
        Self {
            devices: devices.map(|(name, watch)| LoggedDevice {
                name,
                watch,
                outcome: Outcome::Silent,
                quiet_ticks: 0,
            }),
            lines: lines.map(|(name, counts)| LoggedLine { name, counts, logged: [0; 3], quiet_ticks: 0 }),
        }
    }

    /// Logs changes; called once a tick.
    pub fn log_changes(&mut self) {
        self.devices.iter_mut().for_each(LoggedDevice::log_changes);
        self.lines.iter_mut().for_each(LoggedLine::log_changes);
    }
}
