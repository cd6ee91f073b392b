//! Converts the receivers' messages to fixes.

use std::collections::BTreeMap;

use super::collect::{Collected, GpsMessage};
use crate::import::fixes::{Fix, Fixes};
use crate::import::gps_time::gps_us;
use crate::import::receivers::Other;
use crate::import::table::{Destination, Filling, Samples};
use flight_data::Channel;

/// Lowest status of a fix with an altitude.
const IS_3D: f64 = 3.0;
/// Longest time from a fix to its accuracy, which is logged right after it.
const SAME_FIX_US: u64 = 1_000_000;

/// Index of each number in a message, by [`super::rules::GPS`].
mod number {
    pub const STATUS: usize = 0;
    pub const WEEK: usize = 1;
    pub const WEEK_MS: usize = 2;
    pub const SATELLITES: usize = 3;
    pub const HDOP: usize = 4;
    pub const LATITUDE: usize = 5;
    pub const LONGITUDE: usize = 6;
    pub const ALTITUDE: usize = 7;
    pub const SPEED: usize = 8;
    pub const COURSE: usize = 9;
    pub const DOWN: usize = 10;
}

impl GpsMessage {
    fn number(&self, place: usize) -> f64 {
        self.numbers.get(place).copied().unwrap_or(f64::NAN)
    }

    /// The receiver's time, microseconds since 1980.
    pub fn time_us(&self) -> Option<u64> {
        gps_us(self.number(number::WEEK), self.number(number::WEEK_MS))
    }

    fn fix(&self) -> Fix {
        let (sine, cosine) = self.number(number::COURSE).sin_cos();
        let speed = self.number(number::SPEED);
        Fix {
            stamp: self.stamp,
            time_us: self.time_us(),
            altitude_m: self.number(number::ALTITUDE),
            velocity_mps: [speed * cosine, speed * sine, self.number(number::DOWN)],
            satellites: self.number(number::SATELLITES),
            vertical_accuracy_m: f64::NAN,
            latitude_deg: self.number(number::LATITUDE),
            longitude_deg: self.number(number::LONGITUDE),
        }
    }

    fn is_3d(&self) -> bool {
        // The oldest logs have no status.
        let status = self.number(number::STATUS);
        (status.is_nan() || status >= IS_3D) && self.number(number::ALTITUDE).is_finite()
    }
}

/// The fixes of the receiver used.
#[derive(Debug, Default)]
pub struct Receiver {
    /// Its fixes.
    pub fixes: Fixes,
    /// The columns.
    pub fillings: Vec<Filling<'static>>,
    /// Its messages without a 3D fix.
    pub without: usize,
    /// Its number, from 0.
    pub instance: u8,
    /// The other receivers with 3D fixes.
    pub others: Vec<Other>,
}

/// The receiver with the most fixes. `times_us` has the time of each accepted stamp.
pub fn receiver(collected: &Collected, times_us: &[Option<u64>]) -> Receiver {
    let mut counts: BTreeMap<u8, usize> = BTreeMap::new();
    for message in collected.gps.iter().filter(|message| message.is_3d()) {
        *counts.entry(message.instance).or_default() += 1;
    }
    let best = counts.iter().max_by_key(|(instance, count)| (**count, std::cmp::Reverse(**instance)));
    let Some(instance) = best.map(|(instance, _)| *instance) else {
        return Receiver { without: collected.gps.len(), ..Receiver::default() };
    };
    let own = || collected.gps.iter().filter(|message| message.instance == instance);
    let fixes_of = |instance: u8| {
        let own = collected.gps.iter().filter(|message| message.instance == instance && message.is_3d());
        Fixes::new(own.map(GpsMessage::fix), times_us)
    };
    let fixes = fixes_of(instance);
    let others: Vec<Other> = counts
        .keys()
        .filter(|other| **other != instance)
        .map(|other| Other { name: name(*other), number: usize::from(*other) + 1, fixes: fixes_of(*other) })
        .collect();
    let mut fillings = fixes.fillings(times_us);
    fillings.extend(others.iter().flat_map(Other::fillings));
    fillings.push(Filling {
        destination: Destination::signal("gps_hdop"),
        samples: Samples::Own(
            own()
                .filter(|message| message.is_3d())
                .map(|message| (message.stamp, message.number(number::HDOP) as f32))
                .collect(),
        ),
    });
    fillings.extend(accuracies(collected, &fixes.fixes, instance, times_us));
    Receiver { fillings, without: own().filter(|message| !message.is_3d()).count(), instance, others, fixes }
}

/// A receiver's name for the user.
pub fn name(instance: u8) -> String {
    format!("receiver {}", u16::from(instance) + 1)
}

/// The accuracies logged after the fixes, at the fixes' times.
fn accuracies(
    collected: &Collected,
    taken: &[Fix],
    instance: u8,
    times_us: &[Option<u64>],
) -> Vec<Filling<'static>> {
    let Some(group) = collected.groups.get(&(super::rules::ACCURACY_PLACE, instance)) else {
        return Vec::new();
    };
    let of = |destination, place: usize| {
        let samples = group.column(place).filter_map(|(stamp, value)| {
            let next = taken.partition_point(|fix| fix.stamp < stamp);
            let fix = taken.get(next.checked_sub(1)?)?;
            let own_us = collected.stamps_us.get(stamp as usize)?;
            // A receiver that does not know its accuracy reports zero.
            let fix_us = times_us.get(fix.stamp as usize).copied().flatten()?;
            let is_its = fix_us.abs_diff(*own_us) <= SAME_FIX_US && value > 0.0;
            is_its.then_some((fix.stamp, value))
        });
        // A fix that was logged twice has two.
        let mut samples: Vec<(u32, f32)> = samples.collect();
        samples.dedup_by_key(|(stamp, _)| *stamp);
        Filling { destination, samples: samples.into() }
    };
    vec![
        of(Destination::Channel(Channel::GpsVaccM), 0),
        of(Destination::signal("gps_horizontal_accuracy_m"), 1),
        of(Destination::signal("gps_speed_accuracy_mps"), 2),
    ]
}
