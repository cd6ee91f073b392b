//! A flight in blocks of some seconds: height, speed, place.

use kf_core::atmosphere::pressure_altitude_m;

use flight_data::{Channel, Column, Flight};

/// Shortest block, seconds.
const SHORTEST_S: f64 = 1.0;
/// A block is so long that it has this many fixes, so that one wild fix is not its median.
const FIXES_A_BLOCK: f64 = 2.5;
/// An airspeed below this may be wind on a parked aircraft, m/s.
const WIND_MPS: f64 = 8.0;
/// A barometer is not believed if it moves over less than this share of what the receiver moves over: it is stuck.
const STUCK_SHARE: f64 = 0.2;
/// Blocks farther apart than this many of their lengths have a gap between them: where the vehicle went meanwhile is not known.
const GAP_BLOCKS: f64 = 4.0;

/// Where the heights come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heights {
    /// The barometer: some decimetres from one second to the next.
    Barometer,
    /// The receiver, which wanders by metres.
    Receiver,
}

impl Heights {
    /// In words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Barometer => "barometer",
            Self::Receiver => "receiver",
        }
    }
}

/// Changes of height below this show nothing, metres, by a barometer in whole metres: two of its steps.
const WHOLE_METRES_M: f64 = 2.0;
/// The same by a barometer that shows decimetres: gusts and propellers move it by half of that.
const FINE_M: f64 = 1.0;
/// The same by a receiver: three times the 2 m that its altitude wanders by within half a minute.
const RECEIVER_M: f64 = 6.0;

/// One block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Block {
    /// Its beginning, seconds.
    pub(super) time_s: f64,
    /// Median height, metres.
    pub(super) height_m: f64,
    /// Median speed, m/s; `None` where nothing tells.
    pub(super) speed_mps: Option<f64>,
    /// Place north and east of the leg's beginning, metres; a leg is a stretch without gaps.
    pub(super) place_m: [f64; 2],
    /// The leg.
    pub(super) leg: usize,
}

/// All blocks that have a height, in order of time.
pub(super) struct Blocks {
    pub(super) blocks: Vec<Block>,
    /// Length of each, seconds.
    pub(super) length_s: f64,
    pub(super) heights: Heights,
    /// Changes of height below this show nothing, metres.
    pub(super) tolerance_m: f64,
}

/// Row, time in seconds and metres of an altitude.
pub(super) type Sample = (usize, f64, f64);

/// One row's cells that matter.
struct Row {
    time_s: f64,
    height_m: Option<f64>,
    velocity_mps: Option<[f64; 2]>,
    airspeed_mps: Option<f64>,
}

impl Blocks {
    /// Of a flight that has an altitude.
    pub(super) fn new(flight: &Flight) -> Option<Self> {
        let (altitudes, heights) = altitudes(flight)?;
        let times = |samples: &[Sample]| samples.iter().map(|(_, time_s, _)| *time_s).collect();
        let speeds =
            [Channel::GpsVnMps, Channel::TasMps].into_iter().find_map(|channel| flight.channel(channel));
        let speeds = speeds.into_iter().flat_map(Column::samples);
        let speeds: Vec<f64> = speeds.filter_map(|(row, _)| flight.time_s.get(row).copied()).collect();
        // A block without a speed would tell less than one that is longer.
        let interval_s = median_interval_s(times(&altitudes)).max(median_interval_s(speeds));
        let length_s = SHORTEST_S.max(FIXES_A_BLOCK * interval_s);
        let is_whole = |(_, _, metres): &&Sample| metres.fract() == 0.0;
        let tolerance_m = match heights {
            Heights::Receiver => RECEIVER_M,
            // A zero among decimetres is whole too.
            Heights::Barometer if 2 * altitudes.iter().filter(is_whole).count() > altitudes.len() => {
                WHOLE_METRES_M
            }
            Heights::Barometer => FINE_M,
        };
        let finite = |channel: Channel, row: usize| {
            let value = flight.channel(channel)?.get(row)?;
            value.is_finite().then_some(f64::from(value))
        };
        let mut rows = altitudes.iter().peekable();
        let mut latest_s = f64::NEG_INFINITY;
        let mut blocks = Gatherer { length_s, ..Gatherer::default() };
        for (row, time_s) in flight.time_s.iter().copied().enumerate() {
            // Rows that run back in time are left out, as the estimator does.
            if time_s <= latest_s || !time_s.is_finite() {
                continue;
            }
            latest_s = time_s;
            while rows.next_if(|(other, ..)| *other < row).is_some() {}
            blocks.take(&Row {
                time_s,
                height_m: rows.next_if(|(other, ..)| *other == row).map(|(.., metres)| *metres),
                velocity_mps: finite(Channel::GpsVnMps, row)
                    .zip(finite(Channel::GpsVeMps, row))
                    .map(<[f64; 2]>::from),
                airspeed_mps: finite(Channel::TasMps, row),
            });
        }
        Some(Self { blocks: smoothed(blocks.finish()), length_s, heights, tolerance_m })
    }

    /// Whether any block has a speed.
    pub(super) fn has_speed(&self) -> bool {
        self.blocks.iter().any(|block| block.speed_mps.is_some())
    }

    /// Whether there is a gap between a block and the next one.
    pub(super) fn is_gap(&self, block: &Block, next: &Block) -> bool {
        next.time_s - block.time_s > GAP_BLOCKS * self.length_s
    }

    /// Least and greatest height from one time to another, around or beside a block: metres between them.
    pub(super) fn range_m(&self, from_s: f64, to_s: f64) -> f64 {
        let first = self.blocks.partition_point(|block| block.time_s < from_s);
        let inside = self.blocks.get(first..).unwrap_or_default();
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for block in inside.iter().take_while(|block| block.time_s <= to_s) {
            least = least.min(block.height_m);
            greatest = greatest.max(block.height_m);
        }
        (greatest - least).max(0.0)
    }
}

/// Row, time and metres of every altitude of the sensor that shows heights best: the barometer, if there is one that is not stuck.
pub(super) fn altitudes(flight: &Flight) -> Option<(Vec<Sample>, Heights)> {
    let of = |column: Option<&Column>, metres: &dyn Fn(f32) -> Option<f32>| -> Vec<Sample> {
        let samples = column.into_iter().flat_map(Column::samples);
        samples
            .filter_map(|(row, value)| Some((row, *flight.time_s.get(row)?, f64::from(metres(value)?))))
            .filter(|(_, _, metres)| metres.is_finite())
            .collect()
    };
    let own = |value: f32| Some(value);
    let mut barometer = of(flight.channel(Channel::BaroPa), &pressure_altitude_m);
    if barometer.is_empty() {
        barometer = of(flight.channel(Channel::BaroAltM), &own);
    }
    let receiver = of(flight.channel(Channel::GpsAltM), &own);
    let is_stuck = spread_m(&barometer) < STUCK_SHARE * spread_m(&receiver);
    // One with samples in a part of the log only would hide the rest of it.
    let reaches = |one: &[Sample], other: &[Sample]| match (ends_s(one), ends_s(other)) {
        (Some(one), Some(other)) => one.1 - one.0 >= 0.9 * (other.1 - other.0),
        (one, _) => one.is_some(),
    };
    if !is_stuck && reaches(&barometer, &receiver) {
        Some((barometer, Heights::Barometer))
    } else if !receiver.is_empty() {
        Some((receiver, Heights::Receiver))
    } else {
        (!barometer.is_empty()).then_some((barometer, Heights::Barometer))
    }
}

fn ends_s(samples: &[Sample]) -> Option<(f64, f64)> {
    Some((samples.first()?.1, samples.last()?.1))
}

/// Between the tenth and the last tenth of the values.
fn spread_m(samples: &[Sample]) -> f64 {
    let mut metres: Vec<f64> = samples.iter().map(|(_, _, metres)| *metres).collect();
    metres.sort_by(f64::total_cmp);
    let at = |share: usize| metres.get(metres.len() * share / 10).copied().unwrap_or(0.0);
    if metres.is_empty() { 0.0 } else { at(9) - at(1) }
}

/// Median time between samples, seconds; 0 for fewer than two.
pub(super) fn median_interval_s(times_s: Vec<f64>) -> f64 {
    let pairs = times_s.iter().zip(times_s.iter().skip(1));
    let mut intervals: Vec<f64> = pairs.map(|(one, next)| next - one).filter(|s| *s > 0.0).collect();
    median(&mut intervals).unwrap_or(0.0)
}

pub(super) fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len().checked_sub(1)? / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Rows becoming blocks.
#[derive(Default)]
struct Gatherer {
    length_s: f64,
    origin_s: Option<f64>,
    index: u64,
    heights_m: Vec<f64>,
    speeds_mps: Vec<f64>,
    velocities_mps: [Vec<f64>; 2],
    airspeeds_mps: Vec<f64>,
    place_m: [f64; 2],
    leg: usize,
    blocks: Vec<Block>,
}

impl Gatherer {
    fn take(&mut self, row: &Row) {
        let origin_s = *self.origin_s.get_or_insert(row.time_s);
        let index = ((row.time_s - origin_s) / self.length_s) as u64;
        if index != self.index {
            self.close();
            self.index = index;
        }
        self.heights_m.extend(row.height_m);
        self.airspeeds_mps.extend(row.airspeed_mps);
        if let Some([north, east]) = row.velocity_mps {
            self.speeds_mps.push(libm::hypot(north, east));
            self.velocities_mps[0].push(north);
            self.velocities_mps[1].push(east);
        }
    }

    fn close(&mut self) {
        let time_s = self.origin_s.unwrap_or(0.0) + self.index as f64 * self.length_s;
        let speed = median(&mut self.speeds_mps);
        let velocity = self.velocities_mps.each_mut().map(|values| median(values));
        let airspeed = median(&mut self.airspeeds_mps).filter(|speed| *speed >= WIND_MPS);
        if let Some(height_m) = median(&mut self.heights_m) {
            let before = self.blocks.last();
            let elapsed_s = before.map_or(0.0, |before| time_s - before.time_s);
            match velocity {
                [Some(north), Some(east)] if elapsed_s <= GAP_BLOCKS * self.length_s => {
                    self.place_m[0] += north * elapsed_s;
                    self.place_m[1] += east * elapsed_s;
                }
                _ => self.leg += 1,
            }
            self.blocks.push(Block {
                time_s,
                height_m,
                speed_mps: speed.or(airspeed),
                place_m: self.place_m,
                leg: self.leg,
            });
        }
        self.heights_m.clear();
        self.speeds_mps.clear();
        self.airspeeds_mps.clear();
        self.velocities_mps.iter_mut().for_each(Vec::clear);
    }

    fn finish(mut self) -> Vec<Block> {
        self.close();
        self.blocks
    }
}

/// Height and speed of each block as the median of three: where a block has only two samples, one wild one would be half of it.
fn smoothed(blocks: Vec<Block>) -> Vec<Block> {
    let of = |place: usize, value: &dyn Fn(&Block) -> Option<f64>| {
        let around = blocks.get(place.saturating_sub(1)..(place + 2).min(blocks.len())).unwrap_or_default();
        let mut values: Vec<f64> = around.iter().filter_map(value).collect();
        // At the ends there are two: the block's own.
        if values.len() == 3 { median(&mut values) } else { None }
    };
    let smooth = |(place, block): (usize, &Block)| Block {
        height_m: of(place, &|block| Some(block.height_m)).unwrap_or(block.height_m),
        speed_mps: block.speed_mps.map(|own| of(place, &|block| block.speed_mps).unwrap_or(own)),
        ..*block
    };
    blocks.iter().enumerate().map(smooth).collect()
}
