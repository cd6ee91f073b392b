//! The catalogue of effects, explained.

mod picture;

use std::fmt::Write as _;

use kf_core::effect::{EffectId, Parts};
use kf_core::formula::MAX_OPS;
use model::{Board, Model};

pub use picture::Picture;

/// What is to be known of an effect beside what the catalogue itself has.
#[derive(Clone, Copy, Debug)]
pub struct Explanation {
    /// What it is, in one sentence.
    pub what: &'static str,
    /// What the coefficient is multiplied by, metres per unit of it.
    pub formula: &'static str,
    /// Where the plausible range comes from.
    pub source: &'static str,
    /// What it looks like in a flight.
    pub looks_like: &'static str,
}

/// The explanation of an effect; `None` for one that is newer than this guide, which the tests do not let be.
#[must_use]
pub fn explanation(effect: EffectId) -> Option<Explanation> {
    use EffectId as Id;
    let texts = match effect {
        Id::BaroDynamicPressure => (
            "The static port reads a part of the dynamic pressure.",
            "V^2/(2g)",
            "Bernoulli: -1 where the flow stagnates, +1 on a strongly curved skin; good ports are within 0.1 (NASA RP-1046)",
            "The altitude steps with every change of speed, at once, and back with it.",
        ),
        Id::BaroCarrierField => (
            "The mother ship's pressure field was in the calibration, and is gone at release.",
            "V^2/(2g) at launch; 0 before it",
            "as for baro.dynamic_pressure",
            "One step at launch, which stays.",
        ),
        Id::BaroAngleOfAttack => (
            "The port's pressure coefficient changes with the angle of attack.",
            "aoa V^2/(2g)",
            "a thin aerofoil's lift coefficient, 2 pi a radian (Anderson, Fundamentals of Aerodynamics, 4.7)",
            "An error in pull-ups and steep turns, and one that grows as the aircraft slows down.",
        ),
        Id::BaroSideslip => (
            "Ports on both sides, joined, read low or high in sideslip.",
            "sideslip^2 V^2/(2g)",
            "a cylinder across the flow: -3 to 1 (Anderson, 3.13), and room for another body's flow",
            "An error of the same sign in slips to either side.",
        ),
        Id::BaroLag => (
            "Tubing and sensor follow the pressure late.",
            "-hdot",
            "UAVs' tubing 0.01 to 1 s, long lines several (NASA RP-1046); never negative",
            "Too low in climbs and too high in descents, by the lag times the climb rate; nothing in level flight.",
        ),
        Id::BaroScale => (
            "A metre of the barometer is not a metre: its scale factor, or air that is not the standard one.",
            "h - h0",
            "40 K off the standard's 288 K make 14 % (MIL-HDBK-310's extremes)",
            "An error in proportion to the height above where it was calibrated, the same going up and coming down.",
        ),
        Id::BaroTemperature => (
            "The reading changes with the sensor's own temperature.",
            "T - T0",
            "MS5611: 2.5 hPa over its range is 21 m over some tens of kelvins; uncompensated sensors are ten times as bad",
            "An error that follows baro_temp_c, in sunlight and with the electronics' heat.",
        ),
        Id::BaroWarmUp => (
            "The sensor warms up after it was switched on, and its temperature was not logged.",
            "1 - exp(-t/tau)",
            "twice the MS5611's 2.5 hPa",
            "An error that grows fast, then ever more slowly, and stays.",
        ),
        Id::BaroDrift => (
            "The weather changes the pressure.",
            "t",
            "1 hPa an hour is 0.0023 m/s; a squall line's 7 hPa in ten minutes 0.1 m/s",
            "A straight line over the flight, whatever the aircraft does.",
        ),
        Id::BaroAcceleration => (
            "The sensor's membrane and gel have weight.",
            "n_z - 1",
            "some pascals a g; 10 m are 120 Pa",
            "An error in turns and pull-ups, gone in level flight.",
        ),
        Id::BaroPropwash => (
            "The propeller's slipstream reaches the port.",
            "throttle^2",
            "a small UAV's disc loading at full throttle, 600 Pa (momentum theory), is 50 m",
            "Steps with the throttle, on the ground as well.",
        ),
        Id::ImuVelocityError => (
            "The vertical velocity was wrong at release.",
            "t",
            "transfer alignment from a mother ship: metres a second at worst",
            "A straight line from the launch on.",
        ),
        Id::ImuAccelBias => (
            "The vertical accelerometer has a bias.",
            "t^2/2",
            "data sheets' zero-g offset is 20 mg; 100 mg is a broken part",
            "A parabola from the launch on.",
        ),
        Id::ImuAccelScale => (
            "The vertical accelerometer has a scale error.",
            "double integral of (upward specific force - g)",
            "data sheets' sensitivity error is 0.5 %; ten times that is a broken part",
            "An error that grows in vertical manoeuvres and runs on after them.",
        ),
        Id::ImuTilt => (
            "The attitude is off in pitch, and turns forward acceleration into the vertical.",
            "double integral of the forward horizontal acceleration",
            "beyond 0.2 rad nothing that is linear in it holds",
            "An error that grows while the aircraft speeds up or slows down.",
        ),
        Id::ImuGyroBias => (
            "The pitch error grows with time, as a gyro's bias makes it.",
            "double integral of the forward horizontal acceleration times t",
            "data sheets' zero-rate offset is 0.5 degrees a second, 0.009 rad/s",
            "As imu.tilt, the later the more.",
        ),
        Id::ImuVibration => (
            "Vibration is rectified into a bias.",
            "double integral of half the squared difference of neighbouring samples, summed over the axes",
            "IEEE Std 1293: 10 mg per g^2 is 0.001 s^2/m; an unbalanced mount is worse",
            "An error that grows while the motor runs rough.",
        ),
        Id::ImuGravityGradient => (
            "Gravity falls with height, and the navigator does not know it.",
            "double integral of 3.086e-6 (h - h0)",
            "1 by theory (Torge, Geodesy, 3.3), 0 where the navigator has it already",
            "Metres in minutes, some kilometres above the launch.",
        ),
        Id::ImuEotvos => (
            "Motion over a turning, round earth changes the weight, and the navigator does not know it.",
            "double integral of (2 Omega v_E cos(latitude) + v^2/R)",
            "1 by theory (Torge), 0 where the navigator has it already",
            "An error that is greater eastward than westward, at high speed.",
        ),
        Id::GpsLatency => (
            "The reference is late.",
            "-hdot",
            "smoothing and telemetry make up to some seconds; a receiver that predicts can be early",
            "All sensors seem to lead in climbs, by the same time.",
        ),
        Id::GpsConvergence => (
            "The receiver settles after its start.",
            "exp(-t/tau)",
            "tens of metres with few satellites (Kaplan and Hegarty, Understanding GPS)",
            "All sensors drift alike, ever more slowly.",
        ),
        Id::GpsLeverArm => (
            "The antenna is ahead of the sensors.",
            "sin(pitch)",
            "no more than the aircraft's length",
            "All sensors move alike with the pitch.",
        ),
        _ => return None,
    };
    let (what, formula, source, looks_like) = texts;
    Some(Explanation { what, formula, source, looks_like })
}

/// The effects whose names are that one, or begin with it (`baro` for all of the barometer's).
#[must_use]
pub fn named(model: &Model, name: &str) -> Vec<EffectId> {
    let exact = model.effect_named(name);
    let of_subject = || {
        let prefix = format!("{}.", name.trim_end_matches('.'));
        model.catalogue().filter(|effect| effect.name().starts_with(&prefix)).collect()
    };
    exact.map_or_else(of_subject, |effect| vec![effect])
}

/// What stands for an effect's name that is none, if one is near.
#[must_use]
pub fn nearest(model: &Model, name: &str) -> Option<&'static str> {
    let distance = |effect: &EffectId| strsim::osa_distance(name, effect.name());
    let nearest = model.catalogue().min_by_key(distance)?;
    (distance(&nearest) <= nearest.name().len() / 3).then(|| nearest.name())
}

fn range(effect: EffectId) -> String {
    let [least, most] = effect.plausible();
    let unit = if effect.unit() == "1" { String::new() } else { format!(" {}", effect.unit()) };
    format!("{least} to {most}{unit}")
}

/// The catalogue, and the model's own effects, a line each.
#[must_use]
pub fn list(model: &Model) -> String {
    let width = |text: fn(EffectId) -> usize| model.catalogue().map(text).max().unwrap_or(0);
    let (names, ranges) = (width(|effect| effect.name().len()), width(|effect| range(effect).len()));
    let mut text = format!("{:names$}  {:ranges$}  what it is\n", "effect", "plausible");
    for effect in model.catalogue() {
        let own = || effect.formula().map_or("", |parts| parts.about);
        let what = explanation(effect).map_or_else(own, |explanation| explanation.what);
        let _ = writeln!(text, "{:names$}  {:ranges$}  {what}", effect.name(), range(effect));
    }
    text + "\n'pylon effects NAME' explains one: its formula, the columns that it needs, and what it looks like.\n"
}

/// One of the model's own effects, explained.
fn defined(model: &Model, effect: EffectId, parts: &Parts) -> String {
    let name = effect.name();
    let columns = model.columns().iter().filter(|column| parts.needs.contains(&column.name()));
    let units: String = columns.map(|column| format!("               {}\n", column.unit_said())).collect();
    let has = |board| model.check_signals_of(effect, board).is_ok();
    let flies = match (has(Board::Recorded), has(Board::F405)) {
        (true, true) => "on every board",
        (true, false) => {
            "in QEMU and where a vehicle delivers its signals; the F405 board's own sensors do not"
        }
        _ => "on no flight computer, which has not all of its columns; it serves at the desk",
    };
    format!(
        "{name}, on {subject}, by formula of the model\n  {about}\n\n  adds         coefficient x {law}\n  coefficient  {unit}, \
         plausibly {range}\n  needs        {needs}\n{units}  takes        {ops} operations of {most} and {words} numbers of memory\n  \
         flies        {flies}\n\nWhether a flight has it: pylon diagnose FLIGHT --model MODEL.toml. To learn it: pylon add {name} \
         --model MODEL.toml --from FLIGHT.\n",
        subject = effect.subject().name(),
        about = if parts.about.is_empty() { "(the model says nothing about it)" } else { parts.about },
        law = parts.law,
        unit = if effect.unit() == "1" { "a number" } else { effect.unit() },
        range = range(effect),
        needs = if parts.needs.is_empty() { "nothing but time".to_owned() } else { parts.needs.join(", ") },
        ops = parts.program.ops().len(),
        most = MAX_OPS,
        words = parts.program.state_words(),
    )
}

/// One effect, explained.
#[must_use]
pub fn explained(model: &Model, effect: EffectId) -> String {
    if let Some(parts) = effect.formula() {
        return defined(model, effect, parts);
    }
    let needs =
        if effect.needs().is_empty() { "nothing but time".to_owned() } else { effect.needs().join(", ") };
    let Some(Explanation { what, formula, source, looks_like }) = explanation(effect) else {
        return format!("{}\n", effect.name());
    };
    let name = effect.name();
    format!(
        "{name}, on {subject}\n  {what}\n\n  adds         coefficient x {formula}\n  coefficient  {unit}, plausibly {range}\n  \
         because      {source}\n  needs        {needs}\n  looks like   {looks_like}\n\nWhether a flight has it: pylon diagnose \
         FLIGHT. To learn it: pylon add {name} --model MODEL.toml --from FLIGHT.\n",
        subject = effect.subject().name(),
        unit = if effect.unit() == "1" { "a number" } else { effect.unit() },
        range = range(effect),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_of_the_catalogue_is_explained_once() {
        let mut seen = std::collections::BTreeSet::new();
        for effect in EffectId::ALL {
            let found = explanation(effect).unwrap_or_else(|| panic!("{} is not explained", effect.name()));
            assert!(seen.insert(found.what), "{}", effect.name());
            for sentence in [found.what, found.looks_like] {
                assert!(sentence.ends_with('.') && !sentence.trim_end_matches('.').is_empty(), "{sentence}");
            }
            let text = explained(&Model::default(), effect);
            for part in [effect.name(), found.formula, &range(effect)] {
                assert!(text.contains(part), "{part}: {text}");
            }
            effect.needs().iter().for_each(|column| assert!(text.contains(column), "{column}: {text}"));
            assert_eq!(
                list(&Model::default())
                    .lines()
                    .filter(|line| line.starts_with(&format!("{} ", effect.name())))
                    .count(),
                1
            );
        }
    }

    #[test]
    fn a_name_is_one_effect_or_all_of_a_sensors() {
        let model = Model::default();
        assert_eq!(named(&model, "baro.lag"), [EffectId::BaroLag]);
        assert_eq!(named(&model, "gps").len(), 3);
        assert_eq!(named(&model, "lag"), []);
        assert_eq!((nearest(&model, "baro.lga"), nearest(&model, "weather")), (Some("baro.lag"), None));
    }
}
