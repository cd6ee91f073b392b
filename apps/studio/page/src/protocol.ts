// The engine's requests and answers, with the arrays in place.

import type * as Engine from "./generated/protocol";
import type { Resolved } from "./engine/client";

export type { Acting, Airborne, FlightPlan, Headline, ModelText, NoiseFacts, PlannedLeg, PlannedManoeuvre, Signal, Times, Window } from "./generated/protocol";
export type Added = Resolved<Engine.Added>;
export type CandidateFacts = Resolved<Engine.CandidateFacts>;
export type Compared = Resolved<Engine.Compared>;
export type Diagnosed = Resolved<Engine.Diagnosed>;
export type EffectGuide = Resolved<Engine.EffectGuide>;
export type Ladder = Resolved<Engine.Ladder>;
export type ModelFacts = Resolved<Engine.ModelFacts>;
export type Opened = Resolved<Engine.Opened>;
export type Sample = Resolved<Engine.Sample>;
export type SensorDiagnosis = Resolved<Engine.SensorDiagnosis>;
export type Span = Resolved<Engine.Span>;
export type Correlated = Resolved<Engine.Correlated>;
export type Drawn = Resolved<Engine.Drawn>;
export type Paired = Resolved<Engine.Paired>;
export type Ribbons = Resolved<Engine.Ribbons>;
export type Planned = Resolved<Engine.Planned>;
export type Offer = Resolved<Engine.Offer>;
export type EffectOutlook = Resolved<Engine.EffectOutlook>;
export type SetOutlook = Resolved<Engine.SetOutlook>;
export type Series = Resolved<Engine.Series>;
export type Defined = Resolved<Engine.Defined>;
export type Discovered = Resolved<Engine.Discovered>;
export type FormulaChecked = Resolved<Engine.FormulaChecked>;
export type FormulaProblem = Resolved<Engine.FormulaProblem>;
