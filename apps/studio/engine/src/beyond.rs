//! The error beyond the reference: the part that is not the reference's own wander.

use analysis::diagnose::{ErrorSlot, NoiseFacts, reference_wander};
use kf_core::effect::EffectSubject;
use kf_core::sensor::{SENSORS, Sensor};

use crate::curve::{Curve, Flown, in_error, regressor};
use crate::engine::{Engine, Progress, Refused, parsed, replay};
use crate::protocol::Acting;
use crate::recording::Recording;

/// Limit on the slots of a flight: more than a wide screen has pixels.
const SLOTS: f64 = 6_000.0;
/// Shortest slot, seconds: much shorter than a wander's correlation time.
const SHORTEST_S: f64 = 0.5;

/// A sensor's mean error in time slots, without the reference's wander, and one sigma of the remaining
/// uncertainty.
pub fn curve(
    engine: &mut Engine,
    flown: &Flown<'_>,
    sensor: Sensor,
    (noise, found): (&NoiseFacts, &[Acting]),
    progress: &mut Progress<'_>,
) -> Result<Curve, Refused> {
    let recording = engine.recording(flown.flight, flown.model, flown.times, progress)?;
    let found = explained(engine, flown, found)?;
    let slots = slots(&recording, noise, &found);
    let wander = reference_wander(&slots.of, noise);
    let (mut times, mut values, mut sigmas) = (Vec::new(), Vec::new(), Vec::new());
    for ((slot, raw_m), (wander_m, sigma_m)) in slots.of.iter().zip(&slots.raw_m).zip(wander) {
        if let Some(raw_m) = raw_m[sensor.index()] {
            times.push(slot.time_s);
            values.push(raw_m - wander_m);
            sigmas.push(sigma_m);
        }
    }
    Ok(Curve::own(times, values, "m").with_sigma(sigmas))
}

/// What an effect adds to the errors: times in seconds and metres; `sensor` is `None` for all sensors.
struct Explained {
    points: Vec<(f64, f64)>,
    sensor: Option<Sensor>,
}

fn explained(engine: &Engine, flown: &Flown<'_>, found: &[Acting]) -> Result<Vec<Explained>, Refused> {
    let replay = replay(engine.flight(flown.flight)?, flown.model, flown.times)?;
    let model = parsed(flown.model)?;
    let each = found.iter().map(|acting| {
        let regressor = regressor(acting, &model)?;
        let points = in_error(&replay, regressor, acting.coefficient);
        let sensor = match regressor.id.subject() {
            EffectSubject::Gps => None,
            EffectSubject::Sensor(sensor) => Some(sensor),
        };
        Ok(Explained { points, sensor })
    });
    each.collect()
}

/// Errors in time slots.
struct Slots {
    /// Errors without the explained part.
    of: Vec<ErrorSlot>,
    /// Errors as measured.
    raw_m: Vec<[Option<f64>; SENSORS]>,
}

/// Sums for one sensor over one slot.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    raw: f64,
    sum: f64,
    squares: f64,
}

fn slots(recording: &Recording, noise: &NoiseFacts, found: &[Explained]) -> Slots {
    let mut slots = Slots { of: Vec::new(), raw_m: Vec::new() };
    let (Some(first_s), Some(last_s)) = (recording.time_s.first(), recording.time_s.last()) else {
        return slots;
    };
    let width_s = ((last_s - first_s) / SLOTS).max(SHORTEST_S);
    let mut next = vec![0_usize; found.len()];
    let mut sums = [Sums::default(); SENSORS];
    let mut fixes = 0.0_f64;
    let mut current = 0_u64;
    let mut close = |slot: u64, sums: &mut [Sums; SENSORS], fixes: &mut f64| {
        if sums.iter().any(|sums| sums.count > 0.0) {
            let mean = |sums: &Sums, sum: f64| (sums.count > 0.0).then(|| sum / sums.count);
            slots.of.push(ErrorSlot {
                time_s: first_s + (slot as f64 + 0.5) * width_s,
                mean_m: sums.map(|sums| mean(&sums, sums.sum)),
                variance_m2: sums.map(|sums| {
                    let mean_m = sums.sum / sums.count.max(1.0);
                    let spread = (sums.squares / sums.count.max(1.0) - mean_m * mean_m).max(0.0);
                    spread / sums.count.max(1.0) + noise.fix_sigma_m * noise.fix_sigma_m / fixes.max(1.0)
                }),
            });
            slots.raw_m.push(sums.map(|sums| mean(&sums, sums.raw)));
        }
        *sums = [Sums::default(); SENSORS];
        *fixes = 0.0;
    };
    for (tick, time_s) in recording.time_s.iter().enumerate() {
        let slot = ((time_s - first_s) / width_s) as u64;
        if slot != current {
            close(current, &mut sums, &mut fixes);
            current = slot;
        }
        if recording.reference_m.get(tick).is_some_and(|metres| metres.is_finite()) {
            fixes += 1.0;
        }
        let mut off_m = [0.0; SENSORS];
        for (explained, next) in found.iter().zip(&mut next) {
            while explained.points.get(*next + 1).is_some_and(|(at_s, _)| at_s <= time_s) {
                *next += 1;
            }
            let metres =
                explained.points.get(*next).filter(|(at_s, _)| at_s <= time_s).map_or(0.0, |(_, m)| *m);
            for sensor in Sensor::ALL {
                if explained.sensor.is_none_or(|own| own == sensor) {
                    off_m[sensor.index()] += metres;
                }
            }
        }
        for ((sums, track), off_m) in sums.iter_mut().zip(&recording.sensors).zip(off_m) {
            let Some(error_m) = track.error_m.get(tick).copied().filter(|error_m| error_m.is_finite()) else {
                continue;
            };
            let (raw_m, left_m) = (f64::from(error_m), f64::from(error_m) - off_m);
            sums.count += 1.0;
            sums.raw += raw_m;
            sums.sum += left_m;
            sums.squares += left_m * left_m;
        }
    }
    close(current, &mut sums, &mut fixes);
    slots
}
