//! Free flight: monitoring of the latched sensors (section 4 of the paper).

use serde::{Deserialize, Serialize};

use crate::config::{MissionConfig, SecondCorrection};
use crate::latch::{LatchRecord, SensorLatch};
use crate::monitor::{KeptMonitor, Monitor, longest_step_us};
use crate::moving_average::{KeptAverage, MovingAverage};
use crate::output::Trust;
use crate::reference_check::{Play, ReferenceCheck, Standing};
use crate::sensor::Sensor;
use crate::time::{microseconds, seconds_between};
use crate::ud::{NoiseVariance, Row, UdFilter};

/// Error of one sensor after this tick's reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WatchedError {
    /// Error of eq. 16 less the second correction, metres.
    pub error_m: f32,
    /// Its moving average, metres; `None` if the error was not judged because the reference may have caused
    /// it.
    pub moving_average_m: Option<f32>,
}

/// The second correction of one sensor.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to box the window on")]
enum Correction {
    Off,
    MovingAverage { average: MovingAverage, value_m: f32 },
    Kalman { filter: UdFilter<0, 1>, noise: NoiseVariance, wander_m2_per_s: f32, last_us: u64 },
}

impl Correction {
    /// The state before launch.
    fn new(kind: &SecondCorrection, window_us: u64) -> Self {
        match kind {
            SecondCorrection::Off | SecondCorrection::Kalman { .. } => Self::Off,
            SecondCorrection::MovingAverage => {
                Self::MovingAverage { average: MovingAverage::new(window_us), value_m: 0.0 }
            }
        }
    }

    /// Starts the correction at launch.
    #[inline(never)]
    fn begin(&mut self, kind: &SecondCorrection, latched: &SensorLatch, time_us: u64) {
        match (self, kind) {
            (Self::MovingAverage { average, value_m }, _) => {
                average.restart();
                *value_m = 0.0;
            }
            (correction, &SecondCorrection::Kalman { wander_m_per_sqrt_s }) => {
                let noise = NoiseVariance::new(latched.residual_variance_m2);
                let filter = UdFilter::new([], [], [0.0], [latched.bias_variance_m2]);
                *correction = match (noise, filter) {
                    (Ok(noise), Ok(filter)) => Self::Kalman {
                        filter,
                        noise,
                        wander_m2_per_s: wander_m_per_sqrt_s * wander_m_per_sqrt_s,
                        last_us: time_us,
                    },
                    // A residual without spread gives the filter no measurement noise: no correction.
                    _ => Self::Off,
                };
            }
            _ => {}
        }
    }

    /// Correction to subtract from the next reading, metres.
    fn value_m(&self) -> f32 {
        match self {
            Self::Off => 0.0,
            Self::MovingAverage { value_m, .. } => *value_m,
            Self::Kalman { filter, .. } => filter.tail()[0],
        }
    }

    /// Updates the correction with the uncorrected error.
    fn learn(&mut self, time_us: u64, error_m: f32) {
        match self {
            Self::Off => {}
            Self::MovingAverage { average, value_m } => *value_m = average.add(time_us, error_m),
            Self::Kalman { filter, noise, wander_m2_per_s, last_us } => {
                let variance = *wander_m2_per_s * seconds_between(*last_us, time_us);
                *last_us = time_us;
                let row = Row { head: None, tail: [1.0], first: 0 };
                // A refused step leaves the filter, and therefore the correction, unchanged.
                if filter.add_tail_noise(0, variance).is_ok() && filter.update(&row, error_m, *noise).is_ok()
                {
                    filter.fold();
                }
            }
        }
    }
}

/// State of a second correction that cannot be recovered from configuration and latch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(clippy::large_enum_variant, reason = "there is no heap to box the window on")]
enum KeptCorrection {
    Off,
    MovingAverage(KeptAverage),
    Kalman { state_m: f32, pending_m: f32, variance_m2: f32, last_us: u64 },
}

impl Correction {
    fn kept(&self) -> KeptCorrection {
        match self {
            Self::Off => KeptCorrection::Off,
            Self::MovingAverage { average, .. } => KeptCorrection::MovingAverage(average.kept()),
            Self::Kalman { filter, last_us, .. } => KeptCorrection::Kalman {
                state_m: filter.tail()[0],
                pending_m: filter.pending_tail()[0],
                variance_m2: filter.variance(0),
                last_us: *last_us,
            },
        }
    }

    /// False if the stored state is of another kind or is not a valid filter.
    fn restore(&mut self, kept: &KeptCorrection) -> bool {
        match (self, kept) {
            (Self::Off, KeptCorrection::Off) => true,
            (Self::MovingAverage { average, value_m }, KeptCorrection::MovingAverage(kept)) => {
                average.restore(kept);
                // Before the first sample there is no mean.
                let mean_m = average.mean();
                *value_m = if mean_m.is_nan() { 0.0 } else { mean_m };
                true
            }
            (
                Self::Kalman { filter, last_us, .. },
                KeptCorrection::Kalman { state_m, pending_m, variance_m2, last_us: kept_us },
            ) => {
                let Ok(mut kept) = UdFilter::new([], [], [*state_m], [*variance_m2]) else { return false };
                let is_restored = kept.shift_tail(0, *pending_m).is_ok();
                *filter = kept;
                *last_us = *kept_us;
                is_restored
            }
            _ => false,
        }
    }
}

/// Monitoring of one sensor.
#[derive(Clone, Debug)]
struct Watch {
    /// The sensor has an alarm limit to be monitored by.
    is_on: bool,
    monitor: Monitor,
    correction: Correction,
    /// The sensor's effects could not be continued over a restart: its error is no longer known.
    stopped: bool,
    last_error: LastError,
    /// The last reading was not judged.
    is_unjudged: bool,
}

/// The sensor's latest evidence about the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct LastError {
    /// Error of its last reading against the reference as it is now, metres.
    error_m: f32,
    time_us: u64,
}

impl Watch {
    /// Whether the sensor can be used as a witness for the reference.
    fn can_compare(&self, time_us: u64, silent_after_us: u64) -> bool {
        self.is_on
            && !self.stopped
            && self.monitor.trust() != Trust::Untrustworthy
            && time_us.saturating_sub(self.last_error.time_us) <= silent_after_us
    }

    /// Whether it supports the reference, and the receiver's alternative altitude, `other_m` away.
    fn supported(&self, other_m: f32) -> [bool; 2] {
        let error_m = self.last_error.error_m;
        [self.is_within_bound(error_m), self.is_within_bound(error_m - other_m)]
    }

    fn is_within_bound(&self, error_m: f32) -> bool {
        error_m * error_m <= self.monitor.bound_m2()
    }
}

/// State of a watch that cannot be recovered from configuration and latch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct KeptWatch {
    monitor: KeptMonitor,
    correction: KeptCorrection,
    stopped: bool,
    last_error: LastError,
}

/// State of free flight that cannot be recovered from configuration and latch. It is read part by part.
pub(crate) type KeptFreeFlight = (Standing, [Option<KeptWatch>; WATCHED.len()]);

/// The sensors that leave with the UAV. No room is kept for one that does not: a watch takes over half a
/// kilobyte.
pub(crate) const WATCHED: [Sensor; 2] = [Sensor::ImuSlave, Sensor::Baro];

const fn position(sensor: Sensor) -> Option<usize> {
    match sensor {
        Sensor::ImuMaster => None,
        Sensor::ImuSlave => Some(0),
        Sensor::Baro => Some(1),
    }
}

/// Monitoring of every sensor that leaves with the UAV. It exists from the first tick on, so that nothing of
/// its size has to be made and moved at launch.
#[derive(Clone, Debug)]
pub(crate) struct FreeFlight {
    /// One for each of [`WATCHED`].
    watches: [Watch; WATCHED.len()],
    reference: ReferenceCheck,
    silent_after_us: u64,
}

impl FreeFlight {
    /// Not started yet; must be started by [`Self::begin`].
    pub(crate) fn new<const E: usize>(config: &MissionConfig<E>) -> Self {
        let window_us = microseconds(config.monitor.window_s);
        let watch = |_| Watch {
            is_on: false,
            monitor: Monitor::new(0.0, window_us)
                .with_persistence(microseconds(config.monitor.persistence_s)),
            correction: Correction::new(&config.second_correction, window_us),
            stopped: false,
            last_error: LastError { error_m: 0.0, time_us: 0 },
            is_unjudged: false,
        };
        Self {
            watches: WATCHED.map(watch),
            reference: ReferenceCheck::new(config),
            silent_after_us: microseconds(config.reference.lost_after_s),
        }
    }

    /// Starts at a launch or a suspected launch. `reference_left_m` is the reference's departure from its
    /// mean over the calibration, metres.
    #[inline(never)]
    pub(crate) fn begin<const E: usize>(
        &mut self,
        config: &MissionConfig<E>,
        latch: &LatchRecord,
        reference_left_m: f32,
    ) {
        self.reference.launch(latch.time_us, reference_left_m);
        for (watch, sensor) in self.watches.iter_mut().zip(WATCHED) {
            let latched = latch.sensors.get(sensor.index());
            let latched = latched.filter(|latched| latched.bound_m2 > 0.0 && latched.bound_m2.is_finite());
            watch.is_on = latched.is_some();
            watch.stopped = false;
            // A reading is expected soon; until then it supports no altitude.
            watch.last_error = LastError { error_m: f32::NAN, time_us: latch.time_us };
            watch.is_unjudged = false;
            if let Some(latched) = latched {
                let longest_step_us = longest_step_us(latch.duration_s, latched.readings);
                watch.monitor.restart(latched.bound_m2, latch.time_us, longest_step_us);
                watch.correction.begin(&config.second_correction, latched, latch.time_us);
            }
        }
    }

    /// State for a snapshot.
    pub(crate) fn kept(&self) -> KeptFreeFlight {
        let kept = |watch: &Watch| {
            watch.is_on.then(|| KeptWatch {
                monitor: watch.monitor.kept(),
                correction: watch.correction.kept(),
                stopped: watch.stopped,
                last_error: watch.last_error,
            })
        };
        let [slave, baro] = &self.watches;
        (self.reference.standing(), [kept(slave), kept(baro)])
    }

    /// Restores the reference's standing from a snapshot.
    pub(crate) fn restore_standing(&mut self, standing: Standing) {
        self.reference.restore(standing);
    }

    /// Restores the watch over the sensor at a place of [`WATCHED`] from a snapshot; false if that watch does
    /// not belong to this configuration and latch.
    pub(crate) fn restore_watch(&mut self, place: usize, kept: Option<&KeptWatch>) -> bool {
        let Some(watch) = self.watches.get_mut(place) else { return false };
        match kept {
            None => !watch.is_on,
            Some(kept) if watch.is_on => {
                watch.monitor.restore(&kept.monitor);
                watch.stopped = kept.stopped;
                watch.last_error = kept.last_error;
                watch.correction.restore(&kept.correction)
            }
            Some(_) => false,
        }
    }

    /// Stops monitoring: the sensor's error is not known from now on. Flags stay.
    pub(crate) fn stop(&mut self, sensor: Sensor) {
        if let Some(watch) = self.watch_mut(sensor) {
            watch.stopped = true;
        }
    }

    /// Raises a flag that was recorded elsewhere.
    pub(crate) fn raise(&mut self, sensor: Sensor, trust: Trust) {
        if let Some(watch) = self.watch_mut(sensor) {
            watch.monitor.raise(trust);
        }
    }

    /// The flag raised for a sensor, if any.
    pub(crate) fn flag(&self, sensor: Sensor) -> Option<Trust> {
        let watch = self.watch(sensor)?;
        Some(watch.monitor.trust()).filter(|trust| *trust != Trust::Trusted)
    }

    #[inline]
    fn watch(&self, sensor: Sensor) -> Option<&Watch> {
        self.watches.get(position(sensor)?).filter(|watch| watch.is_on)
    }

    #[inline]
    fn watch_mut(&mut self, sensor: Sensor) -> Option<&mut Watch> {
        self.watches.get_mut(position(sensor)?).filter(|watch| watch.is_on)
    }

    /// Altitude that replaces the last fix, metres, at that fix's time; `None` if the fix is good.
    #[inline]
    pub(crate) const fn carried_m(&self) -> Option<f32> {
        self.reference.carried_m()
    }

    /// Takes a fix: the altitude carried forward to it, if any, and the fix's own, metres, free of effects.
    /// True if the fix is good; otherwise [`Self::carried_m`] is the reference.
    #[inline(never)]
    pub(crate) fn take_fix(&mut self, time_us: u64, carried_m: Option<f32>, altitude_m: f32) -> bool {
        if !self.reference.is_on() {
            return true;
        }
        let departure_m = carried_m.map_or(0.0, |carried_m| altitude_m - carried_m);
        let Self { watches, reference, silent_after_us } = self;
        let mut is_contradicted = false;
        let is_vouched = || {
            let (mut witnesses, mut by_carried, mut by_fix) = (0, 0, 0);
            for watch in watches.iter().filter(|watch| watch.can_compare(time_us, *silent_after_us)) {
                let [carried, fix] = watch.supported(departure_m);
                witnesses += 1;
                by_carried += i32::from(carried);
                by_fix += i32::from(fix);
            }
            is_contradicted = by_fix == 0 && by_carried > 0 && by_carried == witnesses;
            by_fix == witnesses && by_carried < witnesses
        };
        let is_good = reference.take(time_us, carried_m, departure_m, is_vouched);
        if is_good {
            self.move_reference(departure_m);
        } else if is_contradicted {
            reference.discredit();
        }
        is_good
    }

    /// Moves the reference by `by_m` metres, and the sensors' recorded errors with it.
    pub(crate) fn move_reference(&mut self, by_m: f32) {
        self.watches.iter_mut().for_each(|watch| watch.last_error.error_m -= by_m);
    }

    /// Takes the error of eq. 16 of one sensor, metres; `None` if the sensor is not watched or the error
    /// overflows. `is_current`: the reference is not carried forward by an old climb rate. After launch a
    /// vehicle manoeuvres as no carrier does, so a last climb rate that is extrapolated for some seconds
    /// proves nothing about a sensor.
    #[inline]
    pub(crate) fn take(
        &mut self,
        sensor: Sensor,
        time_us: u64,
        error_m: f32,
        is_current: bool,
    ) -> Option<WatchedError> {
        let place = position(sensor)?;
        let watch = self.watches.get(place).filter(|watch| watch.is_on && !watch.stopped)?;
        let corrected_m = error_m - watch.correction.value_m();
        if !corrected_m.is_finite() {
            return None;
        }
        let is_unjudged = self.reference.is_on()
            && (!is_current || self.may_be_the_references(place, time_us, corrected_m));
        let watch = self.watches.get_mut(place)?;
        watch.last_error = LastError { error_m: corrected_m, time_us };
        watch.is_unjudged = is_unjudged;
        if is_unjudged {
            return Some(WatchedError { error_m: corrected_m, moving_average_m: None });
        }
        watch.correction.learn(time_us, error_m);
        let moving_average_m = Some(watch.monitor.update(time_us, corrected_m));
        Some(WatchedError { error_m: corrected_m, moving_average_m })
    }

    /// Whether the reference may have caused an error, so that it does not count against the sensor. An error
    /// within the alarm limit settles a dispute about the reference. Inlined, it would be in the image once for
    /// each sensor.
    #[inline(never)]
    fn may_be_the_references(&mut self, place: usize, time_us: u64, error_m: f32) -> bool {
        let Some(own) = self.watches.get(place) else { return false };
        if own.monitor.trust() == Trust::Untrustworthy {
            return false;
        }
        if self.reference.is_lost(time_us) {
            return true;
        }
        if own.is_within_bound(error_m) {
            self.reference.settle();
            return false;
        }
        self.is_excused(place, time_us, error_m)
    }

    /// Whether an error beyond the alarm limit is excused by the reference's alternative altitude, or by the
    /// other sensor's error.
    #[inline]
    fn is_excused(&mut self, place: usize, time_us: u64, error_m: f32) -> bool {
        let (own, other) = match (&self.watches, place) {
            ([slave, baro], 0) => (slave, baro),
            ([slave, baro], _) => (baro, slave),
        };
        let other_m = self.reference.other_m();
        let by_other = own.is_within_bound(error_m - other_m);
        if !other.can_compare(time_us, self.silent_after_us) {
            return by_other || self.reference.is_disputed();
        }
        if by_other {
            match other.supported(other_m) {
                [false, true] => {
                    self.reference.discredit();
                    return true;
                }
                [true, false] if self.reference.is_witness(other.last_error.time_us) => {}
                _ => return true,
            }
        }
        let own = (error_m, own.monitor.bound_m2());
        let other = (other.last_error.error_m, other.monitor.bound_m2());
        !is_likelier_own(own, other, self.reference.play())
    }

    /// Trust in a sensor. A raised flag stays. Otherwise a sensor that is silent, or that has no credible
    /// reference, is unmonitored.
    #[inline]
    pub(crate) fn trust(&self, sensor: Sensor, time_us: u64, has_reference: bool) -> Trust {
        let Some(watch) = self.watch(sensor) else { return Trust::Unmonitored };
        let is_silent = time_us.saturating_sub(watch.last_error.time_us) > self.silent_after_us;
        match watch.monitor.trust() {
            Trust::Trusted if !has_reference || is_silent || watch.stopped || watch.is_unjudged => {
                Trust::Unmonitored
            }
            trust => trust,
        }
    }
}

/// Whether an error beyond a sensor's alarm limit is more likely the sensor's own than the reference's, given
/// the other sensor's error. For each: the error, metres, and the square of its alarm limit. The limits are
/// the same multiple of each sensor's sigma, and chi squared is in units of its square.
///
/// A reference that is off by `r` costs `(own - r)^2 / own_bound^2 + (others - r)^2 / others_bound^2 + d^2
/// stiffness`, at the best `r`, where `d` is the distance of `r` from the interval between the receiver's two
/// altitudes ([`Play`]). A receiver whose climb rate agrees with its altitude is off by no more than its
/// fixes' own errors. One that converges is off in one direction by its remaining error, and not in the
/// other. An error of the sensor costs only the other's, `others^2 / others_bound^2`, and at most 1: beyond
/// its limit the other sensor is wrong as well. Without this cap two failed sensors would hide each other for
/// ever. If nothing limits the error of the reference, there is no cap: two errors beyond their limits in the
/// same direction are blamed on the reference before they count as two failures.
fn is_likelier_own(
    (own_m, own_bound_m2): (f32, f32),
    (others_m, others_bound_m2): (f32, f32),
    play: Option<Play>,
) -> bool {
    let (own, others) = (1.0 / own_bound_m2, 1.0 / others_bound_m2);
    let others_cost = others * others_m * others_m;
    let by_itself = if play.is_some() { others_cost.min(1.0) } else { others_cost };
    let Play { other_m, stiffness_per_m2 } = play.unwrap_or(Play { other_m: 0.0, stiffness_per_m2: 0.0 });
    // The common part of the two errors, within the receiver's two altitudes; beyond them the stiffness
    // limits it.
    let common_m = (own * own_m + others * others_m) / (own + others);
    let word_m = common_m.max(other_m.min(0.0)).min(other_m.max(0.0));
    let (own_m, others_m) = (own_m - word_m, others_m - word_m);
    let pulled_per_m = own * own_m + others * others_m;
    let explained = pulled_per_m * pulled_per_m / (own + others + stiffness_per_m2);
    by_itself < own * own_m * own_m + others * others_m * others_m - explained
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Alarm limits of 7 m and a reference without a known limit: the other sensor supports it unless the two
    /// sensors are closer to each other than the other is to the reference. Against a reference with a known
    /// limit both have failed if they are more than 9.9 m apart, the root of 49 + 49.
    #[test]
    fn an_error_is_a_sensors_own_unless_the_reference_explains_both() {
        for (own_m, others_m, is_own) in [
            (8.0, 0.0, true),
            (8.0, 3.2, true),
            (8.0, 3.4, false),
            (8.0, -6.0, true),
            (8.0, 7.5, false),
            (30.0, 21.0, false),
            (30.0, 19.0, false),
            (-23.0, 9.0, true),
            (8.0, f32::NAN, false),
        ] {
            assert_eq!(is_likelier_own((own_m, 49.0), (others_m, 49.0), None), is_own, "{own_m} {others_m}");
        }
        for (others_m, is_own) in [(21.0, false), (19.0, true)] {
            let play = Some(Play { other_m: 0.0, stiffness_per_m2: 1e-9 });
            assert_eq!(is_likelier_own((30.0, 49.0), (others_m, 49.0), play), is_own, "{others_m}");
        }
    }

    /// A receiver that may be off by 10 m explains two sensors that are 8 m off, but not two that are 20 m
    /// off.
    #[test]
    fn a_reference_explains_no_more_than_it_may_be_off() {
        for (own_m, others_m, is_own) in
            [(8.0, 8.0, false), (12.0, 12.0, true), (20.0, 20.0, true), (8.0, 3.2, true), (8.0, -6.0, true)]
        {
            let play = Some(Play { other_m: 0.0, stiffness_per_m2: 0.01 });
            assert_eq!(is_likelier_own((own_m, 49.0), (others_m, 49.0), play), is_own, "{own_m} {others_m}");
        }
    }

    /// A converging receiver with 5.7 m left between its two altitudes explains errors of 8.7 m and 4.7 m in
    /// one direction, but not in the other, nor one of 8.7 m alone, nor errors far beyond its two altitudes.
    #[test]
    fn a_reference_is_off_to_the_side_of_its_other_word() {
        for (own_m, others_m, other_m, is_own) in [
            (8.7, 4.7, 5.7, false),
            (-8.7, -4.7, -5.7, false),
            (8.7, 4.7, -5.7, true),
            (8.7, 4.7, 0.0, true),
            (8.7, 0.3, 5.7, true),
            (30.0, 28.0, 5.7, true),
            (30.0, 28.0, 30.0, false),
        ] {
            let play = Some(Play { other_m, stiffness_per_m2: 1.0 / 72.0 });
            let said = is_likelier_own((own_m, 47.0), (others_m, 49.0), play);
            assert_eq!(said, is_own, "{own_m} {others_m} {other_m}");
        }
    }

    #[test]
    fn every_sensor_that_flies_free_has_its_place() {
        let flying = Sensor::ALL.into_iter().filter(|sensor| sensor.flies_free());
        assert!(flying.eq(WATCHED));
        for sensor in Sensor::ALL {
            let found = WATCHED.iter().position(|watched| *watched == sensor);
            assert_eq!(position(sensor), found);
        }
    }
}
