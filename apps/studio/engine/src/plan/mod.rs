//! Planning the next flight: its scenario is simulated, and the information that it would give is added to
//! that of the flights.

mod circumstances;
mod manoeuvres;
mod scenario;

use std::rc::Rc;

use analysis::diagnose::{Further, Outlook, Planner, diagnose_further};
use flight_data::{Channel, Flight};
use replay::{GivenTimes, Replay};
use simulate::scenario::Noise;
use simulate::{Scenario, Truth, simulate};

use crate::engine::{Engine, Progress, Refused, counting, parsed, refused};
use crate::protocol::{
    DiagnoseRequest, FlightPlan, Gain, Offer, PlanRequest, Planned, PlannedLeg, PlannedSegment, Reached,
};
use crate::results::to_diagnose;
use circumstances::Circumstances;

/// Straight and level flight before the first manoeuvre of a suggested plan, seconds.
const CALIBRATION_S: f64 = 60.0;

/// Plans a flight.
pub fn planned(
    engine: &mut Engine,
    request: PlanRequest,
    progress: &mut Progress<'_>,
) -> Result<Planned, Refused> {
    let PlanRequest { flights, hold_outs, model, times, plan } = request;
    let diagnosed = DiagnoseRequest { flights, hold_outs, model, times };
    let further = further(engine, &diagnosed, progress)?;
    let learned: Vec<&Flight> = diagnosed
        .flights
        .iter()
        .map(|name| engine.flight(name).map(|open| &open.flight))
        .collect::<Result<_, _>>()?;
    let planning = Planning {
        engine,
        request: &diagnosed,
        planner: &further.planner,
        around: Circumstances::of(&learned),
        learned,
    };
    let mut offers = planning.offers();
    let plan = match plan {
        Some(plan) => plan,
        None => {
            let all = offers.len() as u64;
            for (done, offer) in offers.iter_mut().enumerate() {
                progress("flying each manoeuvre", done as u64, all);
                // A manoeuvre that cannot be flown in these circumstances is not suggested.
                let alone = planning.plan(vec![offer.leg]);
                offer.gain = planning.flown(&alone).ok().map(|flown| gain(&flown.outlook));
            }
            offers.sort_by(|one, other| better(one.gain.as_ref(), other.gain.as_ref()));
            let best = offers.iter().find(|offer| offer.gain.is_some());
            planning.plan(best.map(|offer| offer.leg).into_iter().collect())
        }
    };
    manoeuvres::check(&plan, &planning.around)?;
    progress("simulating the plan", 0, 0);
    let Flown { outlook, scenario, text, truth } = planning.flown(&plan)?;
    Ok(Planned {
        segments: segments(&plan, &scenario, &truth),
        reached: reached(&truth),
        duration_s: scenario.duration_s(),
        remarks: planning.around.remarks(),
        plan,
        outlook,
        scenario: text,
        offers,
    })
}

/// The information in the flights: from a diagnosis already made of them, or from a new one.
fn further(
    engine: &mut Engine,
    request: &DiagnoseRequest,
    progress: &mut Progress<'_>,
) -> Result<Rc<Further>, Refused> {
    let key = engine.diagnosis_key(request)?;
    if let Some(found) = engine.further(&key) {
        return Ok(found);
    }
    if request.flights.is_empty() {
        return Err(refused("no flight to learn from: a plan builds on recorded flights"));
    }
    let learned = to_diagnose(engine, &request.flights, &request.model, &request.times)?;
    let held = to_diagnose(engine, &request.hold_outs, &request.model, &request.times)?;
    let found = diagnose_further(&learned, &held, &mut counting("diagnosing", progress), engine.executor);
    let further =
        found.map_err(refused)?.1.ok_or_else(|| refused("these flights give no basis for a plan"))?;
    Ok(engine.keep_further(key, further))
}

/// The inputs of planning.
struct Planning<'a> {
    engine: &'a Engine,
    request: &'a DiagnoseRequest,
    planner: &'a Planner,
    learned: Vec<&'a Flight>,
    around: Circumstances,
}

/// A plan, simulated.
struct Flown {
    outlook: Outlook,
    scenario: Scenario,
    text: String,
    truth: Truth,
}

impl Planning<'_> {
    fn offers(&self) -> Vec<Offer> {
        manoeuvres::offers(&self.around)
    }

    fn plan(&self, legs: Vec<PlannedLeg>) -> FlightPlan {
        FlightPlan {
            speed_mps: self.around.speed_mps,
            altitude_m: self.around.altitude_m,
            calibration_s: CALIBRATION_S,
            legs,
        }
    }

    fn flown(&self, plan: &FlightPlan) -> Result<Flown, Refused> {
        let text = scenario::text(plan, &self.around);
        let scenario = Scenario::from_toml(&text, "the plan").map_err(refused)?;
        let (flight, truth) = simulate(&exact(scenario.clone()), scenario.seed).map_err(refused)?;
        let flight = recorded_as(flight, &self.learned);
        let model = parsed(&self.request.model)?;
        let replay = Replay::to_diagnose(&flight, &model, GivenTimes::default()).map_err(refused)?;
        let outlook = self.planner.outlook(&replay, self.engine.executor);
        Ok(Flown { outlook, scenario, text, truth })
    }
}

/// The scenario with noise-free signals, because noise in a regressor is not excitation.
fn exact(mut scenario: Scenario) -> Scenario {
    let sensors = &mut scenario.sensors;
    sensors.air_data.airspeed_sigma_mps = 0.0;
    sensors.air_data.angle_sigma_rad = 0.0;
    sensors.air_data.temperature_sigma_c = 0.0;
    sensors.attitude.sigma_rad = 0.0;
    sensors.inertial.accel_noise = Noise::default();
    sensors.inertial.gyro_noise = Noise::default();
    sensors.gps.velocity_sigma_mps = 0.0;
    sensors.baro.temperature.sigma_c = 0.0;
    scenario
}

/// The planned flight as the user's recorder would log it: without channels that one of the flights lacks.
fn recorded_as(mut planned: Flight, learned: &[&Flight]) -> Flight {
    let records = |channel: Channel| {
        learned
            .iter()
            .all(|flight| flight.channel(channel).is_some_and(|column| column.samples().next().is_some()))
    };
    planned.channels.retain(|(channel, _)| match channel {
        Channel::Launch => true,
        Channel::BaroPa => records(Channel::BaroPa) || records(Channel::BaroAltM),
        channel => records(*channel),
    });
    planned
}

/// The value of an outlook.
fn gain(outlook: &Outlook) -> Gain {
    let told: Vec<f64> = outlook
        .sets
        .iter()
        .map(|set| {
            let told = |member: &analysis::diagnose::MemberOutlook| {
                member.probability * member.probability_then.unwrap_or(member.probability)
            };
            set.members.iter().map(told).sum()
        })
        .collect();
    let effects = outlook.effects.iter();
    let shrunk: Vec<f64> =
        effects.filter_map(|effect| Some(effect.sigma_then? / effect.sigma_now?)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let shows = outlook.effects.iter().filter(|effect| effect.is_seen_then && !effect.is_seen_now).count();
    Gain {
        tells_apart: (!told.is_empty()).then(|| mean(&told)),
        shows: shows as u32,
        narrows_to: if shrunk.is_empty() { 1.0 } else { mean(&shrunk) },
    }
}

/// Orders the better first: by how well it distinguishes the effects of a set, then by how many more it
/// shows, then by how much it narrows.
fn better(one: Option<&Gain>, other: Option<&Gain>) -> std::cmp::Ordering {
    let (Some(one), Some(other)) = (one, other) else { return other.is_some().cmp(&one.is_some()) };
    let told = |gain: &Gain| gain.tells_apart.unwrap_or(0.0);
    told(other)
        .total_cmp(&told(one))
        .then(other.shows.cmp(&one.shows))
        .then(one.narrows_to.total_cmp(&other.narrows_to))
}

fn segments(plan: &FlightPlan, scenario: &Scenario, truth: &Truth) -> Vec<PlannedSegment> {
    let mut from_s = 0.0;
    let mut airspeed_mps = plan.speed_mps;
    let flown = manoeuvres::segments(plan).into_iter().zip(&scenario.free_flight);
    flown
        .map(|(name, segment)| {
            airspeed_mps = segment.airspeed_mps.unwrap_or(airspeed_mps);
            let begin_s = from_s;
            from_s += segment.duration_s;
            let end_s = plan.calibration_s + from_s;
            let at = truth.trajectory.partition_point(|sample| sample.time_s < end_s);
            let then = truth.trajectory.get(at).or_else(|| truth.trajectory.last());
            PlannedSegment {
                manoeuvre: name.manoeuvre.to_owned(),
                from_s: begin_s,
                duration_s: segment.duration_s,
                airspeed_mps,
                flight_path_deg: segment.flight_path_deg,
                bank_deg: segment.bank_deg,
                load_factor: segment.load_factor,
                altitude_then_m: then.map_or(plan.altitude_m, |sample| sample.altitude_m),
            }
        })
        .collect()
}

fn reached(truth: &Truth) -> Reached {
    let free = || truth.trajectory.iter().filter(|sample| !sample.captive);
    let range = |of: &dyn Fn(&simulate::TruthSample) -> f64| {
        free().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| {
            [least.min(value), most.max(value)]
        })
    };
    let from = truth.trajectory.first().map_or([0.0; 2], |sample| sample.position_m);
    let distance = |sample: &simulate::TruthSample| {
        let [north, east] = sample.position_m;
        (north - from[0]).hypot(east - from[1])
    };
    Reached {
        airspeed_mps: range(&|sample| sample.airspeed_mps),
        altitude_m: range(&|sample| sample.altitude_m),
        load_factor: range(&simulate::TruthSample::load_factor),
        distance_m: range(&distance)[1],
    }
}
