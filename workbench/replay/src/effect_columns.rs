//! Which columns an effect needs that a flight does not have.

use kf_core::effect::EffectId;
use kf_core::formula::Signal;
use model::Model;

use flight_data::{Channel, Column, Flight};

/// Speed over ground, which stands in for airspeed and, along the track, for forward acceleration.
const SPEED_OVER_GROUND: [&str; 2] = ["gps_vn_mps", "gps_ve_mps"];

/// The columns that an effect's regressor needs and the flight has no sample of; none where another
/// signal stands in for them ([`kf_core::effect::SignalTracker`]).
#[must_use]
pub fn missing_columns(flight: &Flight, effect: EffectId) -> Vec<&'static str> {
    let has = |name: &str| column(flight, name).is_some_and(|column| column.samples().next().is_some());
    let has_speed = SPEED_OVER_GROUND.into_iter().all(has);
    if has_speed && matches!(effect, EffectId::ImuTilt | EffectId::ImuGyroBias) {
        return Vec::new();
    }
    // In a formula `tas_mps` is the measured airspeed; what has a stand-in is called `airspeed_mps`.
    let reads_airspeed =
        effect.formula().is_none_or(|parts| parts.program.signals() & Signal::TrueAirspeed.bit() == 0);
    // A flight without a gyro says the load factor all the same, and one without a heading roll and pitch.
    let has_accel =
        effect.formula().is_some() && ["accel_x_mps2", "accel_y_mps2", "accel_z_mps2"].into_iter().all(has);
    let has_level = effect.formula().is_some() && ["roll_rad", "pitch_rad"].into_iter().all(has);
    let is_there = |name: &str| {
        has(name)
            || (has_speed && reads_airspeed && name == "tas_mps")
            || (has_accel && name.starts_with("gyro_"))
            || (has_level && name == "yaw_rad")
    };
    effect.needs().iter().copied().filter(|name| !is_there(name)).collect()
}

/// The column of that name, known to the estimator or not.
pub(super) fn column<'a>(flight: &'a Flight, name: &str) -> Option<&'a Column> {
    let known = Channel::from_name(name).and_then(|channel| flight.channel(channel));
    known.or_else(|| flight.extra.iter().find(|(own, _)| own == name).map(|extra| &extra.1))
}

/// What is to be said of the columns that a model's formulas read and the estimator does not know: a line each for those that the flight
/// has not, with the nearest that it has, and for those whose unit nothing says.
#[must_use]
pub fn column_notes(flight: &Flight, model: &Model) -> Vec<String> {
    let mut notes = Vec::new();
    for said in model.columns().iter() {
        if column(flight, said.name()).is_none() {
            let known = Channel::ALL.iter().copied().filter(|channel| flight.channel(*channel).is_some());
            let extra = flight.extra.iter().map(|extra| extra.0.as_str());
            let names = known.map(|channel| -> &str { channel.name() }).chain(extra);
            let mut ranked: Vec<_> =
                names.map(|name| (strsim::jaro_winkler(said.name(), name), name)).collect();
            ranked.sort_by(|(left, _), (right, _)| right.total_cmp(left));
            let nearest: Vec<&str> = ranked.into_iter().take(3).map(|(_, name)| name).collect();
            notes.push(format!(
                "a formula of the model reads {}, which the flight has no column of (nearest: {}): its effect is left out",
                said.name(),
                nearest.join(", ")
            ));
        } else if said.is_guessed() {
            notes.push(said.unit_said());
        }
    }
    notes
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
