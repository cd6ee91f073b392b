//! Converts an altitude above the ellipsoid to one above mean sea level, with the geoid height given by the
//! user.

use std::str::FromStr;

use flight_data::{AltitudeDatum, Channel, Column, Flight, is_altitude};

use super::error::ImportError;

/// Range of the geoid's height above the WGS-84 ellipsoid, metres: EGM2008 has -107 m south of India and 86 m
/// by New Guinea.
const GEOID_HEIGHTS_M: std::ops::RangeInclusive<f64> = -108.0..=87.0;

/// A column to convert: `COLUMN=METRES`.
#[derive(Clone, Debug, PartialEq)]
pub struct ToMsl {
    /// The altitude's column.
    pub column: String,
    /// Height of the geoid above the ellipsoid there, metres.
    pub geoid_height_m: f64,
}

impl FromStr for ToMsl {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (column, metres) = text
            .split_once('=')
            .ok_or_else(|| format!("'{text}', expected COLUMN=METRES, such as gps_alt_m=47.2"))?;
        let found = metres.trim().parse().ok().filter(|metres| GEOID_HEIGHTS_M.contains(metres));
        let geoid_height_m = found.ok_or_else(|| {
            format!(
                "'{metres}', expected the metres by which the geoid is above the ellipsoid there, from {} to {} anywhere on Earth",
                GEOID_HEIGHTS_M.start(),
                GEOID_HEIGHTS_M.end()
            )
        })?;
        Ok(Self { column: column.trim().to_owned(), geoid_height_m })
    }
}

/// Converts a column, and records it in the header.
///
/// # Errors
/// [`ImportError::NoSuchAltitude`] without the column; [`ImportError::NotAboveEllipsoid`] if it is not above
/// the ellipsoid.
pub fn to_msl(flight: &mut Flight, conversion: &ToMsl) -> Result<(), ImportError> {
    let ToMsl { column: name, geoid_height_m } = conversion;
    let column = match Channel::from_name(name) {
        Some(channel) => {
            flight.channels.iter_mut().find(|(found, _)| *found == channel).map(|(_, column)| column)
        }
        None => flight.extra.iter_mut().find(|(found, _)| found == name).map(|(_, column)| column),
    };
    let column = column
        .filter(|_| is_altitude(name))
        .ok_or_else(|| ImportError::NoSuchAltitude { name: name.clone() })?;
    let own = flight.header.datum_of(name);
    if own != AltitudeDatum::Ellipsoid {
        return Err(ImportError::NotAboveEllipsoid { name: name.clone(), is: own.words() });
    }
    let mut converted = Column::with_capacity(column.len());
    for row in 0..column.len() {
        converted.push(column.get(row).map(|metres| (f64::from(metres) - geoid_height_m) as f32));
    }
    *column = converted;
    // The flight's own datum still applies to the other columns.
    if name == Channel::GpsAltM.name() {
        let known = flight.channels.iter().map(|(channel, _)| channel.name().to_owned());
        let others: Vec<String> = known.chain(flight.extra.iter().map(|(name, _)| name.clone())).collect();
        let others: Vec<(String, AltitudeDatum)> = others
            .into_iter()
            .filter(|other| other != name && is_altitude(other))
            .map(|other| (flight.header.datum_of(&other), other))
            .map(|(datum, other)| (other, datum))
            .collect();
        flight.header.altitude_datum = AltitudeDatum::Msl;
        others.iter().for_each(|(other, datum)| flight.header.set_datum(other, *datum));
    }
    flight.header.set_datum(name, AltitudeDatum::Msl);
    flight.header.other.push((format!("geoid_height_m {name}"), geoid_height_m.to_string()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flight() -> Flight {
        let text = "# pylon-flight: 1\n# altitude_datum: ellipsoid\n# altitude_datum imu_slave_alt_m: msl\n\
                    time_s,gps_alt_m,baro_alt_m,imu_master_alt_m,imu_slave_alt_m,flap\n0,147.5,90,148,100,1\n1,148.5,91,149,101,1\n";
        flight_data::parse(text.as_bytes()).unwrap().0
    }

    fn converted(names: &[&str]) -> Result<Flight, String> {
        let mut flight = flight();
        for name in names {
            to_msl(&mut flight, &name.parse()?).map_err(|error| error.to_string())?;
        }
        Ok(flight)
    }

    #[test]
    fn one_column_is_converted_and_the_others_keep_their_datum() {
        let flight = converted(&["gps_alt_m=47.5"]).unwrap();
        let values: Vec<f32> =
            flight.channel(Channel::GpsAltM).unwrap().samples().map(|(_, value)| value).collect();
        assert_eq!(values, [100.0, 101.0]);
        let datums = ["gps_alt_m", "baro_alt_m", "imu_master_alt_m", "imu_slave_alt_m"];
        assert_eq!(
            datums.map(|name| flight.header.datum_of(name).name()),
            ["msl", "pressure", "ellipsoid", "msl"]
        );
        let mut text = Vec::new();
        flight_data::to_writer(&mut text, &flight).unwrap();
        let again = flight_data::parse(&text).unwrap().0;
        assert_eq!(again.header, flight.header);
        let both = converted(&["gps_alt_m=47.5", "imu_master_alt_m=47.5"]).unwrap();
        assert_eq!(both.channel(Channel::ImuMasterAltM).unwrap().get(1), Some(101.5));
        assert_eq!(both.header.datum_of("imu_master_alt_m"), AltitudeDatum::Msl);
    }

    #[test]
    fn what_is_no_altitude_above_the_ellipsoid_is_refused_by_its_name() {
        for (given, words) in [
            ("imu_slave_alt_m=47.5", "imu_slave_alt_m is measured above mean sea level"),
            ("baro_alt_m=47.5", "baro_alt_m is measured above 1013.25 hPa"),
            ("flap=47.5", "no altitude flap"),
            ("tas_mps=1", "no altitude tas_mps"),
            ("gps_alt_m", "expected COLUMN=METRES"),
            ("gps_alt_m=200", "from -108 to 87 anywhere"),
            ("gps_alt_m=nan", "from -108 to 87 anywhere"),
        ] {
            let error = converted(&[given]).unwrap_err();
            assert!(error.contains(words), "{given}: {error}");
        }
        assert!(converted(&["gps_alt_m=1", "gps_alt_m=1"]).is_err());
    }
}
