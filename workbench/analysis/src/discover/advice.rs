//! What to fly to distinguish a law from those that it is equal to: among the manoeuvres of the diagnosis'
//! advice, each with the unknown columns held or moved in steps, the one that would separate the laws most.

use std::sync::Arc;

use kf_core::input::TickInput;

use super::fit::{Bench, Fitted};
use super::search::Search;
use super::signals::Blocks;
use crate::diagnose::parts::{ADVICE_BLOCK_S, MANOEUVRES, Problem, SignalMeans, Trim, flown};

/// How long a moved column stays at each place, seconds.
const STEP_S: f64 = 10.0;
/// The places in turn, as shares of its range in the flights.
const PLACES: [f64; 6] = [0.0, 1.0, 0.5, 0.25, 0.75, 0.1];
/// Sigmas below which a manoeuvre distinguishes nothing.
const APART: f64 = 3.0;

/// What a law is equal to on the flights.
pub struct Equals<'a> {
    /// Columns of the catalogue's effects.
    pub effects: &'a [usize],
    /// Laws.
    pub laws: &'a [&'a Fitted],
    /// Names of the effects, then of the laws.
    pub names: &'a [String],
}

/// What to fly, in words; empty where no manoeuvre would distinguish the law from any of them. Takes the
/// manoeuvre that distinguishes it from most of them and, of several, the one that separates these most.
pub fn to_separate(bench: &Bench<'_>, one: &Fitted, equals: &Equals<'_>, trim: &Trim) -> String {
    if equals.names.is_empty() {
        return String::new();
    }
    let signals = bench.search.signals;
    let laws = || std::iter::once(one).chain(equals.laws.iter().copied());
    let mut moved: Vec<Option<usize>> = vec![None];
    moved.extend((0..signals.signals.len()).filter(|s| signals.signals[*s].is_unknown).map(Some));
    moved.retain(|signal| signal.is_none_or(|signal| laws().any(|law| law.law.uses(signal))));
    let mut best: Option<(usize, f64, Vec<f64>, String)> = None;
    for manoeuvre in &MANOEUVRES {
        let ticks = with_body_rates(manoeuvre.fly(trim));
        for moved in &moved {
            let blocks = blocks(&ticks, bench.search, *moved);
            let Some(apart) = apart(bench, one, equals, &ticks, &blocks) else { continue };
            let told: Vec<f64> = apart.iter().copied().filter(|sigmas| *sigmas >= APART).collect();
            let least = told.iter().copied().fold(f64::INFINITY, f64::min);
            let is_better = best.as_ref().is_none_or(|(most, farthest, ..)| {
                told.len() > *most || (told.len() == *most && least > *farthest)
            });
            if !told.is_empty() && is_better {
                let with = moved.map_or_else(String::new, |signal| {
                    let signal = &signals.signals[signal];
                    let [least, most] = signal.range.map(super::grammar::number);
                    let unit = if signal.name.unit == "1" { "" } else { &signal.name.unit };
                    let gap = if unit.is_empty() { "" } else { " " };
                    format!(
                        ", with {} moved in steps of {STEP_S:.0} s between {least} and {most}{gap}{unit}",
                        signal.name.name
                    )
                });
                best = Some((told.len(), least, apart, format!("{}{with}", manoeuvre.describe(trim))));
            }
        }
    }
    best.map_or_else(String::new, |(_, least, apart, what)| describe(&apart, least, &what, equals.names))
}

fn describe(apart: &[f64], least: f64, what: &str, names: &[String]) -> String {
    let named = |is_told: bool| -> Vec<&str> {
        let chosen = names.iter().zip(apart).filter(|(_, sigmas)| (**sigmas >= APART) == is_told);
        chosen.map(|(name, _)| name.as_str()).collect()
    };
    if named(false).is_empty() {
        return format!("To tell them apart, fly {what}: they would be {least:.0} sigmas apart.");
    }
    format!(
        "To distinguish it from {}, fly {what}: they would be {least:.0} sigmas apart. No manoeuvre also distinguishes it from {}.",
        named(true).join(" and "),
        named(false).join(" or ")
    )
}

/// The ticks with the body rates that follow from their attitudes.
fn with_body_rates(mut ticks: Vec<TickInput>) -> Vec<TickInput> {
    let mut last: Option<(u64, [f32; 3])> = None;
    for tick in &mut ticks {
        let now = tick.signals.attitude_rad.map(|attitude| (tick.time_us, attitude));
        if let (Some((last_us, before)), Some((now_us, attitude)), Some(imu)) = (last, now, &mut tick.imu) {
            let step_s = (now_us - last_us) as f32 * 1e-6;
            let [roll_rate, pitch_rate, yaw_rate]: [f32; 3] =
                std::array::from_fn(|k| (attitude[k] - before[k]) / step_s);
            let [roll, pitch, _] = attitude;
            let (sine, cosine) = (libm::sinf(roll), libm::cosf(roll));
            let turn = yaw_rate * libm::cosf(pitch);
            imu.gyro_radps = [
                roll_rate - yaw_rate * libm::sinf(pitch),
                pitch_rate * cosine + turn * sine,
                turn * cosine - pitch_rate * sine,
            ];
        }
        last = now.or(last);
    }
    ticks
}

/// The ticks' signals at every block of the advice. A signal that no tick has is at its mean over the
/// flights, except the one that is moved.
fn blocks(ticks: &[TickInput], search: &Search<'_>, moved: Option<usize>) -> Blocks {
    let mut means = SignalMeans::new(0);
    let mut altitude = 0.0_f32;
    let (mut next_s, mut last_s) = (0.0, 0.0);
    let (mut time_s, mut free, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for tick in ticks {
        let now_s = tick.time_us as f64 * 1e-6;
        let climb = tick.gps.and_then(|fix| fix.velocity_down_mps).map_or(0.0, |down| -down);
        altitude += climb * (now_s - last_s) as f32;
        last_s = now_s;
        means.take(tick, Some(altitude), 0, &[]);
        if now_s < next_s {
            continue;
        }
        next_s += ADVICE_BLOCK_S;
        time_s.push(now_s);
        free.push(tick.launch);
        rows.push(means.close());
    }
    let launch_s = free.iter().position(|free| *free).and_then(|at| time_s.get(at)).copied().unwrap_or(0.0);
    let place = |time_s: f64| {
        let step = ((time_s - launch_s) / STEP_S).floor();
        if step < 0.0 { PLACES[0] } else { PLACES[step as usize % PLACES.len()] }
    };
    let steps: Vec<f64> = time_s.iter().map(|time_s| place(*time_s)).collect();
    search.signals.planned(time_s, free, &rows, moved.map(|signal| (signal, steps.as_slice())))
}

/// Sigmas by which the nearest of the others would be worse than the law if these blocks were flown.
fn apart(
    bench: &Bench<'_>,
    one: &Fitted,
    equals: &Equals<'_>,
    ticks: &[TickInput],
    blocks: &Blocks,
) -> Option<Vec<f64>> {
    let mut series = flown(ticks, &bench.prepared.candidates, equals.effects, bench.problem);
    let first = equals.effects.len();
    for fitted in std::iter::once(one).chain(equals.laws.iter().copied()) {
        let column = blocks.law(&fitted.law)?;
        let column = column.iter().map(|value| fitted.subject.spread(*value));
        series.columns.push(Arc::new(column.collect()));
    }
    let series = [series];
    let planned = Problem::new(&series, bench.problem.prior.clone(), Vec::new(), &executor::Inline);
    let picks: Vec<usize> = (0..=first + equals.laws.len()).collect();
    let information = planned.information(&one.fit.noise, &picks);
    let left = 1.0 / information.solve(&[first])?.covariance.first()?;
    let sigmas = |other: usize| {
        // A law that the manoeuvre does not show at all is distinguished from one that it shows.
        let shared = match information.solve(&[other]) {
            Some(_) => information.shared(first, other, &[]).unwrap_or(1.0),
            None => 0.0,
        };
        (one.coefficient * one.coefficient * left * (1.0 - shared)).sqrt()
    };
    Some((0..picks.len()).filter(|pick| *pick != first).map(sigmas).collect())
}

#[cfg(test)]
mod tests {
    use executor::Inline;
    use kf_core::input::ImuSample;

    use super::*;
    use crate::discover::signals::Signals;
    use crate::discover::small_flights::flight;

    fn tick(time_s: f64, attitude_rad: [f32; 3]) -> TickInput {
        let mut tick = TickInput {
            time_us: (time_s * 1e6) as u64,
            imu: Some(ImuSample { accel_mps2: [0.0; 3], gyro_radps: [0.0; 3] }),
            ..TickInput::default()
        };
        tick.signals.attitude_rad = Some(attitude_rad);
        tick
    }

    /// What a gyro reads while the heading turns at 0.2 rad/s: level, about the vertical axis only; banked,
    /// about pitch and yaw; nose up, about roll and yaw. A roll and a pitch rate by themselves are about
    /// their own axes.
    #[test]
    fn body_rates_are_those_of_the_attitude() {
        let rates = |from: [f32; 3], rate: [f32; 3]| {
            let before: [f32; 3] = std::array::from_fn(|k| from[k] - 0.1 * rate[k]);
            with_body_rates(vec![tick(0.0, before), tick(0.1, from)])[1].imu.unwrap().gyro_radps
        };
        let (sine, cosine) = (0.6_f32.sin(), 0.6_f32.cos());
        let cases = [
            ([0.0, 0.0, 1.0], [0.0, 0.0, 0.2], [0.0, 0.0, 0.2]),
            ([0.6, 0.0, 1.0], [0.0, 0.0, 0.2], [0.0, 0.2 * sine, 0.2 * cosine]),
            ([0.0, 0.6, 1.0], [0.0, 0.0, 0.2], [-0.2 * sine, 0.0, 0.2 * cosine]),
            ([0.0, 0.0, 1.0], [0.3, 0.0, 0.0], [0.3, 0.0, 0.0]),
            ([0.6, 0.0, 1.0], [0.0, 0.3, 0.0], [0.0, 0.3 * cosine, -0.3 * sine]),
        ];
        for (attitude, rate, wanted) in cases {
            let found = rates(attitude, rate);
            // Differences in single precision over a tenth of a second.
            assert!(
                found.iter().zip(wanted).all(|(one, other)| (one - other).abs() < 1e-5),
                "{found:?} {wanted:?}"
            );
        }
    }

    /// The blocks of a manoeuvre are those of the advice, from its first tick, captive until its launch; the
    /// moved column is at its places.
    #[test]
    fn a_manoeuvres_blocks_are_the_advices() {
        let recorded: Vec<Vec<f64>> = (0..30)
            .map(|k| {
                let mut block = vec![f64::NAN; 21];
                block[0] = 20.0 + f64::from(k);
                block[10] = 0.1 + 0.02 * f64::from(k);
                block
            })
            .collect();
        let names: Vec<String> = (0..21).map(|k| format!("known{k}")).collect();
        let series = flight(&[0.0; 30], &[]);
        let signals = Signals::new(&[(&series, &recorded)], &names, &[]);
        let search = Search { signals: &signals, flights: 1, subjects: 1, executor: &Inline };
        let trim = Trim { speed_mps: 40.0, altitude_m: 1_000.0, angle_of_attack_rad: 0.05 };
        let ticks = MANOEUVRES[6].fly(&trim);
        let found = blocks(&ticks, &search, Some(1));
        let airspeeds = found.values_of(0);
        let wanted = (180.0 / ADVICE_BLOCK_S).round() as usize;
        assert!(airspeeds.len().abs_diff(wanted) <= 1, "{} {wanted}", airspeeds.len());
        assert!(airspeeds.iter().all(|airspeed| (airspeed - 40.0).abs() < 1e-4));
        // Half a minute of the throttle's places after the launch: no two neighbouring steps are alike.
        let throttle = found.values_of(1);
        assert!(throttle.iter().all(|value| (0.1 - 1e-9..=0.68 + 1e-9).contains(value)), "{throttle:?}");
        let captive = (60.0 / ADVICE_BLOCK_S) as usize;
        assert!(throttle[..captive].windows(2).all(|pair| pair[0] == pair[1]));
        assert!(throttle[captive + 2..].iter().any(|value| (value - throttle[0]).abs() > 0.1));
    }

    /// The advice names the laws that it distinguishes, and those that it does not.
    #[test]
    fn the_advice_names_what_it_tells_apart() {
        let names = ["a".to_owned(), "b".to_owned()];
        let (much, little) = (10.0 * APART, 0.1 * APART);
        let both = describe(&[much, much], much, "a loop", &names);
        assert!(both.starts_with("To tell them apart, fly a loop: they would be"), "{both}");
        let one = describe(&[much, little], much, "a loop", &names);
        assert!(
            one.contains("To distinguish it from a, fly a loop")
                && one.ends_with("also distinguishes it from b."),
            "{one}"
        );
    }
}
