//! `pylon diagnose --json`.

use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use crate::batch::Batch;
use crate::diagnose::Diagnosis;

/// A diagnosis of all flights together and, of several, of each by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct DiagnoseResult {
    /// The flights together; absent if `failed`.
    #[serde(flatten)]
    pub together: Option<Diagnosis>,
    /// Why the flights together were not diagnosed: a defect of this program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// Each flight by itself, where there is more than one.
    #[serde(flatten)]
    pub one_by_one: Option<Batch>,
}

impl<'de> Deserialize<'de> for DiagnoseResult {
    /// By way of a `Value`: serde's `flatten` loses numbers where a dependency has `serde_json` keep their digits.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let together = value.get("verdict").map(|_| Diagnosis::deserialize(&value)).transpose();
        let one_by_one = value.get("by_flight").map(|_| Batch::deserialize(&value)).transpose();
        Ok(Self {
            together: together.map_err(D::Error::custom)?,
            failed: value.get("failed").and_then(Value::as_str).map(str::to_owned),
            one_by_one: one_by_one.map_err(D::Error::custom)?,
        })
    }
}
