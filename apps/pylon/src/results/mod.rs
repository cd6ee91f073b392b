//! JSON results of the commands (`--json`): plain types that can read what they wrote, and their schemas.

mod effects;
mod files;
mod fly;
mod plan;

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

pub use effects::{EffectExplained, EffectsResult};
pub use files::{ExportResult, ImportResult, ReportResult, SimulateResult};
pub use fly::{
    ChipsResult, FirstDifference, FlyAgreement, FlyDifference, FlyResult, PartCost, SensorAgreementResult,
};
pub use plan::PlanResult;

pub use crate::batch::{DiagnoseResult, FailedDiagnosis};
pub use crate::compare::Comparison;
pub use crate::discover::Discovery;
pub use crate::learn::{Addition, Ladder};
pub use crate::overview::Overview;

/// The version of the results that are defined here.
pub const VERSION: u32 = 1;

/// The commands that print JSON, each with the schema of its output.
#[must_use]
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        ("add", schema::<Addition>("add")),
        ("compare", schema::<Comparison>("compare")),
        ("diagnose", schema::<DiagnoseResult>("diagnose")),
        ("discover", schema::<Discovery>("discover")),
        ("effects", schema::<EffectsResult>("effects")),
        ("export", schema::<ExportResult>("export")),
        ("fly", schema::<FlyResult>("fly")),
        ("import", schema::<ImportResult>("import")),
        ("ladder", schema::<Ladder>("ladder")),
        ("open", schema::<Overview>("open")),
        ("plan", schema::<PlanResult>("plan")),
        ("report", schema::<ReportResult>("report")),
        ("simulate", schema::<SimulateResult>("simulate")),
    ]
}

fn schema<T: JsonSchema>(command: &str) -> Schema {
    let mut schema =
        SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>();
    schema.insert("title".to_owned(), format!("pylon {command} --json").into());
    schema
}
