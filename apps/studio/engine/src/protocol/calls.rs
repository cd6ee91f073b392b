//! Every request and its answer.

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

        /// Every request's name, type and answer type, in TypeScript's notation.
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
    /// The contents of a flight, with other times.
    Flight "flight" (FlightRequest) -> "Opened",
    /// Forgets a flight.
    Close "close" (CloseRequest) -> "Closed",
    /// The models that come with Pylon.
    Presets "presets" (PresetsRequest) -> "Array<Preset>",
    /// The contents of a model.
    Model "model" (ModelRequest) -> "ModelFacts",
    /// The catalogue of effects.
    Effects "effects" (EffectsRequest) -> "Array<EffectGuide>",
    /// Curves over time.
    Series "series" (SeriesRequest) -> "Series",
    /// Phases, trust, manoeuvres and motion over time.
    Ribbons "ribbons" (CompareRequest) -> "Ribbons",
    /// One signal against another.
    Scatter "scatter" (ScatterRequest) -> "Paired",
    /// A signal's correlation with itself or another.
    Correlation "correlation" (CorrelationRequest) -> "Correlated",
    /// How well a model agrees with a flight.
    Compare "compare" (CompareRequest) -> "Compared",
    /// Which effect a model lacks.
    Diagnose "diagnose" (DiagnoseRequest) -> "Diagnosed",
    /// A planned flight, and what it would show.
    Plan "plan" (PlanRequest) -> "Planned",
    /// An effect by formula, checked and roughly fitted for display.
    Formula "formula" (FormulaRequest) -> "FormulaChecked",
    /// A search for laws that are not in the catalogue.
    Discover "discover" (DiscoverRequest) -> "Discovered",
    /// An effect learned and added.
    Add "add" (AddRequest) -> "Added",
    /// Every revision on every flight.
    Ladder "ladder" (LadderRequest) -> "Ladder",
    /// A file of a result.
    Export "export" (ExportRequest) -> "Exported",
}
