//! The strapdown vertical channel: climb rate and altitude from an accelerometer and a gyro.
//!
//! Frames: body forward-right-down, specific force in m/s^2, rates in rad/s; altitude and climb rate positive
//! up. Flat earth, standard gravity: the omitted terms (gravity's gradient, Eotvos) are effects of the
//! catalogue, and a constant error of gravity counts as a bias of the accelerometer.
//!
//! # Captive flight
//! [`VerticalChannel::inertial`] levels the channel and finds the gyro's bias: from the velocities of
//! [`VerticalChannel::velocity`] if there are any (`velocity_match`), otherwise from specific force alone
//! (`levelling`), which mistakes the phugoid and gusts for tilts. [`VerticalChannel::reference`] ties
//! altitude and climb rate to the reference and finds the accelerometer's bias along the vertical (`tie`: a
//! Kalman filter, so that fixes after gaps and in bursts have the right weight). The levelling is a
//! least-squares fit over a window (`memory`). The vertical channel itself does not need a heading.
//!
//! The altitude is published while the tie's climb rate is known to 1 m/s, so a long outage of the receiver
//! ends it.
//!
//! A unit that has shown noise and then repeats itself on all axes for longer than [`Config::longest_gap_s`]
//! has stopped: there is no altitude meanwhile, and the alignment starts again when the readings change. A
//! unit that never had noise is an ideal one at rest, unless velocities contradict that.
//!
//! [`VerticalChannel::hold`] stops the alignment while a launch is suspected;
//! [`VerticalChannel::resume_captive`] continues it.
//!
//! # Free flight
//! After [`VerticalChannel::launch`] only the inertial samples move the channel. Its errors then grow as in
//! theory (Titterton and Weston, section 12.3): a wrong climb rate with t, a wrong accelerometer bias with
//! t^2/2, a tilt with the double integral of horizontal acceleration, a gyro bias with that of t times it.
//!
//! A gap between inertial samples of up to [`Config::longest_gap_s`] is bridged by a straight line, counted,
//! added to the uncertainty, and mended if it has cost too much (`bridge`). After a longer gap there is no
//! altitude any more. A restart of the flight computer is also a gap ([`VerticalChannel::resume`]).
//!
//! # Method
//! Attitude: the vertical row of the direction cosine matrix, turned by the rotation vector of each interval
//! with the coning of two rates that change linearly (J. E. Bortz, "A new mathematical formulation for
//! strapdown inertial navigation", IEEE Transactions AES-7, 1971; P. G. Savage, "Strapdown Inertial
//! Navigation Integration Algorithm Design, Part 1", J. Guidance 21, 1998). Velocity and altitude: vertical
//! acceleration is taken as linear over each interval. Sums are compensated.

mod bridge;
mod kept;
mod leap;
mod levelling;
mod memory;
mod reference;
mod sum;
mod tie;
mod vector;
mod velocity_match;

use crate::guard::Guard;
use crate::input::ImuSample;
use crate::time::seconds_between;
use bridge::{BridgeCost, MENDED_BY_CLIMB_M2PS2, UNKNOWN_ALTITUDE_M2, UNKNOWN_CLIMB_M2PS2};
use leap::Step;
use levelling::Levelling;
use memory::Memory;
use sum::Sum;
use tie::Tie;
use vector::{Down, Vector, cross, difference, dot, scaled, sum};
use velocity_match::VelocityMatch;

pub use crate::atmosphere::STANDARD_GRAVITY_MPS2 as GRAVITY_MPS2;
pub use kept::KeptChannel;

/// Readings beyond these are invalid: with this limit every sum below stays finite for hours.
const MAXIMUM_FORCE_MPS2: f32 = 1_000.0;
const MAXIMUM_RATE_RADPS: f32 = 100.0;
const MAXIMUM_ALTITUDE_M: f32 = 100_000.0;
const MAXIMUM_SPEED_MPS: f32 = 1_000.0;
/// Time of levelling on specific force before velocities are matched, seconds. It doubles each time that
/// velocities soon contradict the level, up to the levelling's window. Otherwise a receiver with worse
/// velocities than assumed would prevent the alignment for ever.
const COARSE_LEVEL_S: f32 = 5.0;
const CONTRADICTIONS: u8 = 5;
/// Variance of the lacking acceleration after a disturbance of the level, (m/s^2)^2: from a tilt of 0.1 rad.
const DISTURBED_M2PS4: f32 = 2.5e-3;
/// Number and duration (seconds) of outliers after which they are right: a receiver's faulty jump ends
/// sooner, and two outliers may lie on both sides of an outage.
const OUTLIERS: u8 = 5;
const LONGEST_OUTLIER_S: f32 = 10.0;
/// Variance of the climb rate above which the altitude is not aligned, (m/s)^2: 1.6 m/s, the cost of a gap of
/// 1.1 s. After 20 s of fixes it is 0.2 m/s; an outage of the receiver raises it to this limit in two
/// minutes.
const ALIGNED_M2PS2: f32 = 2.5;
/// Longest time between two samples that is not a gap, seconds: less than 50 samples a second cannot follow
/// an aircraft.
const LONGEST_INTERVAL_S: f32 = 0.03;
/// Longest gap without [`Guard::InertialBridge`], seconds.
const UNGUARDED_GAP_S: f32 = 0.1;
/// Longest time that the tie's covariance is propagated in one step, seconds.
const LONGEST_PASS_S: f32 = 1.5;
/// Largest turn between two samples, rad: beyond it two rates no longer describe the motion, and the series
/// end.
const LONGEST_ANGLE_RAD: f32 = 1.0;

/// Windows and limits of the alignment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Window of the levelling, seconds: long compared with the phugoid, short compared with the wander of a
    /// gyro's bias.
    pub level_window_s: f32,
    /// Window of the tie to the reference, seconds.
    pub anchor_window_s: f32,
    /// Least time of alignment before the channel gives an altitude, seconds. The present tie must cover half
    /// of it. The level on specific force must cover all of it, unless a match with velocities has lasted.
    pub minimum_s: f32,
    /// Longest time between two inertial samples that is bridged by a straight line, seconds.
    pub longest_gap_s: f32,
    /// Turn rate, smoothed over 1 s, above which flight is not trimmed, rad/s. It must be well above the
    /// gyro's bias and the gusts' rates, or the mean is one-sided. A slower turn is taken for straight
    /// flight: at V m/s its bank, and therefore the tilt, is V/g times its rate.
    pub turn_limit_radps: f32,
    /// Square of the load factor less 1, smoothed in the same way, beyond which flight is not trimmed.
    pub load_limit: f32,
}

impl Config {
    /// For a MEMS unit: a gyro's bias of 0.5 deg/s is 0.009 rad/s. These are bridged: a transient of a
    /// second, the reset after it (0.105 s) and the largest age of the newest snapshot at a restart (0.1 s).
    pub const MEMS: Self = Self {
        level_window_s: 120.0,
        anchor_window_s: 60.0,
        minimum_s: 20.0,
        longest_gap_s: 1.3,
        turn_limit_radps: 0.03,
        load_limit: 0.05,
    };
}

/// Why a sample was refused. The channel is unchanged, unless it was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrapdownError {
    /// A sample is NaN or infinite.
    NotFinite,
    /// A sample is beyond the range of any unit of this class (100 g, 100 rad/s) or of any aircraft (100 km).
    Implausible,
    /// Time has not increased.
    OutOfOrder,
    /// A change since the last sample that no aircraft makes, for at most a second; or a turn of more than a
    /// radian between the two.
    Spike,
    /// More than the longest gap lies between two samples: in captive flight the alignment starts again; in
    /// free flight the channel has lost its altitude for good.
    Gap,
    /// In free flight there is no reference, unless a gap is being mended.
    Launched,
    /// The altitude differs from the channel's by more than its uncertainty explains. After ten seconds of
    /// such fixes alone, or after the duration of the tie if that is shorter, the tie starts again.
    Outlier,
    /// There is no inertial sample yet that shows the direction of down.
    NoVertical,
    /// The channel was lost in a gap.
    Lost,
}

/// Counters of the channel. All saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Inertial samples taken.
    pub samples: u32,
    /// Of those, captive ones that were excluded from the levelling: the flight was not trimmed.
    pub untrimmed: u32,
    /// Samples refused.
    pub refused: u32,
    /// Gaps between samples that were bridged.
    pub bridged: u32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Captive,
    /// With the accelerometer's bias as found before launch, body axes, m/s^2.
    Free {
        accel_bias: Vector,
        aligned: bool,
    },
    Lost,
}

/// The part of the last sample that the next interval needs.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Last {
    time_us: u64,
    force: Vector,
    rate: Vector,
    acceleration_mps2: f32,
}

/// The channel.
#[derive(Clone, Debug, PartialEq)]
pub struct VerticalChannel {
    config: Config,
    phase: Phase,
    down: Option<Down>,
    levelling: Levelling,
    /// Until launch, once there are velocities.
    matching: Option<VelocityMatch>,
    /// Successive matches that were soon contradicted.
    contradictions: u8,
    is_launched: bool,
    last: Option<Last>,
    /// Time covered by fixes since the tie began.
    anchor: Memory,
    /// Duration of the alignment's ties before this one, seconds.
    anchor_before_s: f32,
    /// Time of the last fix taken.
    anchor_time_us: u64,
    tie: Tie,
    /// Time to which the tie's covariance is propagated.
    tie_time_us: u64,
    /// Variance of the climb rate from bridged gaps that has not been mended, (m/s)^2.
    bridged_m2ps2: f32,
    /// In free flight: fixes are taken to mend a gap.
    is_mending: bool,
    /// When a climb rate last mended it, or mending began, microseconds.
    climb_fix_us: Option<u64>,
    /// Variance of the altitude when mending began, m^2: free flight's own drift.
    drifted_m2: f32,
    /// How much longer the next gap may be than the clock shows, seconds.
    unknown_s: f32,
    /// By [`Self::resume`]: of the levelling only the result is known.
    is_resumed: bool,
    /// Samples refused in a row because they leapt.
    spikes: u8,
    /// The first of them leapt in captive flight: what was no movement of a carrier does not become one of
    /// the vehicle at the release.
    is_captive_leap: bool,
    /// How long the samples have been the same on all axes, seconds. A unit has noise: while it repeats
    /// itself it gives no more information than a gap, and costs as much once the readings change. After
    /// longer than the longest gap it has stopped, or is an ideal one at rest.
    repeated_s: f32,
    /// It is not an ideal unit: three samples in a row have differed, or velocities have contradicted that it
    /// is at rest.
    has_noise: bool,
    /// In captive flight the altitude depends on the last fix taken only, and the next one may contradict it.
    is_unconfirmed: bool,
    /// Time of the first outlier since the last fix taken, and the number of outliers.
    outlying: Option<(u64, u8)>,
    altitude: Sum,
    climb_rate: Sum,
    /// Lacking acceleration: upward acceleration missing from the accelerometer, found with the reference,
    /// m/s^2.
    lacking_mps2: Sum,
    counts: Counts,
}

impl VerticalChannel {
    /// A channel without any knowledge yet, in captive flight.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            config,
            phase: Phase::Captive,
            down: None,
            levelling: Levelling::default(),
            matching: None,
            contradictions: 0,
            is_launched: false,
            last: None,
            anchor: Memory::default(),
            anchor_before_s: 0.0,
            anchor_time_us: 0,
            tie: Tie::START,
            tie_time_us: 0,
            bridged_m2ps2: 0.0,
            is_mending: false,
            climb_fix_us: None,
            drifted_m2: 0.0,
            unknown_s: 0.0,
            is_resumed: false,
            spikes: 0,
            is_captive_leap: false,
            repeated_s: 0.0,
            has_noise: false,
            is_unconfirmed: false,
            outlying: None,
            altitude: Sum::default(),
            climb_rate: Sum::default(),
            lacking_mps2: Sum::default(),
            counts: Counts::default(),
        }
    }

    /// Takes an inertial sample: specific force (m/s^2) and rate (rad/s), body axes.
    ///
    /// # Errors
    /// [`StrapdownError`]; the sample is then counted as refused.
    pub fn inertial(&mut self, time_us: u64, sample: &ImuSample) -> Result<(), StrapdownError> {
        let outcome = self.advance(time_us, sample);
        match outcome {
            Ok(()) => self.counts.samples = self.counts.samples.saturating_add(1),
            Err(error) => {
                match error {
                    StrapdownError::Gap => self.lose(),
                    StrapdownError::Spike => self.spikes = self.spikes.saturating_add(1),
                    _ => {}
                }
                self.counts.refused = self.counts.refused.saturating_add(1);
            }
        }
        outcome
    }

    /// Takes a horizontal velocity of the reference in captive flight, north and east, m/s. One a second is
    /// used.
    ///
    /// # Errors
    /// [`StrapdownError::Launched`], [`StrapdownError::NotFinite`], [`StrapdownError::Implausible`],
    /// [`StrapdownError::NoVertical`]; nothing has changed then.
    pub fn velocity(&mut self, time_us: u64, velocity_mps: [f32; 2]) -> Result<(), StrapdownError> {
        if self.phase != Phase::Captive {
            return Err(StrapdownError::Launched);
        }
        if !velocity_mps.iter().all(|part| part.is_finite()) {
            return Err(StrapdownError::NotFinite);
        }
        if velocity_mps.iter().any(|part| part.abs() > MAXIMUM_SPEED_MPS) {
            return Err(StrapdownError::Implausible);
        }
        let Some(down) = &self.down else { return Err(StrapdownError::NoVertical) };
        let is_coarse = self.levelling.elapsed_s() < self.unmatched_s();
        match &mut self.matching {
            Some(matching) if !matching.is_void(time_us) => matching.reference(time_us, velocity_mps, down),
            // The match is linear: it needs a level to some hundredths of a radian.
            _ if is_coarse => {}
            matching => VelocityMatch::begin(matching, time_us, velocity_mps, down),
        }
        Ok(())
    }

    /// Time of levelling on specific force before velocities are matched, seconds.
    fn unmatched_s(&self) -> f32 {
        let unmatched_s = COARSE_LEVEL_S * f32::from(1_u8 << self.contradictions.min(CONTRADICTIONS));
        unmatched_s.min(self.config.level_window_s)
    }

    /// From now on only inertial samples move the channel. Calling it again changes nothing.
    pub fn launch(&mut self) {
        self.hold();
        self.matching = None;
        self.is_launched = true;
    }

    /// As [`Self::launch`], but provisional: until that is called or [`Self::resume_captive`].
    pub fn hold(&mut self) {
        if self.phase == Phase::Captive {
            if let Some(matching) = &mut self.matching {
                matching.hold();
            }
            // Upward is minus down: an upward lack is a bias that points down in body axes.
            let lacking = self.lacking_mps2.value();
            let down = self.down.map_or([0.0; 3], |down| down.get());
            let accel_bias = down.map(|part| part * lacking);
            self.phase = Phase::Free { accel_bias, aligned: self.is_aligned() };
            // A gap that the reference had no time to mend in captive flight is mended now.
            self.is_mending = self.bridged_m2ps2 > MENDED_BY_CLIMB_M2PS2;
            self.drifted_m2 = self.tie.altitude_m2();
            self.climb_fix_us = self.is_mending.then_some(self.tie_time_us);
            self.is_captive_leap = self.spikes > 0;
        }
    }

    /// Withdraws a hold: the alignment continues, or starts again if the channel was lost meanwhile. No
    /// effect after [`Self::launch`].
    pub fn resume_captive(&mut self) {
        match self.phase {
            Phase::Free { .. } if !self.is_launched && !self.is_resumed => self.phase = Phase::Captive,
            Phase::Free { .. } | Phase::Lost if !self.is_launched => {
                *self = Self { counts: self.counts, ..Self::new(self.config) }
            }
            Phase::Captive | Phase::Free { .. } | Phase::Lost => {}
        }
    }

    /// Adds the cost of a straight line over a gap to the uncertainties: `gap_s` seconds by the clock, and
    /// possibly `unknown_s` more.
    fn bridge(&mut self, gap_s: f32, unknown_s: f32) {
        self.counts.bridged = self.counts.bridged.saturating_add(1);
        let cost = BridgeCost::of(gap_s + unknown_s);
        let climbed_m = self.climb_rate.value() * unknown_s;
        self.bridged_m2ps2 += cost.climb_m2ps2;
        if self.bridged_m2ps2 > MENDED_BY_CLIMB_M2PS2 && matches!(self.phase, Phase::Free { .. }) {
            if !self.is_mending {
                self.drifted_m2 = self.tie.altitude_m2();
            }
            self.is_mending = true;
            // Wait for the first climb rate after it, if there are any.
            self.climb_fix_us = Some(self.tie_time_us);
        }
        self.tie.add(climbed_m * climbed_m, cost.climb_m2ps2, cost.tilt_rad2);
        if let Some(matching) = &mut self.matching {
            matching.bridge(cost.climb_m2ps2, cost.tilt_rad2);
        }
    }

    /// Whether the unit has noise but repeats itself for longer than may be bridged.
    fn stands_still(&self) -> bool {
        self.has_noise && self.repeated_s > self.config.longest_gap_s
    }

    /// Velocities have contradicted the level. If the match had agreed with them before, something brief
    /// moved it: wrong samples, or wrong fixes. The level is then off by no more than a match can start from,
    /// so the next fix starts another one. If velocities contradict it at once, or twice before a match has
    /// lasted, the match has turned their errors into a gyro bias, and the level is unknown: false.
    #[cold]
    #[inline(never)]
    fn keeps_level(&mut self, has_agreed: bool, has_lasted: bool) -> bool {
        let is_brief = has_lasted || has_agreed && self.contradictions == 0;
        self.contradictions = if has_lasted { 0 } else { (self.contradictions + 1).min(CONTRADICTIONS) };
        if is_brief {
            // The lacking acceleration is not known any better than that.
            self.tie.add(0.0, 0.0, DISTURBED_M2PS4);
        } else {
            self.levelling = Levelling::default();
        }
        is_brief
    }

    fn lose(&mut self) {
        match self.phase {
            Phase::Captive => {
                let (counts, has_noise) = (self.counts, self.has_noise);
                *self = Self { counts, has_noise, ..Self::new(self.config) };
            }
            Phase::Free { .. } | Phase::Lost => self.phase = Phase::Lost,
        }
    }

    /// Takes the whole sample, or changes nothing.
    fn advance(&mut self, time_us: u64, sample: &ImuSample) -> Result<(), StrapdownError> {
        let ImuSample { accel_mps2: force, gyro_radps } = *sample;
        if !force.iter().chain(&gyro_radps).all(|part| part.is_finite()) {
            return Err(StrapdownError::NotFinite);
        }
        if force.iter().any(|part| part.abs() > MAXIMUM_FORCE_MPS2)
            || gyro_radps.iter().any(|part| part.abs() > MAXIMUM_RATE_RADPS)
        {
            return Err(StrapdownError::Implausible);
        }
        if self.phase == Phase::Lost {
            return Err(StrapdownError::Lost);
        }
        let Some(last) = self.last else {
            let down = Down::from_specific_force(force, GRAVITY_MPS2).ok_or(StrapdownError::NoVertical)?;
            self.down = Some(down);
            self.last = Some(Last { time_us, force, rate: gyro_radps, acceleration_mps2: 0.0 });
            return Ok(());
        };
        let Some(mut down) = self.down else { return Err(StrapdownError::NoVertical) };
        if time_us <= last.time_us {
            return Err(StrapdownError::OutOfOrder);
        }
        let step_s = seconds_between(last.time_us, time_us);
        let longest_gap_s =
            if Guard::InertialBridge.stands() { self.config.longest_gap_s } else { UNGUARDED_GAP_S };
        if step_s > longest_gap_s {
            return Err(StrapdownError::Gap);
        }
        let is_captive = self.phase == Phase::Captive;
        let repeats = force == last.force && gyro_radps == last.rate;
        // It is unknown what the vehicle did while the unit stood still: neither level nor altitude can be
        // relied on.
        let is_doubted = || self.matching.as_ref().is_some_and(VelocityMatch::is_doubted);
        if is_captive && !repeats && self.repeated_s > longest_gap_s && (self.has_noise || is_doubted()) {
            return Err(StrapdownError::Gap);
        }
        let step = leap::follow(
            [force, gyro_radps],
            [last.force, last.rate],
            &down,
            is_captive || self.is_captive_leap,
            self.spikes,
        );
        if Guard::PlausibleReading.stands() && step == Step::Leap {
            return Err(StrapdownError::Spike);
        }
        let bias = self.levelling.gyro_bias_radps();
        // A wrong sample must not be used for bridging.
        let last_rate = if step == Step::Back { gyro_radps } else { last.rate };
        let (before, after) = (difference(last_rate, bias), difference(gyro_radps, bias));
        // The body turns by this angle, so down turns against it.
        let coning = cross(before, after);
        let angle = scaled(sum(scaled(sum(before, after), 0.5), scaled(coning, step_s / 12.0)), -step_s);
        if dot(angle, angle) > LONGEST_ANGLE_RAD * LONGEST_ANGLE_RAD {
            // The next one may turn less: a wild sample must not end what a gap would not end.
            return Err(StrapdownError::Spike);
        }
        down.rotate(angle);
        if is_captive && self.matching.as_ref().is_some_and(|matching| matching.is_void(time_us)) {
            if let Some(matching) = self.matching.as_ref().filter(|matching| matching.is_contradicted()) {
                let (has_agreed, has_lasted) = (matching.has_agreed(), matching.has_lasted());
                self.has_noise |= self.repeated_s > longest_gap_s;
                if !self.keeps_level(has_agreed, has_lasted) {
                    // A fit that begins with a level far off would turn the error into a gyro bias.
                    down = Down::from_specific_force(force, GRAVITY_MPS2).unwrap_or(down);
                }
            }
            self.matching = None;
        }
        if let Some(matching) = &mut self.matching {
            matching.take(&mut down, &mut self.levelling.gyro_bias, force, angle, step_s);
            if is_captive {
                self.levelling.pass(step_s, &self.config);
            }
        } else if is_captive && !self.levelling.take(&mut down, force, gyro_radps, step_s, &self.config) {
            self.counts.untrimmed = self.counts.untrimmed.saturating_add(1);
            if self.levelling.is_stuck() {
                let repeated_s = self.repeated_s;
                self.lose();
                self.repeated_s = repeated_s;
                return Ok(());
            }
        }
        let vertical = down.get();
        let lacking = match self.phase {
            Phase::Free { accel_bias, .. } => dot(vertical, accel_bias),
            Phase::Captive | Phase::Lost => self.lacking_mps2.value(),
        };
        let acceleration = lacking - dot(vertical, force) - GRAVITY_MPS2;
        let previous = if step == Step::Back { acceleration } else { last.acceleration_mps2 };
        let climb_rate = self.climb_rate.value();
        self.altitude.add(step_s * (climb_rate + step_s / 6.0 * (2.0 * previous + acceleration)));
        self.climb_rate.add(0.5 * step_s * (previous + acceleration));
        self.spikes = 0;
        self.is_captive_leap = false;
        if seconds_between(self.tie_time_us, time_us) > LONGEST_PASS_S {
            self.pass_tie(time_us);
        }
        let unknown_s = core::mem::take(&mut self.unknown_s);
        let repeated_s = if repeats {
            self.repeated_s += step_s;
            0.0
        } else {
            self.has_noise = self.has_noise || self.repeated_s == 0.0;
            core::mem::take(&mut self.repeated_s)
        };
        let gap_s = if repeated_s > longest_gap_s { step_s } else { step_s.max(repeated_s) };
        if gap_s > LONGEST_INTERVAL_S || unknown_s > 0.0 {
            self.pass_tie(time_us);
            self.bridge(gap_s, unknown_s);
        }
        self.down = Some(down);
        self.last = Some(Last { time_us, force, rate: gyro_radps, acceleration_mps2: acceleration });
        Ok(())
    }

    /// Whether the level is known: the fit on specific force covers the minimum time, or a match with
    /// velocities has lasted, which knows it sooner.
    fn is_level(&self) -> bool {
        self.levelling.elapsed_s() >= self.config.minimum_s
            || self.matching.as_ref().is_some_and(VelocityMatch::has_lasted)
    }

    /// Whether level, altitude and climb rate are known. What disturbs the first half of the minimum time,
    /// untrimmed flight or a receiver that jumps, does not delay it: by the end of that time the errors are
    /// those of an undisturbed alignment. The variance of the climb rate judges the tie.
    #[must_use]
    #[inline(never)]
    pub fn is_aligned(&self) -> bool {
        match self.phase {
            Phase::Captive => {
                !self.is_unconfirmed
                    && !self.stands_still()
                    && self.anchor_before_s + self.anchor.elapsed_s() >= self.config.minimum_s
                    && self.is_level()
                    && self.anchor.elapsed_s() >= 0.5 * self.config.minimum_s
                    && (self.tie.climb_m2ps2() <= ALIGNED_M2PS2 || !Guard::TieKnowsGaps.stands())
            }
            Phase::Free { aligned, .. } => {
                aligned
                    && (!self.is_mending
                        || self.tie.climb_m2ps2() <= UNKNOWN_CLIMB_M2PS2
                            && self.tie.altitude_m2() - self.drifted_m2 <= UNKNOWN_ALTITUDE_M2)
            }
            Phase::Lost => false,
        }
    }

    /// Altitude above the reference's datum, metres; `None` until aligned, and once lost.
    #[must_use]
    pub fn altitude_m(&self) -> Option<f32> {
        self.is_aligned().then(|| self.altitude.value())
    }

    /// Climb rate, m/s; `None` when the altitude is.
    #[must_use]
    pub fn climb_rate_mps(&self) -> Option<f32> {
        self.is_aligned().then(|| self.climb_rate.value())
    }

    /// Variance of the altitude against the reference's, m^2; it grows in free flight.
    #[must_use]
    pub fn altitude_variance_m2(&self) -> f32 {
        self.tie.altitude_m2()
    }

    /// The unit vector that points down, body axes: (-sin pitch, sin roll cos pitch, cos roll cos pitch).
    #[must_use]
    pub fn down_body(&self) -> Option<[f32; 3]> {
        self.down.map(|down| down.get())
    }

    /// The gyro's bias by the levelling, body axes, rad/s.
    #[must_use]
    pub fn gyro_bias_radps(&self) -> [f32; 3] {
        self.levelling.gyro_bias_radps()
    }

    /// Lacking acceleration: upward acceleration missing from the accelerometer by the reference, m/s^2.
    #[must_use]
    pub const fn lacking_acceleration_mps2(&self) -> f32 {
        self.lacking_mps2.value()
    }

    /// Counters of the channel.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.counts
    }
}

#[cfg(test)]
mod tests;
