//! Effects by formula, from a model's `[[effect_definition]]` tables.

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

/// Value of `on` for an effect that all sensors have alike.
const EVERY_SENSOR: &str = "every sensor";

/// One `[[effect_definition]]` table.
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
    /// Units of columns that the estimator does not know and whose names do not give a unit.
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

/// The definitions from the tables of a model's text.
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
    // With telemetry's prefix, the longest id that fits into a MAVLink text.
    const LONGEST: usize = 40;
    if id.len() > LONGEST || words.len() != 2 || !words.into_iter().all(is_word) {
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
            // An effect that all sensors have alike is the reference's, with the opposite sign.
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
            let message = "the formula is too long by one operation: an effect on every sensor is computed as the reference's, with the opposite sign";
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

/// A power of two with which the largest plausible coefficient gives about 16 metres: the regressor's size in
/// flight is not known here.
fn typical_regressor_m([least, most]: [f32; 2]) -> f32 {
    let largest = least.abs().max(most.abs());
    let exponent = libm::roundf(libm::log2f(16.0 / largest)).clamp(-10.0, 14.0);
    libm::exp2f(exponent)
}

fn negated(program: &Program) -> Option<Program> {
    let ops: Vec<Op> = program.ops().iter().copied().chain([Op::Negate]).collect();
    // Unused masks are 0 and harmless.
    Program::new(&ops, program.masks())
}

/// The tree with every id replaced by its definition. An unknown id stays, and is refused when the tree is
/// compiled.
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

/// A tree of another text, with all its spans at the place in this text that named it.
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

/// Every definition that this process has seen: an effect's id is a reference to one, so it must live on.
static DEFINITIONS: Mutex<Vec<&'static Definition>> = Mutex::new(Vec::new());

/// The definition of these parts, the same one for equal parts; a process keeps some kilobyte for each that
/// it has read.
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

/// A text with static lifetime, the same one for equal texts.
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Board, Model, codegen};

    const FLAP: &str = "[[effect_definition]]\nid = \"baro.flap_wash\"\non = \"baro\"\nregressor = \"tas_mps^2 / (2*g) * flap\"\nplausible = [-0.5, 0.5]\n";

    fn refused(text: &str) -> String {
        Model::parse(text).unwrap_err().to_string()
    }

    fn with(from: &str, to: &str) -> String {
        assert!(FLAP.contains(from));
        FLAP.replace(from, to)
    }

    #[test]
    fn a_definition_is_an_effect_of_its_model_alone() {
        let model = Model::parse(FLAP).unwrap();
        let id = model.effect_named("baro.flap_wash").unwrap();
        assert_eq!((id.unit(), id.needs(), id.plausible()), ("1", &["tas_mps", "flap"][..], [-0.5, 0.5]));
        assert_eq!(id.typical_regressor_m(), 32.0);
        assert_eq!(Model::default().effect_named("baro.flap_wash"), None);
        // The same again is the same effect; another formula is a different one.
        assert_eq!(Model::parse(FLAP).unwrap().definitions(), [id]);
        assert_ne!(Model::parse(&with("2*g", "3*g")).unwrap().definitions(), [id]);
        assert_eq!(model.catalogue().count(), 23);
    }

    #[test]
    fn what_can_be_no_definition_is_refused_with_its_row() {
        for (text, said) in [
            (with("baro.flap_wash", "flap"), "row 2: effect_definition id 'flap', expected two words"),
            (with("baro.flap_wash", &format!("baro.{}", "a".repeat(36))), "and no more than 40 of them"),
            (
                with("baro.flap_wash", "baro.lag"),
                "row 2: effect_definition 'baro.lag' has the id of an effect of the catalogue",
            ),
            (
                format!("{FLAP}{FLAP}"),
                "row 7: effect_definition 'baro.flap_wash' has the id of another definition",
            ),
            (with("on = \"baro\"", "on = \"barro\""), "row 3: on = 'barro' is not a sensor; nearest: baro"),
            (with("/ (2*g)", "/ (2*"), "row 4: the regressor of effect_definition baro.flap_wash:"),
            (with("* flap", ""), "plausible"),
            (
                with("plausible = [-0.5, 0.5]", "plausible = [0.5, -0.5]"),
                "plausible of effect_definition baro.flap_wash is [0.5, -0.5]",
            ),
            (
                with("plausible", "unit = \"1/s\"\nplausible"),
                "times a coefficient in 1/s that is m/s, expected metres; its unit would be 1",
            ),
            (
                with("plausible", "units = { flap = \"furlong\" }\nplausible"),
                "units.flap of effect_definition baro.flap_wash",
            ),
            (
                with("* flap", "* baro.flap_wash"),
                "baro.flap_wash -> baro.flap_wash refer to each other in a circle",
            ),
            (
                format!("{FLAP}[[effect]]\nid = \"baro.flap_wosh\"\ncoefficient = 1\n"),
                "nearest: baro.flap_wash",
            ),
        ] {
            if said == "plausible" {
                assert!(Model::parse(&text).is_ok());
                continue;
            }
            assert!(refused(&text).contains(said), "{text}\n{}", refused(&text));
        }
        let two = "[[effect_definition]]\nid = \"a.x\"\non = \"baro\"\nregressor = \"1[m] + b.y\"\nplausible = [-1, 1]\n\
                   [[effect_definition]]\nid = \"b.y\"\non = \"baro\"\nregressor = \"2 * a.x\"\nplausible = [-1, 1]\n";
        assert!(refused(two).contains("a.x -> b.y -> a.x"), "{}", refused(two));
    }

    #[test]
    fn one_definition_may_name_another_and_the_catalogue() {
        let named = format!(
            "{FLAP}[[effect_definition]]\nid = \"baro.two\"\non = \"every sensor\"\nregressor = \"baro.flap_wash + baro.dynamic_pressure * flap\"\nplausible = [-1, 1]\n"
        );
        let model = Model::parse(&named).unwrap();
        let id = model.effect_named("baro.two").unwrap();
        assert_eq!(id.subject().name(), "gps");
        // The definitions that it uses are part of it.
        let changed = Model::parse(&named.replace("2*g", "3*g")).unwrap();
        assert_ne!(changed.effect_named("baro.two").unwrap(), id);
    }

    #[test]
    fn a_learned_coefficient_belongs_to_its_formula() {
        let model = Model::parse(FLAP).unwrap();
        let now = crate::fingerprint_text(model.definitions()[0].formula().unwrap().fingerprint);
        let learned = |text: &str, formula: &str| {
            format!(
                "{text}[[effect]]\nid = \"baro.flap_wash\"\ncoefficient = 0.3\nlearned_from = \"a.csv\"\n{formula}"
            )
        };
        let formula = format!("formula = \"{now}\"\n");
        assert!(Model::parse(&learned(FLAP, &formula)).is_ok());
        // A different layout is not a change.
        assert!(Model::parse(&learned(&with("2*g", " 2 * (g) "), &formula)).is_ok());
        let said = refused(&learned(&with("2*g", "2.5*g"), &formula));
        assert!(said.contains("was learned for another formula") && said.contains(&now), "{said}");
        let said = refused(&learned(FLAP, ""));
        assert!(said.contains(&format!("add formula = \"{now}\"")), "{said}");
        assert!(
            refused("[[effect]]\nid = \"baro.lag\"\ncoefficient = 1\nformula = \"ab\"\n")
                .contains("the catalogue's")
        );
    }

    #[test]
    fn a_board_flies_what_it_measures() {
        let flown = |regressor: &str| {
            let text = with("tas_mps^2 / (2*g) * flap", regressor)
                + "[[effect]]\nid = \"baro.flap_wash\"\ncoefficient = 0.3\n";
            Model::parse(&text).unwrap()
        };
        let lacks = |regressor: &str, board| {
            flown(regressor).check_signals(board).err().map(|error| error.to_string())
        };
        assert!(
            lacks("flap * tas_mps^2/g", Board::Recorded)
                .unwrap()
                .contains("baro.flap_wash reads flap, which")
        );
        assert!(lacks("flap * tas_mps^2/g", Board::F405).unwrap().contains("reads tas_mps, flap, which"));
        assert_eq!(lacks("throttle * tas_mps^2/g", Board::Recorded), None);
        assert!(lacks("throttle * airspeed_mps^2/g", Board::F405).unwrap().contains("reads throttle, which"));
        assert_eq!(lacks("load_factor * airspeed_mps^2/g", Board::F405), None);
        // Only the effects that the model accounts for fly.
        assert!(Model::parse(FLAP).unwrap().check_signals(Board::F405).is_ok());
        let source = codegen(&flown("throttle * tas_mps^2/g")).unwrap();
        assert!(source.contains("Defined(&DEFINITION_0)") && source.contains("Op::Power(2)"), "{source}");
    }

    #[test]
    fn formulas_that_remember_too_much_are_refused() {
        let delayed = |name: &str| {
            with("baro.flap_wash", name).replace("* flap", "* delay(throttle, 1) * delay(throttle, 2)")
                + &format!("[[effect]]\nid = \"{name}\"\ncoefficient = 0.3\n")
        };
        let text: String = ["a.a", "a.b", "a.c"].map(delayed).concat();
        assert!(
            refused(&text).contains("store 126 numbers; with 0 estimated effects a restart keeps at most 82"),
            "{}",
            refused(&text)
        );
    }
}
