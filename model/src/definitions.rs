//! Effects by formula, of a model's `[[effect_definition]]` tables.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use kf_core::effect::{Definition, EffectId, EffectSubject, Parts};
use kf_core::formula::{Op, Program};
use kf_core::sensor::Sensor;
use serde::Deserialize;
use toml::Spanned;

use crate::ModelError;
use crate::file::{nearest, row_and_column};
use crate::formula::{Columns, Dimension, Expression, Formula, FormulaError, Kind, of_catalogue, parse};

/// What `on` says for an effect that every sensor has alike.
const EVERY_SENSOR: &str = "every sensor";

/// An `[[effect_definition]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DefinitionTable {
    id: Spanned<String>,
    on: Spanned<String>,
    regressor: Spanned<String>,
    #[serde(default = "plain")]
    unit: String,
    plausible: [f32; 2],
    about: Option<String>,
    /// Units of columns that neither the estimator knows nor their names say.
    #[serde(default)]
    units: BTreeMap<String, String>,
}

fn plain() -> String {
    "1".to_owned()
}

/// A model's effects by formula, and the columns that they read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Definitions {
    pub(crate) effects: Vec<EffectId>,
    pub(crate) columns: Columns,
}

/// The definitions of the tables of a model's text.
pub(crate) fn definitions(tables: &[DefinitionTable], text: &str) -> Result<Definitions, ModelError> {
    let mut trees = BTreeMap::new();
    for table in tables {
        let id = table.id.get_ref().as_str();
        check_id(table, tables, text)?;
        let tree = parse(table.regressor.get_ref()).map_err(|error| table.wrong(error, text))?;
        trees.insert(id, tree);
    }
    let mut columns = Columns::default();
    for table in tables {
        for (name, unit) in &table.units {
            let dimension = Dimension::of_unit(unit).ok_or_else(|| ModelError::Value {
                key: format!("units.{name} of effect_definition {}", table.id.get_ref()),
                found: format!("'{unit}'"),
                expected: "a product of m, s, K, Pa, rad and 1, such as m/s^2",
            })?;
            if !columns.declare(name, dimension) {
                return Err(ModelError::Value {
                    key: format!("units.{name} of effect_definition {}", table.id.get_ref()),
                    found: format!("'{unit}'"),
                    expected: "the unit that another definition has for it, and no more than 8 columns in all",
                });
            }
        }
    }
    let mut effects = Vec::with_capacity(tables.len());
    for table in tables {
        effects.push(table.effect(&trees, &mut columns, text)?);
    }
    Ok(Definitions { effects, columns })
}

fn check_id(table: &DefinitionTable, tables: &[DefinitionTable], text: &str) -> Result<(), ModelError> {
    let id = table.id.get_ref();
    let (row, _) = row_and_column(text, table.id.span().start);
    let is_word = |word: &str| {
        word.starts_with(|c: char| c.is_ascii_lowercase())
            && word.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    let words: Vec<&str> = id.split('.').collect();
    if words.len() != 2 || !words.into_iter().all(is_word) {
        return Err(ModelError::DefinitionId { row, id: id.clone() });
    }
    if EffectId::from_name(id).is_some() {
        return Err(ModelError::DefinitionClash { row, id: id.clone(), with: "an effect of the catalogue" });
    }
    let is_later =
        |other: &&DefinitionTable| other.id.get_ref() == id && other.id.span().start < table.id.span().start;
    if tables.iter().any(|other| is_later(&other)) {
        return Err(ModelError::DefinitionClash { row, id: id.clone(), with: "another definition above it" });
    }
    Ok(())
}

impl DefinitionTable {
    fn wrong(&self, error: FormulaError, text: &str) -> ModelError {
        let (row, _) = row_and_column(text, self.regressor.span().start);
        ModelError::Formula { row, id: self.id.get_ref().clone(), error: Box::new(error) }
    }

    fn subject(&self, text: &str) -> Result<(EffectSubject, bool), ModelError> {
        let on = self.on.get_ref().as_str();
        let sensor = Sensor::ALL.into_iter().find(|sensor| sensor.name() == on);
        match (on, sensor) {
            (_, Some(sensor)) => Ok((EffectSubject::Sensor(sensor), false)),
            ("gps", _) => Ok((EffectSubject::Gps, false)),
            // What every sensor has alike is the reference's, with the opposite sign.
            (EVERY_SENSOR, _) => Ok((EffectSubject::Gps, true)),
            _ => {
                let (row, _) = row_and_column(text, self.on.span().start);
                let known = ["baro", "imu_slave", "imu_master", "gps", EVERY_SENSOR];
                Err(ModelError::DefinitionOn { row, on: on.to_owned(), nearest: nearest(on, &known) })
            }
        }
    }

    fn effect(
        &self,
        trees: &BTreeMap<&str, Expression>,
        columns: &mut Columns,
        text: &str,
    ) -> Result<EffectId, ModelError> {
        let id = self.id.get_ref().as_str();
        let law = self.regressor.get_ref().as_str();
        let (subject, is_negative) = self.subject(text)?;
        let mut path = vec![id.to_owned()];
        let tree = match trees.get(id) {
            Some(tree) => inlined(tree, trees, &mut path).map_err(|cycle| {
                let (row, _) = row_and_column(text, self.regressor.span().start);
                ModelError::Cycle { row, path: cycle.join(" -> ") }
            })?,
            None => parse(law).map_err(|error| self.wrong(error, text))?,
        };
        let formula = Formula::of_expression(law, &tree, columns).map_err(|error| self.wrong(error, text))?;
        formula.check_unit(&self.unit).map_err(|error| self.wrong(error, text))?;
        let [least, most] = self.plausible;
        if !(least.is_finite() && most.is_finite() && least < most) {
            return Err(ModelError::Value {
                key: format!("plausible of effect_definition {id}"),
                found: format!("[{least}, {most}]"),
                expected: "two finite numbers, the smaller first",
            });
        }
        let program = if is_negative { negated(formula.program()) } else { Some(*formula.program()) };
        let Some(program) = program else {
            let whole = 0..law.len();
            let message = "the formula is too long by one operation: what every sensor has is the reference's, with the opposite sign";
            let error = FormulaError { message: message.to_owned(), span: whole, text: law.to_owned() };
            return Err(self.wrong(error, text));
        };
        let unit = Dimension::of_unit(&self.unit).unwrap_or(Dimension::ONE).to_string();
        let fingerprint = formula.fingerprint(columns, &[self.on.get_ref(), &unit]);
        let mut needs: Vec<&'static str> = Vec::new();
        let of_signals = formula.signals().iter().flat_map(|signal| signal.needs()).copied();
        for need in of_signals.chain(formula.columns().iter().map(|name| leaked(name))) {
            if !needs.contains(&need) {
                needs.push(need);
            }
        }
        Ok(EffectId::Defined(interned(Parts {
            name: leaked(id),
            subject,
            unit: leaked(&unit),
            needs: needs.leak(),
            plausible: self.plausible,
            typical_regressor_m: typical_regressor_m(self.plausible),
            program,
            law: leaked(law),
            about: leaked(self.about.as_deref().unwrap_or_default()),
            fingerprint,
        })))
    }
}

/// A power of two with which the largest plausible coefficient makes some 16 metres: what the regressor is in flight is not known here.
fn typical_regressor_m([least, most]: [f32; 2]) -> f32 {
    let largest = least.abs().max(most.abs());
    let exponent = libm::roundf(libm::log2f(16.0 / largest)).clamp(-10.0, 14.0);
    libm::exp2f(exponent)
}

fn negated(program: &Program) -> Option<Program> {
    let ops: Vec<Op> = program.ops().iter().copied().chain([Op::Negate]).collect();
    // Masks that are not used are 0, and do no harm.
    Program::new(&ops, program.masks())
}

/// The tree with what it names by id put in its place; what is not there stays, and is refused when it is compiled.
fn inlined(
    tree: &Expression,
    trees: &BTreeMap<&str, Expression>,
    path: &mut Vec<String>,
) -> Result<Expression, Vec<String>> {
    let boxed = |inner: &Expression, path: &mut Vec<String>| inlined(inner, trees, path).map(Box::new);
    let kind = match &tree.kind {
        Kind::Name(name) if name.contains('.') => {
            if path.iter().any(|above| above == name) {
                path.push(name.clone());
                return Err(path.clone());
            }
            let of_catalogue = EffectId::from_name(name).and_then(of_catalogue);
            let named = of_catalogue.and_then(|law| parse(law).ok());
            let Some(named) = trees.get(name.as_str()).or(named.as_ref()) else { return Ok(tree.clone()) };
            path.push(name.clone());
            let inner = inlined(named, trees, path)?;
            path.pop();
            return Ok(placed(inner, tree));
        }
        Kind::Negative(inner) => Kind::Negative(boxed(inner, path)?),
        Kind::Binary(operator, left, right) => {
            Kind::Binary(*operator, boxed(left, path)?, boxed(right, path)?)
        }
        Kind::Call(function, arguments) => {
            let arguments = arguments.iter().map(|argument| inlined(argument, trees, path));
            Kind::Call(*function, arguments.collect::<Result<_, _>>()?)
        }
        other => other.clone(),
    };
    Ok(Expression { kind, span: tree.span.clone() })
}

/// A tree of another text, all of it where it was named in this one.
fn placed(tree: Expression, at: &Expression) -> Expression {
    let boxed = |inner: Box<Expression>| Box::new(placed(*inner, at));
    let kind = match tree.kind {
        Kind::Negative(inner) => Kind::Negative(boxed(inner)),
        Kind::Binary(operator, left, right) => Kind::Binary(operator, boxed(left), boxed(right)),
        Kind::Call(function, arguments) => {
            Kind::Call(function, arguments.into_iter().map(|argument| placed(argument, at)).collect())
        }
        other => other,
    };
    Expression { kind, span: at.span.clone() }
}

/// Every definition that this process has seen: an effect's id is a reference to one, which must stay.
static DEFINITIONS: Mutex<Vec<&'static Definition>> = Mutex::new(Vec::new());

/// The definition of these parts, always the same for the same; a process keeps some kilobyte for each that it has read.
fn interned(parts: Parts) -> &'static Definition {
    let mut known = DEFINITIONS.lock().unwrap_or_else(PoisonError::into_inner);
    let same = |there: &&&'static Definition| {
        let there = there.parts();
        (there.name, there.fingerprint, there.unit, there.law, there.about, there.plausible)
            == (parts.name, parts.fingerprint, parts.unit, parts.law, parts.about, parts.plausible)
            && there.program == parts.program
            && there.subject == parts.subject
    };
    if let Some(there) = known.iter().find(same) {
        return there;
    }
    let has_time_constant = parts.program.has_time_constant();
    let new: &'static Definition = Box::leak(Box::new(Definition::new(parts, has_time_constant)));
    known.push(new);
    new
}

/// A text that stays, always the same for the same.
fn leaked(text: &str) -> &'static str {
    static TEXTS: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
    let mut known = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(there) = known.iter().find(|there| **there == text) {
        return there;
    }
    let new: &'static str = Box::leak(text.to_owned().into_boxed_str());
    known.push(new);
    new
}
