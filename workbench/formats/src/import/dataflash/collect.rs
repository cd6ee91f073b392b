//! Collects messages into groups of values.

use std::collections::BTreeMap;

use super::format::{Layout, Message, has_scale, is_integer};
use super::rules::{FieldRule, GPS, RULES, Rule, Target};
use super::units::{Scale, Units};
use crate::import::stamps::NO_TIME;
use crate::import::table::Group;
use flight_data::Channel;

/// Largest number of instances of one kind of message; a greater number is damage.
const MOST_INSTANCES: f64 = 8.0;
/// Largest microseconds that an f64 holds as a whole number.
const LARGEST_TIME_US: f64 = 9.0e15;

/// A message of the receiver, with its numbers in the order of [`GPS`]'s fields.
#[derive(Clone, Copy, Debug)]
pub struct GpsMessage {
    pub stamp: u32,
    pub instance: u8,
    pub numbers: [f64; 11],
}

/// All useful data of a log.
#[derive(Debug, Default)]
pub struct Collected {
    /// Time of each used message, microseconds of the autopilot's clock, in the log's order; [`NO_TIME`]
    /// where it has none.
    pub stamps_us: Vec<u64>,
    /// Byte or line of each used message.
    pub places: Vec<usize>,
    /// Messages by rule and instance.
    pub groups: BTreeMap<(usize, u8), Group>,
    /// The receivers' messages.
    pub gps: Vec<GpsMessage>,
    /// Parameters, with the last value of each.
    pub parameters: BTreeMap<String, f64>,
    /// The autopilot's name as it reports it.
    pub firmware: Option<String>,
    /// Messages of each layout.
    pub counts: Vec<usize>,
    /// Whether each layout is used.
    pub is_used: Vec<bool>,
    /// Values that are not finite.
    pub not_finite: usize,
    /// Messages with an instance that no autopilot has.
    pub bad_instances: usize,
    /// Fields with a unit of another quantity, each once.
    pub other_units: Vec<String>,
    units: Units,
    plans: Vec<Option<Plan>>,
}

/// How to handle messages of a layout.
#[derive(Clone, Debug)]
enum Plan {
    Nothing,
    Values(Values),
    Parameter { name: usize, value: usize },
    Firmware { text: usize },
    FieldUnits { kind: usize, units: usize, multipliers: usize },
    Unit { id: usize, label: usize },
    Multiplier { id: usize, value: usize },
}

/// A rule applied to a layout.
#[derive(Clone, Debug)]
struct Values {
    /// Its index among the rules; `None` for the receiver's.
    rule: Option<usize>,
    first_instance: u8,
    instance_field: Option<usize>,
    /// Index of the time field, and microseconds a unit.
    time: Option<(usize, f64)>,
    /// For each of the rule's fields: index and factor, if the layout has the field.
    fields: Vec<Option<(usize, f64)>>,
}

impl Collected {
    /// Adds a message and returns whether its numbers could be read.
    pub fn take(&mut self, layouts: &[Layout], message: &Message<'_>) -> bool {
        let Some(layout) = layouts.get(message.layout) else { return false };
        // Definitions were read before.
        if layout.name == "FMT" {
            return true;
        }
        self.counts.resize(layouts.len(), 0);
        self.is_used.resize(layouts.len(), false);
        self.plans.resize(layouts.len(), None);
        if let Some(count) = self.counts.get_mut(message.layout) {
            *count += 1;
        }
        let plan = match self.plans.get_mut(message.layout).and_then(Option::take) {
            Some(plan) => plan,
            None => self.plan(layout),
        };
        if let Some(used) = self.is_used.get_mut(message.layout) {
            *used = !matches!(plan, Plan::Nothing);
        }
        let done = self.follow(&plan, layout, message);
        // A message of units may have changed how this kind is read.
        if let Some(slot) = self.plans.get_mut(message.layout) {
            *slot = Some(plan);
        }
        if let Some(kind) = done.1 {
            for (plan, layout) in self.plans.iter_mut().zip(layouts) {
                if layout.kind == kind {
                    *plan = None;
                }
            }
        }
        done.0
    }

    fn follow(&mut self, plan: &Plan, layout: &Layout, message: &Message<'_>) -> (bool, Option<u8>) {
        let number = |index: usize| message.number(layout, index);
        let text = |index: usize| message.text(layout, index);
        let letter = |index| number(index).and_then(|id| char::from_u32(id as u32));
        let mut of_kind = None;
        let is_read = match plan {
            Plan::Nothing => true,
            Plan::Values(values) => return (self.values(values, layout, message), None),
            Plan::Parameter { name, value } => match (text(*name), number(*value)) {
                (Some(name), Some(value)) => {
                    let is_name = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
                    let is_good = !name.is_empty() && name.chars().all(is_name);
                    if is_good {
                        self.parameters.insert(name, value);
                    }
                    is_good
                }
                _ => false,
            },
            Plan::Firmware { text: field } => {
                let said = text(*field).unwrap_or_default();
                self.firmware_text(&said);
                true
            }
            Plan::FieldUnits { kind, units, multipliers } => {
                match (number(*kind), text(*units), text(*multipliers)) {
                    (Some(kind), Some(units), Some(multipliers)) => {
                        of_kind = Some(kind as u8);
                        self.units.of_type(kind as u8, &units, &multipliers);
                        true
                    }
                    _ => false,
                }
            }
            Plan::Unit { id, label } => match (letter(*id), text(*label)) {
                (Some(id), Some(label)) => {
                    self.units.label(id, label);
                    true
                }
                _ => false,
            },
            Plan::Multiplier { id, value } => match (letter(*id), number(*value)) {
                (Some(id), Some(value)) => {
                    self.units.multiplier(id, value);
                    true
                }
                _ => false,
            },
        };
        (is_read, of_kind)
    }

    /// Keeps a text if it is the autopilot's name.
    pub fn firmware_text(&mut self, said: &str) {
        let is_name = ["Ardu", "APM", "Blimp", "AntennaTracker", "Rover V", "Copter V", "Plane V"]
            .iter()
            .any(|name| said.starts_with(name));
        if self.firmware.is_none() && is_name {
            self.firmware = Some(said.chars().filter(|letter| !letter.is_control()).collect());
        }
    }

    fn plan(&mut self, layout: &Layout) -> Plan {
        let field = |name| layout.field(&[name]);
        let plan = match layout.name.as_str() {
            "PARM" => field("Name").zip(field("Value")).map(|(name, value)| Plan::Parameter { name, value }),
            "MSG" => layout.field(&["Message", "Msg"]).map(|text| Plan::Firmware { text }),
            "VER" => field("FWS").map(|text| Plan::Firmware { text }),
            "FMTU" => field("FmtType")
                .zip(field("UnitIds"))
                .zip(field("MultIds"))
                .map(|((kind, units), multipliers)| Plan::FieldUnits { kind, units, multipliers }),
            "UNIT" => field("Id").zip(field("Label")).map(|(id, label)| Plan::Unit { id, label }),
            "MULT" => field("Id").zip(field("Mult")).map(|(id, value)| Plan::Multiplier { id, value }),
            name => {
                let of_name = |rule: &Rule| {
                    rule.messages.iter().find_map(|(known, first)| (*known == name).then_some(*first))
                };
                let rules = RULES.iter().enumerate().map(|(place, rule)| (Some(place), rule));
                std::iter::once((None, &GPS))
                    .chain(rules)
                    .find_map(|(place, rule)| Some((place, rule, of_name(rule)?)))
                    .map(|(place, rule, first)| Plan::Values(self.values_plan(layout, place, rule, first)))
            }
        };
        plan.unwrap_or(Plan::Nothing)
    }

    fn values_plan(
        &mut self,
        layout: &Layout,
        place: Option<usize>,
        rule: &Rule,
        first_instance: u8,
    ) -> Values {
        let first = layout.fields.first().map(|field| field.name.as_str());
        let time = match first {
            Some("TimeUS") => Some((0, 1.0)),
            // In a receiver's message this field is the receiver's time.
            Some("TimeMS") if place.is_some() => Some((0, 1_000.0)),
            _ if place.is_none() => layout.field(&["T"]).map(|field| (field, 1_000.0)),
            _ => None,
        };
        let named = || {
            let found = layout.field(&["I", "C"])?;
            layout.fields.get(found).filter(|field| field.letter == b'B' && found <= 1).map(|_| found)
        };
        let instance_field = self.units.instance_field(layout.kind).or_else(named);
        let fields = rule.fields.iter().map(|wanted| {
            let index = layout.field(wanted.names)?;
            self.factor(layout, index, wanted).map(|factor| (index, factor))
        });
        let fields = fields.collect();
        Values { rule: place, first_instance, instance_field, time, fields }
    }

    /// Factor from a field's unit to the flight's.
    fn factor(&mut self, layout: &Layout, index: usize, rule: &FieldRule) -> Option<f64> {
        let field = layout.fields.get(index)?;
        if rule.target == Target::Throttle {
            let is_plane = layout.field(&["NavRoll"]).is_some() || layout.name == "THR";
            let is_old_copter = is_integer(field.letter) && !is_plane;
            return Some(match () {
                () if is_plane || self.units.is_percent(layout.kind, index) => 0.01,
                () if is_old_copter => 0.001,
                () => 1.0,
            });
        }
        match self.units.scale(layout.kind, index, has_scale(field.letter), rule.quantity) {
            Scale::By(factor) => Some(factor),
            Scale::Unsaid => Some(rule.factor),
            Scale::Other(unit) => {
                let text = format!("{}.{} is in {unit}", layout.name, field.name);
                if !self.other_units.contains(&text) {
                    self.other_units.push(text);
                }
                None
            }
        }
    }

    fn values(&mut self, plan: &Values, layout: &Layout, message: &Message<'_>) -> bool {
        let instance = match plan.instance_field.map(|field| message.number(layout, field)) {
            None => 0.0,
            Some(Some(instance)) => instance,
            Some(None) => return false,
        };
        if !(0.0..MOST_INSTANCES).contains(&instance) {
            self.bad_instances += 1;
            return true;
        }
        let instance = plan.first_instance.saturating_add(instance as u8);
        let mut numbers = [f64::NAN; 16];
        let mut not_finite = 0;
        for (slot, field) in numbers.iter_mut().zip(&plan.fields) {
            let Some((index, factor)) = field else { continue };
            match message.number(layout, *index).map(|number| number * factor) {
                Some(number) if number.is_finite() => *slot = number,
                Some(_) => not_finite += 1,
                None => return false,
            }
        }
        let time_us = match plan.time {
            None => NO_TIME,
            Some((field, unit)) => match message.number(layout, field).map(|time| time * unit) {
                // Beyond all clocks, and so later than its neighbours.
                Some(time_us) => time_us.clamp(0.0, LARGEST_TIME_US) as u64,
                None => return false,
            },
        };
        self.not_finite += not_finite;
        let Ok(stamp) = u32::try_from(self.stamps_us.len()) else { return false };
        self.stamps_us.push(time_us);
        self.places.push(message.place);
        match plan.rule {
            None => {
                let mut fix = GpsMessage { stamp, instance, numbers: [f64::NAN; 11] };
                fix.numbers.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number);
                self.gps.push(fix);
            }
            Some(rule) => {
                let targets = RULES.get(rule).map_or(&[][..], |rule| rule.fields);
                for (number, field) in numbers.iter_mut().zip(targets) {
                    if field.target == Target::Channel(Channel::YawRad) {
                        *number = half_turn(*number);
                    }
                }
                let width = plan.fields.len();
                let group = self.groups.entry((rule, instance)).or_insert_with(|| Group::new(width));
                group.push(stamp, numbers.iter().map(|number| *number as f32));
            }
        }
        true
    }
}

/// An angle between half a turn below zero and half a turn above.
fn half_turn(angle_rad: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle_rad - turn * (angle_rad / turn).round()
}
