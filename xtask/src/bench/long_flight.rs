//! The long flights of the host's benchmarks.

use std::fmt::Write as _;

/// Captive flight per hour of flight, seconds.
const CAPTIVE_S: u32 = 600;
/// A round of the free flight: manoeuvre, seconds, parameters. Ten an hour.
const ROUND: [(&str, u32, &str); 9] = [
    ("turn", 60, "bank_deg = 25.0"),
    ("straight", 20, ""),
    ("climb", 20, "flight_path_deg = 4.0"),
    ("level_off", 20, ""),
    ("dive", 20, "flight_path_deg = -4.0"),
    ("level_off", 20, ""),
    ("turn", 60, "bank_deg = -25.0"),
    ("accelerate", 40, "airspeed_mps = 34.0"),
    ("decelerate", 40, "airspeed_mps = 26.0"),
];
const ROUNDS: u32 = 10;
/// Its hidden effects: a diagnosis without a finding would end soon; these take several rounds.
const EFFECTS: [(&str, &str); 3] =
    [("baro.dynamic_pressure", "0.1"), ("gps.latency", "0.8"), ("imu.velocity_error", "0.02")];

/// The scenario of a flight of this many hours, with all sensors at their usual rates, 200 rows a second, and
/// three hidden effects.
pub fn scenario(hours: u32) -> String {
    let mut text = format!(
        "name = \"bench-{hours}-h\"\nsource = \"simulated to be measured\"\n\n[captive]\nduration_s = {}.0\n\
         altitude_m = 1200.0\nairspeed_mps = 28.0\n\n[turbulence]\nhorizontal_sigma_mps = 0.8\n\
         vertical_sigma_mps = 0.5\nlength_m = 200.0\n",
        hours * CAPTIVE_S
    );
    for _ in 0..hours * ROUNDS {
        for (manoeuvre, duration_s, wanted) in ROUND {
            // Writing to a string cannot fail.
            let _ = write!(
                text,
                "\n[[free_flight]]\nmanoeuvre = \"{manoeuvre}\"\nduration_s = {duration_s}.0\n{wanted}\n"
            );
        }
    }
    for (effect, coefficient) in EFFECTS {
        let _ = write!(text, "\n[[effect]]\nid = \"{effect}\"\ncoefficient = {coefficient}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_is_an_hour() {
        let round: u32 = ROUND.iter().map(|(_, duration_s, _)| duration_s).sum();
        assert_eq!(CAPTIVE_S + ROUNDS * round, 3600);
        assert_eq!(scenario(2).matches("[[free_flight]]").count(), 2 * 10 * 9);
        assert!(scenario(2).contains("duration_s = 1200.0"));
    }
}
