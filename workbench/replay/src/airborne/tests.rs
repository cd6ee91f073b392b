use super::*;
use flight_data::{Channel, Column};

/// A flight in whole seconds: height and speed over ground for each.
struct Track {
    rows: Vec<(f32, f32)>,
}

impl Track {
    fn at(height_m: f32) -> Self {
        Self { rows: vec![(height_m, 0.0)] }
    }

    /// Adds this many seconds at a climb rate and a speed.
    fn then(mut self, seconds: usize, climb_mps: f32, speed_mps: f32) -> Self {
        let from_m = self.rows.last().map_or(0.0, |row| row.0);
        self.rows.extend((1..=seconds).map(|k| (from_m + climb_mps * k as f32, speed_mps)));
        self
    }

    /// The part of it from that second on.
    fn from(mut self, second: usize) -> Self {
        self.rows.drain(..second);
        self
    }

    fn flight(&self) -> Flight {
        let mut flight = Flight::default();
        let mut columns = [Channel::GpsAltM, Channel::BaroAltM, Channel::GpsVnMps, Channel::GpsVeMps]
            .map(|channel| (channel, Column::default()));
        for (row, (height_m, speed_mps)) in self.rows.iter().enumerate() {
            flight.time_s.push(row as f64);
            // The receiver wanders by 2 m over a minute; the barometer has some decimetres of noise.
            let wander_m = 2.0 * (row as f32 / 10.0).sin();
            let noise_m = 0.2 * ((row * 7919 % 13) as f32 - 6.0) / 6.0;
            let cells = [height_m + wander_m, height_m + 40.0 + noise_m, *speed_mps, 0.0];
            columns.iter_mut().zip(cells).for_each(|((_, column), cell)| column.push(Some(cell)));
        }
        flight.channels = columns.into();
        flight
    }
}

/// A glider: a minute on the ground, a tow, a glide, a minute on the ground. It rolls from 60 s, lifts off at
/// 80 s and touches down at 680 s.
fn glider() -> Track {
    Track::at(300.0)
        .then(60, 0.0, 0.0)
        .then(20, 0.0, 25.0)
        .then(200, 3.0, 30.0)
        .then(400, -1.5, 30.0)
        .then(10, 0.0, 15.0)
        .then(60, 0.0, 0.0)
}

fn ends(flight: &Flight) -> Vec<(Option<f64>, Option<f64>)> {
    let rounded = |time_s: Option<f64>| time_s.map(f64::round);
    find(flight).airborne.iter().map(|o| (rounded(o.take_off_s), rounded(o.landing_s))).collect()
}

/// Exactly one time in the air, with both ends within some seconds.
fn assert_one(flight: &Flight, take_off_s: f64, landing_s: f64) {
    let found = ends(flight);
    let [(Some(off_s), Some(down_s))] = found[..] else { panic!("{found:?}") };
    assert!((off_s - take_off_s).abs() <= 6.0 && (down_s - landing_s).abs() <= 6.0, "{found:?}");
}

#[test]
fn a_glider_takes_off_after_its_roll_and_lands() {
    let flight = glider().flight();
    assert_one(&flight, 80.0, 680.0);
    let found = find(&flight);
    assert_eq!(found.heights, Some(Heights::Barometer));
    assert_eq!(found.airborne[0].ground_from_s, Some(0.0));
}

#[test]
fn every_set_of_sensors_will_do() {
    let without = |channels: &[Channel]| {
        let mut flight = glider().flight();
        flight.channels.retain(|(channel, _)| !channels.contains(channel));
        flight
    };
    use Channel::{BaroAltM, GpsAltM, GpsVeMps, GpsVnMps};
    assert_one(&without(&[GpsAltM, GpsVnMps, GpsVeMps]), 80.0, 680.0);
    assert_one(&without(&[BaroAltM]), 82.0, 678.0);
    assert_one(&without(&[GpsAltM]), 80.0, 680.0);
    assert_eq!(find(&without(&[BaroAltM, GpsAltM])), AirborneIntervals::default());
    assert_eq!(find(&Flight::default()), AirborneIntervals::default());
}

#[test]
fn a_barometer_that_is_stuck_gives_way_to_the_receiver() {
    let mut flight = glider().flight();
    let rows = flight.rows();
    let mut stuck = Column::default();
    (0..rows).for_each(|_| stuck.push(Some(412.0)));
    flight.set_channel(Channel::BaroAltM, stuck);
    assert_eq!(find(&flight).heights, Some(Heights::Receiver));
    assert_one(&flight, 82.0, 678.0);
}

#[test]
fn wild_cells_and_gaps_move_nothing() {
    let mut flight = glider().flight();
    for row in (3..flight.rows()).step_by(11) {
        let wild = if row % 2 == 0 { f32::NAN } else { 9_000.0 };
        flight.channels[1].1.set(row, Some(wild));
        flight.channels[2].1.set(row + 1, Some(150.0));
    }
    // No data for half a minute in the air and for ten seconds on the ground.
    for row in (300..330).chain(20..30) {
        flight.channels.iter_mut().for_each(|(_, column)| {
            column.set(row, None);
        });
    }
    assert_one(&flight, 80.0, 680.0);
}

#[test]
fn a_log_may_begin_and_end_in_the_air() {
    let begins = glider().from(200).flight();
    let found = ends(&begins);
    assert!(matches!(found[..], [(None, Some(down_s))] if (down_s - 480.0).abs() < 6.0), "{found:?}");
    let mut ends_aloft = glider();
    ends_aloft.rows.truncate(400);
    let found = ends(&ends_aloft.flight());
    assert!(matches!(found[..], [(Some(off_s), None)] if (off_s - 80.0).abs() < 6.0), "{found:?}");
}

#[test]
fn what_never_leaves_the_ground_is_no_flight() {
    assert_eq!(ends(&Track::at(100.0).then(600, 0.0, 0.0).flight()), []);
    // A walk up a hill, and a taxi on the flat.
    assert_eq!(
        ends(&Track::at(100.0).then(300, 0.0, 0.0).then(600, 0.1, 1.2).then(60, 0.0, 0.0).flight()),
        []
    );
    assert_eq!(
        ends(&Track::at(100.0).then(60, 0.0, 0.0).then(200, 0.0, 9.0).then(60, 0.0, 0.0).flight()),
        []
    );
    // Level flight from the first row to the last shows neither a take-off nor a landing.
    assert_eq!(ends(&Track { rows: vec![(500.0, 40.0); 600] }.flight()), []);
}

#[test]
fn several_flights_are_told_apart_and_the_longest_is_found() {
    let twice = glider()
        .then(100, 0.0, 0.0)
        .then(20, 0.0, 25.0)
        .then(300, 3.0, 30.0)
        .then(600, -1.5, 30.0)
        .then(90, 0.0, 0.0);
    let found = find(&twice.flight());
    assert_eq!(found.airborne.len(), 2, "{found:?}");
    let (place, longest) = found.longest().unwrap();
    assert_eq!(place, 1);
    let landed_s = found.airborne[0].landing_s.unwrap();
    assert_eq!(longest.ground_from_s, Some(landed_s));
    // A moment belongs to the flight that it is in, or the one that it is before.
    assert_eq!(found.around(100.0).unwrap().0, 0);
    assert_eq!(found.around(landed_s + 50.0).unwrap().0, 1);
    assert_eq!(found.around(longest.landing_s.unwrap() + 1.0), None);
}

#[test]
fn a_copter_that_hovers_has_not_landed() {
    // Straight up, a minute's hover, sideways, a hover at the same height, back, and down.
    let copter = Track::at(50.0)
        .then(30, 0.0, 0.0)
        .then(10, 2.0, 0.0)
        .then(60, 0.0, 0.0)
        .then(20, 0.0, 8.0)
        .then(60, 0.0, 0.3)
        .then(10, -2.0, 0.0)
        .then(30, 0.0, 0.0);
    assert_one(&copter.flight(), 30.0, 190.0);
    // A copter that comes down in between, and stands where it took off, has landed.
    let twice = Track::at(50.0).then(30, 0.0, 0.0).then(10, 1.0, 0.0).then(20, 0.0, 5.0).then(10, -1.0, 0.0);
    let twice =
        twice.then(20, 0.0, 0.0).then(10, 1.0, 0.0).then(20, 0.0, 5.0).then(10, -1.0, 0.0).then(20, 0.0, 0.0);
    assert_eq!(ends(&twice.flight()).len(), 2);
}

#[test]
fn a_paraglider_that_stands_in_the_wind_has_not_landed() {
    let parked = Track::at(900.0)
        .then(20, 0.0, 0.0)
        .then(200, 1.0, 6.0)
        .then(40, 0.0, 1.0)
        .then(300, -1.2, 7.0)
        .then(60, 0.0, 0.0);
    let found = ends(&parked.flight());
    assert_eq!(found.len(), 1, "{found:?}");
}

#[test]
fn a_barometer_that_leaps_on_the_ground_is_no_flight() {
    let mut flight = glider().then(300, 0.0, 0.0).flight();
    for row in 850..flight.rows() {
        let value = flight.channels[1].1.get(row).unwrap();
        flight.channels[1].1.set(row, Some(value + 30.0));
    }
    assert_one(&flight, 80.0, 680.0);
}

#[test]
fn a_receiver_that_settles_is_no_flight() {
    // Its position and altitude drift while the barometer stays constant, as after a cold start.
    let mut flight = glider().flight();
    for row in 0..25 {
        flight.channels[0].1.set(row, Some(340.0 - 1.6 * row as f32));
        flight.channels[2].1.set(row, Some(9.0 - 0.3 * row as f32));
    }
    assert_one(&flight, 80.0, 680.0);
}
