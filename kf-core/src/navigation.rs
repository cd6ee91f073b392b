//! The UAV's own altitude from its inertial samples, for when no unit delivers one.
//!
//! This runs between the sensors and the mission: [`InertialAltitude::tick`] takes a tick's input and fills
//! [`TickInput::imu_slave_altitude_m`] from the strapdown vertical channel, which it levels and ties to the
//! reference in captive flight. From the first tick of a suspected launch the channel takes no reference,
//! except to mend a gap between its samples. If the suspicion is withdrawn, it continues as before.
//!
//! A calibration uses one source only. If an altitude comes from outside before the channel is aligned, the
//! channel is never used. If the channel has delivered first, altitudes from outside are counted and ignored.
//!
//! Before launch the channel's altitude follows the reference, so its bias is zero and its spread is the
//! reference's. The calibration of this sensor therefore does not show how far it can be trusted in free
//! flight. There it drifts as described in [`crate::strapdown`].

use crate::input::{GpsFix, LaunchDoubt, TickInput};
use crate::reading::is_held;
use crate::strapdown::{Config, KeptChannel, VerticalChannel};
use serde::{Deserialize, Serialize};

/// Time between two altitudes of the channel, microseconds. Successive ones differ by the integral of the
/// same noise: a higher rate would only look like more information.
const INTERVAL_US: u64 = 50_000;

/// Square of the largest difference between the channel's climb rate and a fix's in captive flight, in
/// addition to three of its own sigmas, (m/s)^2: 3 m/s. A fix's climb rate is known to 0.2 m/s, and its delay
/// (0.2 s) costs 1 m/s in the roughest air.
const DENIED_M2PS2: f32 = 9.0;
const DENIED_SIGMAS_SQUARED: f32 = 9.0;
/// Time after which a denied channel is tied again, microseconds: whatever moved it, or the receiver, was no
/// transient of a second.
const LONGEST_DENIED_US: u64 = 2_000_000;

/// Source of the altitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AltitudeSource {
    /// No source yet.
    #[default]
    None,
    /// A separate unit.
    Outside,
    /// The strapdown channel.
    Channel,
}

/// Counters; the channel's own are [`VerticalChannel::counts`]. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NavigationCounts {
    /// Altitudes that the channel delivered.
    pub delivered: u32,
    /// Altitudes from outside that were ignored because the channel had delivered first.
    pub outside_ignored: u32,
    /// Fixes that the channel refused, for their altitude or their velocity.
    pub fixes_refused: u32,
}

/// State kept over a restart, from the first suspicion of a launch on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptInertial {
    channel: KeptChannel,
    delivered_us: Option<u64>,
    is_launched: bool,
}

/// Provides the altitude; see the module.
#[derive(Clone, Debug)]
pub struct InertialAltitude {
    channel: VerticalChannel,
    source: AltitudeSource,
    last_fix: Option<GpsFix>,
    /// When [`Self::last_fix`] came, if the channel has not taken it yet.
    due_us: Option<u64>,
    delivered_us: Option<u64>,
    is_launched: bool,
    /// Launched, or suspected to be.
    is_off: bool,
    /// The climb rates of the channel and of the last fix before the launch disagree. It is unknown which is
    /// wrong, so nothing is delivered for calibration: otherwise the altitude of a unit that reads free fall
    /// would be followed within the gates of everything that uses it. After a launch the channel delivers
    /// again: the monitor then finds whether it is right.
    is_denied: bool,
    /// Since when, microseconds.
    denied_us: u64,
    counts: NavigationCounts,
}

impl InertialAltitude {
    /// The state before the first tick.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            channel: VerticalChannel::new(config),
            source: AltitudeSource::None,
            last_fix: None,
            due_us: None,
            delivered_us: None,
            is_launched: false,
            is_off: false,
            is_denied: false,
            denied_us: 0,
            counts: NavigationCounts::default(),
        }
    }

    /// State from which a restart continues; `None` in captive flight and if there is nothing to store.
    #[must_use]
    pub fn kept(&self) -> Option<KeptInertial> {
        match self.source {
            AltitudeSource::Channel if self.is_off => Some(KeptInertial {
                channel: self.channel.kept()?,
                delivered_us: self.delivered_us,
                is_launched: self.is_launched,
            }),
            _ => None,
        }
    }

    /// Continues from the stored state, before the first tick. `unknown_s`: how much longer than the clock
    /// shows the interruption may have been, seconds. False, and nothing changes, if the stored channel is
    /// invalid.
    #[must_use]
    pub fn resume(&mut self, kept: &KeptInertial, unknown_s: f32) -> bool {
        if !self.channel.resume(&kept.channel, unknown_s) {
            return false;
        }
        self.source = AltitudeSource::Channel;
        self.delivered_us = kept.delivered_us;
        self.is_launched = kept.is_launched;
        self.is_off = true;
        true
    }

    /// Source of the altitude.
    #[must_use]
    pub const fn source(&self) -> AltitudeSource {
        self.source
    }

    /// The channel.
    #[must_use]
    pub const fn channel(&self) -> &VerticalChannel {
        &self.channel
    }

    /// The counters.
    #[must_use]
    pub const fn counts(&self) -> &NavigationCounts {
        &self.counts
    }

    /// Processes a tick before the mission does, and fills in the UAV's inertial altitude (metres, the
    /// reference's datum) if the channel is its source. Must be called for every tick, in order.
    pub fn tick(&mut self, input: &mut TickInput) {
        if self.source == AltitudeSource::None && input.imu_slave_altitude_m.is_some() {
            self.source = AltitudeSource::Outside;
        }
        if self.source == AltitudeSource::Outside {
            return;
        }
        self.take_due_fix();
        self.follow_launch(input);
        let has_sample = input.imu.is_some_and(|imu| {
            // The channel counts a refused sample.
            self.channel.inertial(input.time_us, &imu).is_ok()
        });
        if let Some(fix) = input.gps {
            self.note_fix(input.time_us, &fix);
        }
        if self.source == AltitudeSource::Channel && input.imu_slave_altitude_m.take().is_some() {
            self.counts.outside_ignored = self.counts.outside_ignored.saturating_add(1);
        }
        let is_due = self
            .delivered_us
            .is_none_or(|delivered_us| input.time_us.saturating_sub(delivered_us) >= INTERVAL_US);
        // Not at a fix's own tick: the mission compares the altitude with that fix, which the channel has not
        // taken yet.
        let may_speak = has_sample && is_due && self.due_us.is_none() && (self.is_off || !self.is_denied);
        if let (true, Some(altitude_m)) = (may_speak, self.channel.altitude_m()) {
            self.source = AltitudeSource::Channel;
            self.delivered_us = Some(input.time_us);
            self.counts.delivered = self.counts.delivered.saturating_add(1);
            input.imu_slave_altitude_m = Some(altitude_m);
        }
    }

    fn follow_launch(&mut self, input: &TickInput) {
        self.is_launched |= input.launch;
        let is_off = self.is_launched || input.launch_doubt == LaunchDoubt::Suspected;
        if self.is_launched {
            self.channel.launch();
        } else if is_off {
            self.channel.hold();
        } else if self.is_off {
            self.channel.resume_captive();
        }
        self.is_off = is_off;
    }

    /// Compares the channel's climb rate with a fix's (metres, m/s), until the launch. True if they have
    /// contradicted each other for so long that the channel is tied to the fix again.
    fn is_retied_to(&mut self, time_us: u64, altitude_m: f32, climb_mps: f32) -> bool {
        let Some((own_mps, variance_m2ps2)) = self.channel.tied_climb_rate() else { return false };
        let apart_mps = own_mps - climb_mps;
        let was_denied = self.is_denied;
        self.is_denied = apart_mps * apart_mps > DENIED_M2PS2 + DENIED_SIGMAS_SQUARED * variance_m2ps2;
        if !was_denied {
            self.denied_us = time_us;
        }
        let has_lasted = time_us.saturating_sub(self.denied_us) > LONGEST_DENIED_US;
        if !self.is_denied || self.is_off || !has_lasted {
            return false;
        }
        self.denied_us = time_us;
        self.channel.retie(time_us, altitude_m, climb_mps).is_ok()
    }

    /// Records a new fix that is not held: the reference in captive flight and while a gap is mended.
    fn note_fix(&mut self, time_us: u64, fix: &GpsFix) {
        if self.last_fix.as_ref().is_none_or(|last| !is_held(fix, last)) {
            self.last_fix = Some(*fix);
            self.due_us = Some(time_us);
        }
    }

    /// The channel takes a fix at the next tick, before any new input there, with the same result as after
    /// the fix's own tick. That tick is expensive enough without it.
    fn take_due_fix(&mut self) {
        let Some(time_us) = self.due_us.take() else { return };
        let Some(fix) = self.last_fix else { return };
        let is_retied = !self.is_launched
            && fix
                .velocity_down_mps
                .is_some_and(|down_mps| self.is_retied_to(time_us, fix.altitude_m, -down_mps));
        if self.is_off && !self.channel.is_mending() {
            return;
        }
        let mut is_taken = is_retied || self.channel.reference(time_us, fix.altitude_m).is_ok();
        // Once its altitude has mended the gap, its climb rate is not needed.
        if let (true, true, Some(down_mps)) = (self.is_off, self.channel.is_mending(), fix.velocity_down_mps)
        {
            is_taken &= self.channel.climb_rate_fix(time_us, -down_mps).is_ok();
        }
        if let (Some(north), Some(east), false) = (fix.velocity_north_mps, fix.velocity_east_mps, self.is_off)
        {
            is_taken &= self.channel.velocity(time_us, [north, east]).is_ok();
        }
        if !is_taken {
            self.counts.fixes_refused = self.counts.fixes_refused.saturating_add(1);
        }
    }
}

#[cfg(test)]
mod tests;
