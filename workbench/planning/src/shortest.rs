//! The shortest plan that resolves what the flights leave open.
//!
//! If there are sets of effects that the flights cannot tell apart, the plan is to resolve each of them with
//! a probability of [`RESOLVED`]. Otherwise it is to show each effect that the flights have not excited, at
//! its largest physically possible size, with the same probability; and where all are excited, or none can be, to narrow
//! the coefficients. Manoeuvres are added one after the other, each time the one that brings this nearest for its
//! duration; then those that turn out not to be needed are removed. All plans cannot be tried: it is the
//! shortest that this finds.

use std::ops::ControlFlow;

use analysis::diagnose::{EffectOutlook, Outlook, SetOutlook};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use statistics::{normal_above, normal_quantile};

use crate::plan::{FlightPlan, PlannedLeg, PlannedManoeuvre};
use crate::{Flown, Planning, gain};

/// The probability with which a plan is to resolve a set, or to show an effect.
pub const RESOLVED: f64 = 0.9;
/// A plan that resolves a set with less is not worth a flight: the probability below which an effect is no
/// suspect.
pub const HOPELESS: f64 = 0.05;
/// Longest free flight of a plan before circling is added, seconds.
const LONGEST_S: f64 = 600.0;
/// Ten minutes of circling, five to the right and five to the left, in which a slow effect has time to act.
const CIRCLING: PlannedLeg =
    PlannedLeg { manoeuvre: PlannedManoeuvre::Turns, amount: 20.0, duration_s: 300.0, times: 1 };
/// Most repetitions of it: 50 minutes are nearly four times the longest time constant that a diagnosis tries,
/// 800 s, after which a warming up is over and a drift is not.
const MOST_CIRCLING: u32 = 5;
/// Most manoeuvres added one after the other.
const STEPS: usize = 12;
/// The standard normal quantiles beyond which a probability counts as that of the limit: what is certain is
/// not worth a manoeuvre, and what is hopeless has no numbers below this. What is nearly hopeless counts: one
/// manoeuvre alone may not bring it near.
const QUANTILES: [f64; 2] = [-36.0, 2.0];

/// What a plan is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Aim {
    /// To resolve the sets.
    Sets,
    /// To show the effects that no flight has excited.
    Effects,
    /// To make the coefficients more certain: nothing else is open, or no manoeuvre on offer shows it.
    Coefficients,
}

/// The plan that was found.
#[derive(Clone, Debug)]
pub struct Shortest {
    /// What it is for.
    pub aim: Aim,
    /// The plan.
    pub plan: FlightPlan,
    /// The plan, simulated.
    pub flown: Flown,
}

impl Shortest {
    /// Whether it resolves every set, or shows every effect, with a probability of [`RESOLVED`].
    #[must_use]
    pub fn is_enough(&self) -> bool {
        self.aim.is_reached(&self.flown.outlook)
    }
}

/// The effects that the flights have not excited, and whose signals a plan has.
fn open(outlook: &Outlook) -> impl Iterator<Item = &EffectOutlook> {
    outlook.effects.iter().filter(|effect| !effect.is_seen_now && effect.is_planned)
}

impl Aim {
    fn of(outlook: &Outlook) -> Self {
        if !outlook.sets.is_empty() {
            Self::Sets
        } else if open(outlook).next().is_some() {
            Self::Effects
        } else {
            Self::Coefficients
        }
    }

    fn is_reached(self, outlook: &Outlook) -> bool {
        match self {
            Self::Sets => outlook.sets.iter().all(|set| set.resolved >= RESOLVED),
            Self::Effects => open(outlook).all(|effect| effect.detection_then >= RESOLVED),
            Self::Coefficients => true,
        }
    }

    /// Whether more of this plan would not help: every set is resolved or hopeless. What is not shown of the
    /// effects that are not excited may as well be left.
    fn is_settled(self, outlook: &Outlook) -> bool {
        let is_settled = |set: &SetOutlook| set.resolved >= RESOLVED || set.resolved < HOPELESS;
        self == Self::Effects || outlook.sets.iter().all(is_settled)
    }

    /// How many sets are resolved, or effects shown.
    fn achieved(self, outlook: &Outlook) -> usize {
        match self {
            Self::Sets => outlook.sets.iter().filter(|set| set.resolved >= RESOLVED).count(),
            Self::Effects => open(outlook).filter(|effect| effect.detection_then >= RESOLVED).count(),
            Self::Coefficients => 0,
        }
    }

    /// How near an outlook is to the aim: the sum of the quantiles of all probabilities that count; for the
    /// coefficients, the share by which they become more certain.
    fn nearness(self, outlook: &Outlook) -> f64 {
        match self {
            Self::Sets => outlook.sets.iter().map(of_set).sum(),
            Self::Effects => open(outlook).map(|effect| quantile(effect.detection_then)).sum(),
            Self::Coefficients => -gain(outlook).narrows_to,
        }
    }
}

/// How near a set is to being resolved: each of its effects counts with its probability.
fn of_set(set: &SetOutlook) -> f64 {
    let members = set.members.iter();
    let of_members: f64 =
        members.filter_map(|member| Some(member.probability * quantile(member.identified?))).sum();
    of_members + quantile(set.resolved)
}

fn quantile(probability: f64) -> f64 {
    let [least, most] = QUANTILES;
    if probability <= normal_above(-least) {
        least
    } else if probability >= normal_above(-most) {
        most
    } else {
        normal_quantile(probability)
    }
}

/// A plan under construction.
struct Step {
    legs: Vec<PlannedLeg>,
    outlook: Outlook,
    seconds: f64,
}

/// Searches for the shortest plan; `None` where no manoeuvre can be flown. `progress` is called once for each
/// plan that is simulated; if it breaks, the best plan so far is returned.
#[must_use]
pub fn shortest(planning: &Planning<'_>, progress: &mut dyn FnMut() -> ControlFlow<()>) -> Option<Shortest> {
    let first = steps(planning, &[], progress);
    let mut aim = Aim::of(&first.found.first()?.outlook);
    let mut best = search(planning, aim, first, progress)?;
    // None of these manoeuvres excites what is left: a sideslip, for example.
    if aim == Aim::Effects && aim.achieved(&best.outlook) == 0 {
        aim = Aim::Coefficients;
        best = search(planning, aim, steps(planning, &[], progress), progress)?;
    }
    let plan = planning.plan(best.legs);
    let flown = planning.flown(&plan).ok()?;
    Some(Shortest { aim, plan, flown })
}

fn search(
    planning: &Planning<'_>,
    aim: Aim,
    mut steps: Steps,
    progress: &mut dyn FnMut() -> ControlFlow<()>,
) -> Option<Step> {
    let nearness = |step: &Step| aim.nearness(&step.outlook);
    let is_enough = |step: &Step| aim.is_reached(&step.outlook);
    // Nothing is known of a flight without a manoeuvre: the first is compared with the worst.
    let worst = steps.found.iter().map(nearness).fold(f64::INFINITY, f64::min);
    let mut best: Option<Step> = None;
    for _ in 0..STEPS {
        let from = best.as_ref().map_or(worst, nearness);
        let seconds = best.as_ref().map_or(0.0, |best| best.seconds);
        let rate = |step: &Step| (nearness(step) - from) / (step.seconds - seconds);
        let is_better = |step: &Step| best.is_none() || nearness(step) > from;
        let better = steps.found.into_iter().filter(|step| step.seconds <= LONGEST_S && is_better(step));
        let Some(next) = better.max_by(|one, other| rate(one).total_cmp(&rate(other))) else { break };
        let is_last = steps.is_stopped || is_enough(&next);
        let legs = next.legs.clone();
        best = Some(next);
        if is_last {
            break;
        }
        steps = self::steps(planning, &legs, progress);
    }
    let mut best = best?;
    if aim == Aim::Sets && !is_enough(&best) {
        best = with_circling(planning, best, progress);
    }
    Some(trimmed(planning, aim, best, progress))
}

/// The plan with as much circling at its end as it takes to resolve another set, and the plan as it was where none
/// does: what changes within minutes or hours, such as a drift or a warming up, takes time and no manoeuvre.
fn with_circling(planning: &Planning<'_>, best: Step, progress: &mut dyn FnMut() -> ControlFlow<()>) -> Step {
    let may_be_resolved = |set: &SetOutlook| {
        let members = set.members.iter().filter(|member| member.identified.is_some());
        let most = members.map(|member| member.probability).sum::<f64>() + set.nothing.unwrap_or(0.0);
        set.resolved < RESOLVED && most >= RESOLVED
    };
    if !best.outlook.sets.iter().any(may_be_resolved) {
        return best;
    }
    for times in 1..=MOST_CIRCLING {
        let legs = [best.legs.as_slice(), &[PlannedLeg { times, ..CIRCLING }]].concat();
        let is_better = |step: &Step| Aim::Sets.achieved(&step.outlook) > Aim::Sets.achieved(&best.outlook);
        if let Some(longer) = step(planning, legs).filter(is_better) {
            return longer;
        }
        if progress().is_break() {
            break;
        }
    }
    best
}

/// The plan without what later manoeuvres made superfluous, and what showed no further effect. Where a set is
/// neither resolved nor hopeless nothing is left out: all of it counts for that one.
fn trimmed(
    planning: &Planning<'_>,
    aim: Aim,
    mut best: Step,
    progress: &mut dyn FnMut() -> ControlFlow<()>,
) -> Step {
    while aim.achieved(&best.outlook) > 0 && aim.is_settled(&best.outlook) {
        let mut removals: Vec<(usize, u32)> =
            best.legs.iter().enumerate().flat_map(|(at, leg)| [(at, 1), (at, leg.times)]).collect();
        removals.dedup();
        let shorter = removals.into_iter().filter_map(|(at, times)| {
            let shorter = step(planning, without(&best.legs, at, times));
            progress().is_continue().then_some(shorter)?
        });
        let is_as_good = |step: &Step| aim.achieved(&step.outlook) >= aim.achieved(&best.outlook);
        let Some(found) =
            shorter.filter(is_as_good).min_by(|one, other| one.seconds.total_cmp(&other.seconds))
        else {
            break;
        };
        best = found;
    }
    best
}

/// Plans that are one manoeuvre longer.
struct Steps {
    found: Vec<Step>,
    is_stopped: bool,
}

fn steps(
    planning: &Planning<'_>,
    legs: &[PlannedLeg],
    progress: &mut dyn FnMut() -> ControlFlow<()>,
) -> Steps {
    let mut steps = Steps { found: Vec::new(), is_stopped: false };
    for leg in planning.offers().into_iter().flat_map(|offer| [Some(offer.leg), longer(offer.leg)]).flatten()
    {
        steps.found.extend(step(planning, with(legs, leg)));
        if progress().is_break() {
            steps.is_stopped = true;
            break;
        }
    }
    steps
}

/// A climb three times as long as the one on offer: the air's temperature, and with it the barometer's,
/// changes over hundreds of metres.
fn longer(leg: PlannedLeg) -> Option<PlannedLeg> {
    let is_long = leg.manoeuvre == PlannedManoeuvre::LongClimb;
    is_long.then_some(PlannedLeg { duration_s: 3.0 * leg.duration_s, ..leg })
}

/// Flies these legs, if they can be flown.
fn step(planning: &Planning<'_>, legs: Vec<PlannedLeg>) -> Option<Step> {
    let (outlook, seconds) = planning.coarsely(&planning.plan(legs.clone())).ok()?;
    Some(Step { legs, outlook, seconds })
}

/// The legs and half of an offered manoeuvre's repetitions, joined to one of the same kind.
fn with(legs: &[PlannedLeg], offered: PlannedLeg) -> Vec<PlannedLeg> {
    let times = offered.times.div_ceil(2);
    let mut legs = legs.to_vec();
    let is_same =
        |leg: &&mut PlannedLeg| leg.manoeuvre == offered.manoeuvre && leg.duration_s == offered.duration_s;
    match legs.iter_mut().find(is_same) {
        Some(leg) => leg.times += times,
        None => legs.push(PlannedLeg { times, ..offered }),
    }
    legs
}

/// The legs with so many repetitions less of one of them.
fn without(legs: &[PlannedLeg], at: usize, times: u32) -> Vec<PlannedLeg> {
    let mut legs = legs.to_vec();
    if let Some(leg) = legs.get_mut(at) {
        leg.times = leg.times.saturating_sub(times);
    }
    legs.retain(|leg| leg.times > 0);
    legs
}

#[cfg(test)]
mod tests {
    use analysis::diagnose::MemberOutlook;

    use super::*;

    fn leg(manoeuvre: PlannedManoeuvre, duration_s: f64, times: u32) -> PlannedLeg {
        PlannedLeg { manoeuvre, amount: 6.0, duration_s, times }
    }

    #[test]
    fn a_manoeuvre_is_added_to_those_of_its_kind_and_length() {
        let climb = leg(PlannedManoeuvre::LongClimb, 40.0, 1);
        let legs = with(&with(&[], climb), leg(PlannedManoeuvre::PullUps, 3.0, 5));
        assert_eq!(legs, [climb, leg(PlannedManoeuvre::PullUps, 3.0, 3)], "half of its repetitions");
        assert_eq!(with(&legs, climb)[0].times, 2);
        let longer = longer(climb).unwrap();
        assert_eq!(with(&legs, longer).last(), Some(&leg(PlannedManoeuvre::LongClimb, 120.0, 1)));
        assert_eq!(super::longer(leg(PlannedManoeuvre::Turns, 15.0, 2)), None);
        assert_eq!(without(&legs, 0, 1), [leg(PlannedManoeuvre::PullUps, 3.0, 3)]);
        assert_eq!(without(&legs, 1, 1), [climb, leg(PlannedManoeuvre::PullUps, 3.0, 2)]);
    }

    fn member(probability: f64, identified: Option<f64>) -> MemberOutlook {
        let sigmas = None;
        MemberOutlook {
            effect: "one".into(),
            probability,
            probability_then: None,
            left: None,
            sigmas,
            identified,
        }
    }

    /// What is certain counts as two sigmas and no more, so that no manoeuvre is spent on it; what is nearly
    /// hopeless still counts, so that the first manoeuvres of a long plan are found.
    #[test]
    fn certainty_counts_no_further_and_hopelessness_does() {
        let set = |identified: [f64; 2]| {
            let members = identified.map(|identified| member(0.5, Some(identified))).to_vec();
            let resolved = 0.5 * identified.iter().sum::<f64>();
            of_set(&SetOutlook { members, nothing: None, cleared: None, resolved })
        };
        assert!((set([1.0, 1.0]) - 4.0).abs() < 1e-9);
        assert_eq!(set([0.999, 0.99999]).total_cmp(&set([1.0, 1.0])), std::cmp::Ordering::Equal);
        assert!(set([1e-100, 1e-90]) > set([1e-100, 1e-100]));
        // Half certain and half hopeless is no better than two that are halfway.
        assert!(set([1.0, 1e-30]) < set([0.5, 0.5]));
        // An effect whose signal is not recorded counts in what is resolved only.
        let hidden = |identified: f64| SetOutlook {
            members: vec![member(0.5, Some(identified)), member(0.5, None)],
            nothing: None,
            cleared: None,
            resolved: 0.5 * identified,
        };
        assert!((of_set(&hidden(1.0)) - 1.0).abs() < 1e-9);
        assert!(of_set(&hidden(0.9)) < of_set(&hidden(1.0)));
    }

    #[test]
    fn the_sets_come_first_then_what_is_not_excited() {
        let effect = |is_seen_now: bool, is_planned: bool, detection_then: f64| EffectOutlook {
            effect: "one".into(),
            sensor: "baro".into(),
            unit: "1".into(),
            is_found: false,
            coefficient: None,
            sigma_now: None,
            sigma_then: None,
            largest: 1.0,
            is_seen_now,
            is_seen_then: detection_then >= RESOLVED,
            detection_then,
            is_planned,
        };
        let set = |resolved| SetOutlook { resolved, ..SetOutlook::default() };
        let outlook = |effects: Vec<EffectOutlook>, sets: Vec<SetOutlook>| Outlook { effects, sets };
        let seen = outlook(vec![effect(true, true, 1.0), effect(false, false, 0.0)], Vec::new());
        assert_eq!((Aim::of(&seen), Aim::of(&seen).is_reached(&seen)), (Aim::Coefficients, true));
        let unseen = outlook(vec![effect(false, true, 0.89)], Vec::new());
        assert_eq!((Aim::of(&unseen), Aim::of(&unseen).is_reached(&unseen)), (Aim::Effects, false));
        let shown = outlook(vec![effect(false, true, 0.9)], Vec::new());
        assert!(Aim::Effects.is_reached(&shown));
        let partly = outlook(vec![effect(false, true, 0.95), effect(false, true, 0.2)], Vec::new());
        assert_eq!((Aim::Effects.achieved(&partly), Aim::Effects.is_reached(&partly)), (1, false));
        let both = outlook(vec![effect(false, true, 0.0)], vec![set(0.95), set(0.85)]);
        assert_eq!((Aim::of(&both), Aim::of(&both).is_reached(&both)), (Aim::Sets, false));
        assert!(Aim::Sets.is_reached(&outlook(Vec::new(), vec![set(0.95), set(0.9)])));
        let settled = |sets: [f64; 2]| Aim::Sets.is_settled(&outlook(Vec::new(), sets.map(set).to_vec()));
        assert_eq!([[0.95, 0.9], [0.95, 0.04], [0.95, 0.06]].map(settled), [true, true, false]);
    }
}
