//! A model's text with one more effect, otherwise unchanged.

use model::Effect;
use thiserror::Error;
use time::Date;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value, value};

use crate::diagnose::LowPassDelay;

/// Why a model's text cannot be changed.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DocumentError {
    /// It is not TOML.
    #[error("{}", .0.message())]
    Syntax(#[source] toml_edit::TomlError),
    /// Its effects or revisions are neither tables nor an array of inline tables.
    #[error(
        "{0} is neither [[{0}]] tables nor an array of inline tables; write each one as a table below a line [[{0}]]"
    )]
    NotTables(&'static str),
}

/// A revision's errors, besides its effect: root mean square errors in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RevisionErrors {
    /// On the flights learned from, before and after.
    pub learning: [Option<f64>; 2],
    /// On the held-out data, before and after.
    pub held_out: [Option<f64>; 2],
}

/// The text with an effect added, or changed if it was there.
///
/// # Errors
/// See [`DocumentError`].
pub fn with_effect(text: &str, effect: &Effect, date: Date) -> Result<String, DocumentError> {
    let mut document = parse(text)?;
    let id = effect.term.id().name();
    let has_id = |table: &dyn TableLike| table.get("id").and_then(Item::as_str) == Some(id);
    if let Some(array) = inline_tables(&mut document, "effect") {
        let at = array.iter().position(|table| table.as_inline_table().is_some_and(|table| has_id(table)));
        match at.and_then(|at| array.get_mut(at)?.as_inline_table_mut()) {
            Some(table) => fill(table, effect, date),
            None => {
                let mut table = InlineTable::new();
                set(&mut table, "id", id);
                fill(&mut table, effect, date);
                append_inline(array, table);
            }
        }
        return Ok(document.to_string());
    }
    let is_first = !document.contains_key("effect");
    let trailing = take_trailing(&mut document, is_first);
    let effects = tables(&mut document, "effect")?;
    let at = effects.iter().position(|table| has_id(table));
    match at.and_then(|at| effects.get_mut(at)) {
        Some(table) => fill(table, effect, date),
        None => {
            let mut table = Table::new();
            set(&mut table, "id", id);
            fill(&mut table, effect, date);
            append(effects, table, &trailing, text.trim().is_empty());
        }
    }
    Ok(document.to_string())
}

/// The text with a delay defined as a low pass, unless it has that definition.
///
/// # Errors
/// See [`DocumentError`].
pub fn with_low_pass(text: &str, delay: LowPassDelay) -> Result<String, DocumentError> {
    let mut document = parse(text)?;
    let key = "effect_definition";
    let is_it = |table: &dyn TableLike| table.get("id").and_then(Item::as_str) == Some(delay.id);
    if let Some(array) = inline_tables(&mut document, key) {
        if !array.iter().any(|table| table.as_inline_table().is_some_and(|table| is_it(table))) {
            let mut table = InlineTable::new();
            define(&mut table, delay);
            append_inline(array, table);
        }
        return Ok(document.to_string());
    }
    let trailing = take_trailing(&mut document, true);
    let definitions = tables(&mut document, key)?;
    if definitions.iter().any(|table| is_it(table)) {
        return Ok(text.to_owned());
    }
    let mut table = Table::new();
    define(&mut table, delay);
    append(definitions, table, &trailing, text.trim().is_empty());
    Ok(document.to_string())
}

fn define(table: &mut dyn TableLike, delay: LowPassDelay) {
    set(table, "id", delay.id);
    set(table, "on", delay.on);
    set(table, "regressor", LowPassDelay::REGRESSOR);
    set(table, "unit", delay.catalogues.unit());
    set(table, "plausible", Array::from_iter(delay.catalogues.plausible().map(decimal)));
    set(table, "about", format!("{} as a low pass, by `pylon add`", delay.catalogues.name()));
}

/// The text without an effect.
///
/// # Errors
/// See [`DocumentError`].
pub fn without_effect(text: &str, id: &str) -> Result<String, DocumentError> {
    let mut document = parse(text)?;
    let has_id = |table: &dyn TableLike| table.get("id").and_then(Item::as_str) == Some(id);
    if let Some(array) = inline_tables(&mut document, "effect") {
        array.retain(|table| !table.as_inline_table().is_some_and(|table| has_id(table)));
    } else {
        tables(&mut document, "effect")?.retain(|table| !has_id(table));
    }
    Ok(document.to_string())
}

/// The text with one more revision.
///
/// # Errors
/// See [`DocumentError`].
pub fn with_revision(
    text: &str,
    number: u32,
    effect: &Effect,
    date: Date,
    replaced: Option<f32>,
    errors: &RevisionErrors,
) -> Result<String, DocumentError> {
    let mut document = parse(text)?;
    if let Some(array) = inline_tables(&mut document, "revision") {
        let mut table = InlineTable::new();
        fill_revision(&mut table, number, effect, date, replaced, errors);
        append_inline(array, table);
        return Ok(document.to_string());
    }
    let trailing = take_trailing(&mut document, true);
    let mut table = Table::new();
    fill_revision(&mut table, number, effect, date, replaced, errors);
    append(tables(&mut document, "revision")?, table, &trailing, false);
    Ok(document.to_string())
}

fn fill_revision(
    table: &mut dyn TableLike,
    number: u32,
    effect: &Effect,
    date: Date,
    replaced: Option<f32>,
    errors: &RevisionErrors,
) {
    set(table, "number", i64::from(number));
    set(table, "date", datetime(date));
    set(table, "effect", effect.term.id().name());
    if let Some(learned_from) = &effect.learned_from {
        set(table, "learned_from", learned_from.as_str());
    }
    set(table, "coefficient", decimal(effect.term.coefficient));
    set(table, "sigma", decimal(effect.term.sigma));
    set(table, "estimate", effect.estimate);
    put_time_constant(table, effect);
    if let Some(replaced) = replaced {
        set(table, "replaced_coefficient", decimal(replaced));
    }
    let [before, after] = errors.learning;
    let [held_before, held_after] = errors.held_out;
    for (key, metres) in [
        ("rms_before_m", before),
        ("rms_after_m", after),
        ("held_out_before_m", held_before),
        ("held_out_after_m", held_after),
    ] {
        if let Some(metres) = metres {
            set(table, key, (metres * 1e4).round() / 1e4);
        }
    }
}

fn parse(text: &str) -> Result<DocumentMut, DocumentError> {
    text.parse().map_err(DocumentError::Syntax)
}

/// Comments at the text's end, which must stay before a table that is added there.
fn take_trailing(document: &mut DocumentMut, is_at_end: bool) -> String {
    let trailing = document.trailing().as_str().unwrap_or_default().to_owned();
    if is_at_end {
        document.set_trailing("");
        trailing
    } else {
        String::new()
    }
}

/// The array of inline tables, if they are written as one.
fn inline_tables<'a>(document: &'a mut DocumentMut, key: &str) -> Option<&'a mut Array> {
    let is_inline = document.get(key)?.as_array()?.iter().all(Value::is_inline_table);
    if is_inline { document.get_mut(key)?.as_array_mut() } else { None }
}

/// Adds an inline table in the layout of the last one: behind it, or on a line of its own.
fn append_inline(array: &mut Array, mut table: InlineTable) {
    let first = array.iter().next().and_then(|table| table.decor().prefix()?.as_str());
    let indent = first.and_then(|prefix| Some(&prefix[prefix.rfind('\n')?..])).map(str::to_owned);
    // What follows the last one, before the bracket or its comma, may be a comment: it stays there.
    if let Some(last) = array.iter_mut().last() {
        let behind = last.decor().suffix().and_then(|text| text.as_str()).unwrap_or_default().to_owned();
        if !behind.is_empty() {
            last.decor_mut().set_suffix("");
            let trailing = array.trailing().as_str().unwrap_or_default().to_owned();
            array.set_trailing(format!("{behind}{trailing}"));
        }
    }
    let trailing = array.trailing().as_str().unwrap_or_default().to_owned();
    let prefix = match (&indent, array.is_empty()) {
        (Some(indent), _) => {
            // Comments before the bracket stay before the new table.
            let kept = trailing.rfind('\n').map_or("", |end| &trailing[..end]);
            array.set_trailing(trailing.rfind('\n').map_or("\n", |end| &trailing[end..]).to_owned());
            array.set_trailing_comma(true);
            format!("{kept}{indent}")
        }
        (None, true) => String::new(),
        (None, false) => " ".to_owned(),
    };
    table.decor_mut().set_prefix(prefix);
    array.push_formatted(Value::InlineTable(table));
}

/// The `[[key]]` tables, created if there are none.
fn tables<'a>(
    document: &'a mut DocumentMut,
    key: &'static str,
) -> Result<&'a mut ArrayOfTables, DocumentError> {
    let item = document.entry(key).or_insert(Item::ArrayOfTables(ArrayOfTables::new()));
    item.as_array_of_tables_mut().ok_or(DocumentError::NotTables(key))
}

/// Adds a table, with an empty line before it unless it is alone, after the comments at the text's end.
fn append(tables: &mut ArrayOfTables, mut table: Table, trailing: &str, is_alone: bool) {
    let gap = if is_alone { "" } else { "\n" };
    table.decor_mut().set_prefix(format!("{}{gap}", trailing));
    tables.push(table);
}

fn fill(table: &mut dyn TableLike, effect: &Effect, date: Date) {
    let term = &effect.term;
    set(table, "coefficient", decimal(term.coefficient));
    set(table, "sigma", decimal(term.sigma));
    set(table, "estimate", effect.estimate);
    if let Some(learned_from) = &effect.learned_from {
        set(table, "learned_from", learned_from.as_str());
    }
    set(table, "date", datetime(date));
    put_time_constant(table, effect);
    // A learned coefficient belongs to its formula.
    if let Some(parts) = term.id().formula() {
        set(table, "formula", model::fingerprint_text(parts.fingerprint));
    }
    match term.envelope_m {
        Some(envelope_m) => set(table, "envelope_m", Array::from_iter(envelope_m.map(decimal))),
        None => drop(table.remove("envelope_m")),
    }
}

fn put_time_constant(table: &mut dyn TableLike, effect: &Effect) {
    let regressor = &effect.term.regressor;
    if regressor.id.has_time_constant() {
        set(table, "time_constant_s", decimal(regressor.time_constant_s));
        set(table, "since", regressor.since.name());
    }
}

/// Sets a key; a comment after an existing value stays.
fn set(table: &mut dyn TableLike, key: &str, new: impl Into<Value>) {
    match table.get_mut(key) {
        Some(Item::Value(old)) => {
            let decor = old.decor().clone();
            *old = new.into();
            *old.decor_mut() = decor;
        }
        _ => drop(table.insert(key, value(new))),
    }
}

/// The shortest decimal number that equals this one in single precision.
pub(super) fn decimal(single: f32) -> f64 {
    single.to_string().parse().unwrap_or_else(|_| f64::from(single))
}

fn datetime(date: Date) -> toml_edit::Datetime {
    let year = u16::try_from(date.year()).unwrap_or_default();
    let date = toml_edit::Date { year, month: date.month().into(), day: date.day() };
    toml_edit::Datetime { date: Some(date), time: None, offset: None }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use kf_core::effect::{EffectId, EffectTerm};
    use model::Model;
    use time::Month;

    use super::*;

    /// A definition is written once, among tables and among inline tables, and what was there stays.
    #[test]
    fn a_low_pass_is_defined_once() {
        let delay = LowPassDelay::of(EffectId::BaroLag).unwrap();
        let own = "{ id = \"baro.flap\", on = \"baro\", regressor = \"tas_mps\", unit = \"s\", plausible = [0.0, 1.0] }";
        let texts = ["", "# ours\nsettling_s = 5.0\n# end\n", &format!("effect_definition = [{own}]\n")];
        for text in texts {
            let once = with_low_pass(text, delay).unwrap();
            assert_eq!(with_low_pass(&once, delay).unwrap(), once);
            let names: Vec<&str> =
                Model::parse(&once).unwrap().definitions().iter().map(|id| id.name()).collect();
            assert_eq!(names.last(), Some(&"baro.low_pass_lag"), "{once}");
            assert!(!text.starts_with('#') || once.contains("# ours") && once.contains("# end"), "{once}");
        }
    }

    #[test]
    fn an_effect_is_removed_and_the_others_stay() {
        let tables = "[[effect]]\nid = \"baro.lag\"\ncoefficient = 1.0\n\n[[effect]]\nid = \"baro.scale\"\ncoefficient = 0.1\n";
        let inline = "effect = [{ id = \"baro.lag\", coefficient = 1.0 }, { id = \"baro.scale\", coefficient = 0.1 }]\n";
        for text in [tables, inline] {
            let without = Model::parse(&without_effect(text, "baro.lag").unwrap()).unwrap();
            let left: Vec<EffectId> = without.effects.iter().map(|effect| effect.term.id()).collect();
            assert_eq!(left, [EffectId::BaroScale]);
        }
    }

    fn effect(coefficient: f32) -> Effect {
        let term = EffectTerm {
            envelope_m: Some([-0.5, 63.25]),
            ..EffectTerm::new(EffectId::BaroDynamicPressure, coefficient, 0.002)
        };
        Effect { term, estimate: false, learned_from: Some("a.csv".to_owned()), date: None }
    }

    fn day() -> Date {
        Date::from_calendar_date(2026, Month::November, 21).unwrap()
    }

    fn added(text: &str, coefficient: f32) -> String {
        let errors = RevisionErrors { learning: [Some(4.0), Some(1.23456)], held_out: [Some(5.0), None] };
        let with = with_effect(text, &effect(coefficient), day()).unwrap();
        let number = Model::parse(&with).unwrap().next_revision();
        with_revision(&with, number, &effect(coefficient), day(), None, &errors).unwrap()
    }

    #[test]
    fn an_empty_file_gets_the_effect_and_its_revision() {
        let text = added("", 0.06);
        let expected = "\
[[effect]]
id = \"baro.dynamic_pressure\"
coefficient = 0.06
sigma = 0.002
estimate = false
learned_from = \"a.csv\"
date = 2026-11-21
envelope_m = [-0.5, 63.25]

[[revision]]
number = 1
date = 2026-11-21
effect = \"baro.dynamic_pressure\"
learned_from = \"a.csv\"
coefficient = 0.06
sigma = 0.002
estimate = false
rms_before_m = 4.0
rms_after_m = 1.2346
held_out_before_m = 5.0
";
        assert_eq!(text, expected);
        let model = Model::parse(&text).unwrap();
        assert_eq!(model.effects[0].term, effect(0.06).term);
    }

    #[test]
    fn every_line_that_was_there_stays_and_in_its_order() {
        let text = "\
# our aircraft
settling_s = 12   # a slow mother ship

[[effect]]
# of the installation
id = \"baro.lag\"
coefficient = 0.3

[monitor]   # strict
multiplier = 2.5

[[revision]]
number = 4
# the end
";
        let changed = added(text, 0.061);
        let mut rest = changed.lines();
        for line in text.lines() {
            assert!(rest.any(|other| other == line), "{line}\n{changed}");
        }
        let model = Model::parse(&changed).unwrap();
        assert_eq!(model.effects.len(), 2);
        assert_eq!(model.revision_numbers(), [4, 5]);

        // Learned again: the effect's own lines change, the comments behind its values stay.
        let again = changed.replace(
            "coefficient = 0.061\nsigma = 0.002\nest",
            "coefficient = 0.061 # ours\nsigma = 0.002\nest",
        );
        let again = added(&again, 0.0625);
        assert!(again.contains("coefficient = 0.0625 # ours\n"), "{again}");
        let model = Model::parse(&again).unwrap();
        assert_eq!((model.effects.len(), model.effects[1].term.coefficient), (2, 0.0625));
        assert_eq!(model.revisions[1].coefficient, Some(0.061));
    }

    #[test]
    fn comments_of_a_file_without_tables_stay_at_its_head() {
        let changed = added("# our aircraft\n", 0.06);
        assert!(changed.starts_with("# our aircraft\n\n[[effect]]\n"), "{changed}");
    }

    #[test]
    fn inline_tables_stay_inline() {
        let line = "effect = [{ id = \"baro.lag\", coefficient = 0.3 }] # ours\nsettling_s = 12\n";
        let changed = added(line, 0.06);
        assert!(
            changed.starts_with("effect = [{ id = \"baro.lag\", coefficient = 0.3 }, { id = "),
            "{changed}"
        );
        assert!(changed.contains("}] # ours\nsettling_s = 12\n\n[[revision]]\n"), "{changed}");
        assert_eq!(Model::parse(&changed).unwrap().effects.len(), 2);

        let lines = "\
settling_s = 12
effect = [
    # of the installation
    { id = \"baro.lag\", coefficient = 0.3 },  # s
    { id = \"baro.scale\", coefficient = 0.01 }  # of the day
    # the last
]
revision = []
";
        for lines in [lines.to_owned(), lines.replace("}  # of", "},  # of")] {
            let changed = added(&lines, 0.06);
            for comment in ["    # of the installation\n", "},  # s\n", "# of the day\n", "    # the last\n"]
            {
                assert!(changed.contains(comment), "{comment}\n{changed}");
            }
            let added_at = changed.find("\n    { id = \"baro.dynamic_pressure\"").unwrap();
            assert!(added_at > changed.find("# the last").unwrap(), "{changed}");
            let model = Model::parse(&changed).unwrap();
            assert_eq!((model.effects.len(), model.revision_numbers()), (3, vec![1]));
            // Learned again: in its place.
            let again = added(&changed, 0.0625);
            let model = Model::parse(&again).unwrap();
            assert_eq!((model.effects.len(), model.effects[2].term.coefficient), (3, 0.0625));
            assert_eq!(model.revision_numbers(), [1, 2]);
        }
        assert_eq!(Model::parse(&added("effect = []\n", 0.06)).unwrap().effects.len(), 1);
    }
}
