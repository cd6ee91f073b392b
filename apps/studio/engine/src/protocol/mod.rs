//! The protocol between a page and the engine: one request, one answer, as JSON.
//!
//! Arrays of numbers do not pass through JSON: an answer refers to them by their position ([`Numbers`]) in
//! the numbers that are handed over with it. The bytes of a log come with a request, those of an export with
//! an answer.
//!
//! A model is a value: every request that needs one contains its text. So an engine keeps no state but the
//! flights, which are the user's files: a lost one is opened again, and any number of engines can work on one
//! model.

mod calls;
mod correlation;
mod effects;
mod flights;
mod formula;
mod headline;
mod models;
mod numbers;
mod plan;
mod results;
mod ribbons;
mod scatter;
mod series;

pub use calls::{REQUESTS, Request};
pub use correlation::{Correlated, CorrelationRequest};
pub use effects::{EffectGuide, EffectsRequest};
pub use flights::{
    Airborne, CloseRequest, Closed, ColumnFacts, FlightRequest, OpenRequest, OpenSampleRequest, Opened,
    Sample, SamplesRequest, Times, TimesByFlight, Window,
};
pub use formula::{Defined, DiscoverRequest, Discovered, FormulaChecked, FormulaProblem, FormulaRequest};
pub use headline::{Headline, Tone};
pub use models::{ModelFacts, ModelRequest, ModelText, Preset, PresetsRequest, RevisionFacts, TermFacts};
pub use numbers::Numbers;
pub use plan::{PlanRequest, Planned};
pub use results::{
    AddRequest, Added, CompareRequest, Compared, DiagnoseRequest, Diagnosed, ExportRequest, Exported,
    Exports, LadderRequest,
};
pub use ribbons::{MotionNumbers, Ribbons, Span};
pub use scatter::{Paired, ScatterRequest};
pub use series::{Acting, Drawn, Series, SeriesRequest, Signal};
