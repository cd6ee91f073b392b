//! Every request and what it is answered by.

use serde::Deserialize;

use super::{
    AddRequest, CloseRequest, CompareRequest, CorrelationRequest, DiagnoseRequest, DiscoverRequest,
    EffectsRequest, ExportRequest, FlightRequest, FormulaRequest, LadderRequest, ModelRequest, OpenRequest,
    OpenSampleRequest, PlanRequest, PresetsRequest, SamplesRequest, ScatterRequest, SeriesRequest,
};

macro_rules! calls {
    ($($(#[$doc:meta])* $variant:ident $name:literal ($request:ty) -> $answer:literal,)*) => {
        /// A request.
        #[derive(Clone, Debug, Deserialize)]
        #[serde(tag = "call", content = "of", rename_all = "snake_case")]
        pub enum Request {
            $($(#[$doc])* $variant($request),)*
        }

        /// Every request's name, its type and its answer's, as TypeScript has them.
        pub const REQUESTS: &[(&str, &str, &str)] = &[$(($name, stringify!($request), $answer),)*];
    };
}

calls! {
    /// Opens a log; its bytes come with the request.
    Open "open" (OpenRequest) -> "Opened",
    /// The flights that come with Pylon.
    Samples "samples" (SamplesRequest) -> "Array<Sample>",
    /// Simulates and opens one of them.
    OpenSample "open_sample" (OpenSampleRequest) -> "Opened",
    /// What is in a flight, calibrated on another window.
    Flight "flight" (FlightRequest) -> "Opened",
    /// Forgets a flight.
    Close "close" (CloseRequest) -> "Closed",
    /// The models that come with Pylon.
    Presets "presets" (PresetsRequest) -> "Array<Preset>",
    /// What is in a model.
    Model "model" (ModelRequest) -> "ModelFacts",
    /// The catalogue of effects.
    Effects "effects" (EffectsRequest) -> "Array<EffectGuide>",
    /// Curves over time.
    Series "series" (SeriesRequest) -> "Series",
    /// Phases, trust, manoeuvres and motion over time.
    Ribbons "ribbons" (CompareRequest) -> "Ribbons",
    /// One signal over another.
    Scatter "scatter" (ScatterRequest) -> "Paired",
    /// A signal's correlation with itself or another.
    Correlation "correlation" (CorrelationRequest) -> "Correlated",
    /// How well a model agrees with a flight.
    Compare "compare" (CompareRequest) -> "Compared",
    /// Which effect a model lacks.
    Diagnose "diagnose" (DiagnoseRequest) -> "Diagnosed",
    /// A flight that is planned, and what it would tell.
    Plan "plan" (PlanRequest) -> "Planned",
    /// An effect by formula, checked and fitted for the eye.
    Formula "formula" (FormulaRequest) -> "FormulaChecked",
    /// Laws that nobody wrote down.
    Discover "discover" (DiscoverRequest) -> "Discovered",
    /// An effect learned and added.
    Add "add" (AddRequest) -> "Added",
    /// Every revision on every flight.
    Ladder "ladder" (LadderRequest) -> "Ladder",
    /// A file of a result.
    Export "export" (ExportRequest) -> "Exported",
}
