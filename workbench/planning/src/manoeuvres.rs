//! Manoeuvres that can be planned, as segments of a scenario.

use crate::circumstances::Circumstances;
use crate::error::PlanError;
use crate::plan::{FlightPlan, Offer, PlannedLeg, PlannedManoeuvre};

/// Longest plan, seconds.
const LONGEST_S: f64 = 7200.0;
/// Limit on the number of legs, and on the repetitions of one.
const MOST: usize = 40;
/// Flight-path angle in pull-ups, degrees.
const PULL_UP_DEG: f64 = 12.0;
/// The bank between straight legs, degrees.
const LEG_BANK_DEG: f64 = 45.0;
/// Straight and level flight between turns and after pull-ups, seconds.
const BETWEEN_S: f64 = 5.0;
/// Standard gravity, m/s^2.
const GRAVITY: f64 = 9.806_65;

/// One segment of a scenario's free flight: the manoeuvre's name there, and its keys.
pub struct Segment {
    pub manoeuvre: &'static str,
    pub duration_s: f64,
    pub keys: Vec<(&'static str, f64)>,
}

/// The manoeuvres on offer, with suggested values.
pub fn offers(around: &Circumstances) -> Vec<Offer> {
    let speed = around.speed_mps;
    let offer = |manoeuvre, [amount, least, most]: [f64; 3], unit: &str, duration_s, times| Offer {
        leg: PlannedLeg { manoeuvre, amount, duration_s, times },
        unit: unit.to_owned(),
        least,
        most,
        gain: None,
    };
    let share = |share: f64| (share * speed).round().max(1.0);
    vec![
        offer(PlannedManoeuvre::SpeedSweep, [share(0.25), 1.0, share(0.4)], "m/s", 20.0, 2),
        offer(PlannedManoeuvre::Climbs, [6.0, 1.0, 25.0], "deg", 20.0, 2),
        offer(PlannedManoeuvre::PullUps, [1.8, 1.1, 3.0], "g", 3.0, 6),
        offer(PlannedManoeuvre::Turns, [45.0, 5.0, 60.0], "deg", 15.0, 2),
        offer(PlannedManoeuvre::Level, [0.0, 0.0, 0.0], "", 120.0, 1),
        offer(PlannedManoeuvre::LongClimb, [6.0, 1.0, 25.0], "deg", 40.0, 1),
        offer(PlannedManoeuvre::Legs, [share(0.2), 1.0, share(0.4)], "m/s", 10.0, 4),
    ]
}

/// Refuses a plan that cannot be flown.
pub fn check(plan: &FlightPlan, around: &Circumstances) -> Result<(), PlanError> {
    let between = |what: &str, value: f64, least: f64, most: f64| {
        if (least..=most).contains(&value) {
            Ok(())
        } else {
            Err(PlanError::Range { what: what.to_owned(), value, least, most })
        }
    };
    between("the speed, m/s,", plan.speed_mps, 8.0, 350.0)?;
    between("the altitude, m,", plan.altitude_m, 0.0, 15_000.0)?;
    between("the calibration, s,", plan.calibration_s, 20.0, 600.0)?;
    if plan.legs.is_empty() || plan.legs.len() > MOST {
        return Err(PlanError::Manoeuvres { found: plan.legs.len(), most: MOST });
    }
    let wide = Circumstances { speed_mps: plan.speed_mps, ..*around };
    let offers = offers(&wide);
    for leg in &plan.legs {
        let offer = offers.iter().find(|offer| offer.leg.manoeuvre == leg.manoeuvre);
        if let Some(offer) = offer.filter(|offer| !offer.unit.is_empty()) {
            between(&format!("the amount, {},", offer.unit), leg.amount, offer.least, offer.most)?;
        }
        between("a duration, s,", leg.duration_s, 1.0, 600.0)?;
        between("the times", f64::from(leg.times), 1.0, MOST as f64)?;
    }
    let seconds: f64 = segments(plan).iter().map(|segment| segment.duration_s).sum();
    between("the plan's length, s,", plan.calibration_s + seconds, 1.0, LONGEST_S)
}

/// The segments of a plan.
pub fn segments(plan: &FlightPlan) -> Vec<Segment> {
    let mut segments = Vec::new();
    for leg in &plan.legs {
        for _ in 0..leg.times {
            once(leg, plan.speed_mps, &mut segments);
        }
        // Returns to the state in which this leg began, for the next one.
        segments.push(segment("level_off", BETWEEN_S, &[("airspeed_mps", plan.speed_mps)]));
    }
    segments
}

/// Rate of a level turn at this bank, degrees, and true airspeed, m/s: `g tan(bank) / V`, rad/s.
pub fn turn_rate_radps(bank_deg: f64, speed_mps: f64) -> f64 {
    GRAVITY * libm::tan(bank_deg.to_radians()) / speed_mps
}

fn segment(manoeuvre: &'static str, duration_s: f64, keys: &[(&'static str, f64)]) -> Segment {
    Segment { manoeuvre, duration_s, keys: keys.to_vec() }
}

fn once(leg: &PlannedLeg, speed_mps: f64, out: &mut Vec<Segment>) {
    let PlannedLeg { manoeuvre, amount, duration_s, .. } = *leg;
    let fast = [("airspeed_mps", speed_mps + amount)];
    let slow = [("airspeed_mps", speed_mps - amount)];
    match manoeuvre {
        PlannedManoeuvre::SpeedSweep => {
            out.push(segment("accelerate", duration_s, &fast));
            out.push(segment("decelerate", duration_s, &slow));
        }
        PlannedManoeuvre::Climbs => {
            out.push(segment("climb", duration_s, &[("flight_path_deg", amount)]));
            out.push(segment("level_off", 0.5 * duration_s, &[]));
            out.push(segment("dive", duration_s, &[("flight_path_deg", -amount)]));
            out.push(segment("level_off", 0.5 * duration_s, &[]));
        }
        PlannedManoeuvre::PullUps => {
            out.push(segment(
                "pull_up",
                duration_s,
                &[("flight_path_deg", PULL_UP_DEG), ("load_factor", amount)],
            ));
            out.push(segment(
                "dive",
                duration_s,
                &[("flight_path_deg", -PULL_UP_DEG), ("load_factor", 2.0 - amount)],
            ));
        }
        PlannedManoeuvre::Turns => {
            out.push(segment("turn", duration_s, &[("bank_deg", amount)]));
            out.push(segment("straight", BETWEEN_S, &[]));
            out.push(segment("turn", duration_s, &[("bank_deg", -amount)]));
            out.push(segment("straight", BETWEEN_S, &[]));
        }
        PlannedManoeuvre::Level => out.push(segment("straight", duration_s, &[])),
        PlannedManoeuvre::LongClimb => {
            out.push(segment("climb", duration_s, &[("flight_path_deg", amount)]));
            out.push(segment("level_off", duration_s, &[]));
            out.push(segment("dive", duration_s, &[("flight_path_deg", -amount)]));
            out.push(segment("level_off", BETWEEN_S, &[]));
        }
        PlannedManoeuvre::Legs => {
            out.push(segment("accelerate", duration_s, &fast));
            out.push(segment("decelerate", duration_s, &slow));
            // A quarter of a circle at this bank and speed.
            let quarter_s = core::f64::consts::FRAC_PI_2 / turn_rate_radps(LEG_BANK_DEG, speed_mps);
            out.push(segment("turn", quarter_s, &[("bank_deg", LEG_BANK_DEG), ("airspeed_mps", speed_mps)]));
        }
    }
}
