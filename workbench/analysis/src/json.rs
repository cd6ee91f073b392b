//! Helpers for reading results back from JSON.

use serde::Deserialize as _;
use serde::de::{DeserializeOwned, Deserializer, Error as _};

/// Reads a flattened part. Serde's own `flatten` loses numbers where a dependency makes `serde_json` keep
/// their digits (serde_json's issue 505); through a `Value` they survive.
///
/// # Errors
/// When something is missing from the part, or has the wrong type.
pub fn whole<'de, T: DeserializeOwned, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::deserialize(serde_json::Value::deserialize(deserializer)?).map_err(D::Error::custom)
}
