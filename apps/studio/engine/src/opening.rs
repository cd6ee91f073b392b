//! Opens a log and reports its contents.

use analysis::batch::vehicle;
use analysis::overview::Overview;
use flight_data::{Channel, Column};
use kf_core::sensor::Sensor;

use crate::engine::{Engine, OpenFlight, Refused, given, refused};
use crate::protocol::{ColumnFacts, OpenRequest, Opened, Times};

/// Opens a log from its bytes.
pub fn open(engine: &mut Engine, request: OpenRequest, bytes: &[u8]) -> Result<Opened, Refused> {
    let OpenRequest { flight, file } = request;
    let format = formats::import::format_name(bytes).to_owned();
    let read = formats::import::open(bytes, &file, engine.executor)
        .map_err(|error| refused(format!("{file}: {error}")))?;
    opened(engine.keep(flight, file, format, read), Times::default())
}

/// The contents of an opened flight, with the user's times.
pub fn opened(open: &OpenFlight, times: Times) -> Result<Opened, Refused> {
    let OpenFlight { file, format, flight, notes, .. } = open;
    let overview = Overview::new(file, format, flight, notes, given(times));
    let facts = |name: &str, is_known: bool, column: &Column| ColumnFacts {
        name: name.to_owned(),
        is_known,
        values: column.samples().count() as u32,
    };
    let known = flight.channels.iter().map(|(channel, column)| facts(channel.name(), true, column));
    let extra = flight.extra.iter().map(|(name, column)| facts(name, false, column));
    let columns: Vec<ColumnFacts> = known.chain(extra).collect();
    Ok(Opened {
        vehicle: vehicle(&flight.header),
        first_s: flight.time_s.iter().copied().fold(f64::INFINITY, f64::min),
        last_s: flight.time_s.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        sensors: sensors(open),
        columns,
        overview,
    })
}

/// The altitude sensors that a mission over this flight has.
fn sensors(open: &OpenFlight) -> Vec<String> {
    let flight = &open.flight;
    let has = |channels: &[Channel]| channels.iter().any(|channel| flight.channel(*channel).is_some());
    let is_there = |sensor: &Sensor| match sensor {
        Sensor::Baro => has(&[Channel::BaroPa, Channel::BaroAltM]),
        Sensor::ImuMaster => has(&[Channel::ImuMasterAltM]),
        // The flight computer computes it if the log lacks it.
        Sensor::ImuSlave => {
            has(&[Channel::ImuSlaveAltM]) || (has(&[Channel::AccelZMps2]) && has(&[Channel::GyroXRadps]))
        }
    };
    let order = [Sensor::Baro, Sensor::ImuSlave, Sensor::ImuMaster];
    order.into_iter().filter(is_there).map(|sensor| sensor.name().to_owned()).collect()
}
