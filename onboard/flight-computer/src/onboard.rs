//! Derives from the sensors, before the mission, whether the vehicle has left, and the altitude of its own
//! inertial unit.

use kf_core::estimator::ConfigError;
use kf_core::input::{LaunchDoubt, TickInput};
use kf_core::launch::{CaptiveForce, LaunchConfig, LaunchDetector, LaunchInput};
use kf_core::navigation::{InertialAltitude, KeptInertial};
use kf_core::strapdown;

/// See the module.
#[derive(Clone, Debug)]
pub struct Onboard {
    launch: LaunchDetector,
    /// `None` if a restart has lost the alignment: in free flight there is nothing to align with.
    inertial: Option<InertialAltitude>,
    last_message_us: Option<u64>,
    /// Whether a launch was decided before a restart.
    has_left: bool,
}

impl Onboard {
    /// Attached to the pylon, without any data yet.
    ///
    /// # Errors
    /// [`ConfigError`]: the launch's limits are invalid.
    pub fn new(launch: LaunchConfig, strapdown: strapdown::Config) -> Result<Self, ConfigError> {
        Ok(Self {
            launch: LaunchDetector::new(launch)?,
            inertial: Some(InertialAltitude::new(strapdown)),
            last_message_us: None,
            has_left: false,
        })
    }

    /// After a restart in free flight: the vehicle has left, whatever the wire and the force show. The
    /// inertial altitude continues from its kept state; without that it stops, and `imu_slave` has no
    /// readings.
    pub fn resume_in_free_flight(&mut self, kept: Option<&KeptInertial>, unknown_s: f32) {
        self.has_left = true;
        if !self.resume_inertial(kept, unknown_s) {
            self.inertial = None;
        }
    }

    /// After a restart while a launch is suspected: the calibration is held, and so is the inertial altitude.
    /// `force`: the last [`LaunchDetector::captive_force`], if there was one.
    pub fn resume_suspected(
        &mut self,
        kept: Option<&KeptInertial>,
        unknown_s: f32,
        force: Option<CaptiveForce>,
    ) {
        self.launch.resume_suspected(force);
        // Without a kept state the alignment begins again: the vehicle may still be captive.
        let _ = self.resume_inertial(kept, unknown_s);
    }

    #[inline(never)]
    fn resume_inertial(&mut self, kept: Option<&KeptInertial>, unknown_s: f32) -> bool {
        let (Some(inertial), Some(kept)) = (&mut self.inertial, kept) else { return false };
        inertial.resume(kept, unknown_s)
    }

    /// After a restart that was, as far as is known, under the pylon; `is_wire_broken`: an open wire was
    /// known to be broken, and means nothing.
    pub fn resume_captive(&mut self, is_wire_broken: bool) {
        if is_wire_broken {
            self.launch.call_wire_broken();
        } else {
            self.launch.resume_captive();
        }
    }

    /// After a cold start that has found traces of a mission.
    pub fn note_traces(&mut self) {
        self.launch.note_traces();
    }

    /// State of the inertial altitude to keep for a restart.
    #[must_use]
    pub fn kept(&self) -> Option<KeptInertial> {
        self.inertial.as_ref()?.kept()
    }

    /// The launch decision, and its counts.
    #[must_use]
    pub const fn launch(&self) -> &LaunchDetector {
        &self.launch
    }

    /// The strapdown channel's altitude, and its counts; `None` once the alignment was lost.
    #[must_use]
    pub const fn inertial(&self) -> Option<&InertialAltitude> {
        self.inertial.as_ref()
    }

    /// Takes a tick's sensor values and the state of the umbilical's wire (open: true; `None`: it could not
    /// be read), and adds what the mission needs.
    pub fn complete(&mut self, input: &mut TickInput, wire_is_open: Option<bool>) {
        if input.imu_master_altitude_m.is_some() {
            self.last_message_us = Some(input.time_us);
        }
        let state = self.launch.tick(&LaunchInput {
            time_us: input.time_us,
            is_open: wire_is_open,
            force_mps2: input.imu.map(|imu| imu.accel_mps2),
            last_message_us: self.last_message_us,
            climb_mps: input.gps.and_then(|fix| fix.velocity_down_mps).map(|down_mps| -down_mps),
            ground_speed_squared_m2ps2: input.gps.and_then(|fix| {
                let (north_mps, east_mps) = (fix.velocity_north_mps?, fix.velocity_east_mps?);
                Some(north_mps * north_mps + east_mps * east_mps)
            }),
        });
        input.launch = self.has_left || state.is_launched();
        input.launch_doubt = if self.has_left { LaunchDoubt::None } else { state.doubt() };
        if let Some(inertial) = &mut self.inertial {
            inertial.tick(input);
        }
    }
}

#[cfg(test)]
mod tests {
    use kf_core::input::ImuSample;

    use super::*;

    fn onboard() -> Onboard {
        Onboard::new(LaunchConfig::DEFAULT, strapdown::Config::MEMS).unwrap()
    }

    /// A tick under the pylon, or with a specific force of 2 m/s^2 instead of 9.8 after leaving it.
    fn input(tick: u64, is_free: bool) -> TickInput {
        // Noise of the unit, so that the force is not constant.
        let noise = if tick.is_multiple_of(2) { 0.05 } else { -0.05 };
        let lift_mps2 = if is_free { 2.0 } else { 9.8 };
        TickInput {
            time_us: 1_000_000 + tick * 5_000,
            imu: Some(ImuSample { accel_mps2: [0.0, 0.0, noise - lift_mps2], gyro_radps: [0.0; 3] }),
            imu_master_altitude_m: (!is_free && tick.is_multiple_of(20)).then_some(2_000.0),
            ..TickInput::default()
        }
    }

    #[test]
    fn a_wire_that_opens_is_doubted_at_once_and_a_launch_when_the_force_goes_with_it() {
        let mut onboard = onboard();
        let mut first_doubt = None;
        let mut launched = None;
        for tick in 0..4_400 {
            let is_free = tick >= 4_000;
            let mut input = input(tick, is_free);
            onboard.complete(&mut input, Some(is_free));
            if input.launch_doubt == LaunchDoubt::Suspected {
                first_doubt.get_or_insert(tick);
            }
            if input.launch {
                launched.get_or_insert(tick);
            }
        }
        assert_eq!(first_doubt, Some(4_000));
        // Silent for five intervals of 0.1 s and no less: until then her messages could have shown a broken
        // wire.
        assert!(launched.is_some_and(|tick| (4_080..4_110).contains(&tick)), "{launched:?}");
    }

    #[test]
    fn a_wire_that_breaks_under_the_pylon_is_no_launch() {
        let mut onboard = onboard();
        for tick in 0..6_000 {
            let mut input = input(tick, false);
            onboard.complete(&mut input, Some(tick >= 4_000));
            assert!(!input.launch, "{tick}");
        }
        assert_eq!(onboard.launch().counts().broken_wires, 1);
    }

    /// Without a calibration and with an unknown force, the same open wire is a cable torn before power-on,
    /// or a release during a reset.
    #[test]
    fn a_wire_that_is_open_at_the_start_is_a_launch_only_after_an_interruption() {
        for is_launch in [false, true] {
            let mut onboard = onboard();
            if is_launch {
                onboard.resume_captive(false);
            }
            let mut launched = false;
            for tick in 0..1_000 {
                let mut input = TickInput {
                    // The clock of an interrupted flight continues.
                    time_us: 60_000_000 + tick * 5_000,
                    imu_master_altitude_m: None,
                    ..input(tick, false)
                };
                onboard.complete(&mut input, Some(true));
                launched |= input.launch;
            }
            assert_eq!(launched, is_launch);
        }
    }

    #[test]
    fn after_a_restart_in_free_flight_there_is_no_altitude_and_it_has_left() {
        let mut onboard = onboard();
        onboard.resume_in_free_flight(None, 0.0);
        assert!(onboard.inertial().is_none());
        for tick in 0..10 {
            let mut input = input(tick, false);
            onboard.complete(&mut input, None);
            assert_eq!((input.imu_slave_altitude_m, input.launch), (None, true));
        }
        assert_eq!(onboard.launch().counts().unreadable, 10);
    }
}
