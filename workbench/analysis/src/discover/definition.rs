//! Turns a law into an effect definition of a model.

use thiserror::Error;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, value};

use super::discovery::FoundLaw;

/// Factor by which the physical range exceeds the coefficient that was found, either way.
const PLAUSIBLE: f64 = 3.0;

/// Why a model's text cannot take a definition.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DefinitionError {
    /// It is not TOML.
    #[error("{0}")]
    Syntax(#[source] toml_edit::TomlError),
    /// The id exists already.
    #[error("{0} is already defined; choose another id")]
    Taken(String),
    /// The definitions are not tables.
    #[error(
        "effect_definition is not an [[effect_definition]] table; write each one as a table below such a line"
    )]
    NotTables,
}

/// An id for a law: what it acts on, and its signals.
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

/// An effect by formula, as an `[[effect_definition]]` contains it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewDefinition<'a> {
    /// Its id: two words separated by a dot.
    pub id: &'a str,
    /// What it acts on: a sensor, `gps`, or `every sensor`.
    pub on: &'a str,
    /// The formula.
    pub regressor: &'a str,
    /// Unit of the coefficient.
    pub unit: &'a str,
    /// The largest plausible coefficient, either way.
    pub largest: f64,
    /// A description; empty if there is none.
    pub about: &'a str,
}

/// The range of a coefficient that was found: the largest one taken to be physical, either way. Two digits
/// are enough for a range.
#[must_use]
pub fn largest_plausible(coefficient: f64) -> f64 {
    let largest = PLAUSIBLE * coefficient.abs();
    format!("{largest:.1e}").parse().unwrap_or(largest)
}

/// The text with a law appended as an effect definition, otherwise unchanged.
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

/// The text with an effect definition appended, otherwise unchanged.
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
    // Appended to the text rather than inserted into its document, so that a comment at the end stays in
    // place.
    let gap = match text {
        "" => "",
        text if text.ends_with('\n') => "\n",
        _ => "\n\n",
    };
    Ok(format!("{text}{gap}{added}"))
}
