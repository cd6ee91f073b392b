//! One run: a flight, clean and with its faults, with a sensor failing in both.

use std::panic::{AssertUnwindSafe, catch_unwind};

use anyhow::Result;
use chip_models::flown::{Chip, Fault};
use kf_core::config::MissionConfig;
use kf_core::input::{BaroReading, TickInput};
use kf_core::sensor::Sensor;
use model::Model;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

use super::computer::{Computer, FlownMission};
use super::draw::draw;
use super::fault::{Dip, DipTick, Drawn};
use super::flight::{self, FIRST_US, Row, TICK_US, pressure_pa};
use super::plan::Plan;
use super::watch::Watched;

/// Slope of a drift, m/s.
const DRIFT_MPS: f32 = 2.0;
/// Size of a step, in the monitor's sigmas, of which the bound is a multiple ([`MULTIPLIER`]).
const STEP_SIGMAS: f32 = 10.0;
/// The default model's `monitor.multiplier`.
const MULTIPLIER: f32 = 3.0;
/// How long an inertial unit is pushed to make the altitude integrated from it drift, ticks: half a second.
pub const PUSH_TICKS: usize = 100;

/// How a sensor fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FailureKind {
    /// It drifts from that tick on.
    Drift,
    /// It has an offset from that tick on.
    Step,
}

/// A sensor that fails in free flight, by itself: the monitor must detect it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failure {
    /// The sensor.
    pub sensor: Sensor,
    /// Its kind of failure.
    pub kind: FailureKind,
    /// Its first tick.
    pub tick: usize,
    /// Upwards or downwards.
    pub sign: f32,
}

/// A run, drawn from its seed.
#[derive(Clone, Debug)]
pub struct Case {
    /// Number of the run.
    pub index: u64,
    /// The flight.
    pub plan: Plan,
    /// Its faults.
    pub faults: Vec<Drawn>,
    /// The sensor that fails in both flights.
    pub failure: Option<Failure>,
}

/// Both flights of a run.
pub struct Flown {
    /// The flight without the faults.
    pub clean: Watched,
    /// The flight with the faults.
    pub faulty: Watched,
}

/// The random numbers for one part of a run, independent of the other parts.
fn random(seed: u64, index: u64, part: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(index * 4 + part);
    random
}

impl Case {
    /// Draws a run. `is_short`: with a flight short enough to fly in QEMU within seconds.
    #[must_use]
    pub fn draw(seed: u64, index: u64, is_short: bool) -> Self {
        let plan = Plan::draw(&mut random(seed, index, 0), is_short);
        let mut random = random(seed, index, 1);
        let faults = draw(&plan, &mut random);
        let failure = (plan.separates && random.random_bool(0.67)).then(|| Failure {
            sensor: if random.random_bool(0.6) { Sensor::Baro } else { Sensor::ImuSlave },
            kind: if random.random_bool(0.5) { FailureKind::Drift } else { FailureKind::Step },
            tick: plan.separation() + random.random_range(1_800..4_000.min(plan.ticks() - plan.separation())),
            sign: if random.random_bool(0.5) { 1.0 } else { -1.0 },
        });
        // An altitude that the flight computer integrates itself cannot step.
        let failure = failure.map(|failure| match (failure.sensor, plan.own_unit) {
            (Sensor::ImuSlave, None) => Failure { kind: FailureKind::Drift, ..failure },
            _ => failure,
        });
        Self { index, plan, faults, failure }
    }

    /// The flight, tick by tick.
    #[must_use]
    pub fn rows(&self, seed: u64) -> Vec<Row> {
        flight::fly(&self.plan, &mut random(seed, self.index, 2))
    }

    /// Flies the run twice.
    ///
    /// # Errors
    /// The model does not make a mission.
    pub fn fly(&self, seed: u64, config: &MissionConfig<0>) -> Result<Flown> {
        let rows = self.rows(seed);
        let clean = self.fly_one(&rows, config, &[], None)?;
        let faulty = self.fly_one(&rows, config, &self.faults, Some(&clean))?;
        Ok(Flown { clean, faulty })
    }

    fn fly_one(
        &self,
        rows: &[Row],
        config: &MissionConfig<0>,
        faults: &[Drawn],
        clean: Option<&Watched>,
    ) -> Result<Watched> {
        let mut watched = Watched::default();
        watched.step_m = clean.and_then(|clean| clean.step_m);
        let flown = catch_unwind(AssertUnwindSafe(|| self.ticks(rows, config, faults, clean, &mut watched)));
        match flown {
            Ok(flown) => flown?,
            Err(panic) => {
                let said = panic.downcast_ref::<String>().cloned();
                let said = said.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
                watched.panic = Some(said.unwrap_or_default());
            }
        }
        watched.end_reporting();
        Ok(watched)
    }

    fn ticks(
        &self,
        rows: &[Row],
        config: &MissionConfig<0>,
        faults: &[Drawn],
        clean: Option<&Watched>,
        watched: &mut Watched,
    ) -> Result<()> {
        let mut computer = Computer::new(config)?;
        let mut events: Vec<_> = faults.iter().flat_map(|fault| fault.events.iter().copied()).collect();
        events.sort_by_key(|(tick, _)| *tick);
        let mut events = events.into_iter().peekable();
        let mut dips = dips(faults, clean).into_iter().peekable();
        let mut now_us = FIRST_US - TICK_US;
        // While the supply is away: until which tick, and the dip.
        let mut away: Option<(usize, Dip)> = None;
        let mut paused_until = 0;
        for (tick, row) in rows.iter().enumerate() {
            let mut input = row.input;
            for fault in faults {
                if fault.step_us != 0 && fault.from == tick {
                    now_us = now_us.saturating_add_signed(fault.step_us);
                }
            }
            if let Some(failure) = &self.failure {
                fail(
                    failure,
                    self.plan.own_unit.is_some(),
                    tick,
                    row.altitude_m,
                    &computer,
                    watched,
                    &mut input,
                );
            }
            while let Some((_, event)) = events.next_if(|(at, _)| *at <= tick) {
                computer.inject(event);
            }
            if input.launch && watched.first_edge.is_none() {
                watched.first_edge = Some(tick);
            }
            if let Some((until, dip)) = &away {
                if tick < *until {
                    watched.take_nothing(false);
                    continue;
                }
                let report = computer.restart(wire(faults, tick, input.launch), dip)?;
                away = None;
                watched.take_restart(report);
                // After a cold start the board's clock restarts; a chip's model cannot go back in time.
                now_us = report.map_or(0, |report| report.resumed_us).max(now_us);
                let pause_us = report.map_or(0, |report| report.pause_us);
                paused_until = tick + (pause_us / TICK_US) as usize;
            }
            if tick < paused_until {
                watched.take_nothing(true);
                continue;
            }
            now_us += TICK_US;
            input.time_us = now_us;
            // The satellites' time is independent of the flight computer's clock.
            let true_us = FIRST_US + tick as u64 * TICK_US;
            computer.set_receivers_lead(true_us.cast_signed().wrapping_sub(now_us.cast_signed()));
            let dip = dips.next_if(|(at, _)| *at <= tick).map(|(_, dip)| dip);
            let Some(step) = computer.tick(&input, dip.as_ref()) else {
                watched.take_nothing(true);
                continue;
            };
            let operations = computer.work.take();
            if dip.is_some_and(|dip| dip.boundary.is_before_reporting()) {
                watched.take_nothing(false);
            } else if let Some(mission) = computer.mission() {
                watched.take(&step, mission.latch(), mission.counters(), row.altitude_m, operations);
            }
            if let Some(dip) = dip {
                // A restart takes 15 ms: three ticks.
                away = Some((tick + 1 + dip.ticks.max(3), dip));
            }
        }
        Ok(())
    }
}

/// State of the wire when the flight computer starts.
fn wire(faults: &[Drawn], tick: usize, is_open: bool) -> Option<bool> {
    let events = faults.iter().flat_map(|fault| &fault.events).filter(|(at, _)| *at <= tick);
    let last = |chip| events.clone().rfind(|(_, event)| event.chip == chip).map(|(_, event)| event.fault);
    match last(Chip::Wire) {
        Some(Fault::Unreadable) => None,
        Some(Fault::Open) => Some(true),
        Some(Fault::Shorted) => Some(false),
        _ => Some(is_open || last(Chip::Umbilical) == Some(Fault::Torn)),
    }
}

/// The dips, each at its tick.
fn dips(faults: &[Drawn], clean: Option<&Watched>) -> Vec<(usize, Dip)> {
    let edge = clean.and_then(|clean| clean.first_edge).unwrap_or(usize::MAX / 2);
    let latch = clean.and_then(|clean| clean.launched).unwrap_or(usize::MAX / 2);
    let mut dips: Vec<_> = faults
        .iter()
        .flat_map(|fault| &fault.dips)
        .map(|dip| {
            let tick = match dip.tick {
                DipTick::At(tick) => tick,
                DipTick::Edge(after) => edge + after,
                DipTick::Latch(after) => latch + after,
            };
            (tick, *dip)
        })
        .collect();
    dips.sort_by_key(|(tick, _)| *tick);
    dips
}

/// Makes the sensor fail at its tick.
fn fail(
    failure: &Failure,
    has_unit: bool,
    tick: usize,
    altitude_m: f32,
    computer: &Computer,
    watched: &mut Watched,
    input: &mut TickInput,
) {
    if tick < failure.tick {
        return;
    }
    let since_s = (tick - failure.tick) as f32 * 0.005;
    let error_m = failure.sign
        * match failure.kind {
            FailureKind::Drift => DRIFT_MPS * since_s,
            FailureKind::Step => *watched.step_m.get_or_insert_with(|| {
                let latch = computer.mission().and_then(FlownMission::latch);
                let bound_m = latch.map_or(0.0, |latch| latch.sensors[failure.sensor.index()].bound_m());
                STEP_SIGMAS * bound_m / MULTIPLIER
            }),
        };
    match failure.sensor {
        Sensor::Baro => {
            let ratio = pressure_pa(f64::from(altitude_m + error_m)) / pressure_pa(f64::from(altitude_m));
            input.baro = input.baro.map(|reading| match reading {
                BaroReading::PressurePa(pa) => BaroReading::PressurePa(pa * ratio as f32),
                other => other,
            });
        }
        _ if has_unit => {
            input.imu_slave_altitude_m = input.imu_slave_altitude_m.map(|altitude_m| altitude_m + error_m);
        }
        _ => {
            // 2 m/s in half a second.
            if let Some(imu) = input.imu.as_mut().filter(|_| tick < failure.tick + PUSH_TICKS) {
                imu.accel_mps2[2] -= failure.sign * DRIFT_MPS / (PUSH_TICKS as f32 * 0.005);
            }
        }
    }
}

/// The default model's configuration.
///
/// # Errors
/// The default model does not make a mission of that shape.
pub fn config() -> Result<MissionConfig<0>> {
    Ok(Model::default().mission_config::<0>()?)
}
