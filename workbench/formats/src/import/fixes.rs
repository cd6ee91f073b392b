//! A receiver's fixes as columns.

use super::table::{Destination, Filling, Samples};
use flight_data::Channel;

/// A receiver's time is damaged if it is farther from the autopilot's clock than the others by this.
const FAR_US: u64 = 5_000_000;

/// A 3D fix; a missing value is NaN.
#[derive(Clone, Copy, Debug)]
pub struct Fix {
    /// Index of its stamp among the log's.
    pub stamp: u32,
    /// Its time by the receiver's clock.
    pub time_us: Option<u64>,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Velocity north, east, down.
    pub velocity_mps: [f64; 3],
    pub satellites: f64,
    pub vertical_accuracy_m: f64,
    pub latitude_deg: f64,
    pub longitude_deg: f64,
}

impl Fix {
    /// Whether this is the same fix again.
    fn repeats(&self, other: &Self) -> bool {
        let numbers = |fix: &Self| {
            let [north, east, down] = fix.velocity_mps;
            [fix.altitude_m, north, east, down, fix.latitude_deg, fix.longitude_deg].map(f64::to_bits)
        };
        self.time_us.is_some() && self.time_us == other.time_us && numbers(self) == numbers(other)
    }
}

/// The fixes of one receiver, each once.
#[derive(Clone, Debug, Default)]
pub struct Fixes {
    /// The fixes.
    pub fixes: Vec<Fix>,
    /// Messages that repeated the fix before them.
    pub repeated: usize,
    /// The receiver's clock at zero of the log's, microseconds.
    pub epoch_us: Option<i64>,
}

impl Fixes {
    /// From a receiver's messages with a 3D fix. `times_us` has the time of each accepted stamp.
    pub fn new(messages: impl IntoIterator<Item = Fix>, times_us: &[Option<u64>]) -> Self {
        let mut fixes: Vec<Fix> = Vec::new();
        let mut repeated = 0;
        for fix in messages {
            if fixes.last().is_some_and(|before| fix.repeats(before)) {
                repeated += 1;
            } else {
                fixes.push(fix);
            }
        }
        let ahead_us =
            |fix: &Fix| i64::try_from(fix.time_us?).ok()?.checked_sub_unsigned(time(fix, times_us)?);
        let mut ahead: Vec<i64> = fixes.iter().filter_map(ahead_us).collect();
        let middle = ahead.len() / 2;
        let epoch_us = (!ahead.is_empty()).then(|| *ahead.select_nth_unstable(middle).1);
        Self { fixes, repeated, epoch_us }
    }

    /// The columns.
    pub fn fillings(&self, times_us: &[Option<u64>]) -> Vec<Filling<'static>> {
        let filling = |destination, value: &dyn Fn(&Fix) -> f64| Filling {
            destination,
            samples: Samples::Own(self.fixes.iter().map(|fix| (fix.stamp, value(fix) as f32)).collect()),
        };
        let channel = |channel, value: &dyn Fn(&Fix) -> f64| filling(Destination::Channel(channel), value);
        let position = |name: &str, value: &dyn Fn(&Fix) -> f64| Filling {
            destination: Destination::signal(name),
            samples: Samples::Double(self.fixes.iter().map(|fix| (fix.stamp, value(fix))).collect()),
        };
        vec![
            channel(Channel::GpsAltM, &|fix| fix.altitude_m),
            channel(Channel::GpsVnMps, &|fix| fix.velocity_mps[0]),
            channel(Channel::GpsVeMps, &|fix| fix.velocity_mps[1]),
            channel(Channel::GpsVdMps, &|fix| fix.velocity_mps[2]),
            channel(Channel::GpsSats, &|fix| fix.satellites),
            channel(Channel::GpsVaccM, &|fix| fix.vertical_accuracy_m),
            Filling {
                destination: Destination::Channel(Channel::GpsTimeS),
                samples: self.times_s(times_us).into(),
            },
            position("latitude_deg", &|fix| fix.latitude_deg),
            position("longitude_deg", &|fix| fix.longitude_deg),
        ]
    }

    /// Seconds of each fix by the receiver's clock since its first. A fix is left out if the clocks
    /// contradict its time, or if it has the time of the fix before, as with receivers that count whole
    /// seconds.
    fn times_s(&self, times_us: &[Option<u64>]) -> Vec<(u32, f32)> {
        let believed = |fix: &Fix| {
            let expected_us = self.epoch_us?.checked_add_unsigned(time(fix, times_us)?)?;
            let time_us = i64::try_from(fix.time_us?).ok()?;
            (time_us.abs_diff(expected_us) <= FAR_US).then_some(time_us)
        };
        let first_us = self.fixes.iter().find_map(believed).unwrap_or(0);
        let mut latest_us = None;
        let mut samples = Vec::with_capacity(self.fixes.len());
        for fix in &self.fixes {
            let Some(time_us) = believed(fix).filter(|time_us| latest_us != Some(*time_us)) else { continue };
            latest_us = Some(time_us);
            samples.push((fix.stamp, ((time_us - first_us) as f64 / 1e6) as f32));
        }
        samples
    }
}

fn time(fix: &Fix, times_us: &[Option<u64>]) -> Option<u64> {
    times_us.get(fix.stamp as usize).copied().flatten()
}
