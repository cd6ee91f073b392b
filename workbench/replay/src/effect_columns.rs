//! Which columns an effect needs that a flight does not have.

use kf_core::effect::EffectId;

use flight_data::{Channel, Flight};

/// Speed over ground, which stands in for airspeed and, along the track, for forward acceleration.
const SPEED_OVER_GROUND: [&str; 2] = ["gps_vn_mps", "gps_ve_mps"];

/// The columns that an effect's regressor needs and the flight has no sample of; none where another
/// signal stands in for them ([`kf_core::effect::SignalTracker`]).
#[must_use]
pub fn missing_columns(flight: &Flight, effect: EffectId) -> Vec<&'static str> {
    let has = |name: &str| {
        let column = Channel::from_name(name).and_then(|channel| flight.channel(channel));
        column.is_some_and(|column| column.samples().next().is_some())
    };
    let has_speed = SPEED_OVER_GROUND.into_iter().all(has);
    if has_speed && matches!(effect, EffectId::ImuTilt | EffectId::ImuGyroBias) {
        return Vec::new();
    }
    let is_there = |name: &str| has(name) || (has_speed && name == "tas_mps");
    effect.needs().iter().copied().filter(|name| !is_there(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use flight_data::parse;

    #[test]
    fn missing_columns_are_named_unless_something_stands_in() {
        let flight = |names: &str, cells: &str| {
            parse(format!("# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m{names}\n0,1,2{cells}\n").as_bytes())
                .unwrap()
                .0
        };
        let bare = flight("", "");
        assert_eq!(missing_columns(&bare, EffectId::BaroLag), [""; 0]);
        assert_eq!(missing_columns(&bare, EffectId::BaroAngleOfAttack), ["aoa_rad", "tas_mps"]);
        assert_eq!(missing_columns(&bare, EffectId::ImuTilt).len(), 9);
        // A column without a sample is none.
        assert_eq!(missing_columns(&flight(",throttle", ","), EffectId::BaroPropwash), ["throttle"]);
        assert_eq!(missing_columns(&flight(",throttle", ",1"), EffectId::BaroPropwash), [""; 0]);
        let speed = flight(",gps_vn_mps,gps_ve_mps", ",3,4");
        assert_eq!(missing_columns(&speed, EffectId::BaroAngleOfAttack), ["aoa_rad"]);
        assert_eq!(missing_columns(&speed, EffectId::ImuTilt), [""; 0]);
        assert_eq!(missing_columns(&speed, EffectId::ImuAccelScale).len(), 9);
    }

    #[test]
    fn every_column_of_the_catalogue_is_a_flights() {
        for effect in EffectId::ALL {
            for name in effect.needs() {
                assert!(Channel::from_name(name).is_some(), "{name} of {}", effect.name());
            }
        }
    }
}
