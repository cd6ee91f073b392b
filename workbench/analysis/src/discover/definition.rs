//! A law made an effect definition of a model.

use thiserror::Error;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, value};

use super::discovery::FoundLaw;

/// How far beyond what was found nature is taken to keep the coefficient, either way.
const PLAUSIBLE: f64 = 3.0;

/// Why a model's text can not take a definition.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DefinitionError {
    /// It is not TOML.
    #[error("{0}")]
    Syntax(String),
    /// The id is there already.
    #[error("{0} is defined in it already; choose another id")]
    Taken(String),
    /// The definitions are no tables.
    #[error(
        "effect_definition is no [[effect_definition]] table; write each one as a table below such a line"
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

/// The text with a law as an effect definition at its end, everything else in it as it was.
///
/// # Errors
/// See [`DefinitionError`].
pub fn with_definition(text: &str, id: &str, law: &FoundLaw) -> Result<String, DefinitionError> {
    let document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| DefinitionError::Syntax(error.to_string()))?;
    if let Some(definitions) = document.get("effect_definition") {
        let definitions = definitions.as_array_of_tables().ok_or(DefinitionError::NotTables)?;
        if definitions.iter().any(|table| table.get("id").and_then(Item::as_str) == Some(id)) {
            return Err(DefinitionError::Taken(id.to_owned()));
        }
    }
    let mut table = Table::new();
    table.insert("id", value(id));
    table.insert("on", value(&*law.on));
    table.insert("regressor", value(law.regressor.as_str()));
    table.insert("unit", value(law.unit.as_str()));
    let largest = PLAUSIBLE * law.coefficient.abs();
    // Two digits are enough for a range.
    let rounded = format!("{largest:.1e}").parse::<f64>().unwrap_or(largest);
    let mut plausible = Array::new();
    plausible.extend([-rounded, rounded]);
    table.insert("plausible", value(plausible));
    table.insert(
        "about",
        value(format!("a law that pylon discover proposed, with a probability of {:.2}", law.probability)),
    );
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
