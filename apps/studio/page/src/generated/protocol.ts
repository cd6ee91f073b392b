// Made from the engine's own types by its test: UPDATE_TYPES=1 cargo test -p studio-engine --test types
//
// A number that is not finite comes as null, also where the type says `number`.

/**
 * An effect and its coefficient, as in a diagnosis' candidate.
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
 * The held-out flights.
 */
hold_outs: Array<string>, 
/**
 * The current model.
 */
model: ModelText, 
/**
 * The user's times for them.
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
 * The date to record, as 2026-01-31.
 */
date: string, };

/**
 * An effect added.
 */
export type Added = { 
/**
 * What `pylon add --json` prints. If it has `concerns`, the command line would not write it without
 * `--force`.
 */
addition: Addition, 
/**
 * The model with it: the next revision, under the same name.
 */
model: ModelText, 
/**
 * What was learned and how the error falls, in one sentence.
 */
headline: Headline, 
/**
 * Every revision of that model on the flights, those to learn from first: the answer to a
 * [`LadderRequest`]. Null if a flight cannot be calibrated.
 */
ladder: Ladder | null, };

/**
 * An effect added: the keys of `pylon add --json`.
 */
export type Addition = { 
/**
 * Version of the keys' meaning. It increases where a key changes its meaning or is removed.
 */
version: number, 
/**
 * Its id.
 */
effect: string, 
/**
 * The catalogue's effect of which it is another form: a delay that acts as a low pass is written as one,
 * by a definition in the model.
 */
instead_of: string | null, 
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
 * Root mean square error of the sensors concerned before the addition, on the data named by `judged_on`,
 * metres.
 */
rms_before_m: number | null, 
/**
 * The same after the addition, metres.
 */
rms_after_m: number | null, 
/**
 * The data to which these two and the verdict refer.
 */
judged_on: JudgedOn, 
/**
 * The likelihood of the held-out data, which accounts for the wander. It decides, rather than the two
 * errors.
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
 * The coefficient that it replaces.
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
 * Evidence against it: nothing should be written unless the user insists.
 */
concerns: Array<string>, 
/**
 * What else the user should know.
 */
warnings: Array<string>, };

/**
 * Take-off and landing, seconds of the flight's own clock; null: already in the air when the log begins, or
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
 * Several flights, diagnosed one by one.
 */
export type Batch = { 
/**
 * The flights, in the user's order.
 */
by_flight: Array<FlightResult>, 
/**
 * The vehicles, by name.
 */
by_vehicle: Array<VehicleResult>, };

/**
 * The calibration.
 */
export type CalibrationFacts = { 
/**
 * `good`, `degraded`, or null if nothing was latched.
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
 * What determined the end of captive flight.
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
 * Estimated coefficient: together with the other effects found, or alone if the effect was not chosen.
 */
coefficient: number, 
/**
 * One sigma of the coefficient, including autocorrelated noise and the spread over the manoeuvres.
 */
sigma: number, 
/**
 * Its unit.
 */
unit: string, 
/**
 * Probability that the effect acts: the sum over the sets of effects that explain the flights and
 * contain it. Where the climb rate is measured, only identified effects and members of a set have one,
 * which is the probability within that set.
 */
probability: number | null, 
/**
 * Probability of as strong a fit if the effect did not act, times the number of effects tried.
 */
p_value: number, 
/**
 * Root mean square of the held-out errors without this effect, with every other chosen one, m.
 */
rms_before_m: number | null, 
/**
 * The same with this effect, m. Both are absent where most of the error would come from the
 * coefficient's own uncertainty, because only the held-out part shows the effect.
 */
rms_after_m: number | null, 
/**
 * Whether the effect is part of the explanation.
 */
chosen: boolean, 
/**
 * Time constant of the regressor, s, if it has one.
 */
time_constant_s: number | null, 
/**
 * Time constant of the low pass that fits a lag better than a shift of the slope does, seconds, if there
 * is one.
 */
smoothing_s: number | null, 
/**
 * The pure delay that fits a lag better than a shift of the slope does, seconds, if there is one.
 */
pure_delay_s: number | null, 
/**
 * The share of the regressor's squares that is the noise of its own signals, beside the other chosen
 * effects, at most one half. The coefficient may be too small by it, which sigma includes.
 */
noise_share: number, 
/**
 * When the clock of a regressor with a time constant starts: `launch` or `start`.
 */
since: string | null, 
/**
 * How much of the residual the effect makes in free flight, rms, m.
 */
size_m: number, 
/**
 * The range of the regressor in these flights, m per unit.
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
 * False if it was not open.
 */
was_open: boolean, };

/**
 * One effect's coefficient from one flight.
 */
export type Coefficient = { 
/**
 * The estimate, fitted together with the effects that this flight shows to be missing.
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
 * Its name, which for a known column includes the unit.
 */
name: string, 
/**
 * Whether Pylon knows the column.
 */
is_known: boolean, 
/**
 * Number of values.
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
 * The user's times for it.
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
 * The result in one sentence.
 */
headline: Headline, };

/**
 * How well a model agrees with a flight. When serialised, a value that does not exist or is not finite is
 * null.
 */
export type Comparison = { 
/**
 * Version of the meaning of these keys: it changes if a key changes its meaning or is removed.
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
 * Time of the launch by the flight's own clock, seconds.
 */
launch_s: number | null, 
/**
 * The sensors by name; those without a single reading are left out.
 */
sensors: { [key in string]: SensorComparison }, 
/**
 * Cross-check of barometer and inertial altitude while the reference was lost in free flight; null if it
 * never was, or if no pair of readings came.
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
 * Cost and detection of the monitor's rule, and a better rule, by sensor.
 */
rules: { [key in string]: SensorRules }, 
/**
 * Section 4's second corrections, side by side.
 */
remedies: Array<Remedy>, 
/**
 * Where the model fails.
 */
failures: Failures, 
/**
 * Data of the flight that was not used unchanged.
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
 * Result of [`NisSummary`].
 */
export type Consistency = { 
/**
 * Mean NIS; 1 for a consistent filter.
 */
mean: number, 
/**
 * Lower 95 % bound of the mean for a consistent filter.
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
 * Number of innovations.
 */
count: number, 
/**
 * Number of independent innovations that they are worth.
 */
effective_count: number, };

/**
 * A correlation by lag.
 */
export type Correlated = { 
/**
 * Lags, seconds; for a cross-correlation on both sides of zero, positive if the signal lags the other.
 */
lag_s: Numbers, 
/**
 * The correlation, from -1 to 1.
 */
correlation: Numbers, 
/**
 * Half the width of the band that holds 99 of 100 correlations at a lag if there is no true correlation,
 * as MATLAB's `resid` draws it: that of white noise for an autocorrelation; by Bartlett's formula, from
 * both autocorrelations, for a cross-correlation.
 */
band: number, 
/**
 * Length of the blocks whose means are correlated, seconds.
 */
block_s: number, 
/**
 * Number of blocks.
 */
blocks: number, 
/**
 * Whether the lags end sooner than asked for, because the time is too short or the signal has too many
 * gaps.
 */
is_cut: boolean, };

/**
 * Asks for the correlation of a signal (a sensor's error) with itself or another.
 */
export type CorrelationRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model to fly.
 */
model: ModelText, 
/**
 * The user's times for it.
 */
times: Times, 
/**
 * The signal.
 */
signal: Signal, 
/**
 * The other signal; null: the signal itself.
 */
with: Signal | null, 
/**
 * Start, seconds of the flight's own clock; null: its first row.
 */
from_s: number | null, 
/**
 * End; null: its last row.
 */
to_s: number | null, 
/**
 * The longest lag, seconds.
 */
longest_lag_s: number, };

/**
 * Barometer less inertial altitude while the reference was lost, each with its latched bias.
 */
export type CrossCheckFacts = { 
/**
 * Number of pairs of readings.
 */
pairs: number, 
/**
 * The difference farthest from zero, metres.
 */
largest_difference_m: number, 
/**
 * Their agreement after the last pair: `agree`, `doubtful` or `disagree`.
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
 * A usable effect by formula.
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
 * The largest plausible coefficient, of either sign.
 */
largest: number, 
/**
 * The coefficient that fits the error by least squares, together with a constant. It ignores the filter,
 * the other effects and the noise's colour, and is for display only. `add` learns the coefficient for
 * the model.
 */
coefficient: number, 
/**
 * Share of the error's variance that it explains, from 0 to 1.
 */
explained: number, 
/**
 * The formula's value, metres per unit of the coefficient: means over blocks of the flight.
 */
x: Numbers, 
/**
 * The error's mean over each of these blocks, m.
 */
y: Numbers, 
/**
 * The model with the definition, whose coefficient is not learned yet.
 */
model: ModelText, };

/**
 * Delay from a fault until the sensor is called untrustworthy.
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
 * The held-out flights; if there are none, stretches of the flights are held out in turn.
 */
hold_outs: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * The user's times for them.
 */
times: { [key in string]: Times }, };

/**
 * A diagnosis.
 */
export type Diagnosed = { 
/**
 * What `pylon diagnose --json` prints for all flights together. A value that is not finite is null.
 */
diagnosis: Diagnosis, 
/**
 * For several flights: each flight's own result, by vehicle, and which flights do not belong with the
 * others.
 */
batch: Batch | null, 
/**
 * The result in one sentence.
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
 * Number of blocks of residuals that were used.
 */
blocks: number, 
/**
 * Length of a block, s.
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
 * Invalid readings, which the mission refuses as well: not finite, implausible, or of a sensor that is
 * stuck.
 */
refused_readings?: number, 
/**
 * What is wrong with a sensor for the whole flight, because of which it was left out: it is stuck, or a
 * copy of the receiver.
 */
fault: string | null, 
/**
 * Whether the flight records its own launch.
 */
has_launch: boolean, 
/**
 * Number of flights in the log; 0 where the log records its own launch, or shows none.
 */
flights: number, 
/**
 * Number of the analysed one, from 1.
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
 * What is not analysed, and why.
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
 * Version of the keys' meaning. It increases where a key changes its meaning or is removed.
 */
version: number, 
/**
 * The verdict over all sensors: that of the sensor with the largest misfit.
 */
verdict: Verdict, 
/**
 * The diagnosis by sensor; effects of the reference are under `gps`.
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
 * The flights held out, if any. If none, stretches of the flights are held out in turn.
 */
hold_outs: Array<string>, 
/**
 * The noise that was found together with the effects.
 */
noise: NoiseFacts, 
/**
 * Effects that could not be tested, because the flights lack a signal.
 */
untested: Array<Untested>, 
/**
 * Anything remarkable about the input.
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
 * The held-out flights.
 */
hold_outs: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * The user's times for them.
 */
times: { [key in string]: Times }, };

/**
 * The laws found.
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
 * Why no law is proposed, if none is.
 */
why_none: string | null, };

/**
 * What was found.
 */
export type Discovery = { 
/**
 * Version of the keys' meaning. It increases where a key changes its meaning or is removed.
 */
version: number, 
/**
 * The laws, the most probable first; empty where no law of the grammar explains the remainder, or
 * nothing is left to explain.
 */
laws: Array<FoundLaw>, 
/**
 * Probability that none of the laws considered acts.
 */
none: number, 
/**
 * What the catalogue explains: the effects that were estimated together with every law.
 */
catalogue: Array<string>, 
/**
 * The diagnosis' verdict over all sensors.
 */
verdict: Verdict, 
/**
 * The most probable law that was not proposed, and why, if none was proposed.
 */
rejected: Rejected | null, 
/**
 * The signals that were searched.
 */
signals: Array<string>, 
/**
 * Those of the signals that have no known unit: they are treated as plain numbers.
 */
without_unit: Array<string>, 
/**
 * Columns that a formula cannot name, which were left out.
 */
unnamed: Array<string>, 
/**
 * Number of laws that were scored.
 */
scored: number, 
/**
 * Number of laws for which the noise was fitted again.
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
 * The flights held out, if any. If none, stretches of the flights are held out in turn.
 */
hold_outs: Array<string>, 
/**
 * Anything remarkable about the input.
 */
warnings: Array<string>, };

/**
 * One curve.
 */
export type Drawn = { 
/**
 * The quantity that it shows.
 */
signal: Signal, 
/**
 * Its unit; empty if it has none or the flight does not record it.
 */
unit: string, 
/**
 * Least value at each point of the axis; NaN if there is none. The curve is drawn across such points,
 * but not over a gap.
 */
least: Numbers, 
/**
 * Greatest value.
 */
greatest: Numbers, 
/**
 * Standard deviation at each point, if the signal has one.
 */
sigma: Numbers | null, 
/**
 * Gaps in the record, over which no line is drawn: start and end in seconds, pair after pair.
 */
gaps_s: Numbers, 
/**
 * Number of values in the requested time.
 */
values: number, };

/**
 * An effect accounted for by the model.
 */
export type EffectFacts = { 
/**
 * Its id in the catalogue.
 */
effect: string, 
/**
 * Its coefficient: the estimate at the end of captive flight, or the model's constant.
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
 * The range of its regressor in which the coefficient was learned, metres per unit of coefficient.
 */
envelope_m: [number, number] | null, 
/**
 * Number of ticks at which it was used outside of that range.
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
 * The field's usual name for it.
 */
title: string, 
/**
 * Description in one sentence.
 */
what: string, 
/**
 * The formula that the coefficient is multiplied by, metres per unit of the coefficient.
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
 * The coefficient from these flights, estimated together with the effects that were found; null where
 * they do not show it.
 */
coefficient: number | null, 
/**
 * One sigma of the coefficient now, as in the diagnosis; null where the flights do not show it.
 */
sigma_now: number | null, 
/**
 * One sigma with the planned flight; null where that does not show it either.
 */
sigma_then: number | null, 
/**
 * The largest physically possible coefficient, either way.
 */
largest: number, 
/**
 * Whether the flights would have shown a coefficient of that size.
 */
is_seen_now: boolean, 
/**
 * Whether the flights together with the planned one would.
 */
is_seen_then: boolean, 
/**
 * The probability that they would.
 */
detection_then: number, 
/**
 * Whether the plan has the effect's signals. An effect by formula may need a column that no simulation
 * has.
 */
is_planned: boolean, };

/**
 * One effect from all flights of a vehicle.
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
 * Number of flights that determine it.
 */
flights: number, 
/**
 * Mean of its coefficients, without the outliers.
 */
mean: number, 
/**
 * One sigma of the mean.
 */
sigma: number, 
/**
 * Spread of the coefficient from flight to flight beyond their sigmas, 1 sigma.
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
 * Its probability, for a law.
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
 * Makes a file of a result. Its bytes come with the answer and are those that the command line writes.
 */
export type ExportRequest = { 
/**
 * The result to export.
 */
export: Exports, };

/**
 * A file, whose bytes come with the answer.
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
 * A result that can be exported.
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
 * Errors by manoeuvre, in the order of [`Manoeuvre`].
 */
by_manoeuvre: Array<ManoeuvreErrors>, 
/**
 * The signals from which the motion was read.
 */
sources: MotionSources, 
/**
 * Signals that the flight would need for the unknown quantities.
 */
missing: Array<string>, };

/**
 * A fault of a sensor that was healthy before.
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
 * Identification of the flight.
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
 * Origin of the flight.
 */
source: string, 
/**
 * Number of rows.
 */
rows: number, 
/**
 * Time from the first row to the last, seconds.
 */
duration_s: number, 
/**
 * Whether the flight records its own launch.
 */
has_launch: boolean, 
/**
 * Number of flights in the log; 0 where the log records its own launch, or shows none.
 */
flights: number, 
/**
 * Number of the analysed one, from 1.
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
 * What is not analysed, and why.
 */
unused: Array<Unused>, 
/**
 * What else a user should know, one line each.
 */
remarks: Array<string>, };

/**
 * A planned flight.
 */
export type FlightPlan = { 
/**
 * True airspeed of straight and level flight, m/s.
 */
speed_mps: number, 
/**
 * Altitude at its start, m above mean sea level.
 */
altitude_m: number, 
/**
 * Straight and level flight at the start, for the calibration, seconds.
 */
calibration_s: number, 
/**
 * The manoeuvres after that.
 */
legs: Array<PlannedLeg>, };

/**
 * Asks for the contents of an opened flight, with the user's times.
 */
export type FlightRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The user's times for it.
 */
times: Times, };

/**
 * Diagnosis of one flight alone.
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
 * The verdict; `None` if the diagnosis failed.
 */
verdict: Verdict | null, 
/**
 * Why it failed: a defect of this program.
 */
failed: string | null, 
/**
 * Coefficients of the effects in question, by their ids, where the flight determines them.
 */
coefficients: { [key in string]: Coefficient }, };

/**
 * A signal that the unexplained residual follows.
 */
export type Follows = { 
/**
 * The signal, and which form of it.
 */
signal: string, 
/**
 * How far the residual lags behind the signal, s.
 */
lag_s: number, 
/**
 * How much of the residual the signal would explain, rms, m.
 */
size_m: number, 
/**
 * What the signal gains in twice the log likelihood.
 */
evidence: number, };

/**
 * A checked formula: has either `problem` or `definition`.
 */
export type FormulaChecked = { 
/**
 * Why it cannot be used.
 */
problem: FormulaProblem | null, 
/**
 * The formula as a definition.
 */
definition: Defined | null, };

/**
 * An error in a formula, and its position.
 */
export type FormulaProblem = { 
/**
 * The error message.
 */
message: string, 
/**
 * Where it begins in the formula, in UTF-16 units, as JavaScript counts.
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
 * The current model.
 */
model: ModelText, 
/**
 * Its id; null: made from what it acts on and what it reads.
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
 * The largest plausible coefficient, of either sign; null: three times the fitted one, as in
 * `pylon discover`.
 */
largest: number | null, 
/**
 * Description; may be empty.
 */
about: string, 
/**
 * The flight to fit it to.
 */
flight: string, 
/**
 * The user's times for it.
 */
times: Times, 
/**
 * The error to be explained.
 */
error: Signal, 
/**
 * Start of the error that is used, seconds; null: its first value.
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
 * The law, in the form of an effect definition.
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
 * Probability that this law acts, among all that were considered and none.
 */
probability: number, 
/**
 * The same for this law and all that are equal to it on these flights.
 */
probability_with_equals: number, 
/**
 * Root mean square of the held-out errors without the law, m.
 */
rms_before_m: number | null, 
/**
 * The same with the law, m. Both are absent where most of the error would come from the coefficient's
 * own uncertainty.
 */
rms_after_m: number | null, 
/**
 * Length of the law, bits.
 */
bits: number, 
/**
 * What the law gains in twice the log likelihood.
 */
evidence: number, 
/**
 * What the law gains in twice the log likelihood on the held-out flights, or else on the stretches held
 * out in turn.
 */
held_out_gain: number, 
/**
 * How much of the residual the law makes in free flight, rms, m.
 */
size_m: number, 
/**
 * Effects that were found without the law and that it replaces.
 */
instead_of: Array<string>, 
/**
 * Laws and effects that cannot be distinguished from it on these flights, with the correlation of both.
 */
equal_to: Array<Equal>, 
/**
 * What to fly to distinguish it from these, in words; empty where no such manoeuvre is known.
 */
advice: string, };

/**
 * What a manoeuvre by itself would add.
 */
export type Gain = { 
/**
 * The probability that it would resolve a set, averaged over the sets; null without a set.
 */
tells_apart: number | null, 
/**
 * Number of effects that it would show and that no flight shows yet.
 */
shows: number, 
/**
 * The share to which an effect's interval would shrink, averaged over the effects that the flights show.
 */
narrows_to: number, };

/**
 * A stretch in which the reference jumped away and came back, in the flight's own time.
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
 * How good the result is.
 */
tone: Tone, 
/**
 * The effect that the sentence names, if any; Add would add this one.
 */
effect: string | null, };

/**
 * Held-out data, predicted with an effect and without.
 */
export type HeldOutVerdict = { 
/**
 * What twice the log likelihood gains by the effect; negative if the effect makes it worse.
 */
gain: number, 
/**
 * One sigma of the gain by chance.
 */
gain_sigma: number, 
/**
 * The gain if the effect acted exactly as learned; minus that if it did not act.
 */
gain_as_learned: number, 
/**
 * Whether the effect is harmful beyond chance.
 */
is_worse: boolean, 
/**
 * Whether an effect that does not act would be detected, with a probability of 95 %.
 */
can_tell: boolean, };

/**
 * The data on which the errors before and after were computed.
 */
export type JudgedOn = "held_out_flights" | "held_out_manoeuvres";

/**
 * The keys of `pylon ladder --json`.
 */
export type Ladder = { 
/**
 * Version of the keys' meaning. It increases where a key changes its meaning or is removed.
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
 * Flies every revision of a model over flights: `pylon ladder`. The answer is what `pylon ladder --json`
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
 * The user's times for them.
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
 * The effect that it added or learned again.
 */
effect: string | null, 
/**
 * The day.
 */
date: string | null, 
/**
 * The effects of the model at this revision.
 */
effects: Array<string>, 
/**
 * Every flight.
 */
flights: Array<RevisionFlight>, };

/**
 * A manoeuvre of the aircraft.
 */
export type Manoeuvre = "level_flight" | "acceleration" | "deceleration" | "climb" | "descent" | "dive" | "pull_up" | "push_over" | "level_turn" | "climbing_turn" | "descending_turn" | "at_rest" | "unknown";

/**
 * Errors in all stretches of one manoeuvre.
 */
export type ManoeuvreErrors = { 
/**
 * The manoeuvre.
 */
doing: Manoeuvre, 
/**
 * Total duration, seconds.
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
 * The probability now that this effect is the one that acts. Those of the set and of nothing add up to
 * one.
 */
probability: number, 
/**
 * The probability that it would be given with the planned flight, if it is the one that acts: the median
 * over that flight's noise. Null for an effect whose signal the flights lack.
 */
probability_then: number | null, 
/**
 * How many of the set, including this effect, would then still have a probability of 5 % or more.
 */
left: number | null, 
/**
 * By how many sigmas the planned flight would distinguish it from the most similar of the others, or
 * from nothing.
 */
sigmas: number | null, 
/**
 * The probability that it would be identified, if it is the one that acts.
 */
identified: number | null, };

/**
 * The contents of a model.
 */
export type ModelFacts = { 
/**
 * The effects that it accounts for, in the model's order.
 */
effects: Array<TermFacts>, 
/**
 * Its revisions, oldest first.
 */
revisions: Array<RevisionFacts>, 
/**
 * Warnings about unlikely values.
 */
warnings: Array<string>, };

/**
 * Asks for the contents of a model. An error is the file's own: line, key, what was expected.
 */
export type ModelRequest = { 
/**
 * The model.
 */
model: ModelText, };

/**
 * A model, as in its file.
 */
export type ModelText = { 
/**
 * Its name in results: a file's name, or a preset's.
 */
name: string, 
/**
 * Its TOML. An empty text is the default model.
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
 * Alarm limit in sigmas.
 */
multiplier: number, 
/**
 * Length of the moving average, seconds.
 */
window_s: number, 
/**
 * How long the error must exceed the alarm limit before a sensor is untrustworthy, seconds.
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
 * How the aircraft moved during one stretch of flight; `None` if the flight does not have it.
 */
export type Motion = { 
/**
 * Climb rate, m/s, up positive.
 */
climb_rate_mps: number | null, 
/**
 * Speed, m/s: true airspeed, or else ground speed.
 */
speed_mps: number | null, 
/**
 * Its rate of change, m/s^2.
 */
acceleration_mps2: number | null, 
/**
 * Load factor.
 */
load_factor: number | null, 
/**
 * Turn rate, rad/s, positive to the right.
 */
turn_rate_radps: number | null, };

/**
 * The aircraft's motion, second by second; NaN where the flight does not record it.
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
 * The signal from which each quantity was read.
 */
export type MotionSources = { 
/**
 * For the climb rate.
 */
climb_rate: string | null, 
/**
 * For the speed.
 */
speed: string | null, 
/**
 * For the load factor.
 */
load_factor: string | null, 
/**
 * For the turn rate.
 */
turn_rate: string | null, };

/**
 * The noise that was found.
 */
export type NoiseFacts = { 
/**
 * Sigma of the reference's wander, m.
 */
reference_wander_m: number, 
/**
 * Correlation time of the reference's wander, s.
 */
reference_time_s: number, 
/**
 * Sigma of a second, slower wander of the difference of the altitudes (the reference's or a sensor's),
 * m; 0 where the climb rate is measured, which needs none.
 */
slow_wander_m: number, 
/**
 * Correlation time of the slow wander, s.
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
 * Position of an array in the numbers that are handed over with an answer: f64, in the machine's byte order.
 *
 * NaN means that there is no value.
 */
export type Numbers = { 
/**
 * Index of the first number.
 */
start: number, 
/**
 * Number of values.
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
 * Probability that one of this many flights is as far off, if all were alike.
 */
p_value: number, };

/**
 * A manoeuvre on offer.
 */
export type Offer = { 
/**
 * The manoeuvre with suggested values.
 */
leg: PlannedLeg, 
/**
 * Unit of the amount: `m/s`, `deg`, `g`; empty if there is no amount.
 */
unit: string, 
/**
 * The least amount.
 */
least: number, 
/**
 * The largest amount.
 */
most: number, 
/**
 * What it would add by itself; null if that was not asked for, or it cannot be flown here.
 */
gain: Gain | null, };

/**
 * Opens the log whose bytes come with the request: any format that Pylon imports, detected from its content.
 * An error is the importer's own line.
 */
export type OpenRequest = { 
/**
 * Name of the flight in later requests; an open flight of that name is replaced.
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
 * Name of the flight in later requests.
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
 * The result of `pylon open --json`: the format, take-off, landing, launch, which parts are used and why
 * others are not, the sensors, the importer's notes; if the flight cannot be analysed, `refused` gives
 * the reason.
 */
overview: Overview, 
/**
 * The vehicle, identified among others of its type; flights are grouped by it.
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
 * What the flights show now, and what they would show with the planned one.
 */
export type Outlook = { 
/**
 * Every effect whose signals the flights have, those that were found first.
 */
effects: Array<EffectOutlook>, 
/**
 * Every set of effects that the flights cannot tell apart.
 */
sets: Array<SetOutlook>, };

/**
 * What is in a log: the keys of `pylon open --json`.
 */
export type Overview = { 
/**
 * Version of the keys' meaning. It increases where a key changes its meaning or is removed.
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
 * The vehicle, as given in the log.
 */
vehicle: string, 
/**
 * Number of rows.
 */
rows: number, 
/**
 * First time of the flight's own clock, seconds. `--calibrate` counts from zero of that clock, not from
 * this time.
 */
first_s: number, 
/**
 * Time from the first row to the last, seconds.
 */
duration_s: number, 
/**
 * When it was launched or dropped, from its own `launch` column, seconds.
 */
launch_s: number | null, 
/**
 * When it was dropped from a carrier, found by how it falls, seconds; null where it was not, or has a
 * `launch` column.
 */
drop_s: number | null, 
/**
 * The share of it that a diagnosis uses, which needs no calibration; null where it cannot be analysed.
 */
diagnosed_share: number | null, 
/**
 * Every time in the air.
 */
airborne: Array<AirborneTime>, 
/**
 * Time on the ground before the take-off of the flight that is analysed, seconds.
 */
ground_before_s: number | null, 
/**
 * Time after its landing, seconds.
 */
after_landing_s: number | null, 
/**
 * Where it is calibrated, in words; null where nothing can be.
 */
calibration: string | null, 
/**
 * Start and end of the calibration, seconds; null for a flight with a launch, or where nothing can be
 * calibrated.
 */
calibration_window_s: [number, number] | null, 
/**
 * Why it cannot be analysed, if it cannot.
 */
refused: string | null, 
/**
 * What is wrong with the barometer for the whole log, if anything.
 */
barometer_fault: string | null, 
/**
 * The sensors.
 */
sensors: Array<SensorView>, 
/**
 * Anything remarkable about the log.
 */
notes: Array<string>, 
/**
 * Commands to continue with.
 */
next: Array<string>, 
/**
 * Whether the flight records its own launch.
 */
has_launch: boolean, 
/**
 * Number of flights in the log; 0 where the log records its own launch, or shows none.
 */
flights: number, 
/**
 * Number of the analysed one, from 1.
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
 * What is not analysed, and why.
 */
unused: Array<Unused>, 
/**
 * What else a user should know, one line each.
 */
remarks: Array<string>, };

/**
 * Points: every value of y with the value of x at that time, interpolated linearly but not over a gap.
 */
export type Paired = { 
/**
 * Time, seconds.
 */
time_s: Numbers, 
/**
 * Horizontal values.
 */
x: Numbers, 
/**
 * Vertical values.
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
 * Number of points before thinning.
 */
of: number, 
/**
 * Values of y for which x has none.
 */
unpaired: number, };

/**
 * Statistics of a sensor's errors in one phase. A value that the readings cannot give is `None`.
 */
export type PhaseSummary = { 
/**
 * Number of readings that had a reference to compare with.
 */
readings: number, 
/**
 * Time from the first of them to the last, seconds.
 */
duration_s: number, 
/**
 * Mean error (eq. 16, with the latched calibration), metres.
 */
bias_m: number | null, 
/**
 * Standard error of that mean, with the errors' own autocorrelation, metres.
 */
bias_standard_error_m: number | null, 
/**
 * Standard deviation of the error, metres.
 */
spread_m: number | null, 
/**
 * The same from the median absolute deviation, which a few outliers do not move, metres.
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
 * Plans a flight, simulates it, and reports what it would add to the existing flights.
 */
export type PlanRequest = { 
/**
 * The flights to learn from.
 */
flights: Array<string>, 
/**
 * The held-out flights.
 */
hold_outs: Array<string>, 
/**
 * The model.
 */
model: ModelText, 
/**
 * The user's times for them.
 */
times: { [key in string]: Times }, 
/**
 * The plan; null: the one that Pylon suggests, with the gain of each manoeuvre by itself.
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
 * What it would show.
 */
outlook: Outlook, 
/**
 * The simulated scenario, which `pylon simulate` accepts.
 */
scenario: string, 
/**
 * Its segments, for the flight card.
 */
segments: Array<PlannedSegment>, 
/**
 * The ranges that it reaches.
 */
reached: Reached, 
/**
 * Its duration including the calibration, seconds.
 */
duration_s: number, 
/**
 * The manoeuvres on offer, best first if their gains were asked for.
 */
offers: Array<Offer>, 
/**
 * Remarks for the user.
 */
remarks: Array<string>, };

/**
 * A part of a plan.
 */
export type PlannedLeg = { 
/**
 * The manoeuvre.
 */
manoeuvre: PlannedManoeuvre, 
/**
 * Its amount, in the unit given in the offer.
 */
amount: number, 
/**
 * Duration of each of its stretches, seconds.
 */
duration_s: number, 
/**
 * Number of repetitions.
 */
times: number, };

/**
 * A manoeuvre that can be planned.
 */
export type PlannedManoeuvre = "speed_sweep" | "climbs" | "pull_ups" | "turns" | "level" | "long_climb" | "legs";

/**
 * One segment of the scenario.
 */
export type PlannedSegment = { 
/**
 * What to do, as a pilot reads it.
 */
words: string, 
/**
 * Start, seconds after the calibration.
 */
from_s: number, 
/**
 * Duration, seconds.
 */
duration_s: number, 
/**
 * Simulated altitude at its end, m above mean sea level.
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
 * Description in one sentence.
 */
about: string, };

/**
 * Asks for the models that come with Pylon.
 */
export type PresetsRequest = Record<symbol, never>;

/**
 * The least and the greatest values that the simulated flight reaches.
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
 * Largest distance from its start, m.
 */
distance_m: number, };

/**
 * Counts of a source's readings that were used or not.
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
 * A fix held since the last one.
 */
held: number, 
/**
 * Readings of a sensor that repeats one value.
 */
stuck: number, 
/**
 * Refused by the filter.
 */
variance: number, 
/**
 * Finite, but no aircraft can be there or do that.
 */
implausible: number, 
/**
 * Outliers: too far from the filter's prediction.
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
 * Whether it detects the step nine times in ten. If not, no rule does at that false-alarm rate, and this
 * one detects the smallest step.
 */
detects_step: boolean, 
/**
 * The smallest step that it detects nine times in ten, metres.
 */
smallest_step_m: number, 
/**
 * Its false alarms and its detection.
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
 * Counts of fixes that were and were not used.
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
 * The effect of the catalogue that explains as much, if that is the reason.
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
 * Result of a second correction for one sensor.
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
 * Non-negative variances make it a valid process whatever the data. It cannot represent an oscillating
 * autocovariance, which is replaced by the nearest monotone one. Values are Gaussian.
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
 * Longest lag that the data cover, seconds.
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
 * The effect that it added or learned again.
 */
effect: string | null, 
/**
 * The date.
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
 * The signals from which it was computed.
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
 * False alarms of a rule on a healthy sensor, and its delays of detection.
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
 * Rate at which a healthy sensor would be called untrustworthy, per hour (eq. 17, right), once the
 * window is full.
 */
false_alarms_per_hour: number, 
/**
 * Share of launches at which a healthy sensor would be called untrustworthy before the window is full:
 * until then the part without readings counts as no error.
 */
healthy_alarm_in_first_window: number, 
/**
 * Delays for the given faults.
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
 * Description in one sentence, including that it is simulated.
 */
about: string, };

/**
 * Asks for the flights that come with Pylon.
 */
export type SamplesRequest = Record<symbol, never>;

/**
 * Asks for the points of one signal against another.
 */
export type ScatterRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model to fly.
 */
model: ModelText, 
/**
 * The user's times for it.
 */
times: Times, 
/**
 * The signal on the horizontal axis.
 */
x: Signal, 
/**
 * The signal on the vertical axis.
 */
y: Signal, 
/**
 * Start, seconds of the flight's own clock; null: its first row.
 */
from_s: number | null, 
/**
 * End; null: its last row.
 */
to_s: number | null, 
/**
 * Limit on the points; more are thinned out evenly.
 */
at_most: number, };

/**
 * A sensor on a flight without and with the effect.
 */
export type SensorChange = { 
/**
 * With the original model.
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
 * Latched bias (without a launch: the last estimate), metres.
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
 * Root mean square error in captive flight, with the latched bias, metres.
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
 * Time without a reference to monitor it, seconds.
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
 * Counts of readings that were and were not used.
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
 * Ids of the effects that are certainly missing, the strongest first.
 */
missing: Array<string>, 
/**
 * Sets of effect ids: one of each set acts, or none (see `nothing`), and the flights cannot
 * tell which. The most probable comes first. Those below 5 % are not listed; but where an effect does
 * act, the second is.
 */
indistinguishable: Array<Array<string>>, 
/**
 * Probability of each effect of a set, in the order of `indistinguishable`. What remains to 1 is that of
 * nothing, and of effects that are not listed.
 */
probabilities: Array<Array<number>>, 
/**
 * Probability that no effect acts in the place of a set, in the order of `indistinguishable`. Null where
 * it is below 5 %; where the climb rate is measured, null where the set has passed a test of
 * significance.
 */
nothing: Array<number | null>, 
/**
 * Every effect that was tried: the chosen ones first, then by p-value.
 */
candidates: Array<CandidateFacts>, 
/**
 * What to do next, in words; empty if nothing is to be done.
 */
advice: string, 
/**
 * Signals that an unexplained residual follows, the closest first.
 */
follows: Array<Follows>, 
/**
 * How many times larger the sensor's own wander is in free flight than in captive flight, after
 * everything that was found is subtracted.
 */
free_flight_factor: number | null, };

/**
 * The configured rule and the recommended one, for one sensor.
 */
export type SensorRules = { 
/**
 * The residual's stochastic model, fitted to its autocovariance in captive flight.
 */
residual: ResidualModel, 
/**
 * The rule that was flown.
 */
set: RuleQuality | null, 
/**
 * The rule that detects the step soonest at the wanted false-alarm rate.
 */
recommended: Recommendation | null, 
/**
 * The wanted false-alarm rate, per hour.
 */
wanted_false_alarms_per_hour: number, };

/**
 * One sensor's errors on one flight (eq. 16), and its flags.
 */
export type SensorScore = { 
/**
 * Root mean square error in captive flight, with the latched bias, metres; `None` without a reading.
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
 * Duration of its free flight, from launch to the flight's last tick, seconds; `None` without launch.
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
 * Number of samples.
 */
samples: number, 
/**
 * Median rate, samples per second.
 */
rate_hz: number | null, 
/**
 * Its columns.
 */
columns: Array<string>, 
/**
 * Datum of its altitudes, `msl`, `ellipsoid` or `pressure`; null for a sensor that is not an altitude.
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
 * The axis, seconds, increasing: the time of each row, or the middle of each pixel's slot.
 */
time_s: Numbers, 
/**
 * Whether a point is a pixel's slot with least and greatest value; otherwise it is a row, and both are
 * the same array.
 */
is_thinned: boolean, 
/**
 * The curves, in the request's order.
 */
curves: Array<Drawn>, };

/**
 * Asks for curves on one time axis, thinned out without changing how they look: no spike is lost.
 */
export type SeriesRequest = { 
/**
 * The flight.
 */
flight: string, 
/**
 * The model to fly.
 */
model: ModelText, 
/**
 * The user's times for it.
 */
times: Times, 
/**
 * The curves.
 */
signals: Array<Signal>, 
/**
 * Start, seconds of the flight's own clock; null: its first row.
 */
from_s: number | null, 
/**
 * End; null: its last row.
 */
to_s: number | null, 
/**
 * Width of the axis, pixels.
 */
pixels: number, };

/**
 * A set of effects of which one acts, or perhaps none.
 */
export type SetOutlook = { 
/**
 * The effects of the set, the most probable first.
 */
members: Array<MemberOutlook>, 
/**
 * The probability now that none of them acts; null where that is below 5 %.
 */
nothing: number | null, 
/**
 * The probability that the set would no longer be reported, if none of them acts; null where that is
 * below 5 %.
 */
cleared: number | null, 
/**
 * The probability that the planned flight resolves the set: that the effect that acts is then
 * identified, or that the set is no longer reported if none does.
 */
resolved: number, };

/**
 * The quantity that a curve shows.
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
 * The effects that it found and that the model lacks: they too are not the reference's wander.
 */
found: Array<Acting>, } | { "signal": "effect", 
/**
 * The effect.
 */
of: Acting, } | { "signal": "climb_rate" } | { "signal": "speed" } | { "signal": "load_factor" } | { "signal": "turn_rate" };

/**
 * A stretch of time with its label.
 */
export type Span = { 
/**
 * Start, seconds of the flight's own clock.
 */
from_s: number, 
/**
 * End.
 */
to_s: number, 
/**
 * The label: a manoeuvre, a trust or a phase.
 */
what: string, };

/**
 * A stretch of flight with one manoeuvre.
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
 * The manoeuvre.
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
 * Share of the sensor's squared error over all of free flight.
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
 * Time constant of its regressor, seconds, if it has one.
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
 * The date on which it was learned.
 */
date: string | null, };

/**
 * The user's times for a flight; null: those that Pylon finds.
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
 * How good the result is, which determines its look.
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
 * Why no column would help, if none would.
 */
reason?: string | null, };

/**
 * A part of a log that is not analysed.
 */
export type Unused = { 
/**
 * Start, seconds.
 */
from_s: number, 
/**
 * End, seconds.
 */
to_s: number, 
/**
 * Share of the whole log.
 */
share: number, 
/**
 * Why it is not analysed.
 */
reason: string, };

/**
 * A vehicle's flights.
 */
export type VehicleResult = { 
/**
 * The vehicle; empty if the header has none.
 */
vehicle: string, 
/**
 * Number of its flights.
 */
flights: number, 
/**
 * The effects in question that any of them determines.
 */
effects: Array<EffectResult>, };

/**
 * What is known about a misfit, ordered by how much it asks of the user.
 */
export type Verdict = "no_significant_misfit" | "insufficient_excitation" | "identified" | "indistinguishable" | "unknown_effect";

/**
 * Whiteness of a sequence.
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
 * Number of values.
 */
count: number, };

/**
 * Why a law was not proposed.
 */
export type Why = "not_enough_evidence" | "held_out" | "catalogue" | "shape" | "no_formula";

/**
 * Where to calibrate, seconds of the flight's own clock; its end is taken as launch.
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
