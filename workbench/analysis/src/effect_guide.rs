//! The catalogue of effects, explained.

use kf_core::effect::EffectId;

/// Explanation of an effect, in addition to what the catalogue itself contains.
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

/// The explanation of an effect; `None` for one that is newer than this guide, which the tests do not allow.
#[must_use]
pub fn explanation(effect: EffectId) -> Option<Explanation> {
    use EffectId as Id;
    let texts = match effect {
        Id::BaroDynamicPressure => (
            "The static port reads part of the dynamic pressure.",
            "V^2/(2g)",
            "Bernoulli: -1 where the flow stagnates, +1 on a strongly curved skin; good ports are within 0.1 (NASA RP-1046)",
            "The altitude steps at once with every change of speed, and steps back with it.",
        ),
        Id::BaroCarrierField => (
            "The mother ship's pressure field was part of the calibration, and is gone at release.",
            "V^2/(2g) at launch; 0 before it",
            "as for baro.dynamic_pressure",
            "One lasting step at launch.",
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
            "A barometric metre is not a true metre: its scale factor, or non-standard air.",
            "h - h0",
            "40 K off the standard's 288 K make 14 % (MIL-HDBK-310's extremes)",
            "An error in proportion to the height above where it was calibrated, the same climbing and descending.",
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
            "An error that grows in vertical manoeuvres and continues after them.",
        ),
        Id::ImuTilt => (
            "The attitude is off in pitch, and turns forward acceleration into the vertical.",
            "double integral of the forward horizontal acceleration",
            "beyond 0.2 rad nothing linear in it holds",
            "An error that grows while the aircraft speeds up or slows down.",
        ),
        Id::ImuGyroBias => (
            "The pitch error grows with time, as from a gyro's bias.",
            "double integral of the forward horizontal acceleration times t",
            "data sheets' zero-rate offset is 0.5 degrees a second, 0.009 rad/s",
            "As imu.tilt, increasing with time.",
        ),
        Id::ImuVibration => (
            "Vibration is rectified into a bias.",
            "double integral of half the squared difference of neighbouring samples, summed over the axes",
            "IEEE Std 1293: 10 mg per g^2 is 0.001 s^2/m; an unbalanced mount is worse",
            "An error that grows while the motor runs rough.",
        ),
        Id::ImuGravityGradient => (
            "Gravity falls with height, and the navigator ignores it.",
            "double integral of 3.086e-6 (h - h0)",
            "1 by theory (Torge, Geodesy, 3.3), 0 where the navigator already accounts for it",
            "Metres in minutes, some kilometres above the launch.",
        ),
        Id::ImuEotvos => (
            "Motion over a rotating, round earth changes the weight, and the navigator ignores it.",
            "double integral of (2 Omega v_E cos(latitude) + v^2/R)",
            "1 by theory (Torge), 0 where the navigator already accounts for it",
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
