//! Plans the next flight: what it would consist of, and what it would show.
//!
//! A plan is a list of manoeuvres. Its scenario is simulated without noise in calm air, and the information
//! that it would give is added to that of the flights ([`analysis::diagnose::Planner`]). [`shortest`] searches
//! for the shortest plan that resolves what the flights leave open.

mod circumstances;
mod error;
mod manoeuvres;
mod plan;
mod scenario;
pub mod shortest;
mod words;

use std::cmp::Ordering;

use analysis::diagnose::{Outlook, Planner};
use executor::Executor;
use flight_data::{Channel, Flight};
use model::Model;
use replay::{GivenTimes, Replay};
use simulate::scenario::Noise;
use simulate::{Scenario, Truth, TruthSample, simulate};

pub use circumstances::Circumstances;
pub use error::PlanError;
pub use plan::{FlightPlan, Gain, Offer, PlannedLeg, PlannedManoeuvre, PlannedSegment, Reached};

/// Straight and level flight before the first manoeuvre of a suggested plan, seconds.
const CALIBRATION_S: f64 = 60.0;
/// Rows a second while plans are compared. Manoeuvres last seconds, and the diagnosis averages half a second
/// and more; a plan that was chosen is simulated with the flights' own rates.
const COARSE_HZ: f64 = 50.0;

/// What a plan builds on.
pub struct Planning<'a> {
    planner: &'a Planner,
    learned: &'a [&'a Flight],
    model: &'a Model,
    around: Circumstances,
    executor: &'a dyn Executor,
}

/// A plan, simulated.
#[derive(Clone, Debug)]
pub struct Flown {
    /// What it would show.
    pub outlook: Outlook,
    /// Its scenario.
    pub scenario: Scenario,
    /// The scenario's text, which `pylon simulate` accepts.
    pub text: String,
    /// The simulated motion.
    pub truth: Truth,
}

impl<'a> Planning<'a> {
    /// For these flights, from a diagnosis of them with this model.
    #[must_use]
    pub fn new(
        planner: &'a Planner,
        learned: &'a [&'a Flight],
        model: &'a Model,
        executor: &'a dyn Executor,
    ) -> Self {
        Self { planner, learned, model, around: Circumstances::of(learned), executor }
    }

    /// The circumstances of the flights.
    #[must_use]
    pub const fn around(&self) -> &Circumstances {
        &self.around
    }

    /// The manoeuvres on offer, with suggested values.
    #[must_use]
    pub fn offers(&self) -> Vec<Offer> {
        manoeuvres::offers(&self.around)
    }

    /// A plan of these manoeuvres, flown as these flights were.
    #[must_use]
    pub const fn plan(&self, legs: Vec<PlannedLeg>) -> FlightPlan {
        FlightPlan {
            speed_mps: self.around.speed_mps,
            altitude_m: self.around.altitude_m,
            calibration_s: CALIBRATION_S,
            legs,
        }
    }

    /// Refuses a plan that cannot be flown.
    ///
    /// # Errors
    /// [`PlanError`] names the value that is out of its range.
    pub fn check(&self, plan: &FlightPlan) -> Result<(), PlanError> {
        manoeuvres::check(plan, &self.around)
    }

    /// Simulates a plan.
    ///
    /// # Errors
    /// [`PlanError`] where the aircraft cannot fly it.
    pub fn flown(&self, plan: &FlightPlan) -> Result<Flown, PlanError> {
        let text = scenario::text(plan, &self.around);
        let scenario = Scenario::from_toml(&text, "the plan")?;
        let (outlook, truth) = self.outlook(&scenario)?;
        Ok(Flown { outlook, scenario, text, truth })
    }

    /// What a plan would show, from rows and readings that are no more frequent than [`COARSE_HZ`]; its
    /// manoeuvres' duration, seconds.
    ///
    /// # Errors
    /// [`PlanError`] where the aircraft cannot fly it.
    fn coarsely(&self, plan: &FlightPlan) -> Result<(Outlook, f64), PlanError> {
        self.check(plan)?;
        let mut scenario = Scenario::from_toml(&scenario::text(plan, &self.around), "the plan")?;
        // A sensor that is faster has a reading in every row.
        scenario.rate_hz = COARSE_HZ;
        let seconds = scenario.free_flight.iter().map(|segment| segment.duration_s).sum();
        Ok((self.outlook(&scenario)?.0, seconds))
    }

    /// What a scenario would show, and its motion.
    fn outlook(&self, scenario: &Scenario) -> Result<(Outlook, Truth), PlanError> {
        let (flight, truth) = simulate(&exact(scenario.clone()), scenario.seed)?;
        let flight = recorded_as(flight, self.learned);
        let replay = Replay::to_diagnose(&flight, self.model, GivenTimes::default())?;
        Ok((self.planner.outlook(&replay, self.executor), truth))
    }

    /// The manoeuvres on offer with what each would add by itself, the best first. A manoeuvre that cannot be
    /// flown in these circumstances has no gain. `progress` gets the number that were flown, and of how many.
    #[must_use]
    pub fn weighed_offers(&self, progress: &mut dyn FnMut(u64, u64)) -> Vec<Offer> {
        let mut offers = self.offers();
        let all = offers.len() as u64;
        for (done, offer) in offers.iter_mut().enumerate() {
            progress(done as u64, all);
            let alone = self.plan(vec![offer.leg]);
            offer.gain = self.coarsely(&alone).ok().map(|(outlook, _)| gain(&outlook));
        }
        offers.sort_by(|one, other| better(one.gain.as_ref(), other.gain.as_ref()));
        offers
    }
}

impl Flown {
    /// The plan's segments, for a flight card.
    #[must_use]
    pub fn segments(&self, plan: &FlightPlan) -> Vec<PlannedSegment> {
        let mut from_s = 0.0;
        let mut airspeed_mps = plan.speed_mps;
        let segment = |segment: &simulate::scenario::Segment| {
            airspeed_mps = segment.airspeed_mps.unwrap_or(airspeed_mps);
            let begin_s = from_s;
            from_s += segment.duration_s;
            let end_s = plan.calibration_s + from_s;
            let at = self.truth.trajectory.partition_point(|sample| sample.time_s < end_s);
            let then = self.truth.trajectory.get(at).or_else(|| self.truth.trajectory.last());
            PlannedSegment {
                words: words::words(segment, airspeed_mps),
                from_s: begin_s,
                duration_s: segment.duration_s,
                altitude_then_m: then.map_or(plan.altitude_m, |sample| sample.altitude_m),
            }
        };
        self.scenario.free_flight.iter().map(segment).collect()
    }

    /// The ranges that it reaches.
    #[must_use]
    pub fn reached(&self) -> Reached {
        let free = || self.truth.trajectory.iter().filter(|sample| !sample.captive);
        let range = |of: &dyn Fn(&TruthSample) -> f64| {
            free().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], value| {
                [least.min(value), most.max(value)]
            })
        };
        let from = self.truth.trajectory.first().map_or([0.0; 2], |sample| sample.position_m);
        let distance = |sample: &TruthSample| {
            let [north, east] = sample.position_m;
            libm::hypot(north - from[0], east - from[1])
        };
        Reached {
            airspeed_mps: range(&|sample| sample.airspeed_mps),
            altitude_m: range(&|sample| sample.altitude_m),
            load_factor: range(&TruthSample::load_factor),
            distance_m: range(&distance)[1],
        }
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
    let told: Vec<f64> = outlook.sets.iter().map(|set| set.resolved).collect();
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
fn better(one: Option<&Gain>, other: Option<&Gain>) -> Ordering {
    let (Some(one), Some(other)) = (one, other) else { return other.is_some().cmp(&one.is_some()) };
    let told = |gain: &Gain| gain.tells_apart.unwrap_or(0.0);
    told(other)
        .total_cmp(&told(one))
        .then(other.shows.cmp(&one.shows))
        .then(one.narrows_to.total_cmp(&other.narrows_to))
}
