//! Collects messages into groups of values.

use std::collections::BTreeMap;

use super::format::Place;
use super::reader::{Message, Reader};
use super::rules::RULES;
use crate::import::table::Group;

/// More sources of one kind than an autopilot has.
const MOST_INSTANCES: u8 = 8;

/// All useful data of a log.
#[derive(Debug, Default)]
pub struct Collected {
    /// Time of each used message, microseconds since the autopilot's start, in the log's order.
    pub stamps_us: Vec<u64>,
    /// Byte offset of each used message.
    pub places: Vec<usize>,
    /// Messages by rule and instance, with the numbers of the rule's fields.
    pub groups: BTreeMap<(usize, u8), Group>,
    /// Receivers' times, microseconds since 1970, and positions, degrees: with more digits than a group
    /// holds.
    pub exact: BTreeMap<u32, [f64; 3]>,
    /// Parameters at the start.
    pub parameters: BTreeMap<String, f64>,
    /// Number of parameters changed later.
    pub changed: usize,
    /// Texts about the vehicle.
    pub info: BTreeMap<String, Vec<u8>>,
    /// Number of messages of each topic and instance.
    pub counts: BTreeMap<u16, usize>,
    /// Dropouts of data: time of the message before, microseconds, and duration, milliseconds.
    pub dropouts: Vec<(u64, u16)>,
    /// Messages too short to contain their time.
    pub unstamped: usize,
    /// Ids of useful topics that cannot be read, with the reason.
    pub unreadable: BTreeMap<u16, &'static str>,
    /// Fields whose name resembles that of a missing one: topic, the missing field, and the one that exists.
    pub misspelt: Vec<(String, &'static str, String)>,
}

/// How to read a topic.
enum Plan {
    /// It is not used.
    Unused,
    /// It would be used, but cannot be read for this reason.
    Unreadable(&'static str),
    Values(Values),
}

struct Values {
    rule: usize,
    instance: u8,
    time: Place,
    fields: Vec<Option<(Place, f64)>>,
    /// The values read.
    group: Group,
    /// Indices of a receiver's time and position among the fields.
    exact: Option<[usize; 3]>,
}

/// The number of a field in a message's data; NaN if it is missing.
fn number(field: Option<(Place, f64)>, data: &[u8]) -> f64 {
    let Some((place, factor)) = field else { return f64::NAN };
    let number = data.get(place.offset..).and_then(|bytes| place.scalar.read(bytes));
    match number {
        // A division keeps the digits that a factor below one would lose.
        Some(number) if factor < 1.0 => number / (1.0 / factor).round(),
        Some(number) => number * factor,
        None => f64::NAN,
    }
}

impl Collected {
    /// Collects all useful data of a log.
    pub fn read(reader: &mut Reader<'_>) -> Self {
        let mut collected = Self::default();
        // By message id, with the number of messages: looked up for each message.
        let mut plans: Vec<Option<(Plan, usize)>> = Vec::new();
        let mut latest_us = 0;
        while let Some(message) = reader.next() {
            match message {
                Message::Data { id, at, data } => {
                    let place = usize::from(id);
                    if plans.len() <= place {
                        plans.resize_with(place + 1, || None);
                    }
                    let Some(slot) = plans.get_mut(place) else { continue };
                    let (plan, count) = slot.get_or_insert_with(|| {
                        let plan = plan(reader, id);
                        match &plan {
                            Plan::Unused => {}
                            Plan::Unreadable(why) => {
                                collected.unreadable.insert(id, why);
                            }
                            Plan::Values(values) => collected.misspelt.extend(misspelt(reader, id, values)),
                        }
                        (plan, 0)
                    });
                    *count += 1;
                    if let Plan::Values(values) = plan {
                        latest_us = collected.take(values, at, data).unwrap_or(latest_us);
                    }
                }
                Message::Parameter { name, value } => {
                    // A parameter after the first data was changed in flight.
                    if plans.is_empty() {
                        collected.parameters.insert(name.to_owned(), value);
                    } else {
                        collected.changed += 1;
                    }
                }
                Message::Info { name, value } => {
                    collected.info.entry(name.to_owned()).or_insert_with(|| value.to_vec());
                }
                Message::Dropout { ms } => collected.dropouts.push((latest_us, ms)),
            }
        }
        for (plan, id) in plans.into_iter().zip(0..) {
            let Some((plan, count)) = plan else { continue };
            collected.counts.insert(id, count);
            if let Plan::Values(Values { rule, instance, group, .. }) = plan {
                collected.groups.insert((rule, instance), group);
            }
        }
        collected
    }

    /// Adds a message and returns its time.
    fn take(&mut self, plan: &mut Values, at: usize, data: &[u8]) -> Option<u64> {
        let time_us = data
            .get(plan.time.offset..)
            .and_then(|bytes| bytes.first_chunk())
            .map(|chunk| u64::from_le_bytes(*chunk));
        let (Some(time_us), Ok(stamp)) = (time_us, u32::try_from(self.stamps_us.len())) else {
            self.unstamped += 1;
            return None;
        };
        // Limited to the greatest time of a flight, which is beyond all clocks.
        let time_us = time_us.min(9_000_000_000_000_000);
        self.stamps_us.push(time_us);
        self.places.push(at);
        let Values { fields, group, exact, .. } = plan;
        group.push(stamp, fields.iter().map(|field| number(*field, data) as f32));
        if let Some(places) = exact {
            let exact = places.map(|place| number(fields.get(place).copied().flatten(), data));
            self.exact.insert(stamp, exact);
        }
        Some(time_us)
    }
}

/// How to read the topic of an id.
fn plan(reader: &Reader<'_>, id: u16) -> Plan {
    let Some(subscription) = reader.subscriptions.get(&id) else { return Plan::Unused };
    let topic = subscription.topic.as_str();
    let Some((rule, found)) = RULES.iter().enumerate().find(|(_, rule)| rule.topic == topic) else {
        return Plan::Unused;
    };
    if subscription.instance >= MOST_INSTANCES {
        return Plan::Unreadable("its instance is more than any autopilot has");
    }
    let Some(time) = reader.formats.find(topic, "timestamp").filter(|place| place.scalar.len() == 8) else {
        return Plan::Unreadable("its definition has no timestamp");
    };
    let fields = found.fields.iter().map(|field| {
        field.paths.iter().find_map(|(path, factor)| Some((reader.formats.find(topic, path)?, *factor)))
    });
    let exact = super::rules::FIXES.contains(&topic).then_some(super::gps::EXACT);
    let fields: Vec<_> = fields.collect();
    let group = Group::new(fields.len());
    Plan::Values(Values { rule, instance: subscription.instance, time, fields, group, exact })
}

/// The name of the first field in a path.
fn first_step(path: &'static str) -> &'static str {
    path.split(['[', '.']).next().unwrap_or(path)
}

/// Fields of a topic that are missing because of one letter: a definition has no checksum, and a flipped bit
/// in it would lose a column without notice.
fn misspelt(reader: &Reader<'_>, id: u16, values: &Values) -> Vec<(String, &'static str, String)> {
    let (Some(subscription), Some(rule)) = (reader.subscriptions.get(&id), RULES.get(values.rule)) else {
        return Vec::new();
    };
    let paths = || rule.fields.iter().flat_map(|field| field.paths).map(|(path, _)| first_step(path));
    let missing = rule.fields.iter().zip(&values.fields).filter(|(_, place)| place.is_none());
    let mut found = Vec::new();
    for (path, _) in missing.flat_map(|(field, _)| field.paths) {
        let wanted = first_step(path);
        let names: Vec<&str> = reader.formats.fields(&subscription.topic).collect();
        // A name that occurs twice is known, and one of the two is wrong.
        let is_twice = |name: &str| names.iter().filter(|other| **other == name).count() > 1;
        let unknown = names.iter().filter(|name| paths().all(|path| path != **name) || is_twice(name));
        for name in unknown.filter(|name| strsim::osa_distance(name, wanted) == 1) {
            let entry = (subscription.topic.clone(), wanted, (*name).to_owned());
            if !found.contains(&entry) {
                found.push(entry);
            }
        }
    }
    found
}
