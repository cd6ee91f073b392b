// Made from the engine's own types by its test: UPDATE_TYPES=1 cargo test -p studio-engine --test types
//
// A number that is not finite comes as null, also where the type says `number`.

/**
 * An effect and its coefficient, as a diagnosis' candidate has them.
 */
export type Acting = { 
/**
 * Its id.
 */
effect: string, 
/**
 * Its coefficient.
 */
coefficient: number, 
/**
 * Time constant, seconds, for an effect that has one.
 */
time_constant_s: number | null, 
/**
 * `launch` or `start`, for an effect that has a time constant.
 */
since: string | null, };

/**
 * Learns an effect's coefficient and makes the model's next revision: `pylon add`.
 */
export type AddRequest = { 
/**
 * The effect's id.
 */
effect: string, 
/**
 * The flights to learn from.
 */
flights: Array<string>, 
/**
 * The flights to judge by.
 */
hold_outs: Array<string>, 
/**
 * The model as it is.
 */
model: ModelText, 
/**
 * What the user says of their times.
 */
times: { [key in string]: Times }, 
/**
 * Whether the filter is to estimate the coefficient in captive flight.
 */
estimate: boolean, 
/**
 * Time constant, seconds; null: the best of a grid.
 */
time_constant_s: number | null, 
/**
 * `launch` or `start`; null: whichever fits best.
 */
since: string | null, 
/**
 * The day to write down, as 2026-01-31.
 */
date: string, };

/**
 * An effect added.
 */
export type Added = { 
/**
 * What `pylon add --json` prints. Where it has `concerns`, the command line would not write it without
 * being told to.
 */
addition: Addition, 
/**
 * The model with it: the next revision, under the same name.
 */
model: ModelText, 
/**
 * In one sentence: what was learned, and how the error falls.
 */
headline: Headline, 
/**
 * Every revision of that model on the flights, those to learn from first: what [`LadderRequest`] is
 * answered by. Null where a flight has nothing to calibrate on.
 */
ladder: Ladder | null, };

/**
 * An effect added: the keys of `pylon add --json`.
 */
export type Addition = { 
/**
 * Version of what these keys mean: a new one where a key changes its meaning or goes.
 */
version: number, 
/**
 * Its id.
 */
effect: string, 
/**
 * The learned coefficient, as it was written.
 */
coefficient: number, 
/**
 * Its sigma.
 */
sigma: number, 
/**
 * Unit of both.
 */
unit: string, 
/**
 * Root mean square error of the sensors concerned before, on what `judged_on` says, metres.
 */
rms_before_m: number | null, 
/**
 * And after, metres.
 */
rms_after_m: number | null, 
/**
 * What these two, and the verdict, are of.
 */
judged_on: JudgedOn, 
/**
 * What decides, rather than these two: the likelihood of what was held out, which knows the wander.
 */
held_out_verdict: HeldOutVerdict, 
/**
 * Root mean square error of the sensors concerned on the learning flights, before and after, metres.
 */
learning_rms_m: [number | null, number | null], 
/**
 * The coefficient by the diagnosis' own fit, in double precision, and its sigma.
 */
diagnosed: [number, number], 
/**
 * Time constant of its regressor, seconds, where it has one.
 */
time_constant_s: number | null, 
/**
 * When that regressor's clock starts.
 */
since: string | null, 
/**
 * The range of its regressor in the learning flights, metres per unit of coefficient.
 */
envelope_m: [number, number] | null, 
/**
 * Whether it is a state of the filter.
 */
estimate: boolean, 
/**
 * The coefficient that it takes the place of.
 */
replaced_coefficient: number | null, 
/**
 * The revision's number.
 */
revision: number, 
/**
 * The learning flights, before and after.
 */
learning: Array<FlightChange>, 
/**
 * The held-out flights, before and after.
 */
held_out: Array<FlightChange>, 
/**
 * What speaks against it: without being told to go on all the same, nothing should be written.
 */
concerns: Array<string>, 
/**
 * What else the user should know.
 */
warnings: Array<string>, };

/**
 * Take-off and landing, seconds of the flight's own clock; null: in the air already when the log begins, or
 * still when it ends.
 */
export type Airborne = { 
/**
 * When it took off.
 */
take_off_s: number | null, 
/**
 * When it landed.
 */
landing_s: number | null, };

/**
 * One time in the air, seconds of the flight's own clock; null where the log does not show it.
 */
export type AirborneTime = { 
/**
 * When it took off.
 */
take_off_s: number | null, 
/**
 * When it landed.
 */
landing_s: number | null, 
/**
 * How long it was in the air.
 */
duration_s: number, };

/**
 * Several flights, one by one.
 */
export type Batch = { 
/**
 * The flights, in the user's order.
 */
by_flight: Array<FlightResult>, 
/**
 * The vehicles, by their names.
 */
by_vehicle: Array<VehicleResult>, };

/**
 * The calibration.
 */
export type CalibrationFacts = { 
/**
 * `good`, `degraded`, or null when nothing was latched.
 */
quality: string | null, 
/**
 * Names of the checks that failed.
 */
failed_checks: Array<string>, 
/**
 * Length of the calibration, seconds.
 */
duration_s: number | null, 
/**
 * What decided when the captive flight ends.
 */
source: string, };

/**
 * One candidate.
 */
export type CandidateFacts = { 
/**
 * Its id.
 */
effect: string, 
/**
 * Estimated coefficient: beside the other effects found, or alone if it was not.
 */
coefficient: number, 
/**
 * One sigma of it, its autocorrelated noise and its spread over the manoeuvres accounted for.
 */
sigma: number, 
/**
 * Its unit.
 */
unit: string, 
/**
 * The probability that it acts, beside what else may: of the sets of effects that explain the flights,
 * those that have it. Where the climb rate is measured only what is identified and the members of a set
 * have one: in that place.
 */
probability: number | null, 
/**
 * Chance of as strong a fit if the effect did not act, times the number of effects tried.
 */
p_value: number, 
/**
 * Root mean square of the held-out errors without it, with every other chosen one, m.
 */
rms_before_m: number | null, 
/**
 * With it beside those, m; neither is there where most of the error would be the coefficient's own,
 * which what is held out alone shows.
 */
rms_after_m: number | null, 
/**
 * Whether it is part of the explanation.
 */
chosen: boolean, 
/**
 * Time constant of its regressor, s, where it has one.
 */
time_constant_s: number | null, 
/**
 * Time constant of the low pass that fits a lag better than a shift of the slope does, seconds, if one
 * does.
 */
smoothing_s: number | null, 
/**
 * When that regressor's clock starts, where it has a time constant: `launch` or `start`.
 */
since: string | null, 
/**
 * How much of the residual it makes in free flight, rms, m.
 */
size_m: number, 
/**
 * The range of its regressor in these flights, m per unit.
 */
envelope_m: [number, number], };

/**
 * Forgets a flight.
 */
export type CloseRequest = { 
/**
 * The flight.
 */
flight: string, };

/**
 * Whether a flight was closed.
 */
export type Closed = { 
/**
 * False for one that was not open.
 */
was_open: boolean, };

/**
 * One effect's coefficient by one flight.
 */
export type Coefficient = { 
/**
 * The estimate: beside what that flight shows to be missing.
 */
value: number, 
/**
 * One sigma.
 */
sigma: number, 
/**
 * Whether that flight alone shows that the effect is missing.
 */
identified: boolean, };

/**
 * A column of a flight.
 */
export type ColumnFacts = { 
/**
 * Its name; a known one's says the unit.
 */
name: string, 
/**
 * Whether Pylon knows what it is.
 */
is_known: boolean, 
/**
 * How many values it has.
 */
values: number, };

/**
 * Compares a model with a flight: `pylon compare`.
 */
export type CompareRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model.
 */
model: ModelText, 
/**
 * What the user says of its times.
 */
times: Times, };

/**
 * A comparison.
 */
export type Compared = { 
/**
 * What `pylon compare --json` prints. A value that is not finite is null.
 */
comparison: Comparison, 
/**
 * In one sentence.
 */
headline: Headline, };

/**
 * How well a model agrees with a flight. Serialised, a value that does not exist is null, and so is
 * one that is not finite.
 */
export type Comparison = { 
/**
 * Version of what these keys mean: a new one where a key changes its meaning or goes.
 */
version: number, 
/**
 * The flight.
 */
flight: FlightFacts, 
/**
 * The model's name: a preset or a file.
 */
model: string, 
/**
 * When the UAV was launched, by the flight's own clock, seconds.
 */
launch_s: number | null, 
/**
 * The sensors by name; those without a single reading are left out.
 */
sensors: { [key in string]: SensorComparison }, 
/**
 * What barometer and inertial altitude said of each other while the reference was lost in free
 * flight; null where it never was, or no pair of readings came.
 */
cross_check: CrossCheckFacts | null, 
/**
 * The reference.
 */
reference: ReferenceComparison, 
/**
 * The calibration.
 */
calibration: CalibrationFacts, 
/**
 * The effects that the model accounts for, in its order.
 */
effects: Array<EffectFacts>, 
/**
 * The monitor as configured.
 */
monitor: MonitorFacts, 
/**
 * What the monitor's rule costs and catches, and a better one, by sensor.
 */
rules: { [key in string]: SensorRules }, 
/**
 * Section 4's second correction, side by side.
 */
remedies: Array<Remedy>, 
/**
 * Where the model fails.
 */
failures: Failures, 
/**
 * What was in the flight and not used as it stood.
 */
warnings: Array<string>, };

/**
 * A first-order Gauss-Markov process.
 */
export type Component = { 
/**
 * Correlation time, seconds.
 */
time_s: number, 
/**
 * Variance, square metres.
 */
variance_m2: number, };

/**
 * What [`NisSummary`] found.
 */
export type Consistency = { 
/**
 * Mean NIS; 1 for a consistent filter.
 */
mean: number, 
/**
 * Lower 95 % bound of the mean, were the filter consistent.
 */
lower: number, 
/**
 * Upper 95 % bound.
 */
upper: number, 
/**
 * Share of innovations beyond three sigmas; 0.0027 for a consistent filter.
 */
beyond_three_sigmas: number, 
/**
 * How many innovations there were.
 */
count: number, 
/**
 * How many independent ones they are worth.
 */
effective_count: number, };

/**
 * A correlation by lag.
 */
export type Correlated = { 
/**
 * Lags, seconds; of a cross-correlation on both sides of zero, positive where the signal is behind the
 * other.
 */
lag_s: Numbers, 
/**
 * The correlation, from -1 to 1.
 */
correlation: Numbers, 
/**
 * Half the width of the band that 99 of 100 correlations at a lag lie in where there is none, as
 * MATLAB's `resid` draws it: of white noise for an autocorrelation, by Bartlett's formula, from both
 * autocorrelations, for a cross-correlation.
 */
band: number, 
/**
 * Length of the block means that it is made of, seconds.
 */
block_s: number, 
/**
 * How many.
 */
blocks: number, 
/**
 * Whether the time asked for was too short, or the signal has too many gaps, for lags that long; they
 * end sooner.
 */
is_cut: boolean, };

/**
 * Asks how a signal (a sensor's error) is correlated with itself or another.
 */
export type CorrelationRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model that flies.
 */
model: ModelText, 
/**
 * What the user says of its times.
 */
times: Times, 
/**
 * The signal.
 */
signal: Signal, 
/**
 * The other; null: with itself.
 */
with: Signal | null, 
/**
 * From when, seconds of the flight's own clock; null: from its first row.
 */
from_s: number | null, 
/**
 * To when; null: to its last.
 */
to_s: number | null, 
/**
 * The longest lag, seconds.
 */
longest_lag_s: number, };

/**
 * Barometer less inertial altitude while the reference was lost, each by its latched bias.
 */
export type CrossCheckFacts = { 
/**
 * Pairs of readings.
 */
pairs: number, 
/**
 * The difference farthest from zero, metres.
 */
largest_difference_m: number, 
/**
 * What the two had come to after the last pair: `agree`, `doubtful` or `disagree`.
 */
agreement: string, 
/**
 * When they were first doubtful or worse, seconds after launch.
 */
doubtful_after_s: number | null, 
/**
 * When they disagreed, seconds after launch.
 */
disagree_after_s: number | null, };

/**
 * An effect by formula that can be used.
 */
export type Defined = { 
/**
 * Its id.
 */
effect: string, 
/**
 * Unit of its coefficient; `1` for a number.
 */
unit: string, 
/**
 * The largest plausible coefficient, either way.
 */
largest: number, 
/**
 * The coefficient that fits the error by least squares, with a constant beside it. The filter, the other
 * effects and the noise's colour are not in it: it is for the eye. `add` learns the coefficient that
 * counts.
 */
coefficient: number, 
/**
 * Share of the error's variance that it explains there, from 0 to 1.
 */
explained: number, 
/**
 * What the formula says, metres per unit of the coefficient: means over blocks of the flight.
 */
x: Numbers, 
/**
 * The error's mean over each of these blocks, m.
 */
y: Numbers, 
/**
 * The model with the definition; nothing is learned yet.
 */
model: ModelText, };

/**
 * How long after a fault the sensor is called untrustworthy.
 */
export type Delay = { 
/**
 * The fault.
 */
fault: Fault, 
/**
 * Median delay, seconds; `None` when fewer than half of such faults are ever detected.
 */
median_s: number | null, 
/**
 * Delay of the slowest tenth, seconds; `None` when fewer than nine in ten are ever detected.
 */
ninety_percent_s: number | null, };

/**
 * Finds which effect a model lacks: `pylon diagnose`.
 */
export type DiagnoseRequest = { 
/**
 * The flights to learn from: one, or several together.
 */
flights: Array<string>, 
/**
 * The flights to judge by; without, stretches of the flights are held out in turn.
 */
hold_outs: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * What the user says of their times.
 */
times: { [key in string]: Times }, };

/**
 * A diagnosis.
 */
export type Diagnosed = { 
/**
 * What `pylon diagnose --json` prints of all flights together. A value that is not finite is null.
 */
diagnosis: Diagnosis, 
/**
 * Of several flights: what each says alone, by vehicle, and which do not belong with the others.
 */
batch: Batch | null, 
/**
 * In one sentence.
 */
headline: Headline, };

/**
 * One flight.
 */
export type DiagnosedFlight = { 
/**
 * The file.
 */
file: string, 
/**
 * Where captive flight ends and free flight begins, and why.
 */
calibration: string, 
/**
 * Blocks of residuals that were worked on.
 */
blocks: number, 
/**
 * Their length, s.
 */
block_s: number, 
/**
 * Stretches in which the reference jumped away and came back; they were left out.
 */
glitches: Array<Glitch>, 
/**
 * Readings left out because the reference was lost around them.
 */
unreferenced_readings: number, 
/**
 * Readings that are no measurements, to the mission neither: not finite, implausible, or of a sensor
 * that is stuck.
 */
refused_readings?: number, 
/**
 * What is wrong with a sensor for the whole flight, which was left out for it: one that is stuck, or a
 * copy of the receiver.
 */
fault: string | null, 
/**
 * Whether the flight says itself when it was launched.
 */
has_launch: boolean, 
/**
 * How many flights are in the log; 0 where it says itself when it was launched, or shows none.
 */
flights: number, 
/**
 * Which of them is analysed, from 1.
 */
flight: number | null, 
/**
 * When it took off, seconds; null where that is not in the log.
 */
take_off_s: number | null, 
/**
 * When it landed, seconds; null where that is not in the log.
 */
landing_s: number | null, 
/**
 * Share of the log's time that is analysed.
 */
used_share: number, 
/**
 * What is not, and why.
 */
unused: Array<Unused>, 
/**
 * What else a user should know, one line each.
 */
remarks: Array<string>, };

/**
 * A diagnosis of one or more flights with one model.
 */
export type Diagnosis = { 
/**
 * Version of what these keys mean: a new one where a key changes its meaning or goes.
 */
version: number, 
/**
 * Over all sensors: that of the sensor with the largest misfit.
 */
verdict: Verdict, 
/**
 * By sensor; effects of the reference are under `gps`.
 */
sensors: { [key in string]: SensorDiagnosis }, 
/**
 * The model's name: a preset or a file.
 */
model: string, 
/**
 * The flights learned from.
 */
flights: Array<DiagnosedFlight>, 
/**
 * The flights held out, if any; without, stretches of the flights are held out in turn.
 */
hold_outs: Array<string>, 
/**
 * The noise that was found beside the effects.
 */
noise: NoiseFacts, 
/**
 * Effects that could not be tested, because the flights lack a signal.
 */
untested: Array<Untested>, 
/**
 * What was remarkable about the input.
 */
warnings: Array<string>, };

/**
 * Searches for laws that the recorded signals obey: `pylon discover`.
 */
export type DiscoverRequest = { 
/**
 * The flights to learn from.
 */
flights: Array<string>, 
/**
 * The flights to judge by.
 */
hold_outs: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * What the user says of their times.
 */
times: { [key in string]: Times }, };

/**
 * What was found.
 */
export type Discovered = { 
/**
 * What `pylon discover --json` prints.
 */
discovery: Discovery, 
/**
 * An id for each law, as `pylon discover --write` makes it.
 */
ids: Array<string>, 
/**
 * In words, where no law is proposed: why.
 */
why_none: string | null, };

/**
 * What was found.
 */
export type Discovery = { 
/**
 * Version of what these keys mean: a new one where a key changes its meaning or goes.
 */
version: number, 
/**
 * The laws, the most probable first; none where no law of the grammar explains the rest, or nothing is
 * left to explain.
 */
laws: Array<FoundLaw>, 
/**
 * How probable it is that none of the laws that were looked at acts.
 */
none: number, 
/**
 * What the catalogue explains: the effects that stood beside every law.
 */
catalogue: Array<string>, 
/**
 * The diagnosis' verdict over all sensors.
 */
verdict: Verdict, 
/**
 * The most probable law that was not proposed, and why, where none was.
 */
rejected: Rejected | null, 
/**
 * The signals that were searched.
 */
signals: Array<string>, 
/**
 * Of these, columns of no known unit: they count as plain numbers.
 */
without_unit: Array<string>, 
/**
 * Columns that a formula cannot name, which were left out.
 */
unnamed: Array<string>, 
/**
 * Laws that were scored.
 */
scored: number, 
/**
 * Laws that the noise was fitted anew for.
 */
fitted: number, 
/**
 * The model's name: a preset or a file.
 */
model: string, 
/**
 * The flights learned from.
 */
flights: Array<string>, 
/**
 * The flights held out, if any; without, stretches of the flights are held out in turn.
 */
hold_outs: Array<string>, 
/**
 * What was remarkable about the input.
 */
warnings: Array<string>, };

/**
 * One curve.
 */
export type Drawn = { 
/**
 * What it is of.
 */
signal: Signal, 
/**
 * Its unit; empty where it has none or the flight does not say.
 */
unit: string, 
/**
 * Least value at each point of the axis; NaN where there is no value: the curve is drawn through, but
 * not over a gap.
 */
least: Numbers, 
/**
 * Greatest value.
 */
greatest: Numbers, 
/**
 * Standard deviation at each point, where the signal has one.
 */
sigma: Numbers | null, 
/**
 * From when to when the record has a gap, over which no line is drawn: pairs of seconds, one after the
 * other.
 */
gaps_s: Numbers, 
/**
 * Values that lie in the asked for time.
 */
values: number, };

/**
 * An effect that the model accounts for.
 */
export type EffectFacts = { 
/**
 * Its id in the catalogue.
 */
effect: string, 
/**
 * Its coefficient: as estimated by the end of captive flight, or the model's constant.
 */
coefficient: number, 
/**
 * Standard deviation of the coefficient.
 */
sigma: number, 
/**
 * Unit of both.
 */
unit: string, 
/**
 * Whether it was estimated.
 */
estimated: boolean, 
/**
 * The range of its regressor that the coefficient was learned in, metres per unit of coefficient.
 */
envelope_m: [number, number] | null, 
/**
 * Ticks at which it was used outside of that range.
 */
extrapolated_ticks: number, };

/**
 * An effect, explained.
 */
export type EffectGuide = { 
/**
 * Its id.
 */
effect: string, 
/**
 * What it acts on: a sensor, or `gps`.
 */
subject: string, 
/**
 * What it is, in a few words: the field's name for it.
 */
title: string, 
/**
 * What it is, in one sentence.
 */
what: string, 
/**
 * What the coefficient is multiplied by, metres per unit of it.
 */
formula: string, 
/**
 * Unit of the coefficient; `1` for a number.
 */
unit: string, 
/**
 * The plausible range of the coefficient.
 */
plausible: [number, number], 
/**
 * Where that range comes from.
 */
source: string, 
/**
 * What it looks like in a flight.
 */
looks_like: string, 
/**
 * The columns that it needs.
 */
needs: Array<string>, 
/**
 * Whether it has a time constant.
 */
has_time_constant: boolean, };

/**
 * One effect's coefficient.
 */
export type EffectOutlook = { 
/**
 * Its id.
 */
effect: string, 
/**
 * The sensor that it acts on; `gps` for the reference.
 */
sensor: string, 
/**
 * Unit of the coefficient.
 */
unit: string, 
/**
 * Whether it was found to act.
 */
is_found: boolean, 
/**
 * The coefficient as the flights have it, beside the effects that were found; null where they do not
 * show it.
 */
coefficient: number | null, 
/**
 * One sigma of it now, as the diagnosis has it; null where the flights do not show it.
 */
sigma_now: number | null, 
/**
 * One sigma with the planned flight; null where that does not show it either.
 */
sigma_then: number | null, 
/**
 * The largest coefficient that nature makes, either way.
 */
largest: number, 
/**
 * Whether the flights would have shown it at that size.
 */
is_seen_now: boolean, 
/**
 * Whether the flights and the planned one would.
 */
is_seen_then: boolean, 
/**
 * Whether the plan has its signals. One by formula may need a column that no simulation has.
 */
is_planned: boolean, };

/**
 * One effect by all flights of a vehicle.
 */
export type EffectResult = { 
/**
 * Its id.
 */
effect: string, 
/**
 * Its unit.
 */
unit: string, 
/**
 * Flights that tell it.
 */
flights: number, 
/**
 * Their mean, without the outliers.
 */
mean: number, 
/**
 * One sigma of it.
 */
sigma: number, 
/**
 * How much it differs from flight to flight beyond their sigmas, 1 sigma.
 */
spread: number, 
/**
 * Flights that do not belong with the others, the oddest first.
 */
outliers: Array<OddFlight>, };

/**
 * Asks for the catalogue.
 */
export type EffectsRequest = Record<symbol, never>;

/**
 * What a law is equal to on these flights.
 */
export type Equal = { 
/**
 * The law, or the id of the catalogue's effect.
 */
law: string, 
/**
 * Magnitude of the correlation of both whitened columns.
 */
correlation: number, 
/**
 * How probable it is, for a law.
 */
probability: number | null, };

/**
 * Errors of one sensor in one stretch.
 */
export type ErrorFigures = { 
/**
 * Mean, metres.
 */
mean_m: number, 
/**
 * Root mean square, metres.
 */
rms_m: number, };

/**
 * Makes a file of a result. Its bytes come with the answer: byte for byte what the command line writes.
 */
export type ExportRequest = { 
/**
 * What of.
 */
export: Exports, };

/**
 * A file, whose bytes go with the answer.
 */
export type Exported = { 
/**
 * A name for it.
 */
name: string, 
/**
 * Its media type.
 */
media: string, };

/**
 * What a file can be made of.
 */
export type Exports = { "what": "compare" } & CompareRequest | { "what": "diagnose" } & DiagnoseRequest | { "what": "ladder" } & LadderRequest | { "what": "flight", 
/**
 * The flight.
 */
flight: string, };

/**
 * Where the model fails.
 */
export type Failures = { 
/**
 * For each sensor the stretches of largest rms error, worst first.
 */
worst: Array<Stretch>, 
/**
 * Errors by manoeuvre, in the order of their first appearance in [`Manoeuvre`].
 */
by_manoeuvre: Array<ManoeuvreErrors>, 
/**
 * Which signals the motion was read from.
 */
sources: MotionSources, 
/**
 * What the flight would need for what it does not say.
 */
missing: Array<string>, };

/**
 * A fault of a sensor that had been healthy.
 */
export type Fault = { "step": { 
/**
 * Size, metres.
 */
size_m: number, } } | { "ramp": { 
/**
 * Growth, metres a second.
 */
rate_mps: number, } };

/**
 * A flight without and with the effect.
 */
export type FlightChange = { 
/**
 * The file.
 */
file: string, 
/**
 * Every sensor by name.
 */
sensors: { [key in string]: SensorChange }, };

/**
 * Which flight it was.
 */
export type FlightFacts = { 
/**
 * The file.
 */
file: string, 
/**
 * The vehicle.
 */
vehicle: string, 
/**
 * Where the flight comes from.
 */
source: string, 
/**
 * Rows.
 */
rows: number, 
/**
 * From the first row to the last, seconds.
 */
duration_s: number, 
/**
 * Whether the flight says itself when it was launched.
 */
has_launch: boolean, 
/**
 * How many flights are in the log; 0 where it says itself when it was launched, or shows none.
 */
flights: number, 
/**
 * Which of them is analysed, from 1.
 */
flight: number | null, 
/**
 * When it took off, seconds; null where that is not in the log.
 */
take_off_s: number | null, 
/**
 * When it landed, seconds; null where that is not in the log.
 */
landing_s: number | null, 
/**
 * Share of the log's time that is analysed.
 */
used_share: number, 
/**
 * What is not, and why.
 */
unused: Array<Unused>, 
/**
 * What else a user should know, one line each.
 */
remarks: Array<string>, };

/**
 * A flight that is planned.
 */
export type FlightPlan = { 
/**
 * True airspeed of straight and level flight, m/s.
 */
speed_mps: number, 
/**
 * Altitude at which it begins, m above mean sea level.
 */
altitude_m: number, 
/**
 * How long it flies straight and level before, for the calibration, seconds.
 */
calibration_s: number, 
/**
 * What is flown after that.
 */
legs: Array<PlannedLeg>, };

/**
 * Asks for what is in an opened flight, with the user's times.
 */
export type FlightRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * What the user says of its times.
 */
times: Times, };

/**
 * What one flight alone says.
 */
export type FlightResult = { 
/**
 * The file.
 */
file: string, 
/**
 * The vehicle, by the flight's header.
 */
vehicle: string, 
/**
 * The verdict; `None` where the diagnosis failed.
 */
verdict: Verdict | null, 
/**
 * Why it failed: a defect of this program.
 */
failed: string | null, 
/**
 * Coefficients of the effects in question, by their ids, where the flight tells them.
 */
coefficients: { [key in string]: Coefficient }, };

/**
 * A signal that the unexplained residual follows.
 */
export type Follows = { 
/**
 * The signal, and what of it.
 */
signal: string, 
/**
 * How far the residual lags behind it, s.
 */
lag_s: number, 
/**
 * How much of the residual it would explain, rms, m.
 */
size_m: number, 
/**
 * What it gains in twice the log likelihood.
 */
evidence: number, };

/**
 * A formula that was checked: either `problem` or `definition` is there.
 */
export type FormulaChecked = { 
/**
 * Why it cannot be used.
 */
problem: FormulaProblem | null, 
/**
 * It as a definition.
 */
definition: Defined | null, };

/**
 * What is wrong with a formula, and where.
 */
export type FormulaProblem = { 
/**
 * What, in words.
 */
message: string, 
/**
 * Where in the formula it begins, in UTF-16 units, as JavaScript counts.
 */
from: number, 
/**
 * Where it ends.
 */
to: number, };

/**
 * Checks an effect by formula as an `[[effect_definition]]` of a model, and fits it to a flight.
 */
export type FormulaRequest = { 
/**
 * The model as it is.
 */
model: ModelText, 
/**
 * Its id; null: one that is made of what it acts on and what it reads.
 */
id: string | null, 
/**
 * What it acts on: a sensor, `gps`, or `every sensor`.
 */
on: string, 
/**
 * The formula.
 */
regressor: string, 
/**
 * The largest plausible coefficient, either way; null: three times the one that fits, as
 * `pylon discover` has it.
 */
largest: number | null, 
/**
 * What it is, in words; may be empty.
 */
about: string, 
/**
 * The flight to fit it to.
 */
flight: string, 
/**
 * What the user says of its times.
 */
times: Times, 
/**
 * The error that it is to explain.
 */
error: Signal, 
/**
 * From when on the error counts, seconds; null: from its first value.
 */
from_s: number | null, };

/**
 * A law.
 */
export type FoundLaw = { 
/**
 * What it acts on: a sensor, or `gps`.
 */
on: string, 
/**
 * The law, as an effect definition takes it.
 */
regressor: string, 
/**
 * Unit of the coefficient.
 */
unit: string, 
/**
 * The coefficient.
 */
coefficient: number, 
/**
 * One sigma of it.
 */
sigma: number, 
/**
 * How probable it is that this law acts, among all that were looked at and none.
 */
probability: number, 
/**
 * The same of it and all that are equal to it on these flights.
 */
probability_with_equals: number, 
/**
 * Root mean square of the held-out errors without it, m.
 */
rms_before_m: number | null, 
/**
 * With it, m; neither is there where most of the error would be the coefficient's own.
 */
rms_after_m: number | null, 
/**
 * What it takes to say it, bits.
 */
bits: number, 
/**
 * What it gains in twice the log likelihood.
 */
evidence: number, 
/**
 * What the held-out flights, or else the stretches held out in turn, gain by it in twice the log
 * likelihood.
 */
held_out_gain: number, 
/**
 * How much of the residual it makes in free flight, rms, m.
 */
size_m: number, 
/**
 * Effects that were found without the law and that it takes the place of.
 */
instead_of: Array<string>, 
/**
 * Laws and effects that it cannot be told from on these flights, with the correlation of both.
 */
equal_to: Array<Equal>, 
/**
 * What to fly to tell it from these, in words; empty where nothing is known that would.
 */
advice: string, };

/**
 * What a manoeuvre by itself would tell.
 */
export type Gain = { 
/**
 * The probability that it would give the effect of a set that acts, the mean over the sets; null where
 * there is no set.
 */
tells_apart: number | null, 
/**
 * Effects that it would show and that no flight has.
 */
shows: number, 
/**
 * What an effect's interval would shrink to, as a share: the mean over the effects that the flights
 * show.
 */
narrows_to: number, };

/**
 * A stretch in which the reference jumped away and came back, by the flight's own clock.
 */
export type Glitch = { 
/**
 * Its start, s.
 */
from_s: number, 
/**
 * Its end, s.
 */
to_s: number, };

/**
 * A result in one plain sentence, with the number that matters.
 */
export type Headline = { 
/**
 * The sentence.
 */
sentence: string, 
/**
 * How good the news is.
 */
tone: Tone, 
/**
 * The effect that it names, if it names one: what Add would add.
 */
effect: string | null, };

/**
 * What was held out, with an effect and without.
 */
export type HeldOutVerdict = { 
/**
 * What twice the log likelihood gains by the effect; negative: it is worse with it.
 */
gain: number, 
/**
 * One sigma of the gain by chance.
 */
gain_sigma: number, 
/**
 * What the gain would be if the effect acted just as learned; minus that if it did not act.
 */
gain_as_learned: number, 
/**
 * Whether it is worse beyond chance.
 */
is_worse: boolean, 
/**
 * Whether an effect that does not act would be seen, with a chance of 95 %.
 */
can_tell: boolean, };

/**
 * What the errors before and after are of.
 */
export type JudgedOn = "held_out_flights" | "held_out_manoeuvres";

/**
 * The keys of `pylon ladder --json`.
 */
export type Ladder = { 
/**
 * Version of what these keys mean: a new one where a key changes its meaning or goes.
 */
version: number, 
/**
 * The model's name.
 */
model: string, 
/**
 * Its revisions, oldest first; the first is before all of them.
 */
revisions: Array<LadderRevision>, };

/**
 * Flies every revision of a model over flights: `pylon ladder`. Answered by what `pylon ladder --json`
 * prints.
 */
export type LadderRequest = { 
/**
 * The flights.
 */
flights: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * What the user says of their times.
 */
times: { [key in string]: Times }, };

/**
 * One revision.
 */
export type LadderRevision = { 
/**
 * Its number; 0 is before all revisions.
 */
number: number, 
/**
 * The effect that it added or learned anew.
 */
effect: string | null, 
/**
 * The day.
 */
date: string | null, 
/**
 * The effects of the model as it left it.
 */
effects: Array<string>, 
/**
 * Every flight.
 */
flights: Array<RevisionFlight>, };

/**
 * What the aircraft was doing.
 */
export type Manoeuvre = "level_flight" | "acceleration" | "deceleration" | "climb" | "descent" | "dive" | "pull_up" | "push_over" | "level_turn" | "climbing_turn" | "descending_turn" | "at_rest" | "unknown";

/**
 * Errors in all that was flown of one manoeuvre.
 */
export type ManoeuvreErrors = { 
/**
 * What the aircraft was doing.
 */
doing: Manoeuvre, 
/**
 * For how long, in all, seconds.
 */
seconds: number, 
/**
 * How it moved, on average.
 */
motion: Motion, 
/**
 * Errors of the sensors that flew, by name.
 */
sensors: Array<[string, ErrorFigures | null]>, };

/**
 * An effect of a set.
 */
export type MemberOutlook = { 
/**
 * Its id.
 */
effect: string, 
/**
 * The probability that it is the one that acts, now.
 */
probability: number, 
/**
 * The probability that it would be given with the planned flight, if it is the one: the median over that
 * flight's noise. Null for one whose signal the flights lack.
 */
probability_then: number | null, 
/**
 * How many of the set, itself among them, would then still have a probability of 5 % or more.
 */
left: number | null, 
/**
 * By how many sigmas the planned flight would tell it from the one of the others that is most like it.
 */
sigmas: number | null, };

/**
 * What is in a model.
 */
export type ModelFacts = { 
/**
 * The effects that it accounts for, in its order.
 */
effects: Array<TermFacts>, 
/**
 * Its revisions, oldest first.
 */
revisions: Array<RevisionFacts>, 
/**
 * What in it is unlikely.
 */
warnings: Array<string>, };

/**
 * Asks what is in a model. An error is the file's own: line, key, what was expected.
 */
export type ModelRequest = { 
/**
 * The model.
 */
model: ModelText, };

/**
 * A model, as its file is.
 */
export type ModelText = { 
/**
 * What results call it: a file's name, or a preset's.
 */
name: string, 
/**
 * Its TOML. An empty one is the default model.
 */
text: string, };

/**
 * The monitor as configured.
 */
export type MonitorFacts = { 
/**
 * Where sigma comes from.
 */
sigma: string, 
/**
 * Threshold in sigmas.
 */
multiplier: number, 
/**
 * Length of the moving average, seconds.
 */
window_s: number, 
/**
 * For how long the error must have been beyond the threshold before a sensor is untrustworthy, seconds.
 */
persistence_s: number, };

/**
 * A monitor's rule: `|moving average over window_s| > threshold_m`.
 */
export type MonitorRule = { 
/**
 * Threshold, metres: the multiplier times sigma.
 */
threshold_m: number, 
/**
 * Length of the moving average, seconds.
 */
window_s: number, };

/**
 * How the aircraft moved during one stretch of flight; `None` where the flight does not say.
 */
export type Motion = { 
/**
 * Climb rate, m/s, up positive.
 */
climb_rate_mps: number | null, 
/**
 * Speed, m/s: true airspeed, or else over ground.
 */
speed_mps: number | null, 
/**
 * Its growth, m/s^2.
 */
acceleration_mps2: number | null, 
/**
 * Load factor.
 */
load_factor: number | null, 
/**
 * Turn rate, rad/s, to the right positive.
 */
turn_rate_radps: number | null, };

/**
 * How the aircraft moved, second by second; NaN where the flight does not say.
 */
export type MotionNumbers = { 
/**
 * Middle of the second, seconds of the flight's own clock.
 */
time_s: Numbers, 
/**
 * Climb rate, m/s.
 */
climb_rate_mps: Numbers, 
/**
 * Speed, m/s.
 */
speed_mps: Numbers, 
/**
 * Load factor.
 */
load_factor: Numbers, 
/**
 * Turn rate, rad/s.
 */
turn_rate_radps: Numbers, };

/**
 * Which signal a quantity was read from.
 */
export type MotionSources = { 
/**
 * Of the climb rate.
 */
climb_rate: string | null, 
/**
 * Of the speed.
 */
speed: string | null, 
/**
 * Of the load factor.
 */
load_factor: string | null, 
/**
 * Of the turn rate.
 */
turn_rate: string | null, };

/**
 * The noise that was found.
 */
export type NoiseFacts = { 
/**
 * The reference's wander: sigma, m.
 */
reference_wander_m: number, 
/**
 * Its correlation time, s.
 */
reference_time_s: number, 
/**
 * A second, slower wander of the difference of the altitudes, the reference's or a sensor's: sigma, m; 0
 * where the climb rate is measured, which needs none.
 */
slow_wander_m: number, 
/**
 * Its correlation time, s.
 */
slow_time_s: number, 
/**
 * White noise of one fix, m.
 */
fix_sigma_m: number, 
/**
 * Each sensor's own wander (captive flight).
 */
sensor_wander: { [key in string]: SensorWander }, };

/**
 * Where an array lies in the numbers that are handed over with an answer: f64, in the machine's own order.
 *
 * NaN stands for: no value here.
 */
export type Numbers = { 
/**
 * The first one's place.
 */
start: number, 
/**
 * How many.
 */
length: number, };

/**
 * A flight that does not belong with the others.
 */
export type OddFlight = { 
/**
 * The file.
 */
file: string, 
/**
 * Its coefficient.
 */
coefficient: number, 
/**
 * One sigma.
 */
sigma: number, 
/**
 * Chance that one of so many flights is as far off, were all alike.
 */
p_value: number, };

/**
 * A manoeuvre that can be chosen.
 */
export type Offer = { 
/**
 * It, as it is suggested.
 */
leg: PlannedLeg, 
/**
 * What the amount is: `m/s`, `deg`, `g`; empty where there is none.
 */
unit: string, 
/**
 * The least amount.
 */
least: number, 
/**
 * The largest.
 */
most: number, 
/**
 * What it would tell by itself; null where that was not asked, or it cannot be flown there.
 */
gain: Gain | null, };

/**
 * Opens the log whose bytes come with the request: any format that Pylon imports, told by its content. An
 * error is the importer's own line.
 */
export type OpenRequest = { 
/**
 * What later requests call the flight; one of that name is replaced.
 */
flight: string, 
/**
 * The file's name, for results and messages.
 */
file: string, };

/**
 * Simulates a flight that comes with Pylon, and opens it.
 */
export type OpenSampleRequest = { 
/**
 * What later requests call the flight.
 */
flight: string, 
/**
 * The sample's name.
 */
sample: string, };

/**
 * An opened flight.
 */
export type Opened = { 
/**
 * What `pylon open --json` says: the format, take-off, landing, launch, what is used and what not and
 * why, the sensors, the notes of the importer; `refused` says why it cannot be analysed, where it
 * cannot.
 */
overview: Overview, 
/**
 * The vehicle, with what tells it from another of its type: flights are grouped by it.
 */
vehicle: string, 
/**
 * First and last time of the flight's own clock, seconds.
 */
first_s: number, 
/**
 * See [`Self::first_s`].
 */
last_s: number, 
/**
 * Every column, those that Pylon knows first.
 */
columns: Array<ColumnFacts>, 
/**
 * The altitude sensors that a mission over this flight has, by name: `baro`, `imu_slave`, `imu_master`.
 */
sensors: Array<string>, };

/**
 * What the flights tell now, and what they would tell with the planned one.
 */
export type Outlook = { 
/**
 * Every effect that the flights have the signals of, those that were found first.
 */
effects: Array<EffectOutlook>, 
/**
 * Every set of effects that the flights can't tell apart.
 */
sets: Array<SetOutlook>, };

/**
 * What is in a log: the keys of `pylon open --json`.
 */
export type Overview = { 
/**
 * Version of what these keys mean: a new one where a key changes its meaning or goes.
 */
version: number, 
/**
 * The file.
 */
file: string, 
/**
 * What kind of log it is.
 */
format: string, 
/**
 * The vehicle, as the log says.
 */
vehicle: string, 
/**
 * Rows.
 */
rows: number, 
/**
 * First time of the flight's own clock, seconds: what `--calibrate` counts from is zero of that clock,
 * not this.
 */
first_s: number, 
/**
 * From the first row to the last, seconds.
 */
duration_s: number, 
/**
 * When it was launched or dropped, by its own `launch` column, seconds.
 */
launch_s: number | null, 
/**
 * When it was dropped from a carrier, by how it falls, seconds; null where it was not, or has a `launch`
 * column.
 */
drop_s: number | null, 
/**
 * The share of it that a diagnosis works on, which needs no calibration; null where it cannot be
 * analysed.
 */
diagnosed_share: number | null, 
/**
 * Every time in the air.
 */
airborne: Array<AirborneTime>, 
/**
 * On the ground before the take-off of the flight that is analysed, seconds.
 */
ground_before_s: number | null, 
/**
 * After its landing, seconds.
 */
after_landing_s: number | null, 
/**
 * Where it is calibrated, in words; null where nothing can be.
 */
calibration: string | null, 
/**
 * From when to when it is calibrated, seconds; null for a flight with a launch, or where nothing can be
 * calibrated.
 */
calibration_window_s: [number, number] | null, 
/**
 * Why it cannot be analysed, if it cannot.
 */
refused: string | null, 
/**
 * What is wrong with the barometer for all of the log, if anything is.
 */
barometer_fault: string | null, 
/**
 * The sensors.
 */
sensors: Array<SensorView>, 
/**
 * What was remarkable about the log.
 */
notes: Array<string>, 
/**
 * Commands to go on with.
 */
next: Array<string>, 
/**
 * Whether the flight says itself when it was launched.
 */
has_launch: boolean, 
/**
 * How many flights are in the log; 0 where it says itself when it was launched, or shows none.
 */
flights: number, 
/**
 * Which of them is analysed, from 1.
 */
flight: number | null, 
/**
 * When it took off, seconds; null where that is not in the log.
 */
take_off_s: number | null, 
/**
 * When it landed, seconds; null where that is not in the log.
 */
landing_s: number | null, 
/**
 * Share of the log's time that is analysed.
 */
used_share: number, 
/**
 * What is not, and why.
 */
unused: Array<Unused>, 
/**
 * What else a user should know, one line each.
 */
remarks: Array<string>, };

/**
 * Points: every value of y with x at that time, between x's values on a straight line, and not over a gap.
 */
export type Paired = { 
/**
 * When, seconds.
 */
time_s: Numbers, 
/**
 * Across.
 */
x: Numbers, 
/**
 * Up.
 */
y: Numbers, 
/**
 * x's unit.
 */
x_unit: string, 
/**
 * y's unit.
 */
y_unit: string, 
/**
 * How many points there are, of which those are shown.
 */
of: number, 
/**
 * Values of y that x has none for.
 */
unpaired: number, };

/**
 * What a sensor's errors were like in one phase. A value that the readings cannot give is `None`.
 */
export type PhaseSummary = { 
/**
 * Readings that had a reference to be compared with.
 */
readings: number, 
/**
 * Time from the first of them to the last, seconds.
 */
duration_s: number, 
/**
 * Mean error (eq. 16, by the latched calibration), metres.
 */
bias_m: number | null, 
/**
 * Standard error of that mean under the errors' own autocorrelation, metres.
 */
bias_standard_error_m: number | null, 
/**
 * Standard deviation of the error, metres.
 */
spread_m: number | null, 
/**
 * The same by the median absolute deviation, which a few outliers do not move, metres.
 */
robust_spread_m: number | null, 
/**
 * Root mean square of the error, metres.
 */
rms_m: number | null, 
/**
 * How many independent readings they are worth.
 */
effective_readings: number | null, 
/**
 * Correlation time of the error (integrated autocorrelation time), seconds.
 */
correlation_time_s: number | null, 
/**
 * Whiteness of the errors.
 */
error_whiteness: Whiteness | null, 
/**
 * Whiteness of the filter's innovations; captive flight only.
 */
innovation_whiteness: Whiteness | null, 
/**
 * Normalised innovation squared against its chi-squared bounds; captive flight only.
 */
nis: Consistency | null, };

/**
 * Plans a flight, simulates it, and says what it would tell with the flights that there are.
 */
export type PlanRequest = { 
/**
 * The flights to learn from.
 */
flights: Array<string>, 
/**
 * The flights to judge by.
 */
hold_outs: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * What the user says of their times.
 */
times: { [key in string]: Times }, 
/**
 * The plan; null: the one that Pylon suggests, with what each manoeuvre would tell by itself.
 */
plan: FlightPlan | null, };

/**
 * A planned flight.
 */
export type Planned = { 
/**
 * The plan.
 */
plan: FlightPlan, 
/**
 * What it would tell.
 */
outlook: Outlook, 
/**
 * It as a scenario: what `pylon simulate` takes, and what was simulated here.
 */
scenario: string, 
/**
 * Its segments, for the flight card.
 */
segments: Array<PlannedSegment>, 
/**
 * What it reaches.
 */
reached: Reached, 
/**
 * How long it takes, calibration included, seconds.
 */
duration_s: number, 
/**
 * What can be chosen, the best first where their gains were asked for.
 */
offers: Array<Offer>, 
/**
 * What the user should know of it.
 */
remarks: Array<string>, };

/**
 * A part of a plan.
 */
export type PlannedLeg = { 
/**
 * What is flown.
 */
manoeuvre: PlannedManoeuvre, 
/**
 * How much of it, in the unit that the offer says.
 */
amount: number, 
/**
 * How long each of its stretches is held, seconds.
 */
duration_s: number, 
/**
 * How often it is flown.
 */
times: number, };

/**
 * What can be flown.
 */
export type PlannedManoeuvre = "speed_sweep" | "climbs" | "pull_ups" | "turns" | "level" | "long_climb" | "legs";

/**
 * One segment, as the scenario has it.
 */
export type PlannedSegment = { 
/**
 * `straight`, `climb`, `dive`, `level_off`, `pull_up`, `turn`, `accelerate`, `decelerate`.
 */
manoeuvre: string, 
/**
 * From when, seconds after the calibration.
 */
from_s: number, 
/**
 * How long, seconds.
 */
duration_s: number, 
/**
 * The airspeed to hold, m/s.
 */
airspeed_mps: number, 
/**
 * The path to fly, degrees above the horizon, where it has one.
 */
flight_path_deg: number | null, 
/**
 * The bank, degrees, positive to the right, where it has one.
 */
bank_deg: number | null, 
/**
 * The load factor's limit, where it has one.
 */
load_factor: number | null, 
/**
 * Altitude at its end as simulated, m above mean sea level.
 */
altitude_then_m: number, };

/**
 * A model that comes with Pylon.
 */
export type Preset = { 
/**
 * The model.
 */
model: ModelText, 
/**
 * What it is, in one sentence.
 */
about: string, };

/**
 * Asks for the models that come with Pylon.
 */
export type PresetsRequest = Record<symbol, never>;

/**
 * The least and the greatest of what the simulated flight reaches.
 */
export type Reached = { 
/**
 * True airspeed, m/s.
 */
airspeed_mps: [number, number], 
/**
 * Altitude, m above mean sea level.
 */
altitude_m: [number, number], 
/**
 * Load factor.
 */
load_factor: [number, number], 
/**
 * Farthest from where it begins, m.
 */
distance_m: number, };

/**
 * How often a source's readings were used or not.
 */
export type ReadingCounts = { 
/**
 * Used.
 */
accepted: number, 
/**
 * NaN or infinite, or an invalid pressure.
 */
not_finite: number, 
/**
 * A fix held since the last.
 */
held: number, 
/**
 * A sensor that repeats itself.
 */
stuck: number, 
/**
 * Refused by the filter.
 */
variance: number, 
/**
 * Finite, and no aircraft can be there or do that.
 */
implausible: number, 
/**
 * Outliers: too far from what the filter expected.
 */
gated: number, };

/**
 * A recommended rule.
 */
export type Recommendation = { 
/**
 * Value for `[monitor] multiplier`.
 */
multiplier: number, 
/**
 * Value for `[monitor] window_s`.
 */
window_s: number, 
/**
 * Whether it detects the step nine times in ten; if not, no rule does at that false-alarm rate,
 * and this one detects the smallest step.
 */
detects_step: boolean, 
/**
 * The smallest step that it detects nine times in ten, metres.
 */
smallest_step_m: number, 
/**
 * What it costs and catches.
 */
quality: RuleQuality, };

/**
 * The reference in captive flight.
 */
export type ReferenceComparison = { 
/**
 * Innovations of its fixes: bias, spread, whiteness, NIS.
 */
captive: PhaseSummary, 
/**
 * Fixes that were and were not used.
 */
fixes: ReadingCounts, };

/**
 * A law that was not proposed.
 */
export type Rejected = { 
/**
 * What it acts on.
 */
on: string, 
/**
 * The law.
 */
regressor: string, 
/**
 * Why not.
 */
why: Why, 
/**
 * The effect of the catalogue that explains as much, if that is why.
 */
effect: string | null, };

/**
 * One second correction, for every sensor that flies free.
 */
export type Remedy = { 
/**
 * `none`, `moving_average` or `kalman`.
 */
second_correction: string, 
/**
 * The sensors.
 */
sensors: Array<RemedyFigures>, };

/**
 * What a second correction did for one sensor.
 */
export type RemedyFigures = { 
/**
 * The sensor.
 */
sensor: string, 
/**
 * Mean error in free flight, metres.
 */
mean_m: number, 
/**
 * Root mean square error in free flight, metres.
 */
rms_m: number, 
/**
 * When the sensor became doubtful, seconds after launch.
 */
doubtful_after_s: number | null, 
/**
 * When it became untrustworthy, seconds after launch.
 */
untrustworthy_after_s: number | null, };

/**
 * White noise plus first-order Gauss-Markov processes, sampled at a fixed interval.
 *
 * Non-negative variances make it a valid process whatever the data; an oscillating autocovariance
 * is outside it and is replaced by its nearest monotone one. Values are Gaussian.
 */
export type ResidualModel = { 
/**
 * Time between samples, seconds.
 */
sample_interval_s: number, 
/**
 * Variance of the white part, square metres.
 */
white_variance_m2: number, 
/**
 * The correlated parts.
 */
components: Array<Component>, 
/**
 * Longest lag that the data could say anything about, seconds.
 */
longest_lag_s: number, };

/**
 * A revision of a model.
 */
export type RevisionFacts = { 
/**
 * Its number.
 */
number: number, 
/**
 * The effect that it added or learned anew.
 */
effect: string | null, 
/**
 * The day.
 */
date: string | null, };

/**
 * One flight with one revision.
 */
export type RevisionFlight = { 
/**
 * The file.
 */
file: string, 
/**
 * Every sensor by name.
 */
sensors: { [key in string]: SensorScore }, };

/**
 * The ribbons below a flight's curves.
 */
export type Ribbons = { 
/**
 * `settling`, `calibrating`, `free_flight`.
 */
phases: Array<Span>, 
/**
 * By sensor: `calibrating`, `trusted`, `doubtful`, `untrustworthy`, `unmonitored`.
 */
trust: { [key in string]: Array<Span> }, 
/**
 * `level_flight`, `climb`, `dive` and so on.
 */
manoeuvres: Array<Span>, 
/**
 * The motion.
 */
motion: MotionNumbers, 
/**
 * Which signals it was read from.
 */
sources: MotionSources, 
/**
 * The alarm limit of each sensor's moving average and error, m, either side of zero.
 */
bounds_m: { [key in string]: number }, 
/**
 * When the UAV was launched, seconds of the flight's own clock.
 */
launch_s: number | null, };

/**
 * What a rule costs on a healthy sensor and how soon it detects faults.
 */
export type RuleQuality = { 
/**
 * The rule.
 */
rule: MonitorRule, 
/**
 * Share of a healthy sensor's readings beyond the threshold (eq. 17, left).
 */
healthy_share_beyond: number, 
/**
 * Median time until a healthy sensor's first reading beyond the threshold, seconds; `None` when
 * longer than ten minutes.
 */
healthy_first_doubt_s: number | null, 
/**
 * Times an hour at which a healthy sensor would be called untrustworthy (eq. 17, right), once
 * the window is full.
 */
false_alarms_per_hour: number, 
/**
 * Share of launches at which a healthy sensor would be called untrustworthy before the window is
 * full: until then what is not covered counts as no error.
 */
healthy_alarm_in_first_window: number, 
/**
 * Detection of the faults asked about.
 */
delays: Array<Delay>, };

/**
 * A flight that comes with Pylon: a scenario, simulated when it is opened.
 */
export type Sample = { 
/**
 * Its name, for [`OpenSampleRequest`].
 */
name: string, 
/**
 * What it is, in one sentence, that it is simulated included.
 */
about: string, };

/**
 * Asks for the flights that come with Pylon.
 */
export type SamplesRequest = Record<symbol, never>;

/**
 * Asks for the points of one signal over another.
 */
export type ScatterRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model that flies.
 */
model: ModelText, 
/**
 * What the user says of its times.
 */
times: Times, 
/**
 * Across.
 */
x: Signal, 
/**
 * Up.
 */
y: Signal, 
/**
 * From when, seconds of the flight's own clock; null: from its first row.
 */
from_s: number | null, 
/**
 * To when; null: to its last.
 */
to_s: number | null, 
/**
 * More points than this are thinned out evenly.
 */
at_most: number, };

/**
 * A sensor on a flight without and with the effect.
 */
export type SensorChange = { 
/**
 * With the model as it was.
 */
before: SensorScore, 
/**
 * With the new one.
 */
after: SensorScore, };

/**
 * One sensor.
 */
export type SensorComparison = { 
/**
 * Whether the sensor leaves with the UAV.
 */
flies_free: boolean, 
/**
 * Bias as latched (without a launch: as estimated last), metres.
 */
bias_m: number | null, 
/**
 * Its standard deviation by the filter, metres.
 */
bias_sigma_m: number | null, 
/**
 * Spread of the calibrated residual in captive flight (Table 1 of the paper), metres.
 */
residual_sigma_m: number | null, 
/**
 * Root mean square error in captive flight, by the latched bias, metres.
 */
captive_rms_m: number | null, 
/**
 * Root mean square error in free flight, metres.
 */
free_flight_rms_m: number | null, 
/**
 * Moving average of the error at the flight's end, metres.
 */
moving_average_end_m: number | null, 
/**
 * When the sensor became doubtful, seconds after launch.
 */
doubtful_after_s: number | null, 
/**
 * When it became untrustworthy, seconds after launch.
 */
untrustworthy_after_s: number | null, 
/**
 * Trust at the flight's end.
 */
trust: string, 
/**
 * For how long there was no reference to watch it by, seconds.
 */
unmonitored_s: number, 
/**
 * The monitor's alarm limit (multiplier times sigma), metres.
 */
bound_m: number | null, 
/**
 * Captive flight after settling.
 */
captive: PhaseSummary, 
/**
 * Free flight.
 */
free_flight: PhaseSummary, 
/**
 * Readings that were and were not used.
 */
readings: ReadingCounts, };

/**
 * One sensor, or the reference.
 */
export type SensorDiagnosis = { 
/**
 * The verdict.
 */
verdict: Verdict, 
/**
 * Ids of the effects that are missing for sure, the strongest first.
 */
missing: Array<string>, 
/**
 * Sets of ids: of each set, one acts, and the flights can't tell which. The most probable comes first;
 * those below 5 % are not listed, but for the second.
 */
indistinguishable: Array<Array<string>>, 
/**
 * How probable each of a set is to be the one that acts, in the order of `indistinguishable`; what they
 * lack to one is of those that are not listed.
 */
probabilities: Array<Array<number>>, 
/**
 * Every effect that was tried, the chosen ones first and then by their p-value.
 */
candidates: Array<CandidateFacts>, 
/**
 * What to do next, in words; empty where nothing is to be done.
 */
advice: string, 
/**
 * Signals that an unexplained residual follows, the closest first.
 */
follows: Array<Follows>, 
/**
 * How many times larger the sensor's own wander is in free flight than in captive flight, once
 * everything that was found is taken off.
 */
free_flight_factor: number | null, };

/**
 * The rule that is set and the one that is recommended, for one sensor.
 */
export type SensorRules = { 
/**
 * The residual's stochastic model, fitted to its autocovariance in captive flight.
 */
residual: ResidualModel, 
/**
 * The rule that flew.
 */
set: RuleQuality | null, 
/**
 * The rule that detects the step soonest at the wanted false-alarm rate.
 */
recommended: Recommendation | null, 
/**
 * The wanted rate of false alarms, per hour.
 */
wanted_false_alarms_per_hour: number, };

/**
 * One sensor's errors on one flight (eq. 16), and its flags.
 */
export type SensorScore = { 
/**
 * Root mean square error in captive flight, by the latched bias, metres; `None` without a reading.
 */
captive_rms_m: number | null, 
/**
 * Root mean square error in free flight, metres; `None` without a reading.
 */
free_flight_rms_m: number | null, 
/**
 * When it became doubtful, seconds after launch; `None`: never.
 */
doubtful_after_s: number | null, 
/**
 * When it became untrustworthy, seconds after launch; `None`: never.
 */
untrustworthy_after_s: number | null, 
/**
 * How long it flew free: from launch to the flight's last tick, seconds; `None` without launch.
 */
free_flight_s: number | null, };

/**
 * Whether a sensor measured.
 */
export type SensorState = "present" | "stuck" | "copied" | "absent";

/**
 * A sensor of a log.
 */
export type SensorView = { 
/**
 * Its name.
 */
sensor: string, 
/**
 * Whether it measured.
 */
state: SensorState, 
/**
 * Samples.
 */
samples: number, 
/**
 * Median rate, samples a second.
 */
rate_hz: number | null, 
/**
 * Its columns.
 */
columns: Array<string>, 
/**
 * What its altitudes are measured from, `msl`, `ellipsoid` or `pressure`; null for what is no altitude.
 */
datum: string | null, };

/**
 * A sensor's own wander.
 */
export type SensorWander = { 
/**
 * Its sigma, m.
 */
sigma_m: number, 
/**
 * Its correlation time, s.
 */
time_s: number, };

/**
 * Curves on one time axis.
 */
export type Series = { 
/**
 * The axis, seconds, increasing: a row's time each, or the middle of a pixel's slot.
 */
time_s: Numbers, 
/**
 * Whether a point is a pixel's slot, with least and greatest value; otherwise it is a row, and these are
 * the same array.
 */
is_thinned: boolean, 
/**
 * The curves, in the request's order.
 */
curves: Array<Drawn>, };

/**
 * Asks for curves on one time axis, thinned out so that their drawing looks the same: no spike is lost.
 */
export type SeriesRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model that flies.
 */
model: ModelText, 
/**
 * What the user says of its times.
 */
times: Times, 
/**
 * The curves.
 */
signals: Array<Signal>, 
/**
 * From when, seconds of the flight's own clock; null: from its first row.
 */
from_s: number | null, 
/**
 * To when; null: to its last.
 */
to_s: number | null, 
/**
 * How many pixels the axis has.
 */
pixels: number, };

/**
 * Effects of which one acts.
 */
export type SetOutlook = { 
/**
 * Its effects, the most probable first.
 */
members: Array<MemberOutlook>, };

/**
 * What a curve is of.
 */
export type Signal = { "signal": "column", 
/**
 * The name.
 */
name: string, } | { "signal": "reference" } | { "signal": "estimate" } | { "signal": "measured", 
/**
 * The sensor.
 */
sensor: string, } | { "signal": "modelled", 
/**
 * The sensor.
 */
sensor: string, } | { "signal": "error", 
/**
 * The sensor.
 */
sensor: string, } | { "signal": "moving_average", 
/**
 * The sensor.
 */
sensor: string, } | { "signal": "beyond_reference", 
/**
 * The sensor.
 */
sensor: string, 
/**
 * The diagnosis' `noise`.
 */
noise: NoiseFacts, 
/**
 * The effects that it found and that the model lacks: they are no wander of the reference's either.
 */
found: Array<Acting>, } | { "signal": "effect", 
/**
 * The effect.
 */
of: Acting, } | { "signal": "climb_rate" } | { "signal": "speed" } | { "signal": "load_factor" } | { "signal": "turn_rate" };

/**
 * A stretch of time and what there was in it.
 */
export type Span = { 
/**
 * From when, seconds of the flight's own clock.
 */
from_s: number, 
/**
 * To when.
 */
to_s: number, 
/**
 * What, a word of the catalogue: a manoeuvre, a trust, a phase.
 */
what: string, };

/**
 * A stretch of flight in which the aircraft did one thing.
 */
export type Stretch = { 
/**
 * Start and end, seconds after launch.
 */
from_s: number, 
/**
 * See [`Self::from_s`].
 */
to_s: number, 
/**
 * What the aircraft was doing.
 */
doing: Manoeuvre, 
/**
 * How it moved, on average.
 */
motion: Motion, 
/**
 * The sensor.
 */
sensor: string, 
/**
 * Mean error, metres.
 */
mean_m: number, 
/**
 * Root mean square error, metres.
 */
rms_m: number, 
/**
 * Share of the sensor's squared error over the whole of free flight.
 */
share_of_squared_error: number, };

/**
 * An effect of a model.
 */
export type TermFacts = { 
/**
 * Its id.
 */
effect: string, 
/**
 * Its coefficient.
 */
coefficient: number, 
/**
 * One sigma of it.
 */
sigma: number, 
/**
 * Unit of both.
 */
unit: string, 
/**
 * Whether the filter estimates it in captive flight.
 */
estimate: boolean, 
/**
 * Time constant of its regressor, seconds, where it has one.
 */
time_constant_s: number | null, 
/**
 * When that regressor's clock starts: `launch` or `start`.
 */
since: string | null, 
/**
 * What it was learned from.
 */
learned_from: string | null, 
/**
 * The day.
 */
date: string | null, };

/**
 * What the user says of a flight's times; null: what Pylon finds.
 */
export type Times = { 
/**
 * Where to calibrate.
 */
window: Window | null, 
/**
 * When it was in the air.
 */
airborne: Airborne | null, };

/**
 * How good the news is; what it is drawn as.
 */
export type Tone = "good" | "caution" | "bad";

/**
 * An effect that could not be tested.
 */
export type Untested = { 
/**
 * Its id.
 */
effect: string, 
/**
 * The columns that it needs.
 */
needs: Array<string>, 
/**
 * Why no column would help, where none would.
 */
reason?: string | null, };

/**
 * A part of a log that is not analysed.
 */
export type Unused = { 
/**
 * From when, seconds.
 */
from_s: number, 
/**
 * To when, seconds.
 */
to_s: number, 
/**
 * Share of the whole log.
 */
share: number, 
/**
 * Why.
 */
reason: string, };

/**
 * A vehicle's flights.
 */
export type VehicleResult = { 
/**
 * The vehicle; empty where the header does not say one.
 */
vehicle: string, 
/**
 * Its flights.
 */
flights: number, 
/**
 * The effects in question that any of them tells.
 */
effects: Array<EffectResult>, };

/**
 * What is known about a misfit. Ordered by how much it asks of the user.
 */
export type Verdict = "no_significant_misfit" | "insufficient_excitation" | "identified" | "indistinguishable" | "unknown_effect";

/**
 * How white a sequence is.
 */
export type Whiteness = { 
/**
 * Autocorrelation at a lag of one sample; its standard error is 1 / sqrt(n) for a white sequence.
 */
lag_one: number, 
/**
 * Ljung-Box statistic over the first 15 lags.
 */
ljung_box: number, 
/**
 * Probability that a white sequence exceeds it.
 */
p_value: number, 
/**
 * How many values there were.
 */
count: number, };

/**
 * Why a law was not proposed.
 */
export type Why = "not_enough_evidence" | "held_out" | "catalogue" | "shape" | "no_formula";

/**
 * Where to calibrate, seconds of the flight's own clock; launch is said at its end.
 */
export type Window = { 
/**
 * Start.
 */
start_s: number, 
/**
 * End.
 */
end_s: number, };

/** Every request by its name, with its argument and its answer. */
export interface Calls {
  open: { of: OpenRequest; answer: Opened };
  samples: { of: SamplesRequest; answer: Array<Sample> };
  open_sample: { of: OpenSampleRequest; answer: Opened };
  flight: { of: FlightRequest; answer: Opened };
  close: { of: CloseRequest; answer: Closed };
  presets: { of: PresetsRequest; answer: Array<Preset> };
  model: { of: ModelRequest; answer: ModelFacts };
  effects: { of: EffectsRequest; answer: Array<EffectGuide> };
  series: { of: SeriesRequest; answer: Series };
  ribbons: { of: CompareRequest; answer: Ribbons };
  scatter: { of: ScatterRequest; answer: Paired };
  correlation: { of: CorrelationRequest; answer: Correlated };
  compare: { of: CompareRequest; answer: Compared };
  diagnose: { of: DiagnoseRequest; answer: Diagnosed };
  plan: { of: PlanRequest; answer: Planned };
  formula: { of: FormulaRequest; answer: FormulaChecked };
  discover: { of: DiscoverRequest; answer: Discovered };
  add: { of: AddRequest; answer: Added };
  ladder: { of: LadderRequest; answer: Ladder };
  export: { of: ExportRequest; answer: Exported };
}
