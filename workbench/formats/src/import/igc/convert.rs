//! Converts an IGC log's numbers to a flight's columns.

use std::collections::VecDeque;
use std::mem;

use super::log::{Altitudes, Log};
use super::units::{
    Inferred, SpeedSample, UnitUnknown, airspeed_unit, climb_unit, ground_speed_unit, temperature_unit,
};
use crate::import::ImportError;
use crate::import::airspeed::{standard_temperature_c, true_airspeed_factor};
use crate::import::damage::percent;
use crate::import::velocity::velocities;
use flight_data::{AltitudeDatum, Channel, Column, Flight, Header, Note};

/// A zero between pressure altitudes beyond this is a missing value, metres.
const ZERO_IS_FAR_M: f32 = 100.0;

/// Numbers whose unit the specification fixes: code, name of the signal.
const SIGNALS: [(&str, &str); 7] = [
    ("ENL", "engine_noise"),
    ("FXA", "gps_horizontal_error_95_m"),
    ("HDT", "heading_true_deg"),
    ("HDM", "heading_magnetic_deg"),
    ("TRT", "track_true_deg"),
    ("TRM", "track_magnetic_deg"),
    ("WDI", "wind_from_deg"),
];

struct Converter {
    /// The rest of the log: each column is taken out when it is converted, so that nothing is in memory
    /// twice.
    log: Log,
    flight: Flight,
    notes: Vec<Note>,
    /// Velocity over ground at each row, north and east, if a logged speed is to be compared with it.
    ground_mps: Option<(Column, Column)>,
}

/// Turns a log into a flight.
pub fn convert(mut log: Log) -> Result<(Flight, Vec<Note>), ImportError> {
    let fixes = || log.fixes.iter().flatten();
    // A recorder without a GNSS altitude writes zeros.
    let has_altitude = fixes().any(|fix| fix.is_3d && fix.gnss_m != 0.0);
    if !has_altitude {
        let (fixes, corrupt) = (fixes().count(), log.losses.corrupt_lines);
        return Err(ImportError::NoFix { format: "IGC", fixes, corrupt });
    }
    let flight = Flight { header: header(&log), time_s: mem::take(&mut log.time_s), ..Flight::default() };
    let mut converter = Converter { log, flight, notes: Vec::new(), ground_mps: None };
    converter.note_losses();
    converter.reference();
    converter.barometer();
    converter.horizontal();
    converter.additional();
    Ok((converter.flight, converter.notes))
}

/// A second of the day as a time of day.
fn time_of_day(second: u32) -> String {
    format!("{:02}:{:02}:{:02}", second / 3_600, second / 60 % 60, second % 60)
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
    keep("glider_id", log.header("GID").map(one_line));
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

impl Converter {
    fn note(&mut self, text: String) {
        self.notes.push(Note::new(text));
    }

    /// Adds a value of the fix, which is void without its altitude.
    fn put_of_fix(&mut self, channel: Channel, mut column: Column) {
        if let Some(altitude) = self.flight.channel(Channel::GpsAltM) {
            for row in (0..column.len()).filter(|row| altitude.get(*row).is_none()) {
                column.set(row, None);
            }
        }
        self.flight.set_channel(channel, column);
    }

    fn put_signal(&mut self, name: &str, column: Column) {
        self.flight.extra.push((name.to_owned(), column));
    }

    /// The altitudes of rows with a 3D fix.
    fn fixes_3d(&self) -> impl Iterator<Item = Option<Altitudes>> + Clone {
        self.log.fixes.iter().map(|fix| fix.filter(|fix| fix.is_3d))
    }

    fn note_losses(&mut self) {
        let losses = &self.log.losses;
        let mut notes = Vec::new();
        if losses.corrupt_lines > 0 {
            notes.push(format!(
                "lines that could not be read and were left out: {}, the first is line {}; records that were read: {}",
                losses.corrupt_lines,
                losses.first_corrupt_line,
                self.flight.time_s.len()
            ));
        }
        if losses.bad_extension_records > 0 {
            notes.push(format!(
                "I or J records that do not follow the specification: {}; what follows their first fault was left out",
                losses.bad_extension_records
            ));
        }
        if losses.blank_values > 0 {
            notes.push(format!("additional values that are blank or not numbers: {}", losses.blank_values));
        }
        if losses.before_first_fix > 0 {
            notes.push(format!(
                "records with a time before the first fix's, left out: {} of {}, the first is line {}",
                losses.before_first_fix, losses.records, losses.first_before_line
            ));
        }
        let judged = &losses.times;
        let times = &self.flight.time_s;
        if judged.restarts > 0 {
            notes.push(format!(
                "the recorder's clock was set back within the log ({}x): the longest stretch is used; fixes of the others, left \
                 out: {} ({})",
                judged.restarts,
                judged.of_other_runs,
                percent(judged.of_other_runs, losses.records)
            ));
        }
        if let Some(first) = judged.first {
            let before =
                first.before.map_or_else(String::new, |before| format!(" after {}", time_of_day(before)));
            notes.push(format!(
                "records whose time contradicts those around them, left out: {} ({}); the first is line {}, with {}{before}",
                judged.contradicting,
                percent(judged.contradicting, losses.records),
                first.line + 1,
                time_of_day(first.second)
            ));
        }
        let repeated = times.iter().zip(times.iter().skip(1)).filter(|(time, next)| time == next).count();
        let mut latest_s = f64::NEG_INFINITY;
        let mut is_behind = |time_s: f64| {
            let is_behind = time_s < latest_s;
            latest_s = latest_s.max(time_s);
            is_behind
        };
        let behind = times.iter().filter(|time_s| is_behind(**time_s)).count();
        if repeated + behind > 0 {
            notes.push(format!(
                "records that repeat the time of the one before: {repeated}, that are earlier than one before them: {behind}; the \
                 estimator ignores them"
            ));
        }
        notes.into_iter().for_each(|text| self.note(text));
    }

    /// Adds GNSS altitude, and a receiver time, so that a parked receiver's equal fixes are not mistaken for
    /// a held one.
    fn reference(&mut self) {
        let altitudes: Vec<f32> = self.fixes_3d().flatten().map(|fix| fix.gnss_m).collect();
        let missing = false_zeros(&altitudes);
        drop(altitudes);
        let zeros = missing.iter().filter(|missing| **missing).count();
        let mut missing = missing.into_iter();
        let rows = self.flight.rows();
        let (mut times, mut altitudes) = (Column::with_capacity(rows), Column::with_capacity(rows));
        for (time_s, fix) in self.flight.time_s.iter().zip(self.fixes_3d()) {
            let altitude = fix.filter(|_| missing.next() == Some(false)).map(|fix| fix.gnss_m);
            times.push(altitude.map(|_| *time_s as f32));
            altitudes.push(altitude);
        }
        self.flight.set_channel(Channel::GpsTimeS, times);
        self.flight.set_channel(Channel::GpsAltM, altitudes);
        if zeros > 0 {
            self.note(format!("GPS altitudes of zero amid others, left out as missing values: {zeros}"));
        }
        let without = self.log.fixes.iter().flatten().filter(|fix| !fix.is_3d).count();
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
        let fixes = || self.log.fixes.iter().flatten();
        if fixes().all(|fix| fix.pressure_m == 0.0) {
            self.note(
                "no barometer: every pressure altitude is zero; there is nothing to calibrate in this log"
                    .into(),
            );
            return;
        }
        if fixes().nth(1).is_some() && fixes().all(|fix| fix.pressure_m == fix.gnss_m) {
            self.note(
                "no barometer: every pressure altitude is the GPS altitude, copied; there is nothing to calibrate in \
                 this log"
                    .into(),
            );
            return;
        }
        let missing = false_zeros(&fixes().map(|fix| fix.pressure_m).collect::<Vec<_>>());
        let zeros = missing.iter().filter(|missing| **missing).count();
        let mut missing = missing.into_iter();
        let mut pressures = Column::with_capacity(self.flight.rows());
        for fix in &self.log.fixes {
            pressures.push(fix.filter(|_| missing.next() == Some(false)).map(|fix| fix.pressure_m));
        }
        self.flight.set_channel(Channel::BaroAltM, pressures);
        if zeros > 0 {
            self.note(format!("pressure altitudes of zero amid others, left out as missing values: {zeros}"));
        }
        match self.log.header("ALP") {
            None | Some("ISA") => {}
            Some(given) => self.note(format!(
                "the ALP header says '{given}', not ISA: the pressure altitude may be relative to the day's sea-level \
                 pressure, which a bias takes up"
            )),
        }
    }

    fn horizontal(&mut self) {
        let positions = mem::take(&mut self.log.positions);
        let valid =
            || self.fixes_3d().zip(&positions).map(|(fix, position)| fix.is_some().then_some(*position));
        let rows = self.flight.rows();
        let (mut north, mut east, mut missing) = (Column::empty(rows), Column::empty(rows), 0);
        let timed = self.flight.time_s.iter().zip(valid());
        let mut found = velocities(timed.filter_map(|(time_s, valid)| Some((*time_s, valid?))));
        for (row, _) in valid().enumerate().filter(|(_, valid)| valid.is_some()) {
            let velocity = found.next().flatten();
            missing += usize::from(velocity.is_none());
            north.set(row, velocity.map(|found| found.0));
            east.set(row, velocity.map(|found| found.1));
        }
        drop(found);
        let (mut latitude, mut longitude) =
            (Column::double_with_capacity(rows), Column::double_with_capacity(rows));
        for position in valid() {
            latitude.push_f64(position.map(|found| found.latitude_deg));
            longitude.push_f64(position.map(|found| found.longitude_deg));
        }
        drop(positions);
        let is_speed = |code: &str| matches!(code, "TAS" | "IAS" | "GSP");
        if self.log.values.iter().any(|(code, _)| is_speed(code)) {
            self.ground_mps = Some((north.clone(), east.clone()));
        }
        self.put_of_fix(Channel::GpsVnMps, north);
        self.put_of_fix(Channel::GpsVeMps, east);
        self.put_signal("latitude_deg", latitude);
        self.put_signal("longitude_deg", longitude);
        let mut text = "gps_vn_mps and gps_ve_mps are derived from positions, by differences over the neighbouring fixes; \
                        the log measures no vertical velocity"
            .to_owned();
        if missing > 0 {
            text += &format!(" (fixes beside gaps or jumps, without any: {missing})");
        }
        self.note(text);
    }

    fn additional(&mut self) {
        // Airspeeds need the temperature.
        let is_airspeed = |code: &str| matches!(code, "TAS" | "IAS");
        let (airspeeds, others): (Vec<_>, Vec<_>) =
            mem::take(&mut self.log.values).into_iter().partition(|(code, _)| is_airspeed(code));
        for (code, raw) in others {
            match code.as_str() {
                "SIU" => self.put_of_fix(Channel::GpsSats, raw),
                "VXA" => {
                    self.note(
                        "gps_vacc_m is the log's VXA as it stands; its sigma level is the maker's".into(),
                    );
                    self.put_of_fix(Channel::GpsVaccM, raw);
                }
                "OAT" => self.temperature(raw),
                "GSP" => {
                    let samples = self.speed_samples(&raw, |raw, _| raw);
                    let inferred = ground_speed_unit(samples);
                    self.signal_in_unit(&code, "ground_speed_mps", raw, inferred);
                }
                "VAR" => self.vario(&code, "vario_mps", raw),
                "VAT" => self.vario(&code, "vario_total_energy_mps", raw),
                _ => {
                    let known = SIGNALS.iter().find(|(known, _)| *known == code);
                    self.put_signal(
                        &known.map_or_else(|| raw_name(&code), |(_, name)| (*name).to_owned()),
                        raw,
                    );
                }
            }
        }
        self.airspeed(airspeeds);
    }

    /// Adds a signal if its unit could be inferred, else its plain numbers.
    fn signal_in_unit(
        &mut self,
        code: &str,
        name: &str,
        raw: Column,
        inferred: Result<Inferred, UnitUnknown>,
    ) {
        match inferred {
            Ok(Inferred { unit: (unit, scale), why }) => {
                self.note(format!("{name}: {code} is taken as {unit}: {why}"));
                self.put_signal(name, converted(&raw, |_, value| value / scale));
            }
            Err(why) => self.keep_plain(code, name, raw, &why),
        }
    }

    fn keep_plain(&mut self, code: &str, name: &str, raw: Column, why: &UnitUnknown) {
        let plain = raw_name(code);
        self.note(format!(
            "no {name}: the unit of {code} is unknown ({why}); its plain numbers are kept as {plain}"
        ));
        self.put_signal(&plain, raw);
    }

    fn temperature(&mut self, raw: Column) {
        let samples: Vec<(f64, f64)> = self
            .pressure_altitude_or_gnss()
            .zip(cells(&raw))
            .filter_map(|(altitude, raw)| Some((altitude?, raw?)))
            .collect();
        match temperature_unit(&samples) {
            Ok(Inferred { unit: (unit, scale), why }) => {
                self.note(format!("oat_c: OAT is taken as {unit}: {why}"));
                self.flight.set_channel(Channel::OatC, converted(&raw, |_, value| value / scale));
            }
            Err(why) => self.keep_plain("OAT", "oat_c", raw, &why),
        }
    }

    /// Altitude for the atmosphere model, held over rows that have none.
    fn pressure_altitude_or_gnss(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let mut held = None;
        let baro = self.flight.channel(Channel::BaroAltM);
        self.fixes_3d().enumerate().map(move |(row, fix)| {
            let pressure = baro.and_then(|baro| baro.get(row)).map(f64::from);
            held = pressure.or_else(|| fix.map(|fix| f64::from(fix.gnss_m))).or(held);
            held
        })
    }

    fn vario(&mut self, code: &str, name: &str, raw: Column) {
        let baro = self.flight.channel(Channel::BaroAltM);
        let heights = self.flight.time_s.iter().enumerate().filter_map(|(row, time_s)| {
            Some((*time_s, f64::from(baro?.get(row)?), raw.get(row).map(f64::from)))
        });
        // Over two fixes in both directions: a metre of resolution is then some 0.1 m/s at a fix a second.
        let mut window: VecDeque<(f64, f64, Option<f64>)> = VecDeque::with_capacity(5);
        let mut samples = Vec::new();
        for height in heights {
            if window.len() == 5 {
                window.pop_front();
            }
            window.push_back(height);
            let (Some(start), Some(middle), Some(end)) = (window.front(), window.get(2), window.get(4))
            else {
                continue;
            };
            let seconds = end.0 - start.0;
            if let Some(raw) = middle.2.filter(|_| seconds > 0.0 && seconds < 60.0) {
                samples.push(((end.1 - start.1) / seconds, raw));
            }
        }
        let inferred = climb_unit(&samples);
        self.signal_in_unit(code, name, raw, inferred);
    }

    /// Logged numbers with the velocity over ground, which is held for at most one row.
    fn speed_samples(&self, raw: &Column, correct: impl Fn(f64, usize) -> f64) -> Vec<SpeedSample> {
        let Some((north, east)) = &self.ground_mps else { return Vec::new() };
        let mut before = None;
        let mut samples = Vec::new();
        for (row, raw) in cells(raw).enumerate() {
            let ground = north.get(row).map(f64::from).zip(east.get(row).map(f64::from));
            if let (Some(raw), Some(ground_mps)) = (raw, ground.or(before)) {
                samples.push(SpeedSample { raw: correct(raw, row), ground_mps });
            }
            before = ground;
        }
        samples
    }

    fn airspeed(&mut self, mut airspeeds: Vec<(String, Column)>) {
        let mut take = |wanted: &str| {
            let place = airspeeds.iter().position(|(code, _)| code == wanted)?;
            Some(airspeeds.swap_remove(place).1)
        };
        let mut found = false;
        if let Some(raw) = take("TAS") {
            let samples = self.speed_samples(&raw, |raw, _| raw);
            match airspeed_unit(samples) {
                Ok(Inferred { unit: (unit, scale), why }) => {
                    self.note(format!("tas_mps: TAS is taken as {unit}: {why}"));
                    self.flight.set_channel(Channel::TasMps, converted(&raw, |_, value| value / scale));
                    found = true;
                }
                Err(why) => self.keep_plain("TAS", "tas_mps", raw, &why),
            }
        }
        let Some(raw) = take("IAS") else { return };
        let factors = self.airspeed_factors();
        let factor = |index: usize| factors.get(index).copied().unwrap_or(1.0);
        let samples = self.speed_samples(&raw, |raw, index| raw * factor(index));
        match airspeed_unit(samples) {
            Ok(Inferred { unit: (unit, scale), why }) => {
                if !found {
                    let temperature = if self.flight.channel(Channel::OatC).is_some() {
                        "the logged temperature"
                    } else {
                        "the standard atmosphere's temperature"
                    };
                    self.note(format!(
                        "tas_mps: computed from IAS, taken as {unit}, by pressure altitude and \
                         {temperature}: {why}"
                    ));
                    let true_mps = converted(&raw, |row, value| value * factor(row) / scale);
                    self.flight.set_channel(Channel::TasMps, true_mps);
                }
                self.put_signal("indicated_airspeed_mps", converted(&raw, |_, value| value / scale));
            }
            Err(why) => self.keep_plain("IAS", "indicated_airspeed_mps", raw, &why),
        }
    }

    /// Ratio of true to indicated airspeed at each row.
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

fn cells(column: &Column) -> impl Iterator<Item = Option<f64>> + '_ {
    (0..column.len()).map(|row| column.get(row).map(f64::from))
}

/// A column's numbers, converted by a function of row and number.
fn converted(column: &Column, convert: impl Fn(usize, f64) -> f64) -> Column {
    let mut made = Column::with_capacity(column.len());
    for (row, cell) in cells(column).enumerate() {
        made.push(cell.map(|value| convert(row, value) as f32));
    }
    made
}

/// Which values are zeros that mean "none": runs of zeros with neighbours far from sea level.
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
