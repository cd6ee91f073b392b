//! Makes fixes from a receiver's messages.

use super::collect::Collected;
use super::rules::{FIXES, RULES};
use crate::import::fixes::{Fix, Fixes};
use crate::import::receivers::Other;
use crate::import::table::Group;

/// Lowest fix type that has an altitude.
const IS_3D: f32 = 3.0;

/// Indices of a fix's numbers, in the order of its rule.
mod number {
    pub const TYPE: usize = 0;
    pub const TIME: usize = 1;
    pub const ALTITUDE: usize = 2;
    pub const VELOCITY: [usize; 3] = [3, 4, 5];
    pub const VERTICAL_ACCURACY: usize = 6;
    pub const SATELLITES: usize = 7;
    pub const LATITUDE: usize = 8;
    pub const LONGITUDE: usize = 9;
    pub const VELOCITY_VALID: usize = 11;
    pub const WIDTH: usize = 12;
}

/// Numbers that are kept at full precision.
pub const EXACT: [usize; 3] = [number::TIME, number::LATITUDE, number::LONGITUDE];

/// The receiver that serves as the reference.
#[derive(Debug, Default)]
pub struct Receiver {
    /// Its fixes.
    pub fixes: Fixes,
    /// Its topic and instance.
    pub source: (&'static str, u8),
    /// Number of its messages without a 3D fix.
    pub without: usize,
    /// Other receivers.
    pub others: Vec<Other>,
    /// Receivers that are left out: without a 3D fix, or the source of the reference itself; with their
    /// number of 3D fixes.
    pub left_out: Vec<(&'static str, u8, usize)>,
}

/// A group's messages, each with its numbers.
fn messages(group: &Group) -> impl Iterator<Item = (u32, [f32; number::WIDTH])> + '_ {
    let columns: Vec<Vec<f32>> =
        (0..number::WIDTH).map(|place| group.column(place).map(|(_, value)| value).collect()).collect();
    group.stamps().iter().enumerate().map(move |(row, stamp)| {
        let mut numbers = [f32::NAN; number::WIDTH];
        for (slot, column) in numbers.iter_mut().zip(&columns) {
            *slot = column.get(row).copied().unwrap_or(f32::NAN);
        }
        (*stamp, numbers)
    })
}

fn is_3d(numbers: &[f32; number::WIDTH]) -> bool {
    numbers[number::TYPE] >= IS_3D && numbers[number::ALTITUDE].is_finite()
}

/// Topic, instance, messages, and how many of them have a 3D fix.
type Found<'a> = (&'static str, u8, &'a Group, usize);

/// The receiver that the autopilot used, or else the one with the most fixes.
pub fn receiver(collected: &Collected, times_us: &[Option<u64>]) -> Receiver {
    let mut found: Vec<Found<'_>> = Vec::new();
    for topic in FIXES {
        let Some(place) = RULES.iter().position(|rule| rule.topic == topic) else { continue };
        for ((_, instance), group) in collected.groups.range((place, 0)..=(place, u8::MAX)) {
            let count = messages(group).filter(|(_, numbers)| is_3d(numbers)).count();
            found.push((topic, *instance, group, count));
        }
    }
    let with_fixes = |topic: &str| found.iter().any(|(other, _, _, count)| *other == topic && *count > 0);
    let best = FIXES.into_iter().find(|topic| with_fixes(topic)).and_then(|topic| {
        let own = found.iter().filter(|(other, ..)| *other == topic);
        own.max_by_key(|(_, instance, _, count)| (*count, std::cmp::Reverse(*instance)))
    });
    let Some((topic, instance, group, count)) = best else {
        return Receiver {
            without: found.iter().map(|(_, _, group, _)| group.len()).sum(),
            ..Receiver::default()
        };
    };
    let beside = found.iter().filter(|(other, number, ..)| (other, number) != (topic, instance));
    let (beside, mut left_out): (Vec<&Found<'_>>, Vec<&Found<'_>>) =
        beside.partition(|(.., count)| *count > 0);
    // A single sensor_gps beside vehicle_gps_position is the source of the latter.
    let alone = |topic: &str| beside.iter().filter(|(other, ..)| *other == topic).count() == 1;
    let (sources, others): (Vec<&Found<'_>>, Vec<&Found<'_>>) =
        beside.iter().partition(|(other, ..)| other != topic && alone(other));
    left_out.extend(sources);
    Receiver {
        fixes: fixes(collected, group, times_us),
        source: (topic, *instance),
        without: group.len() - count,
        others: others
            .into_iter()
            .map(|(other, number, group, _)| Other {
                name: format!("{other} {}", number + 1),
                number: usize::from(*number) + 1,
                fixes: fixes(collected, group, times_us),
            })
            .collect(),
        left_out: left_out.iter().map(|(other, number, _, count)| (*other, *number, *count)).collect(),
    }
}

/// A receiver's 3D fixes.
fn fixes(collected: &Collected, group: &Group, times_us: &[Option<u64>]) -> Fixes {
    let fixes = messages(group).filter(|(_, numbers)| is_3d(numbers)).map(|(stamp, numbers)| {
        let [time_us, latitude_deg, longitude_deg] =
            collected.exact.get(&stamp).copied().unwrap_or([f64::NAN; 3]);
        let is_valid = numbers[number::VELOCITY_VALID] != 0.0;
        let velocity = number::VELOCITY.map(|place| numbers.get(place).copied().unwrap_or(f32::NAN));
        Fix {
            stamp,
            time_us: (time_us > 0.0).then_some(time_us as u64),
            altitude_m: f64::from(numbers[number::ALTITUDE]),
            velocity_mps: velocity.map(|mps| if is_valid { f64::from(mps) } else { f64::NAN }),
            satellites: f64::from(numbers[number::SATELLITES]),
            vertical_accuracy_m: f64::from(numbers[number::VERTICAL_ACCURACY]),
            latitude_deg,
            longitude_deg,
        }
    });
    Fixes::new(fixes, times_us)
}
