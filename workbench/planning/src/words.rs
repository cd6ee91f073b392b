//! A segment of a plan in words.

use simulate::scenario::{Manoeuvre, Segment};

use crate::manoeuvres::turn_rate_radps;

/// What to do, as a pilot reads it; `airspeed_mps` is the airspeed to hold.
pub fn words(segment: &Segment, airspeed_mps: f64) -> String {
    let speed = format!("{airspeed_mps:.0} m/s");
    let degrees = |value: Option<f64>| format!("{}°", (value.unwrap_or(0.0).abs() * 10.0).round() / 10.0);
    let path = degrees(segment.flight_path_deg);
    match (segment.manoeuvre, segment.load_factor) {
        (Manoeuvre::Accelerate, _) => format!("Accelerate to {speed}, level"),
        (Manoeuvre::Decelerate, _) => format!("Slow down to {speed}, level"),
        (Manoeuvre::Climb, _) => format!("Climb at {path}, {speed}"),
        (Manoeuvre::Dive, None) => format!("Descend at {path}, {speed}"),
        (Manoeuvre::Dive, Some(least)) => format!("Push over to {path} down, not below {least:.1} g"),
        (Manoeuvre::PullUp, Some(most)) => format!("Pull up to {path}, not above {most:.1} g"),
        (Manoeuvre::PullUp, None) => format!("Pull up to {path}, {speed}"),
        (Manoeuvre::Turn, _) => {
            let bank_deg = segment.bank_deg.unwrap_or(0.0);
            let side = if bank_deg > 0.0 { "right" } else { "left" };
            let turned = turn_rate_radps(bank_deg.abs(), airspeed_mps) * segment.duration_s;
            let turn = if turned < core::f64::consts::TAU { "Turn" } else { "Circle to the" };
            format!("{turn} {side} at {} of bank, {speed}", degrees(segment.bank_deg))
        }
        (Manoeuvre::LevelOff, _) => format!("Level off, {speed}"),
        (Manoeuvre::Straight, _) => format!("Straight and level, {speed}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_segment_says_what_to_do() {
        let plain = Segment {
            manoeuvre: Manoeuvre::Straight,
            duration_s: 5.0,
            flight_path_deg: None,
            airspeed_mps: None,
            bank_deg: None,
            load_factor: None,
        };
        let of = |manoeuvre, flight_path_deg, bank_deg, load_factor| {
            words(&Segment { manoeuvre, flight_path_deg, bank_deg, load_factor, ..plain }, 27.6)
        };
        assert_eq!(of(Manoeuvre::Straight, None, None, None), "Straight and level, 28 m/s");
        assert_eq!(of(Manoeuvre::Dive, Some(-6.04), None, None), "Descend at 6°, 28 m/s");
        assert_eq!(
            of(Manoeuvre::Dive, Some(-12.0), None, Some(0.2)),
            "Push over to 12° down, not below 0.2 g"
        );
        assert_eq!(of(Manoeuvre::PullUp, Some(12.0), None, Some(1.8)), "Pull up to 12°, not above 1.8 g");
        assert_eq!(of(Manoeuvre::Turn, None, Some(-45.5), None), "Turn left at 45.5° of bank, 28 m/s");
        assert_eq!(of(Manoeuvre::Decelerate, None, None, None), "Slow down to 28 m/s, level");
        let circling =
            Segment { duration_s: 300.0, bank_deg: Some(20.0), manoeuvre: Manoeuvre::Turn, ..plain };
        assert_eq!(words(&circling, 28.0), "Circle to the right at 20° of bank, 28 m/s");
        // Six times round at 28 m/s, and less than once at 350 m/s.
        assert_eq!(words(&circling, 350.0), "Turn right at 20° of bank, 350 m/s");
    }
}
