//! A sensor that may not be on the board yet.

use drivers::{AltitudeLink, Barometer, BarometerSample, InertialUnit, SatelliteReceiver, SensorError};
use kf_core::input::{GpsFix, ImuSample};

/// A driver that is polled only once its chip is fitted.
#[derive(Clone, Debug)]
pub struct Fitted<Driver> {
    /// The driver.
    pub driver: Driver,
    is_fitted: bool,
}

impl<Driver> Fitted<Driver> {
    /// A driver whose chip is not fitted.
    pub const fn absent(driver: Driver) -> Self {
        Self { driver, is_fitted: false }
    }

    /// The same chip, fitted or not, with another driver.
    pub const fn with<Other>(&self, driver: Other) -> Fitted<Other> {
        Fitted { driver, is_fitted: self.is_fitted }
    }

    /// Fits the chip. Returns whether it was absent before.
    pub const fn fit(&mut self) -> bool {
        let is_new = !self.is_fitted;
        self.is_fitted = true;
        is_new
    }

    /// The driver, if its chip is fitted.
    pub const fn fitted(&mut self) -> Option<&mut Driver> {
        if self.is_fitted { Some(&mut self.driver) } else { None }
    }
}

impl<Driver: SatelliteReceiver> SatelliteReceiver for Fitted<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<GpsFix>, SensorError> {
        self.fitted().map_or(Ok(None), |driver| driver.poll(now_us))
    }
}

impl<Driver: Barometer> Barometer for Fitted<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<BarometerSample>, SensorError> {
        self.fitted().map_or(Ok(None), |driver| driver.poll(now_us))
    }
}

impl<Driver: InertialUnit> InertialUnit for Fitted<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<ImuSample>, SensorError> {
        self.fitted().map_or(Ok(None), |driver| driver.poll(now_us))
    }
}

impl<Driver: AltitudeLink> AltitudeLink for Fitted<Driver> {
    fn poll(&mut self, now_us: u64) -> Result<Option<f32>, SensorError> {
        self.fitted().map_or(Ok(None), |driver| driver.poll(now_us))
    }

    fn put_off(&mut self) -> Result<bool, SensorError> {
        self.fitted().map_or(Ok(false), AltitudeLink::put_off)
    }

    fn set_attached(&mut self, attached: bool) {
        self.driver.set_attached(attached);
    }
}
