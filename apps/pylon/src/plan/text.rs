//! A plan in plain English.

use std::fmt::Write as _;

use analysis::diagnose::{EffectOutlook, Outlook, SetOutlook};
use planning::PlannedSegment;
use view::{Cell, Table};

use super::{Aim, HOPELESS, RESOLVED};
use crate::diagnose::text::{per_cent, set_in_words};
use crate::results::PlanResult;

/// Writes a line to a string, which cannot fail.
macro_rules! put {
    ($out:expr, $($arguments:tt)*) => {{
        let _ = writeln!($out, $($arguments)*);
    }};
}

/// The plan as text about 100 columns wide, with colours as ANSI codes if `colour` is true.
#[must_use]
pub fn text(result: &PlanResult, colour: bool) -> String {
    let mut out = String::new();
    put!(out, "{}\n", result.headline);
    let outlook = &result.outlook;
    for set in &outlook.sets {
        let members = set.members.iter().map(|member| (&*member.effect, member.probability));
        let (one_of, said) = set_in_words(members, set.nothing);
        put!(out, "Open: {one_of} {said}.");
    }
    let unexcited = names(outlook, |_| true);
    if result.aim != Aim::Sets && !unexcited.is_empty() {
        put!(out, "Not excited so far: {unexcited}.");
    }
    put!(out, "{}", purpose(result));
    if is_hopeless(result) {
        for advice in &result.advice {
            put!(out, "{advice}");
        }
        return out;
    }
    put!(
        out,
        "First {:.0} s straight and level at {:.0} m/s and {:.0} m, for the calibration. Then:\n",
        result.plan.calibration_s,
        result.plan.speed_mps,
        result.plan.altitude_m
    );
    put!(out, "{}", view::text::table(&segments(&result.segments), colour));
    let [slow, fast] = result.reached.airspeed_mps;
    let [low, high] = result.reached.altitude_m;
    let [light, heavy] = result.reached.load_factor;
    put!(
        out,
        "It reaches {slow:.0} to {fast:.0} m/s, {low:.0} to {high:.0} m, {light:.1} to {heavy:.1} g and {:.1} km from its start.",
        result.reached.distance_m / 1000.0
    );
    for remark in &result.remarks {
        put!(out, "{remark}");
    }
    for set in &outlook.sets {
        put!(out, "\n{}", promised(set));
    }
    if result.aim == Aim::Effects {
        let shown = names(outlook, |effect| effect.is_seen_then);
        let never = names(outlook, |effect| !effect.is_seen_then);
        if !shown.is_empty() {
            put!(out, "\nAt its largest possible size it would show {shown}.");
        }
        if !never.is_empty() {
            put!(out, "It would still not show {never}.");
        }
    }
    out
}

/// Whether the best plan is as good as none: it would probably resolve no set.
#[must_use]
pub fn is_hopeless(result: &PlanResult) -> bool {
    result.aim == Aim::Sets && result.outlook.sets.iter().all(|set| set.resolved < HOPELESS)
}

/// Names of effects that no flight has excited yet and whose signals the plan has, of those that count.
fn names(outlook: &Outlook, counts: impl Fn(&EffectOutlook) -> bool) -> String {
    let open = outlook.effects.iter().filter(|effect| !effect.is_seen_now && effect.is_planned);
    let names: Vec<&str> = open.filter(|effect| counts(effect)).map(|effect| &*effect.effect).collect();
    names.join(", ")
}

/// What the plan is for, and whether it is enough.
fn purpose(result: &PlanResult) -> String {
    let free_s: f64 = result.segments.iter().map(|segment| segment.duration_s).sum();
    let length = clock(free_s);
    let wanted = per_cent(RESOLVED);
    let sets = &result.outlook.sets;
    let least = sets.iter().map(|set| set.resolved).fold(f64::INFINITY, f64::min);
    let resolved = sets.iter().filter(|set| set.resolved >= RESOLVED).count();
    match (result.aim, result.is_enough) {
        (Aim::Sets, true) => {
            format!(
                "The shortest plan found that resolves this with at least {wanted} takes {length} min of manoeuvres."
            )
        }
        (Aim::Sets, false) if is_hopeless(result) => {
            format!("No plan that was tried resolves this: the best one would with {}.", per_cent(least))
        }
        (Aim::Sets, false) if resolved > 0 => format!(
            "No plan was found that resolves all of this with {wanted}. The best one takes {length} min of manoeuvres and resolves {resolved} of {all}.",
            all = sets.len()
        ),
        (Aim::Sets, false) => format!(
            "No plan was found that resolves this with {wanted}. The best one takes {length} min of manoeuvres and resolves it with {}.",
            per_cent(least)
        ),
        (Aim::Effects, true) => {
            format!("The shortest plan found that would show this takes {length} min of manoeuvres.")
        }
        (Aim::Effects, false) => format!(
            "No plan was found that would show all of this. The best one takes {length} min of manoeuvres."
        ),
        (Aim::Coefficients, _) => format!(
            "{} The manoeuvre that narrows the coefficients most for its length takes {length} min.",
            if names(&result.outlook, |_| true).is_empty() {
                "These flights leave nothing open."
            } else {
                "No manoeuvre on offer would show that."
            }
        ),
    }
}

/// What a set would become.
fn promised(set: &SetOutlook) -> String {
    let mut out = String::new();
    for member in &set.members {
        match member.identified {
            Some(identified) => put!(
                out,
                "If {} acts, diagnosing the flights together identifies it with {}.",
                member.effect,
                per_cent(identified)
            ),
            None => put!(
                out,
                "If {} acts, no flight can show it: these flights do not record its signals.",
                member.effect
            ),
        }
    }
    if let Some(cleared) = set.cleared {
        let none = if set.members.len() == 1 { "it does not act" } else { "none of them acts" };
        put!(out, "If {none}, this is no longer reported with {}.", per_cent(cleared));
    }
    out.trim_end().to_owned()
}

fn segments(segments: &[PlannedSegment]) -> Table {
    let mut table = Table::new().right("  at").right("for").left("manoeuvre").right("altitude then");
    let mut row = |at: String, duration_s: f64, words: String, altitude: String| {
        table.row([
            Cell::from(format!("  {at}")),
            format!("{duration_s:.0} s").into(),
            words.into(),
            altitude.into(),
        ]);
    };
    let altitude = |segment: &PlannedSegment| format!("{:.0} m", segment.altitude_then_m);
    let joined = joined(segments);
    let mut rest = joined.as_slice();
    while let Some(first) = rest.first() {
        let (period, times) = cycle(rest);
        let (now, then) = rest.split_at(period * times);
        let duration_s = now.iter().map(|segment| segment.duration_s).sum();
        let last = now.last().map(altitude).unwrap_or_default();
        if times > 1 {
            row(clock(first.from_s), duration_s, format!("{times} times:"), last);
            for segment in &now[..period] {
                row(String::new(), segment.duration_s, format!("  {}", segment.words), String::new());
            }
        } else {
            row(clock(first.from_s), duration_s, first.words.clone(), last);
        }
        rest = then;
    }
    table
}

/// The segments, each with those after it that say the same.
fn joined(segments: &[PlannedSegment]) -> Vec<PlannedSegment> {
    let same = segments.chunk_by(|one, next| one.words == next.words);
    let join = |same: &[PlannedSegment]| {
        let (first, last) = (same.first()?, same.last()?);
        let duration_s = same.iter().map(|segment| segment.duration_s).sum();
        Some(PlannedSegment { duration_s, altitude_then_m: last.altitude_then_m, ..first.clone() })
    };
    same.filter_map(join).collect()
}

/// Most segments of a cycle.
const LONGEST_CYCLE: usize = 4;

/// How many segments at the beginning repeat, and how often they are flown: the cycle that covers most. One
/// segment, once, where writing a cycle takes no fewer lines.
fn cycle(segments: &[PlannedSegment]) -> (usize, usize) {
    let is_same = |one: &PlannedSegment, other: &PlannedSegment| {
        one.words == other.words && one.duration_s.total_cmp(&other.duration_s).is_eq()
    };
    let repeats = |period: usize| {
        let same = (period..segments.len()).take_while(|k| is_same(&segments[*k], &segments[k - period]));
        (period, 1 + same.count() / period)
    };
    // All lines, less one for the heading and those of one cycle.
    let saved = |(period, times): &(usize, usize)| (period * times).saturating_sub(period + 1);
    let cycles = (1..=LONGEST_CYCLE.min(segments.len())).map(repeats);
    // The first of those that save as much: the shortest cycle.
    cycles.rev().max_by_key(saved).filter(|cycle| saved(cycle) > 0).unwrap_or((1, 1))
}

/// Minutes and seconds.
fn clock(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    format!("{}:{:02}", whole / 60, whole % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flown(plan: &[(&str, f64)]) -> Vec<PlannedSegment> {
        let mut from_s = 0.0;
        let mut segment = |(words, duration_s): &(&str, f64)| {
            let begin_s = from_s;
            from_s += duration_s;
            PlannedSegment {
                words: (*words).to_owned(),
                from_s: begin_s,
                duration_s: *duration_s,
                altitude_then_m: from_s,
            }
        };
        plan.iter().map(&mut segment).collect()
    }

    #[test]
    fn what_repeats_is_written_once() {
        let (up, down, level) = (("Pull up", 3.0), ("Push over", 4.0), ("Level off", 5.0));
        let plan = [&[("Climb", 40.0), level, level][..], &[[up, down]; 3].concat(), &[level]].concat();
        let text = view::text::table(&segments(&flown(&plan)), false);
        let lines: Vec<Vec<&str>> =
            text.lines().skip(2).map(|line| line.split_whitespace().collect()).collect();
        let wanted = [
            "0:00 40 s Climb 40 m",
            "0:40 10 s Level off 50 m",
            "0:50 21 s 3 times: 71 m",
            "3 s Pull up",
            "4 s Push over",
            "1:11 5 s Level off 76 m",
        ];
        assert_eq!(lines, wanted.map(|line| line.split_whitespace().collect::<Vec<_>>()), "{text}");
    }

    #[test]
    fn a_cycle_is_written_only_where_that_is_shorter() {
        let (up, down) = (("Pull up", 3.0), ("Push over", 4.0));
        assert_eq!(cycle(&flown(&[up, down, up])), (1, 1));
        assert_eq!(cycle(&flown(&[up, down, up, down])), (2, 2));
        assert_eq!(cycle(&flown(&[up, down, ("Pull up", 2.0), down])), (1, 1), "another duration");
        assert_eq!(cycle(&flown(&[])), (1, 1));
    }

    #[test]
    fn the_purpose_says_how_much_the_plan_resolves() {
        let said = |resolved: &[f64]| {
            let set = |resolved: &f64| SetOutlook { resolved: *resolved, ..SetOutlook::default() };
            let outlook = Outlook { effects: Vec::new(), sets: resolved.iter().map(set).collect() };
            let segments = flown(&[("Straight and level", 90.0)]);
            let plan = planning::FlightPlan {
                speed_mps: 28.0,
                altitude_m: 500.0,
                calibration_s: 60.0,
                legs: Vec::new(),
            };
            let reached = planning::Reached {
                airspeed_mps: [28.0, 28.0],
                altitude_m: [500.0, 500.0],
                load_factor: [1.0, 1.0],
                distance_m: 4200.0,
            };
            purpose(&PlanResult {
                version: 1,
                model: "default".to_owned(),
                file: None,
                headline: String::new(),
                advice: Vec::new(),
                aim: Aim::Sets,
                is_enough: resolved.iter().all(|resolved| *resolved >= RESOLVED),
                plan,
                segments,
                reached,
                duration_s: 150.0,
                outlook,
                remarks: Vec::new(),
            })
        };
        let best = "No plan was found that resolves";
        assert_eq!(
            said(&[0.95, 0.1]),
            format!(
                "{best} all of this with 90 %. The best one takes 1:30 min of manoeuvres and resolves 1 of 2."
            )
        );
        assert_eq!(
            said(&[0.6, 0.5]),
            format!(
                "{best} this with 90 %. The best one takes 1:30 min of manoeuvres and resolves it with 50 %."
            )
        );
        assert_eq!(said(&[0.001]), "No plan that was tried resolves this: the best one would with < 1 %.");
        assert!(said(&[0.95, 0.9]).starts_with("The shortest plan found"), "{}", said(&[0.95, 0.9]));
    }
}
