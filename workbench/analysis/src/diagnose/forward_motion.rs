//! The forward acceleration by the receiver's velocity, integrated for the inertial effects.
//!
//! A tilt lets the forward acceleration into the vertical channel, integrated twice. Accelerometers and an
//! attitude measure it with a constant error, of which captive flight shows only a part
//! (`kf-core/src/effect/forward_error.rs`); after two integrations the rest may be as large as the aircraft's
//! own motion. A receiver's velocity has no error that grows like that: its changes along the heading are the
//! acceleration's integral. In a turn at constant speed the velocity changes across the heading, and a wind,
//! which does not change, cancels. A wrong heading lets in a part of the turns.

use std::collections::VecDeque;

/// Velocities of this time before launch are averaged, microseconds.
const BEFORE_LAUNCH_US: u64 = 1_000_000;
/// Shortest sum of two headings that has a direction: beyond it the aircraft has turned round between two
/// fixes.
const SHORTEST: f64 = 1e-3;

/// A double integral of a speed's changes, each spread evenly over its interval.
#[derive(Clone, Copy, Debug, Default)]
struct Integral {
    first: f64,
    second: f64,
}

impl Integral {
    fn change(&mut self, by: f64, seconds: f64) {
        self.second += seconds * (self.first + 0.5 * by);
        self.first += by;
    }

    fn after(self, seconds: f64) -> f64 {
        self.second + seconds * self.first
    }
}

/// A fix's velocity, m/s, and the heading then, north and east.
#[derive(Clone, Copy, Debug)]
struct Fix {
    time_us: u64,
    velocity_mps: [f64; 2],
    heading: [f64; 2],
}

/// Integrates the forward acceleration from launch on.
#[derive(Clone, Debug, Default)]
pub(super) struct ForwardMotion {
    heading: Option<[f64; 2]>,
    launch_us: Option<u64>,
    /// The last fixes before launch.
    recent: VecDeque<Fix>,
    last: Option<Fix>,
    /// Of the acceleration, m.
    forward: Integral,
    /// Of the acceleration times the time since launch, m s.
    turning: Integral,
}

impl ForwardMotion {
    /// Starts from the mean of the last velocities: the error of a single one would grow with the time.
    pub(super) fn launch(&mut self, time_us: u64) {
        self.launch_us = Some(time_us);
        let number = self.recent.len() as f64;
        let mean = |part: fn(&Fix) -> [f64; 2]| {
            [0, 1].map(|axis| self.recent.iter().map(|fix| part(fix)[axis]).sum::<f64>() / number)
        };
        if !self.recent.is_empty() {
            let (velocity_mps, heading) = (mean(|fix| fix.velocity_mps), mean(|fix| fix.heading));
            self.last = Some(Fix { time_us, velocity_mps, heading });
        }
        self.recent.clear();
    }

    /// Takes a heading, rad.
    pub(super) fn turn_to(&mut self, heading_rad: f32) {
        if heading_rad.is_finite() {
            let heading_rad = f64::from(heading_rad);
            self.heading = Some([libm::cos(heading_rad), libm::sin(heading_rad)]);
        }
    }

    /// Takes a fix's north and east velocity, m/s.
    pub(super) fn take(&mut self, time_us: u64, velocity_mps: [f32; 2]) {
        let velocity_mps = velocity_mps.map(f64::from);
        let Some(heading) = self.heading.filter(|_| velocity_mps.iter().all(|part| part.is_finite())) else {
            return;
        };
        let now = Fix { time_us, velocity_mps, heading };
        let Some(launch_us) = self.launch_us else {
            self.recent.push_back(now);
            let is_old = |fix: &Fix| time_us.saturating_sub(fix.time_us) > BEFORE_LAUNCH_US;
            while self.recent.front().is_some_and(is_old) {
                self.recent.pop_front();
            }
            return;
        };
        let Some(last) = self.last.replace(now) else { return };
        let along: [f64; 2] = std::array::from_fn(|axis| last.heading[axis] + heading[axis]);
        let length = libm::hypot(along[0], along[1]);
        let seconds = time_us.saturating_sub(last.time_us) as f64 * 1e-6;
        if length < SHORTEST || seconds <= 0.0 {
            return;
        }
        let changed = |axis: usize| velocity_mps[axis] - last.velocity_mps[axis];
        let gained_mps = (changed(0) * along[0] + changed(1) * along[1]) / length;
        let middle_s = time_us.saturating_sub(launch_us) as f64 * 1e-6 - 0.5 * seconds;
        self.forward.change(gained_mps, seconds);
        self.turning.change(gained_mps * middle_s, seconds);
    }

    /// The double integrals of the acceleration, m, and of it times the time since launch, m s; zero before
    /// launch. `None` before a velocity with a heading.
    pub(super) fn integrals(&self, time_us: u64) -> Option<[f64; 2]> {
        if self.launch_us.is_none() {
            return (!self.recent.is_empty()).then_some([0.0; 2]);
        }
        let seconds = time_us.saturating_sub(self.last?.time_us) as f64 * 1e-6;
        Some([self.forward.after(seconds), self.turning.after(seconds)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EAST_WIND_MPS: f32 = -7.0;

    /// The integrals after 40 s of free flight with these airspeeds (m/s) and headings (rad) at the times since
    /// launch, in a wind, with a fix every 0.2 s from 2 s before launch on.
    fn flown(airspeed_mps: impl Fn(f32) -> f32, heading_rad: impl Fn(f32) -> f32) -> [f64; 2] {
        let mut motion = ForwardMotion::default();
        for k in 0..=210_u16 {
            let (time_us, since_s) = (u64::from(k) * 200_000, 0.2 * f32::from(k) - 2.0);
            if k == 10 {
                motion.launch(time_us);
            }
            let (speed, heading) = (airspeed_mps(since_s.max(0.0)), heading_rad(since_s.max(0.0)));
            motion.turn_to(heading);
            motion.take(time_us, [speed * heading.cos(), speed * heading.sin() + EAST_WIND_MPS]);
        }
        motion.integrals(42_000_000).unwrap()
    }

    /// 2 m/s^2 for 40 s: twice 2 is 1600 m, and twice `2 t` is `t^3 / 3`.
    #[test]
    fn a_straight_acceleration_is_its_double_integral() {
        let [forward_m, turning_m_s] = flown(|since_s| 20.0 + 2.0 * since_s, |_| 0.9);
        assert!((forward_m - 1_600.0).abs() < 0.1, "{forward_m}");
        assert!((turning_m_s - 64_000.0 / 3.0).abs() < 5.0, "{turning_m_s}");
    }

    /// Three circles in a wind at a constant airspeed have no forward acceleration, although the speed over
    /// ground changes by 14 m/s.
    #[test]
    fn circles_in_a_wind_have_no_forward_acceleration() {
        let [forward_m, turning_m_s] = flown(|_| 25.0, |since_s| 0.47 * since_s);
        assert!(forward_m.abs() < 0.5 && turning_m_s.abs() < 10.0, "{forward_m} {turning_m_s}");
    }

    #[test]
    fn without_a_heading_or_a_velocity_there_is_nothing() {
        let mut motion = ForwardMotion::default();
        motion.take(0, [20.0, 0.0]);
        motion.launch(100_000);
        assert_eq!(motion.integrals(200_000), None);
        motion.turn_to(0.0);
        motion.take(300_000, [f32::NAN, 0.0]);
        assert_eq!(motion.integrals(400_000), None);
    }
}
