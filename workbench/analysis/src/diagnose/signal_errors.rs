//! Regressors made of signals that were measured late, or with an offset.
//!
//! An airspeed passes through tubing and a filter, a vane has inertia and is aligned to about half a degree,
//! and a receiver whose altitude is late has an equally late velocity. A regressor made of such a signal has
//! the wrong shape, and its remainder looks like another effect: a load factor like what a prompt vane would
//! have measured, and a lever arm like the end of a climb at a late receiver. An attitude is a quarter of a
//! degree wrong, which an inertial regressor integrates twice. So these regressors are also tried as if their
//! signals had been prompt and true: the column is read ahead by the delay, an angle is corrected by an
//! offset, and a forward acceleration is taken from the receiver's velocity. Which of them fits depends on the
//! instrument only, not on the effect: all are one effect.

use kf_core::effect::EffectId;

use super::series::{BySensor, Series};

/// How the signal that a regressor is made of may be wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SignalError {
    /// Delay of the signal, seconds.
    pub late_s: f32,
    /// Amount by which its angle is too small, radians.
    pub offset_rad: f32,
    /// Whether its forward acceleration is taken from the receiver's velocity (`forward_motion.rs`) instead of
    /// specific force and attitude, whose error grows.
    pub is_by_velocity: bool,
}

/// A vane responds within some tenths of a second.
const VANE_LATE_S: [f32; 3] = [0.0, 0.15, 0.3];
/// A vane is aligned to about half a degree.
const VANE_OFFSET_RAD: [f32; 3] = [0.0, 0.01, -0.01];
/// Delay of an airspeed by its tubing and filter.
const AIRSPEED_LATE_S: [f32; 3] = [0.0, 0.3, 0.6];
/// A receiver's altitude that is late by d equals the true one less d times the mean climb rate of the last d
/// seconds: an equally late velocity, read d/2 ahead. A receiver is about three seconds late at most. One that
/// extrapolates may be early, by a second at most: its velocity is read behind.
const RECEIVER_LATE_S: [f32; 9] = [0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, -0.25, -0.5];
/// How much a receiver's delay may differ from twice the time by which its velocity is read ahead, seconds: a
/// step of these delays, beyond which another one is surely nearer.
const RECEIVER_STEP_S: f64 = 0.5;

/// The delays, seconds, that agree with a velocity that is read ahead by `late_s`.
#[must_use]
pub fn receiver_delays_s(late_s: f32) -> [f64; 2] {
    let delay_s = 2.0 * f64::from(late_s);
    [delay_s - RECEIVER_STEP_S, delay_s + RECEIVER_STEP_S]
}

/// The signal errors that are tried for an effect, no error first.
#[must_use]
pub fn errors(effect: EffectId) -> Vec<SignalError> {
    let late = |seconds: &[f32]| {
        seconds.iter().map(|late_s| SignalError { late_s: *late_s, ..SignalError::default() }).collect()
    };
    match effect {
        EffectId::BaroAngleOfAttack => VANE_LATE_S
            .iter()
            .flat_map(|late_s| {
                VANE_OFFSET_RAD.map(|offset_rad| SignalError {
                    late_s: *late_s,
                    offset_rad,
                    ..SignalError::default()
                })
            })
            .collect(),
        EffectId::BaroDynamicPressure => late(&AIRSPEED_LATE_S),
        EffectId::GpsLatency => late(&RECEIVER_LATE_S),
        EffectId::ImuTilt | EffectId::ImuGyroBias => [false, true]
            .into_iter()
            .map(|is_by_velocity| SignalError { is_by_velocity, ..SignalError::default() })
            .collect(),
        _ => vec![SignalError::default()],
    }
}

/// Reads a column of block means ahead by `late_s` (behind, if negative): between the means of the blocks
/// around that time. Where these are in another phase or beyond a gap, the last two connected blocks are
/// extrapolated.
pub(super) fn read_ahead(series: &Series, column: &mut [BySensor], late_s: f32) {
    let share = f64::from(late_s) / series.block_s;
    let seen = |block: usize, sensor: usize| series.readings.get(block).is_some_and(|of| of[sensor] > 0);
    let joins = |block: usize, sensor: usize| {
        let next = block + 1;
        series.free.get(block) == series.free.get(next)
            && seen(block, sensor)
            && seen(next, sensor)
            && series.time_s[next] - series.time_s[block] < 1.5 * series.block_s
    };
    let old = column.to_vec();
    for (block, values) in column.iter_mut().enumerate() {
        for (sensor, value) in values.iter_mut().enumerate().filter(|(sensor, _)| seen(block, *sensor)) {
            let steps = share.abs().ceil() as usize;
            let after = || (block..).take_while(|from| joins(*from, sensor)).take(steps).last();
            let before = || (0..block).rev().take_while(|from| joins(*from, sensor)).take(steps).last();
            let first_before = || block.checked_sub(1).filter(|from| joins(*from, sensor));
            let first_after = || Some(block).filter(|from| joins(*from, sensor));
            let from =
                if share > 0.0 { after().or_else(first_before) } else { before().or_else(first_after) };
            if let Some(from) = from {
                let beyond = share + block as f64 - from as f64;
                *value = old[from][sensor] + beyond * (old[from + 1][sensor] - old[from][sensor]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use kf_core::sensor::SENSORS;

    use super::*;

    fn series(times_s: &[f64], launch: usize) -> Series {
        let blocks = times_s.len();
        Series {
            time_s: times_s.to_vec(),
            free: (0..blocks).map(|block| block >= launch).collect(),
            readings: vec![[0, 0, 10]; blocks],
            block_s: 2.0,
            ..Series::default()
        }
    }

    fn ahead(series: &Series, of: impl Fn(f64) -> f64, late_s: f32) -> Vec<f64> {
        let mut column: Vec<BySensor> = series.time_s.iter().map(|time_s| [0.0, 0.0, of(*time_s)]).collect();
        read_ahead(series, &mut column, late_s);
        assert!(column.iter().all(|values| values[..SENSORS - 1].iter().all(|value| *value == 0.0)));
        column.into_iter().map(|values| values[2]).collect()
    }

    /// A ramp that is read ahead is the ramp at the later time, in the last blocks too.
    #[test]
    fn a_ramp_is_read_ahead_everywhere() {
        let times_s: Vec<f64> = (0..20).map(|k| 1.0 + 2.0 * f64::from(k)).collect();
        for late_s in [0.5, 2.0, 3.0] {
            for (time_s, value) in times_s.iter().zip(ahead(&series(&times_s, 0), |t| 3.0 * t, late_s)) {
                let expected = 3.0 * (time_s + f64::from(late_s));
                assert!((value - expected).abs() < 1e-9, "{late_s} at {time_s}: {value}");
            }
        }
    }

    /// More than a block ahead is read between the two blocks there, and not extrapolated from the next one's
    /// rise.
    #[test]
    fn more_than_a_block_ahead_is_read_where_it_lies() {
        let times_s: Vec<f64> = (0..5).map(|k| 1.0 + 2.0 * f64::from(k)).collect();
        let found = ahead(&series(&times_s, 0), |t| (t * t).round(), 3.0);
        // The squares 1, 9, 25, 49 and 81; at the end the last rise of 32 a block continues.
        assert_eq!(found, [17.0, 37.0, 65.0, 97.0, 129.0]);
    }

    /// What happens at the launch or after a gap is not carried into the blocks before it.
    #[test]
    fn a_launch_and_a_gap_are_not_read_across() {
        let times_s = [1.0, 3.0, 5.0, 7.0, 9.0, 21.0, 23.0];
        let step = |t: f64| if t < 6.0 { 1.0 } else { 5.0 };
        let found = ahead(&series(&times_s, 3), step, 0.5);
        assert_eq!(found, [1.0, 1.0, 1.0, 5.0, 5.0, 5.0, 5.0]);
        let later = |t: f64| if t < 15.0 { 1.0 } else { 5.0 };
        assert_eq!(ahead(&series(&times_s, 0), later, 0.5), [1.0, 1.0, 1.0, 1.0, 1.0, 5.0, 5.0]);
        // A sensor without a reading has no column there.
        let mut silent = series(&times_s, 0);
        silent.readings[2] = [0; SENSORS];
        assert_eq!(ahead(&silent, |t| t, 0.5)[1..4], [3.5, 5.0, 7.5]);
    }

    /// A correct signal is tried first; nothing else is tried for effects that use no such signal.
    #[test]
    fn a_right_signal_comes_first() {
        for effect in EffectId::ALL {
            assert_eq!(errors(effect)[0], SignalError::default());
        }
        assert_eq!(errors(EffectId::BaroAngleOfAttack).len(), 9);
        assert_eq!(errors(EffectId::BaroAcceleration).len(), 1);
    }
}
