//! The meaning of a column's name.

use crate::import::mapping::quantity::{Quantity, UNITS};

/// The role that a column may have by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    Time,
    Counter,
    Latitude,
    Longitude,
    Pressure,
    BaroTemperature,
    OutsideTemperature,
    Temperature,
    GpsAltitude,
    BaroAltitude,
    MasterAltitude,
    SlaveAltitude,
    Altitude,
    North,
    East,
    Down,
    Climb,
    GroundSpeed,
    TrueAirspeed,
    Airspeed,
    Accelerometer,
    Gyro,
    Roll,
    Pitch,
    Yaw,
    AngleOfAttack,
    Sideslip,
    Satellites,
    VerticalAccuracy,
    ReceiverTime,
    Throttle,
    Launch,
}

/// The information in a name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Hint {
    /// Its words, in lower case, without the unit.
    pub words: Vec<String>,
    /// The unit at its end or in brackets.
    pub unit: Option<String>,
    /// 0 to 2 for x to z.
    pub axis: Option<usize>,
    /// Its possible role.
    pub role: Option<Role>,
}

impl Hint {
    /// From a column's name and the unit in the line below it.
    pub fn new(name: &str, unit_below: &str) -> Self {
        let (plain, bracketed) = without_brackets(name);
        let mut words = words(&plain);
        let known_unit = |text: &str| {
            let is = |quantity: Quantity| quantity.unit(text).is_some();
            text.chars().any(|letter| !letter.is_ascii_digit()) && UNITS.iter().any(|unit| is(unit.quantity))
        };
        let mut axis = bracketed.iter().find_map(|text| match text.as_str() {
            "0" => Some(0),
            "1" => Some(1),
            "2" => Some(2),
            _ => None,
        });
        let below = unit_below.trim().trim_matches(['[', ']', '(', ')']).to_owned();
        let mut unit = Some(below)
            .filter(|text| known_unit(text))
            .or_else(|| bracketed.into_iter().find(|text| known_unit(text)));
        // The axis may come before or after the unit.
        axis = axis.or_else(|| take_axis(&mut words));
        for count in (1..=2).rev() {
            if unit.is_some() || words.len() <= count {
                continue;
            }
            let tail = words.get(words.len() - count..).unwrap_or_default();
            let found = [tail.join("_"), tail.concat()].into_iter().find(|text| known_unit(text));
            if found.is_some() {
                words.truncate(words.len() - count);
                unit = found;
            }
        }
        axis = axis.or_else(|| take_axis(&mut words));
        let mut hint = Self { words, unit, axis, role: None };
        hint.role = hint.find_role();
        hint
    }

    /// Whether it contains one of these words.
    pub fn has(&self, words: &[&str]) -> bool {
        self.words.iter().any(|word| words.contains(&word.as_str()))
    }

    /// Whether it names the receiver.
    pub fn is_gps(&self) -> bool {
        self.has(&["gps", "gnss", "gps1", "gps2", "ublox", "ubx", "fix"])
    }

    /// The unit in its canonical spelling, if it is a unit of that quantity.
    pub fn unit_of(&self, quantity: Quantity) -> Option<&'static str> {
        self.unit.as_deref().and_then(|unit| quantity.unit(unit)).map(|unit| unit.name)
    }

    fn find_role(&mut self) -> Option<Role> {
        use Role as R;
        let has = |words: &[&str]| self.has(words);
        let is_baro =
            has(&["baro", "barometer", "barometric", "bmp", "ms5611", "bmp388", "bmp390", "static"]);
        let is_height = has(&[
            "alt",
            "altitude",
            "height",
            "hgt",
            "elevation",
            "elev",
            "asl",
            "msl",
            "hmsl",
            "agl",
            "hae",
        ]) || (self.words == ["h"]);
        let is_speed = has(&["speed", "vel", "velocity", "v"]);
        if has(&["launch", "launched", "release", "released", "separation", "dropped"]) && !is_height {
            return Some(R::Launch);
        }
        if has(&["lat", "latitude"]) {
            return Some(R::Latitude);
        }
        if has(&["lon", "lng", "long", "longitude"]) {
            return Some(R::Longitude);
        }
        if has(&["sats", "nsat", "nsats", "satellites", "numsv", "numsats", "siv", "sat", "sv", "svs"]) {
            return Some(R::Satellites);
        }
        if has(&["vacc", "epv"]) {
            return Some(R::VerticalAccuracy);
        }
        if has(&["tow", "itow"]) || (self.is_gps() && has(&["time", "timestamp"])) {
            return Some(R::ReceiverTime);
        }
        if has(&["temp", "temperature", "oat", "tmp"]) {
            return Some(if has(&["oat", "outside", "ambient", "air"]) {
                R::OutsideTemperature
            } else if is_baro || has(&["press", "pressure"]) {
                R::BaroTemperature
            } else {
                R::Temperature
            });
        }
        if is_height {
            return Some(if self.is_gps() {
                R::GpsAltitude
            } else if is_baro || has(&["press", "pressure"]) {
                R::BaroAltitude
            } else if has(&["master", "mother"]) {
                R::MasterAltitude
            } else if has(&["slave", "imu", "ins", "inertial"]) {
                R::SlaveAltitude
            } else {
                R::Altitude
            });
        }
        let is_pressure_unit = self.unit_of(Quantity::Pressure).is_some();
        if has(&["dynamic", "dyn", "diff", "differential", "pitot", "qbar"])
            && !is_speed
            && !has(&["airspeed"])
        {
            return None;
        }
        if has(&["pressure", "press", "pstat"]) || (is_pressure_unit && (is_baro || has(&["p"]))) {
            return Some(R::Pressure);
        }
        // `baro_ft`: a barometer's value in a unit of length is an altitude.
        if is_baro && !is_speed && self.unit_of(Quantity::Length).is_some() {
            return Some(R::BaroAltitude);
        }
        self.motion_role(is_speed)
    }

    fn motion_role(&mut self, is_speed: bool) -> Option<Role> {
        use Role as R;
        let has = |words: &[&str]| self.has(words);
        for (words, axis) in [
            (["roll", "rollrate", "p", "wx"], 0),
            (["pitch", "pitchrate", "q", "wy"], 1),
            (["yaw", "yawrate", "r", "wz"], 2),
        ] {
            let is_rate =
                has(&["rate", "rates", "dot", "rollrate", "pitchrate", "yawrate", "gyro", "wx", "wy", "wz"]);
            let is_alone = self.words.len() == 1 && words.get(2).is_some_and(|word| has(&[word]));
            if has(&words) && (is_rate || (is_alone && self.unit_of(Quantity::Rate).is_some())) {
                self.axis = self.axis.or(Some(axis));
                return Some(R::Gyro);
            }
        }
        for (words, role, axis) in [
            (["ax", "accx"], R::Accelerometer, 0),
            (["ay", "accy"], R::Accelerometer, 1),
            (["az", "accz"], R::Accelerometer, 2),
            (["gx", "gyrox"], R::Gyro, 0),
            (["gy", "gyroy"], R::Gyro, 1),
            (["gz", "gyroz"], R::Gyro, 2),
        ] {
            if has(&words) {
                self.axis = self.axis.or(Some(axis));
                return Some(role);
            }
        }
        if self.axis.is_some() && has(&["gyro", "gyr", "gyroscope", "omega", "rate", "angular"]) {
            return Some(R::Gyro);
        }
        if self.axis.is_some() && has(&["acc", "accel", "acceleration", "accelerometer", "force"]) {
            return Some(R::Accelerometer);
        }
        let found = [
            (&["tas"][..], R::TrueAirspeed),
            (&["airspeed", "ias", "cas", "eas"], R::Airspeed),
            (&["groundspeed", "sog", "gs", "gspeed"], R::GroundSpeed),
            (&["vn", "veln", "velnorth"], R::North),
            (&["ve", "vele", "veleast"], R::East),
            (&["vd", "veld", "veldown"], R::Down),
            (&["climb", "vario", "climbrate", "vspeed", "vvi", "vs", "roc", "verticalspeed"], R::Climb),
            (&["roll", "phi"], R::Roll),
            (&["pitch", "theta"], R::Pitch),
            (&["yaw", "psi", "heading", "hdg"], R::Yaw),
            (&["aoa", "alpha"], R::AngleOfAttack),
            (&["sideslip", "aos", "beta", "ssa"], R::Sideslip),
            (&["throttle", "thr"], R::Throttle),
        ];
        if let Some((_, role)) = found.into_iter().find(|(words, _)| has(words)) {
            return Some(match role {
                R::Airspeed if has(&["true"]) => R::TrueAirspeed,
                role => role,
            });
        }
        if is_speed {
            for (words, role) in [
                (&["north", "n"][..], R::North),
                (&["east", "e"], R::East),
                (&["down", "d"], R::Down),
                (&["vertical", "up"], R::Climb),
                (&["true"], R::TrueAirspeed),
                (&["air"], R::Airspeed),
                (&["ground", "gps"], R::GroundSpeed),
            ] {
                if has(words) {
                    return Some(role);
                }
            }
        }
        if has(&[
            "time",
            "timestamp",
            "t",
            "ts",
            "elapsed",
            "utc",
            "datetime",
            "millis",
            "micros",
            "uptime",
            "clock",
        ]) || (self.words.len() == 1 && has(&["seconds", "secs", "sec", "ms", "us"]))
        {
            return Some(R::Time);
        }
        has(&[
            "index", "idx", "n", "no", "num", "count", "counter", "seq", "sequence", "packet", "row",
            "sample",
        ])
        .then_some(R::Counter)
    }
}

/// A name without the text in brackets, and that text.
fn without_brackets(name: &str) -> (String, Vec<String>) {
    let (mut plain, mut inside, mut found) = (String::new(), String::new(), Vec::new());
    let mut depth = 0_u32;
    for letter in name.chars() {
        match letter {
            '[' | '(' | '{' => depth += 1,
            ']' | ')' | '}' => {
                depth = depth.saturating_sub(1);
                found.push(std::mem::take(&mut inside).trim().to_owned());
            }
            letter if depth > 0 => inside.push(letter),
            letter => plain.push(letter),
        }
    }
    (plain, found)
}

/// Words of a name: separated by anything but letters and digits, and before a capital that begins a word.
fn words(name: &str) -> Vec<String> {
    let letters: Vec<char> = name.chars().collect();
    let mut words = vec![String::new()];
    for (at, letter) in letters.iter().enumerate() {
        if !letter.is_alphanumeric() {
            words.push(String::new());
            continue;
        }
        let before = at.checked_sub(1).and_then(|at| letters.get(at));
        let after = letters.get(at + 1);
        let begins = letter.is_uppercase()
            && before.is_some_and(|before| {
                before.is_lowercase()
                    || before.is_ascii_digit()
                    || (before.is_uppercase() && after.is_some_and(|after| after.is_lowercase()))
            });
        if begins {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut() {
            word.extend(letter.to_lowercase());
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Takes an axis from the end of a name, if other words are left.
fn take_axis(words: &mut Vec<String>) -> Option<usize> {
    let axis = match words.last()?.as_str() {
        "x" => 0,
        "y" => 1,
        "z" => 2,
        _ => return None,
    };
    (words.len() > 1).then(|| {
        words.pop();
        axis
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_understood() {
        for (name, role, unit) in [
            ("Time [ms]", Some(Role::Time), Some("ms")),
            ("timestamp_us", Some(Role::Time), Some("us")),
            ("GPSAlt(ft)", Some(Role::GpsAltitude), Some("ft")),
            ("gps_alt_m", Some(Role::GpsAltitude), Some("m")),
            ("baroPressureHPa", Some(Role::Pressure), Some("hpa")),
            ("baro_pa", Some(Role::Pressure), Some("pa")),
            ("baro_alt_m", Some(Role::BaroAltitude), Some("m")),
            ("baro_ft", Some(Role::BaroAltitude), Some("ft")),
            ("imu_slave_alt_m", Some(Role::SlaveAltitude), Some("m")),
            ("Latitude", Some(Role::Latitude), None),
            ("vel_n_m_s", Some(Role::North), Some("m_s")),
            ("gps_vd_mps", Some(Role::Down), Some("mps")),
            ("Vertical Speed (ft/min)", Some(Role::Climb), Some("ft/min")),
            ("tas_mps", Some(Role::TrueAirspeed), Some("mps")),
            ("IAS [kt]", Some(Role::Airspeed), Some("kt")),
            ("gyro_rad[1]", Some(Role::Gyro), Some("rad")),
            ("accelerometer_m_s2[2]", Some(Role::Accelerometer), Some("m_s2")),
            ("AccX", Some(Role::Accelerometer), None),
            ("roll_rate_deg_s", Some(Role::Gyro), Some("deg_s")),
            ("roll_rad", Some(Role::Roll), Some("rad")),
            ("numSV", Some(Role::Satellites), None),
            ("battery_voltage", None, None),
            ("dynamic_pressure_pa", None, Some("pa")),
            ("packet", Some(Role::Counter), None),
        ] {
            let hint = Hint::new(name, "");
            assert_eq!((hint.role, hint.unit.as_deref()), (role, unit), "{name}: {hint:?}");
        }
        assert_eq!(Hint::new("gyro_rad[1]", "").axis, Some(1));
        assert_eq!(Hint::new("AccX", "").axis, Some(0));
        assert_eq!(Hint::new("accel_z_mps2", "").axis, Some(2));
        assert_eq!(Hint::new("alt", "[ft]").unit.as_deref(), Some("ft"));
    }
}
