//! A law made an effect definition of a model.

use thiserror::Error;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, value};

use super::discovery::FoundLaw;

/// How far beyond what was found nature is taken to keep the coefficient, either way.
const PLAUSIBLE: f64 = 3.0;

/// Why a model's text cannot take a definition.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DefinitionError {
    /// It is not TOML.
    #[error("{0}")]
    Syntax(#[source] toml_edit::TomlError),
    /// The id is there already.
    #[error("{0} is defined in it already; choose another id")]
    Taken(String),
    /// The definitions are no tables.
    #[error(
        "effect_definition is not an [[effect_definition]] table; write each one as a table below such a line"
    )]
    NotTables,
}

/// An id for a law: what it acts on, and the signals in it.
#[must_use]
pub fn id(law: &FoundLaw, signals: &[String]) -> String {
    let is_in = |signal: &&String| {
        let mut words = law.regressor.split(|letter: char| !letter.is_ascii_alphanumeric() && letter != '_');
        words.any(|word| word == signal.as_str())
    };
    let on = match &*law.on {
        "imu_slave" | "imu_master" => "imu",
        other => other,
    };
    let used: Vec<&str> = signals.iter().filter(is_in).map(String::as_str).collect();
    format!("{on}.{}", used.join("_by_").to_ascii_lowercase())
}

/// An effect by formula, as an `[[effect_definition]]` says it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewDefinition<'a> {
    /// Its id: two words with a dot between.
    pub id: &'a str,
    /// What it acts on: a sensor, `gps`, or `every sensor`.
    pub on: &'a str,
    /// The formula.
    pub regressor: &'a str,
    /// Unit of the coefficient.
    pub unit: &'a str,
    /// The largest plausible coefficient, either way.
    pub largest: f64,
    /// What it is, in words; empty: nothing is said.
    pub about: &'a str,
}

/// The range of a coefficient that was found: how far either way nature is taken to keep it. Two digits are
/// enough for a range.
#[must_use]
pub fn largest_plausible(coefficient: f64) -> f64 {
    let largest = PLAUSIBLE * coefficient.abs();
    format!("{largest:.1e}").parse().unwrap_or(largest)
}

/// The text with a law as an effect definition at its end, everything else in it as it was.
///
/// # Errors
/// See [`DefinitionError`].
pub fn with_definition(text: &str, id: &str, law: &FoundLaw) -> Result<String, DefinitionError> {
    let about = format!("a law that pylon discover proposed, with a probability of {:.2}", law.probability);
    let new = NewDefinition {
        id,
        on: &law.on,
        regressor: &law.regressor,
        unit: &law.unit,
        largest: largest_plausible(law.coefficient),
        about: &about,
    };
    with_new_definition(text, &new)
}

/// The text with an effect definition at its end, everything else in it as it was.
///
/// # Errors
/// See [`DefinitionError`].
pub fn with_new_definition(text: &str, new: &NewDefinition<'_>) -> Result<String, DefinitionError> {
    let document: DocumentMut = text.parse().map_err(DefinitionError::Syntax)?;
    if let Some(definitions) = document.get("effect_definition") {
        let definitions = definitions.as_array_of_tables().ok_or(DefinitionError::NotTables)?;
        if definitions.iter().any(|table| table.get("id").and_then(Item::as_str) == Some(new.id)) {
            return Err(DefinitionError::Taken(new.id.to_owned()));
        }
    }
    let mut table = Table::new();
    table.insert("id", value(new.id));
    table.insert("on", value(new.on));
    table.insert("regressor", value(new.regressor));
    table.insert("unit", value(new.unit));
    let mut plausible = Array::new();
    plausible.extend([-new.largest, new.largest]);
    table.insert("plausible", value(plausible));
    if !new.about.is_empty() {
        table.insert("about", value(new.about));
    }
    let mut definitions = ArrayOfTables::new();
    definitions.push(table);
    let mut added = DocumentMut::new();
    added.insert("effect_definition", Item::ArrayOfTables(definitions));
    // Behind the text rather than into its document: a comment at the text's end stays where it is.
    let gap = match text {
        "" => "",
        text if text.ends_with('\n') => "\n",
        _ => "\n\n",
    };
    Ok(format!("{text}{gap}{added}"))
}
