export interface Window { start_s: number; end_s: number }
export interface ModelText { name: string; text: string }
export interface Numbers { start: number; length: number }
export type Tone = "good" | "caution" | "bad";
export interface Headline { sentence: string; tone: Tone; effect: string | null }
export interface EffectGuide { effect: string; subject: string; title: string; what: string; formula: string; unit: string; plausible: [number, number]; source: string; looks_like: string; needs: string[]; has_time_constant: boolean }
export interface Overview { file: string; format: string; vehicle: string; rows: number; duration_s: number; launch_s: number | null; has_launch: boolean; take_off_s: number | null; landing_s: number | null; used_share: number; unused: Array<{ from_s: number; to_s: number; share: number; reason: string }>; remarks: string[]; calibration: string; refused: string | null; notes: string[] }
export interface Opened { overview: Overview; vehicle: string; first_s: number; last_s: number; columns: Array<{ name: string; is_known: boolean; values: number }>; sensors: string[] }
export interface Sample { name: string; about: string }
export interface CandidateFacts { effect: string; coefficient: number; sigma: number; unit: string; p_value: number; rms_before_m: number | null; rms_after_m: number | null; chosen: boolean; time_constant_s: number | null; since: string | null; size_m: number; envelope_m: [number, number] }
export interface SensorDiagnosis { verdict: string; missing: string[]; indistinguishable: string[][]; probabilities: number[][]; candidates: CandidateFacts[]; advice: string }
export interface Diagnosis { verdict: string; sensors: { [k in string]?: SensorDiagnosis }; untested: Array<{ effect: string; reason: string }> }
export interface Diagnosed { diagnosis: Diagnosis; headline: Headline }
export interface Compared { comparison: { sensors: { [k in string]?: { trust: string } } }; headline: Headline }
export interface Added { addition: { effect: string; concerns: string[] }; model: ModelText; headline: Headline }
export interface Ladder { revisions: Array<{ number: number; effect: string | null; flights: Array<{ file: string; sensors: { [k in string]?: { captive_rms_m: number | null; free_flight_rms_m: number | null } } }> }> }
export interface Span { from_s: number; to_s: number; what: string }
export interface Ribbons { phases: Span[]; trust: { [k in string]?: Span[] }; manoeuvres: Span[]; motion: { time_s: Numbers; climb_rate_mps: Numbers; speed_mps: Numbers; load_factor: Numbers; turn_rate_radps: Numbers }; sources: { speed: string | null }; bounds_m: { [k in string]?: number }; launch_s: number | null }
export type Signal = { signal: "column"; name: string } | { signal: "reference" | "estimate" | "climb_rate" | "speed" | "load_factor" | "turn_rate" } | { signal: "measured" | "modelled" | "error" | "moving_average" | "beyond_reference"; sensor: string } | { signal: "effect"; effect: string; coefficient: number; time_constant_s: number | null; since: string | null };
export interface Drawn { signal: Signal; unit: string; least: Numbers; greatest: Numbers; sigma: Numbers | null; gaps_s: Numbers; values: number }
export interface Series { time_s: Numbers; is_thinned: boolean; curves: Drawn[] }
export interface Paired { time_s: Numbers; x: Numbers; y: Numbers; x_unit: string; y_unit: string; of: number; unpaired: number }
export interface Correlated { lag_s: Numbers; correlation: Numbers; band: number; block_s: number; blocks: number; is_cut: boolean }
export interface ModelFacts { effects: Array<{ effect: string; coefficient: number; sigma: number; unit: string; learned_from: string | null }>; revisions: Array<{ number: number; effect: string | null; date: string | null }>; warnings: string[] }
export interface Exported { name: string; media: string }
export interface Calls {
  open: { of: { flight: string; file: string }; answer: Opened }; samples: { of: object; answer: Sample[] }; open_sample: { of: { flight: string; sample: string }; answer: Opened };
  flight: { of: { flight: string; window: Window | null }; answer: Opened }; close: { of: { flight: string }; answer: { was_open: boolean } };
  model: { of: { model: ModelText }; answer: ModelFacts }; effects: { of: object; answer: EffectGuide[] };
  series: { of: { flight: string; model: ModelText; window: Window | null; signals: Signal[]; from_s: number | null; to_s: number | null; pixels: number }; answer: Series };
  ribbons: { of: { flight: string; model: ModelText; window: Window | null }; answer: Ribbons };
  scatter: { of: { flight: string; model: ModelText; window: Window | null; x: Signal; y: Signal; from_s: number | null; to_s: number | null; at_most: number }; answer: Paired };
  correlation: { of: { flight: string; model: ModelText; window: Window | null; signal: Signal; with: Signal | null; from_s: number | null; to_s: number | null; longest_lag_s: number }; answer: Correlated };
  compare: { of: { flight: string; model: ModelText; window: Window | null }; answer: Compared };
  diagnose: { of: { flights: string[]; hold_outs: string[]; model: ModelText; window: Window | null }; answer: Diagnosed };
  add: { of: { effect: string; flights: string[]; hold_outs: string[]; model: ModelText; window: Window | null; estimate: boolean; time_constant_s: number | null; since: string | null; date: string }; answer: Added };
  ladder: { of: { flights: string[]; model: ModelText; window: Window | null }; answer: Ladder };
  export: { of: { export: object }; answer: Exported };
}
