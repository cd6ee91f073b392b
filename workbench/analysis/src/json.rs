//! What results need to be read back from JSON.

use serde::Deserialize as _;
use serde::de::{DeserializeOwned, Deserializer, Error as _};

/// Reads a flattened part. Serde's own `flatten` loses numbers where a dependency has `serde_json` keep their
/// digits (serde_json's issue 505); by way of a `Value` they survive.
///
/// # Errors
/// What is missing from the part, or of the wrong type.
pub fn whole<'de, T: DeserializeOwned, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::deserialize(serde_json::Value::deserialize(deserializer)?).map_err(D::Error::custom)
}
