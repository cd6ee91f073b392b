//! What a residual may depend on: the flight's signals, block by block.

use crate::flight::{Channel, Column, Flight};
use Channel::{
    AccelXMps2, AccelYMps2, AccelZMps2, AoaRad, BaroTempC, GpsAltM, GpsSats, GpsVaccM, GpsVdMps, GpsVeMps,
    GpsVnMps, GyroXRadps, GyroYRadps, GyroZRadps, OatC, PitchRad, RollRad, SideslipRad, TasMps, Throttle,
    YawRad,
};
use kf_core::atmosphere::STANDARD_GRAVITY_MPS2;

const GRAVITY_MPS2: f64 = STANDARD_GRAVITY_MPS2 as f64;

/// A stretch of flight divided into equal blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Blocks {
    start_s: f64,
    length_s: f64,
    count: usize,
}

impl Blocks {
    /// Shortest block, seconds: longer than the differences between the sensors' and the signals' times.
    const SHORTEST_S: f64 = 0.5;
    /// Limit on the number of blocks.
    const MOST: f64 = 2_000.0;

    /// Blocks of the stretch between two times, seconds.
    pub(super) fn between(start_s: f64, end_s: f64) -> Self {
        let span_s = (end_s - start_s).max(0.0);
        let length_s = (span_s / Self::MOST).max(Self::SHORTEST_S);
        Self { start_s, length_s, count: (span_s / length_s).ceil() as usize }
    }

    /// Length of a block, seconds.
    pub(super) const fn length_s(&self) -> f64 {
        self.length_s
    }

    /// Middle of each block, seconds after the stretch's start.
    pub(super) fn middles_s(&self) -> Vec<Option<f64>> {
        (0..self.count).map(|index| Some((index as f64 + 0.5) * self.length_s)).collect()
    }

    /// Means of timed values by block; values that are not finite are left out.
    pub(super) fn means(&self, values: impl Iterator<Item = (f64, f64)>) -> Vec<Option<f64>> {
        let mut sums = vec![(0.0, 0_u32); self.count];
        for (time_s, value) in values {
            let place = (time_s - self.start_s) / self.length_s;
            if place >= 0.0
                && value.is_finite()
                && let Some((sum, count)) = sums.get_mut(place as usize)
            {
                *sum += value;
                *count += 1;
            }
        }
        sums.into_iter().map(|(sum, count)| (count > 0).then(|| sum / f64::from(count))).collect()
    }
}

/// A signal of a flight.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Signal {
    /// Its name, in words.
    pub(super) name: String,
    /// Its unit; empty for none.
    pub(super) unit: &'static str,
    /// Its mean in each block.
    pub(super) values: Vec<Option<f64>>,
}

/// A signal computed from the cells of one or more channels in one row.
struct Source {
    name: &'static str,
    unit: &'static str,
    channels: &'static [Channel],
    value: fn(&[f64]) -> f64,
}

const fn source(
    name: &'static str,
    unit: &'static str,
    channels: &'static [Channel],
    value: fn(&[f64]) -> f64,
) -> Source {
    Source { name, unit, channels, value }
}

fn first(cells: &[f64]) -> f64 {
    cells.first().copied().unwrap_or(f64::NAN)
}

const SOURCES: &[Source] = &[
    source("altitude by gps", "m", &[GpsAltM], first),
    source("climb rate", "m/s", &[GpsVdMps], |cells| -first(cells)),
    source("airspeed", "m/s", &[TasMps], first),
    source("airspeed squared / 2 g", "m", &[TasMps], |cells| first(cells).powi(2) / (2.0 * GRAVITY_MPS2)),
    source("speed over ground", "m/s", &[GpsVnMps, GpsVeMps], |cells| {
        cells.iter().map(|cell| cell * cell).sum::<f64>().sqrt()
    }),
    source("load factor", "g", &[AccelZMps2], |cells| -first(cells) / GRAVITY_MPS2),
    source("forward acceleration", "m/s²", &[AccelXMps2], first),
    source("sideways acceleration", "m/s²", &[AccelYMps2], first),
    source("angle of attack", "deg", &[AoaRad], |cells| first(cells).to_degrees()),
    source("sideslip", "deg", &[SideslipRad], |cells| first(cells).to_degrees()),
    source("roll", "deg", &[RollRad], |cells| first(cells).to_degrees()),
    source("pitch", "deg", &[PitchRad], |cells| first(cells).to_degrees()),
    source("heading", "deg", &[YawRad], |cells| first(cells).to_degrees()),
    source("roll rate", "deg/s", &[GyroXRadps], |cells| first(cells).to_degrees()),
    source("pitch rate", "deg/s", &[GyroYRadps], |cells| first(cells).to_degrees()),
    source("yaw rate", "deg/s", &[GyroZRadps], |cells| first(cells).to_degrees()),
    source("throttle", "", &[Throttle], first),
    source("outside air temperature", "°C", &[OatC], first),
    source("barometer's temperature", "°C", &[BaroTempC], first),
    source("gps: its own vertical accuracy", "m", &[GpsVaccM], first),
    source("gps: satellites", "", &[GpsSats], first),
];

/// Every signal that the flight has, with its means over the blocks.
pub(super) fn signals(flight: &Flight, blocks: &Blocks, time: &str) -> Vec<Signal> {
    let mut signals = vec![Signal { name: time.to_owned(), unit: "s", values: blocks.middles_s() }];
    for source in SOURCES {
        let columns: Option<Vec<&Column>> =
            source.channels.iter().map(|channel| flight.channel(*channel)).collect();
        let Some(columns) = columns else { continue };
        signals.push(Signal {
            name: source.name.to_owned(),
            unit: source.unit,
            values: blocks.means(samples(flight, &columns, source.value)),
        });
    }
    for (name, column) in &flight.extra {
        signals.push(Signal {
            name: name.clone(),
            unit: "",
            values: blocks.means(samples(flight, &[column], first)),
        });
    }
    signals
}

/// Time and value of each row in which all the columns have a cell.
fn samples<'a>(
    flight: &'a Flight,
    columns: &'a [&'a Column],
    value: fn(&[f64]) -> f64,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let rows = columns.first().into_iter().flat_map(|column| column.samples());
    rows.filter_map(move |(row, _)| {
        let mut cells = [0.0; 3];
        for (cell, column) in cells.iter_mut().zip(columns) {
            *cell = f64::from(column.get(row)?);
        }
        Some((*flight.time_s.get(row)?, value(cells.get(..columns.len())?)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_by_block_and_gaps_stay() {
        let blocks = Blocks::between(10.0, 12.0);
        assert_eq!((blocks.count, blocks.length_s()), (4, 0.5));
        let values = [(9.0, 100.0), (10.1, 1.0), (10.2, 3.0), (11.2, f64::NAN), (11.9, 7.0), (12.1, 100.0)];
        assert_eq!(blocks.means(values.into_iter()), [Some(2.0), None, None, Some(7.0)]);
        assert_eq!(blocks.middles_s()[3], Some(1.75));
        assert_eq!(Blocks::between(0.0, 3_600.0).count, 2_000);
    }

    #[test]
    fn signals_have_their_units_and_only_what_the_flight_has() {
        let mut flight = Flight { time_s: vec![0.0, 0.25, 0.5, 0.75], ..Flight::default() };
        let column = |values: [f32; 4]| {
            let mut column = Column::default();
            values.into_iter().for_each(|value| column.push(Some(value)));
            column
        };
        flight.channels.push((RollRad, column([0.1; 4])));
        flight.channels.push((GpsVnMps, column([3.0; 4])));
        flight.channels.push((GpsVeMps, column([4.0; 4])));
        flight.extra.push(("flap".to_owned(), column([1.0, 3.0, 5.0, 5.0])));
        let found = signals(&flight, &Blocks::between(0.0, 1.0), "time");
        let names: Vec<&str> = found.iter().map(|signal| signal.name.as_str()).collect();
        assert_eq!(names, ["time", "speed over ground", "roll", "flap"]);
        assert_eq!(found[1].values, [Some(5.0), Some(5.0)]);
        assert!((found[2].values[0].unwrap() - 5.729_578).abs() < 1e-5);
        assert_eq!(found[3].values, [Some(2.0), Some(5.0)]);
    }
}
