//! From an IGC log's numbers to a flight's columns.

use super::log::{Log, Row};
use super::units::{
    Inferred, SpeedSample, airspeed_unit, climb_unit, ground_speed_unit, standard_temperature_c,
    temperature_unit, true_airspeed_factor,
};
use super::velocity::{TimedPosition, velocities};
use crate::flight::{AltitudeDatum, Channel, Column, Flight, Header, Note};
use crate::import::ImportError;

/// A zero between pressure altitudes beyond this is a missing value, metres.
const ZERO_IS_FAR_M: f32 = 100.0;

/// Numbers with a unit that the specification fixes: code, name of the signal.
const SIGNALS: [(&str, &str); 7] = [
    ("ENL", "engine_noise"),
    ("FXA", "gps_horizontal_error_95_m"),
    ("HDT", "heading_true_deg"),
    ("HDM", "heading_magnetic_deg"),
    ("TRT", "track_true_deg"),
    ("TRM", "track_magnetic_deg"),
    ("WDI", "wind_from_deg"),
];

/// One cell a row.
type Cells = Vec<Option<f64>>;

struct Converter<'a> {
    log: &'a Log,
    flight: Flight,
    notes: Vec<Note>,
    /// Pressure altitude, where there is a barometer.
    pressure_altitude_m: Cells,
    /// Velocity over ground at each row, held from the last row that has one.
    ground_mps: Vec<Option<(f64, f64)>>,
}

/// Turns a log into a flight.
pub fn convert(log: &Log) -> Result<(Flight, Vec<Note>), ImportError> {
    let fixes = || log.rows.iter().filter_map(|row| row.fix.as_ref());
    // A recorder that has no GNSS altitude writes zeros.
    let has_altitude = fixes().any(|fix| fix.is_3d && fix.gnss_altitude_m != 0.0);
    if !has_altitude {
        let (fixes, corrupt) = (fixes().count(), log.losses.corrupt_lines);
        return Err(ImportError::NoFix { format: "IGC", fixes, corrupt });
    }
    let rows = log.rows.len();
    let mut converter = Converter {
        log,
        flight: Flight {
            header: header(log),
            time_s: log.rows.iter().map(|row| row.time_s).collect(),
            ..Flight::default()
        },
        notes: Vec::new(),
        pressure_altitude_m: vec![None; rows],
        ground_mps: vec![None; rows],
    };
    converter.note_losses();
    converter.reference();
    converter.barometer();
    converter.horizontal();
    converter.additional();
    Ok((converter.flight, converter.notes))
}

fn header(log: &Log) -> Header {
    let one_line = |text: &str| text.replace(|letter: char| letter.is_control(), " ").trim().to_owned();
    let mut other = vec![("log_format".to_owned(), "igc".to_owned())];
    let mut keep = |key: &str, value: Option<String>| {
        other.extend(value.filter(|value| !value.is_empty()).map(|value| (key.to_owned(), value)));
    };
    keep(
        "start_utc",
        log.start.map(|((year, month, day), second)| {
            let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
            format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z")
        }),
    );
    keep("recorder", log.header("A").map(one_line));
    keep("recorder_type", log.header("FTY").map(one_line));
    keep("gps_receiver", log.header("GPS").map(one_line));
    keep("pressure_sensor", log.header("PRS").map(one_line));
    keep("gps_velocity", Some("derived from positions".to_owned()));
    let altitude_datum = match log.header("ALG") {
        Some("GEO") => AltitudeDatum::Msl,
        _ => AltitudeDatum::Ellipsoid,
    };
    Header {
        vehicle: log.header("GTY").map(one_line).unwrap_or_default(),
        source: "imported IGC log".to_owned(),
        altitude_datum,
        other,
    }
}

impl Converter<'_> {
    fn note(&mut self, text: String) {
        self.notes.push(Note::new(text));
    }

    fn put(&mut self, channel: Channel, cells: impl Iterator<Item = Option<f64>>) {
        self.flight.set_channel(channel, column(cells));
    }

    /// A part of the fix, which is nothing without its altitude.
    fn put_of_fix(&mut self, channel: Channel, cells: Cells) {
        let altitude = self.flight.channel(Channel::GpsAltM);
        let has_altitude = |row: usize| altitude.is_some_and(|column| column.get(row).is_some());
        let cells: Vec<_> =
            cells.into_iter().enumerate().map(|(row, cell)| cell.filter(|_| has_altitude(row))).collect();
        self.put(channel, cells.into_iter());
    }

    fn put_signal(&mut self, name: String, cells: impl Iterator<Item = Option<f64>>) {
        self.flight.extra.push((name, column(cells)));
    }

    fn note_losses(&mut self) {
        let losses = &self.log.losses;
        let mut notes = Vec::new();
        if losses.corrupt_lines > 0 {
            notes.push(format!(
                "lines that could not be read and were left out: {}, the first is line {}",
                losses.corrupt_lines, losses.first_corrupt_line
            ));
        }
        if losses.bad_extension_records > 0 {
            notes.push(format!(
                "I or J records that are not as the specification says: {}; what follows their first fault was left out",
                losses.bad_extension_records
            ));
        }
        if losses.blank_values > 0 {
            notes.push(format!("additional values that are blank or not numbers: {}", losses.blank_values));
        }
        if losses.before_first_fix > 0 {
            notes.push(format!(
                "records with a time before the first fix's, left out: {}",
                losses.before_first_fix
            ));
        }
        let times = &self.flight.time_s;
        let pairs = || times.iter().zip(times.iter().skip(1));
        let repeated = pairs().filter(|(time, next)| time == next).count();
        let backward = pairs().filter(|(time, next)| next < time).count();
        if repeated + backward > 0 {
            notes.push(format!(
                "records that repeat the time of the one before: {repeated}, that go back in time: {backward}; the \
                 estimator ignores them"
            ));
        }
        notes.into_iter().for_each(|text| self.note(text));
    }

    /// GNSS altitude, and a receiver time, so that a parked receiver's equal fixes are not taken for
    /// one that is held.
    fn reference(&mut self) {
        let rows = &self.log.rows;
        let (indices, altitudes): (Vec<usize>, Vec<f32>) = rows
            .iter()
            .enumerate()
            .filter_map(|(index, row)| {
                row.fix.filter(|fix| fix.is_3d).map(|fix| (index, fix.gnss_altitude_m))
            })
            .unzip();
        let missing = false_zeros(&altitudes);
        let mut cells = vec![None; rows.len()];
        for ((index, altitude), missing) in indices.into_iter().zip(&altitudes).zip(&missing) {
            if let Some(cell) = cells.get_mut(index) {
                *cell = (!missing).then_some(f64::from(*altitude));
            }
        }
        let times = rows.iter().zip(&cells).map(|(row, altitude)| altitude.map(|_| row.time_s));
        self.put(Channel::GpsTimeS, times.collect::<Vec<_>>().into_iter());
        self.put(Channel::GpsAltM, cells.into_iter());
        let zeros = missing.iter().filter(|missing| **missing).count();
        if zeros > 0 {
            self.note(format!("GPS altitudes of zero amid others, left out as missing values: {zeros}"));
        }
        let without = self.log.rows.iter().filter(|row| row.fix.is_some_and(|fix| !fix.is_3d)).count();
        if without > 0 {
            self.note(format!("fixes that are not 3D (validity V) and give no GPS sample: {without}"));
        }
        match self.log.header("ALG") {
            Some("GEO" | "ELL") => {}
            given => self.note(format!(
                "the ALG header {}: GPS altitude is taken as above the ellipsoid, as the specification demands; \
                 were it above the geoid, only biases would differ",
                given.map_or_else(|| "is missing".to_owned(), |given| format!("says '{given}'"))
            )),
        }
    }

    fn barometer(&mut self) {
        let fixes: Vec<(usize, f32, f32)> = self
            .log
            .rows
            .iter()
            .enumerate()
            .filter_map(|(index, row)| {
                row.fix.map(|fix| (index, fix.pressure_altitude_m, fix.gnss_altitude_m))
            })
            .collect();
        if fixes.iter().all(|(_, pressure, _)| *pressure == 0.0) {
            self.note(
                "no barometer: every pressure altitude is zero; there is nothing to calibrate in this log"
                    .into(),
            );
            return;
        }
        if fixes.len() > 1 && fixes.iter().all(|(_, pressure, gnss)| pressure == gnss) {
            self.note(
                "no barometer: every pressure altitude is the GPS altitude, copied; there is nothing to calibrate in \
                 this log"
                    .into(),
            );
            return;
        }
        let missing = false_zeros(&fixes.iter().map(|(_, pressure, _)| *pressure).collect::<Vec<_>>());
        for ((index, pressure, _), missing) in fixes.iter().zip(&missing) {
            if let Some(cell) = self.pressure_altitude_m.get_mut(*index) {
                *cell = (!missing).then_some(f64::from(*pressure));
            }
        }
        let zeros = missing.iter().filter(|missing| **missing).count();
        if zeros > 0 {
            self.note(format!("pressure altitudes of zero amid others, left out as missing values: {zeros}"));
        }
        let cells = self.pressure_altitude_m.clone();
        self.put(Channel::BaroAltM, cells.into_iter());
        match self.log.header("ALP") {
            None | Some("ISA") => {}
            Some(given) => self.note(format!(
                "the ALP header says '{given}', not ISA: the pressure altitude may be relative to the day's sea-level \
                 pressure, which a bias takes up"
            )),
        }
    }

    fn horizontal(&mut self) {
        let valid = |row: &Row| row.fix.filter(|fix| fix.is_3d).and(row.position);
        let (indices, positions): (Vec<usize>, Vec<TimedPosition>) = self
            .log
            .rows
            .iter()
            .enumerate()
            .filter_map(|(index, row)| valid(row).map(|position| (index, (row.time_s, position))))
            .unzip();
        let velocities = velocities(&positions);
        let missing = velocities.iter().filter(|velocity| velocity.is_none()).count();
        for (index, velocity) in indices.into_iter().zip(velocities) {
            if let Some(slot) = self.ground_mps.get_mut(index) {
                *slot = velocity.map(|(north, east)| (f64::from(north), f64::from(east)));
            }
        }
        let (north, east) = self.ground_mps.iter().map(|velocity| velocity.unzip()).unzip();
        self.put_of_fix(Channel::GpsVnMps, north);
        self.put_of_fix(Channel::GpsVeMps, east);
        let rows = &self.log.rows;
        self.put_signal(
            "latitude_deg".into(),
            rows.iter().map(|row| valid(row).map(|found| found.latitude_deg)),
        );
        self.put_signal(
            "longitude_deg".into(),
            rows.iter().map(|row| valid(row).map(|found| found.longitude_deg)),
        );
        let mut text = "gps_vn_mps and gps_ve_mps are derived from positions, by differences over the neighbouring fixes; \
                        the log measures no vertical velocity"
            .to_owned();
        if missing > 0 {
            text += &format!(" (fixes beside gaps or jumps, without any: {missing})");
        }
        self.note(text);
    }

    /// Cells of a code's numbers as they stand.
    fn raw(&self, code: &str) -> Option<Cells> {
        let wanted = self.log.codes.iter().position(|found| found == code)?;
        let last_of =
            |row: &Row| row.values.iter().rev().find_map(|(code, value)| (*code == wanted).then_some(*value));
        Some(self.log.rows.iter().map(last_of).collect())
    }

    fn additional(&mut self) {
        for code in self.log.codes.clone() {
            let Some(raw) = self.raw(&code) else { continue };
            match code.as_str() {
                "SIU" => self.put_of_fix(Channel::GpsSats, raw),
                "VXA" => {
                    self.note(
                        "gps_vacc_m is the log's VXA as it stands; its sigma level is the maker's".into(),
                    );
                    self.put_of_fix(Channel::GpsVaccM, raw);
                }
                "OAT" => self.temperature(raw),
                // Airspeeds need the temperature.
                "TAS" | "IAS" => {}
                "GSP" => {
                    let samples = self.speed_samples(&raw, |raw, _| raw);
                    let inferred = ground_speed_unit(&samples);
                    self.signal_in_unit(&code, "ground_speed_mps", raw, inferred);
                }
                "VAR" => self.vario(&code, "vario_mps", raw),
                "VAT" => self.vario(&code, "vario_total_energy_mps", raw),
                _ => {
                    let name =
                        SIGNALS.iter().find(|(known, _)| *known == code).map(|(_, name)| (*name).to_owned());
                    let name = name.unwrap_or_else(|| raw_name(&code));
                    self.put_signal(name, raw.into_iter());
                }
            }
        }
        self.airspeed();
    }

    /// A signal if its unit could be told, else its plain numbers.
    fn signal_in_unit(&mut self, code: &str, name: &str, raw: Cells, inferred: Result<Inferred, String>) {
        match inferred {
            Ok(Inferred { unit: (unit, scale), why }) => {
                self.note(format!("{name}: {code} is taken as {unit}: {why}"));
                self.put_signal(name.to_owned(), raw.into_iter().map(|cell| cell.map(|value| value / scale)));
            }
            Err(why) => self.keep_plain(code, name, raw, &why),
        }
    }

    fn keep_plain(&mut self, code: &str, name: &str, raw: Cells, why: &str) {
        let plain = raw_name(code);
        self.note(format!(
            "no {name}: the unit of {code} can not be told ({why}); its plain numbers are kept as {plain}"
        ));
        self.put_signal(plain, raw.into_iter());
    }

    fn temperature(&mut self, raw: Cells) {
        let samples: Vec<(f64, f64)> = self
            .pressure_altitude_or_gnss()
            .zip(&raw)
            .filter_map(|(altitude, raw)| Some((altitude?, (*raw)?)))
            .collect();
        match temperature_unit(&samples) {
            Ok(Inferred { unit: (unit, scale), why }) => {
                self.note(format!("oat_c: OAT is taken as {unit}: {why}"));
                self.put(Channel::OatC, raw.into_iter().map(|cell| cell.map(|value| value / scale)));
            }
            Err(why) => self.keep_plain("OAT", "oat_c", raw, &why),
        }
    }

    /// Altitude for the atmosphere's sake, held over rows that have none.
    fn pressure_altitude_or_gnss(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let mut held = None;
        self.log.rows.iter().zip(&self.pressure_altitude_m).map(move |(row, pressure)| {
            let gnss = row.fix.filter(|fix| fix.is_3d).map(|fix| f64::from(fix.gnss_altitude_m));
            held = pressure.or(gnss).or(held);
            held
        })
    }

    fn vario(&mut self, code: &str, name: &str, raw: Cells) {
        let heights: Vec<(f64, f64, Option<f64>)> = self
            .log
            .rows
            .iter()
            .zip(&self.pressure_altitude_m)
            .zip(&raw)
            .filter_map(|((row, altitude), raw)| Some((row.time_s, (*altitude)?, *raw)))
            .collect();
        // Over two fixes to either side: a metre of resolution is then some 0.1 m/s at a fix a second.
        let samples: Vec<(f64, f64)> = heights
            .windows(5)
            .filter_map(|window| {
                let [(start_s, low, _), .., (end_s, high, _)] = window else { return None };
                let raw = window.get(2)?.2?;
                let seconds = end_s - start_s;
                (seconds > 0.0 && seconds < 60.0).then(|| ((high - low) / seconds, raw))
            })
            .collect();
        let inferred = climb_unit(&samples);
        self.signal_in_unit(code, name, raw, inferred);
    }

    /// Logged numbers with the velocity over ground, held for at most one row.
    fn speed_samples(&self, raw: &Cells, correct: impl Fn(f64, usize) -> f64) -> Vec<SpeedSample> {
        let mut before = None;
        let mut samples = Vec::new();
        for (index, (raw, ground)) in raw.iter().zip(&self.ground_mps).enumerate() {
            if let (Some(raw), Some(ground_mps)) = (*raw, ground.or(before)) {
                samples.push(SpeedSample { raw: correct(raw, index), ground_mps });
            }
            before = *ground;
        }
        samples
    }

    fn airspeed(&mut self) {
        let mut found = false;
        if let Some(raw) = self.raw("TAS") {
            let samples = self.speed_samples(&raw, |raw, _| raw);
            match airspeed_unit(&samples) {
                Ok(Inferred { unit: (unit, scale), why }) => {
                    self.note(format!("tas_mps: TAS is taken as {unit}: {why}"));
                    self.put(Channel::TasMps, raw.into_iter().map(|cell| cell.map(|value| value / scale)));
                    found = true;
                }
                Err(why) => self.keep_plain("TAS", "tas_mps", raw, &why),
            }
        }
        let Some(raw) = self.raw("IAS") else { return };
        let factors = self.airspeed_factors();
        let factor = |index: usize| factors.get(index).copied().unwrap_or(1.0);
        let samples = self.speed_samples(&raw, |raw, index| raw * factor(index));
        match airspeed_unit(&samples) {
            Ok(Inferred { unit: (unit, scale), why }) => {
                if !found {
                    let temperature = if self.flight.channel(Channel::OatC).is_some() {
                        "the logged temperature"
                    } else {
                        "the standard atmosphere's temperature"
                    };
                    self.note(format!(
                        "tas_mps: made of IAS, taken as {unit}, by pressure altitude and {temperature}: {why}"
                    ));
                    let true_mps = raw
                        .iter()
                        .enumerate()
                        .map(|(index, cell)| cell.map(|value| value * factor(index) / scale))
                        .collect::<Vec<_>>();
                    self.put(Channel::TasMps, true_mps.into_iter());
                }
                let cells = raw.into_iter().map(|cell| cell.map(|value| value / scale));
                self.put_signal("indicated_airspeed_mps".into(), cells);
            }
            Err(why) => self.keep_plain("IAS", "indicated_airspeed_mps", raw, &why),
        }
    }

    /// True over indicated airspeed at each row.
    fn airspeed_factors(&self) -> Vec<f64> {
        let temperature = self.flight.channel(Channel::OatC);
        let mut held_c = None;
        self.pressure_altitude_or_gnss()
            .enumerate()
            .map(|(row, altitude)| {
                let measured = temperature.and_then(|column| column.get(row)).map(f64::from);
                held_c = measured.or(held_c);
                altitude.map_or(1.0, |altitude| {
                    true_airspeed_factor(altitude, held_c.unwrap_or_else(|| standard_temperature_c(altitude)))
                })
            })
            .collect()
    }
}

fn raw_name(code: &str) -> String {
    format!("igc_{}", code.to_ascii_lowercase())
}

fn column(cells: impl Iterator<Item = Option<f64>>) -> Column {
    let mut column = Column::default();
    cells.for_each(|cell| column.push(cell.map(|value| value as f32)));
    column
}

/// Which values are zeros that stand for "none": runs of zeros with neighbours far from sea level.
fn false_zeros(values: &[f32]) -> Vec<bool> {
    let mut missing = vec![false; values.len()];
    let mut start = 0;
    for run in values.chunk_by(|value, next| (*value == 0.0) == (*next == 0.0)) {
        let end = start + run.len();
        if run.first() == Some(&0.0) {
            let before = start.checked_sub(1).and_then(|index| values.get(index));
            let neighbours = [before, values.get(end)];
            let is_far = neighbours.iter().flatten().all(|value| value.abs() > ZERO_IS_FAR_M);
            missing.iter_mut().take(end).skip(start).for_each(|slot| *slot = is_far);
        }
        start = end;
    }
    missing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_far_from_their_neighbours_are_missing() {
        let zeros = |values: &[f32]| false_zeros(values).into_iter().map(u8::from).collect::<Vec<_>>();
        assert_eq!(zeros(&[0.0, 0.0, 300.0, 0.0, 310.0, 0.0]), [1, 1, 0, 1, 0, 1]);
        assert_eq!(zeros(&[3.0, 0.0, -2.0, 0.0, 0.0, 1.0]), [0; 6]);
        assert_eq!(zeros(&[500.0, 0.0, 90.0]), [0; 3]);
    }
}
