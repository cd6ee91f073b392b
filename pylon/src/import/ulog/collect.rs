//! From messages to groups of values.

use std::collections::BTreeMap;

use super::format::Place;
use super::reader::{Message, Reader};
use super::rules::RULES;
use crate::import::table::Group;

/// More sources of one kind than any autopilot has.
const MOST_INSTANCES: u8 = 8;

/// All that a log has of use.
#[derive(Debug, Default)]
pub struct Collected {
    /// Time of each used message, microseconds since the autopilot's start, in the log's order.
    pub stamps_us: Vec<u64>,
    /// Byte of each used message.
    pub places: Vec<usize>,
    /// Messages by rule and instance; their numbers are those of the rule's fields.
    pub groups: BTreeMap<(usize, u8), Group>,
    /// Receivers' times, microseconds since 1970, and positions, degrees: more digits than a group holds.
    pub exact: BTreeMap<u32, [f64; 3]>,
    /// Parameters as they were at the start.
    pub parameters: BTreeMap<String, f64>,
    /// Parameters that were changed later.
    pub changed: usize,
    /// Texts about the vehicle.
    pub info: BTreeMap<String, Vec<u8>>,
    /// Messages of each topic and instance.
    pub counts: BTreeMap<u16, usize>,
    /// Times at which data were lost: microseconds of the message before, milliseconds.
    pub dropouts: Vec<(u64, u16)>,
    /// Messages without a field `timestamp`.
    pub unstamped: usize,
}

/// How to read a topic.
enum Plan {
    Nothing,
    Values(Values),
}

struct Values {
    rule: usize,
    instance: u8,
    time: Place,
    fields: Vec<Option<(Place, f64)>>,
    /// Places among the fields of time and position of a receiver.
    exact: Option<[usize; 3]>,
}

impl Values {
    fn number(&self, field: usize, data: &[u8]) -> f64 {
        let Some(Some((place, factor))) = self.fields.get(field) else { return f64::NAN };
        let number = data.get(place.offset..).and_then(|bytes| place.scalar.read(bytes));
        match number {
            // A division keeps the digits that a factor below one would cost.
            Some(number) if *factor < 1.0 => number / (1.0 / factor).round(),
            Some(number) => number * factor,
            None => f64::NAN,
        }
    }
}

impl Collected {
    /// Everything of use in a log.
    pub fn read(reader: &mut Reader<'_>) -> Self {
        let mut collected = Self::default();
        let mut plans: BTreeMap<u16, Plan> = BTreeMap::new();
        let mut latest_us = 0;
        while let Some(message) = reader.next() {
            match message {
                Message::Data { id, at, data } => {
                    *collected.counts.entry(id).or_default() += 1;
                    let plan = plans.entry(id).or_insert_with(|| plan(reader, id));
                    if let Plan::Values(values) = plan {
                        latest_us = collected.take(values, at, data).unwrap_or(latest_us);
                    }
                }
                Message::Parameter { name, value } => {
                    // What comes after the first data is a change in flight.
                    if collected.counts.is_empty() {
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
        collected
    }

    /// Takes a message; its time.
    fn take(&mut self, plan: &Values, at: usize, data: &[u8]) -> Option<u64> {
        let time_us = data
            .get(plan.time.offset..)
            .and_then(|bytes| bytes.first_chunk())
            .map(|chunk| u64::from_le_bytes(*chunk));
        let (Some(time_us), Ok(stamp)) = (time_us, u32::try_from(self.stamps_us.len())) else {
            self.unstamped += 1;
            return None;
        };
        // The greatest time that a flight may have; beyond all clocks.
        let time_us = time_us.min(9_000_000_000_000_000);
        self.stamps_us.push(time_us);
        self.places.push(at);
        let width = plan.fields.len();
        let group = self.groups.entry((plan.rule, plan.instance)).or_insert_with(|| Group::new(width));
        group.push(stamp, (0..width).map(|field| plan.number(field, data) as f32));
        if let Some(fields) = plan.exact {
            self.exact.insert(stamp, fields.map(|field| plan.number(field, data)));
        }
        Some(time_us)
    }
}

/// How to read the topic of an id.
fn plan(reader: &Reader<'_>, id: u16) -> Plan {
    let Some(subscription) = reader.subscriptions.get(&id).filter(|found| found.instance < MOST_INSTANCES)
    else {
        return Plan::Nothing;
    };
    let topic = subscription.topic.as_str();
    let Some((rule, found)) = RULES.iter().enumerate().find(|(_, rule)| rule.topic == topic) else {
        return Plan::Nothing;
    };
    let Some(time) = reader.formats.find(topic, "timestamp").filter(|place| place.scalar.len() == 8) else {
        return Plan::Nothing;
    };
    let fields = found.fields.iter().map(|field| {
        field.paths.iter().find_map(|(path, factor)| Some((reader.formats.find(topic, path)?, *factor)))
    });
    let exact = super::rules::FIXES.contains(&topic).then_some(super::gps::EXACT);
    Plan::Values(Values { rule, instance: subscription.instance, time, fields: fields.collect(), exact })
}
