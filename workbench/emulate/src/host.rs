//! The host's flight computer: the firmware's, run beside it.

use chip_models::flown::RecordedSensors;
use drivers::{Device, Faults, Sensors};
use flight_computer::{FlightComputer, Onboard};
use flight_record::SensorSource;
use kf_core::input::{BaroReading, TickInput};
use kf_core::launch::LaunchConfig;
use kf_core::strapdown;
use model::Model;

use super::error::FlyError;
use replay::{AnyMission, ReplayError, mission};

/// The flight computer of a model, on the host.
pub(super) type HostComputer = FlightComputer<HostSensors, Box<dyn AnyMission>>;

/// The sensors of a record, with an injected error if requested.
pub(super) struct HostSensors {
    /// The sensors.
    pub(super) recorded: RecordedSensors<()>,
    /// Whether every barometer reading is shifted by one unit in the last place.
    ulp_error: bool,
}

impl Sensors for HostSensors {
    fn poll_each(&mut self, now_us: u64, polled: &mut impl FnMut(Device)) -> TickInput {
        let input = self.recorded.poll_each(now_us, polled);
        if self.ulp_error { one_ulp_off(input) } else { input }
    }

    fn faults(&self) -> Faults {
        self.recorded.faults()
    }

    fn wire(&self) -> Option<bool> {
        self.recorded.wire()
    }

    fn decided(&mut self, has_left: bool) {
        self.recorded.decided(has_left);
    }
}

/// A flight computer before its first tick.
pub(super) fn computer(
    model: &Model,
    source: SensorSource,
    ulp_error: bool,
) -> Result<HostComputer, FlyError> {
    let mission = mission(model)?;
    let sensors = HostSensors { recorded: RecordedSensors::new(source, &()), ulp_error };
    Ok(match source {
        SensorSource::Ideal => FlightComputer::new(sensors, mission),
        SensorSource::Chips => {
            let onboard =
                Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS).map_err(ReplayError::from)?;
            FlightComputer::on_board(sensors, mission, onboard)
        }
    })
}

fn one_ulp_off(mut input: TickInput) -> TickInput {
    input.baro = input.baro.map(|reading| match reading {
        BaroReading::PressurePa(pressure_pa) => BaroReading::PressurePa(pressure_pa.next_up()),
        BaroReading::AltitudeM(altitude_m) => BaroReading::AltitudeM(altitude_m.next_up()),
    });
    input
}
