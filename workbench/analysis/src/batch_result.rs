//! The output of `pylon diagnose --json`.

use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use crate::batch::Batch;
use crate::diagnose::Diagnosis;

/// A diagnosis of all flights together and, if there are several, of each by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[schemars(extend("required" = ["version"]))]
pub struct DiagnoseResult {
    /// The flights together; absent if that diagnosis failed.
    #[serde(flatten)]
    pub together: Option<Diagnosis>,
    /// Replacement, if it failed.
    #[serde(flatten)]
    pub failed: Option<FailedDiagnosis>,
    /// Each flight by itself, if there is more than one.
    #[serde(flatten)]
    pub one_by_one: Option<Batch>,
}

/// Result for flights whose diagnosis together failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FailedDiagnosis {
    /// Version of the meaning of these keys: that of a diagnosis.
    pub version: u32,
    /// Why the diagnosis of the flights together failed: a defect of this program.
    pub failed: String,
}

impl FailedDiagnosis {
    /// A failure with that reason.
    #[must_use]
    pub const fn new(failed: String) -> Self {
        Self { version: Diagnosis::VERSION, failed }
    }
}

impl<'de> Deserialize<'de> for DiagnoseResult {
    /// Deserialises through a `Value`: serde's `flatten` loses numbers if a dependency makes `serde_json`
    /// keep their digits.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let together = value.get("verdict").map(|_| Diagnosis::deserialize(&value)).transpose();
        let failed = value.get("failed").map(|_| FailedDiagnosis::deserialize(&value)).transpose();
        let one_by_one = value.get("by_flight").map(|_| Batch::deserialize(&value)).transpose();
        Ok(Self {
            together: together.map_err(D::Error::custom)?,
            failed: failed.map_err(D::Error::custom)?,
            one_by_one: one_by_one.map_err(D::Error::custom)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a result without a version, whose reader cannot know what the other keys mean.
    #[test]
    fn a_result_has_one_version_whether_or_not_the_flights_were_diagnosed() {
        let failed = DiagnoseResult {
            failed: Some(FailedDiagnosis::new("a defect".to_owned())),
            one_by_one: Some(Batch::default()),
            ..DiagnoseResult::default()
        };
        let together = Diagnosis { version: Diagnosis::VERSION, ..Diagnosis::default() };
        let diagnosed = DiagnoseResult { together: Some(together), ..DiagnoseResult::default() };
        for result in [failed, diagnosed] {
            let json = serde_json::to_string(&result).unwrap();
            assert_eq!(json.matches(&format!("\"version\":{}", Diagnosis::VERSION)).count(), 1, "{json}");
            assert_eq!(serde_json::from_str::<DiagnoseResult>(&json).unwrap(), result, "{json}");
        }
    }
}
