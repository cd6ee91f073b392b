//! Finds the columns that an effect needs and a flight does not have.

use kf_core::effect::EffectId;
use kf_core::formula::Signal;
use model::Model;

use flight_data::{Channel, Column, Flight};

/// Speed over ground, which replaces a missing airspeed and, along the track, a missing forward acceleration.
const SPEED_OVER_GROUND: [&str; 2] = ["gps_vn_mps", "gps_ve_mps"];

/// The columns that an effect's regressor needs and of which the flight has no sample, except those that
/// another signal replaces ([`kf_core::effect::SignalTracker`]).
#[must_use]
pub fn missing_columns(flight: &Flight, effect: EffectId) -> Vec<&'static str> {
    let has = |name: &str| column(flight, name).is_some_and(|column| column.samples().next().is_some());
    let has_speed = SPEED_OVER_GROUND.into_iter().all(has);
    if has_speed && matches!(effect, EffectId::ImuTilt | EffectId::ImuGyroBias) {
        return Vec::new();
    }
    // In a formula `tas_mps` is the measured airspeed; the one that may be replaced is called `airspeed_mps`.
    let reads_airspeed =
        effect.formula().is_none_or(|parts| parts.program.signals() & Signal::TrueAirspeed.bit() == 0);
    // A flight without a gyro still has a load factor, and one without a heading still has roll and pitch.
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

/// The column of that name, whether the estimator has it or not.
pub(super) fn column<'a>(flight: &'a Flight, name: &str) -> Option<&'a Column> {
    let known = Channel::from_name(name).and_then(|channel| flight.channel(channel));
    known.or_else(|| flight.extra.iter().find(|(own, _)| own == name).map(|extra| &extra.1))
}

/// Notes on the columns that only the model's formulas read: one line for each that the flight does not have,
/// with the nearest names that it has, and one for each whose unit is not stated.
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
                "a formula of the model reads {}, but the flight has no such column (nearest: {}): its effect is left out",
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
        // A column without samples counts as missing.
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

    fn flight(names: &str, cells: &str) -> Flight {
        parse(format!("# pylon-flight: 1\ntime_s,gps_alt_m,baro_alt_m{names}\n0,1,2{cells}\n").as_bytes())
            .unwrap()
            .0
    }

    /// The effect with that formula.
    fn by_formula(regressor: &str) -> EffectId {
        let text = format!(
            "[[effect_definition]]\nid = \"baro.tried\"\non = \"baro\"\nregressor = \"{regressor}\"\nplausible = [-1.0, 1.0]\n"
        );
        Model::parse(&text).unwrap().effect_named("baro.tried").unwrap()
    }

    /// In a formula the speed over ground replaces `airspeed_mps`, but not the measured `tas_mps`. An
    /// accelerometer without a gyro gives the load factor, and roll and pitch need no heading. An effect of
    /// the catalogue has such a replacement for the airspeed only.
    #[test]
    fn a_formula_has_its_own_stand_ins() {
        let speed = flight(",gps_vn_mps,gps_ve_mps,throttle", ",3,4,1");
        assert_eq!(missing_columns(&speed, by_formula("airspeed_mps^2 / (2*g) * throttle")), [""; 0]);
        assert_eq!(missing_columns(&speed, by_formula("tas_mps^2 / (2*g) * throttle")), ["tas_mps"]);
        let bare = flight(",throttle", ",1");
        assert_eq!(missing_columns(&bare, by_formula("airspeed_mps^2 / (2*g) * throttle")), ["tas_mps"]);
        // The speed over ground replaces nothing else.
        assert_eq!(missing_columns(&speed, by_formula("airspeed_mps^2 / (2*g) * sin(aoa_rad)")), ["aoa_rad"]);
        let accelerometer = flight(",accel_x_mps2,accel_y_mps2,accel_z_mps2", ",0,0,-9.8");
        assert_eq!(missing_columns(&accelerometer, by_formula("load_factor * 1[m]")), [""; 0]);
        assert_eq!(missing_columns(&accelerometer, EffectId::ImuAccelScale).len(), 6);
        let level = flight(",roll_rad,pitch_rad", ",0,0");
        assert_eq!(missing_columns(&level, by_formula("sin(roll_rad) * 1[m]")), [""; 0]);
        assert!(missing_columns(&level, EffectId::ImuAccelScale).contains(&"yaw_rad"));
    }

    /// A column that only a formula uses is found by its name. If the flight does not have it, the nearest
    /// names are listed; if its unit is not stated, that is reported.
    #[test]
    fn columns_that_only_a_formula_knows_are_found_by_name_or_missed() {
        let text = "[[effect_definition]]\nid = \"baro.flap\"\non = \"baro\"\nregressor = \"flap * 1[m]\"\nplausible = [-1.0, 1.0]\n\
                    [[effect]]\nid = \"baro.flap\"\nsigma = 1.0\nestimate = true\n";
        let model = Model::parse(text).unwrap();
        let flown = flight(",gear,flap", ",7,5");
        assert_eq!(column(&flown, "flap").unwrap().get(0), Some(5.0));
        let said = column_notes(&flown, &model);
        assert!(matches!(&said[..], [one] if one.starts_with("flap counts as a plain number")), "{said:?}");
        let said = column_notes(&flight(",flaps,gear", ",5,7"), &model);
        let words = "a formula of the model reads flap, but the flight has no such column (nearest: flaps, ";
        assert!(matches!(&said[..], [one] if one.starts_with(words)), "{said:?}");
        assert_eq!(column_notes(&flown, &Model::default()), [""; 0]);
    }
}
