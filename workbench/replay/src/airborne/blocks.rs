//! A flight in blocks of some seconds: height, speed and place.

use kf_core::atmosphere::pressure_altitude_m;

use flight_data::{Channel, Column, Flight};

/// Shortest block, seconds.
const SHORTEST_S: f64 = 1.0;
/// Least number of fixes in a block, so that one wild fix is not its median.
const FIXES_A_BLOCK: f64 = 2.5;
/// Least airspeed that counts as flight, m/s: a lower one may be wind on a parked aircraft.
const WIND_MPS: f64 = 8.0;
/// A barometer that moves less than this share of the receiver's range is stuck and is not used.
const STUCK_SHARE: f64 = 0.2;
/// Blocks farther apart than this many block lengths have a gap between them, in which the vehicle's motion
/// is unknown.
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
    /// Name for users.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Barometer => "barometer",
            Self::Receiver => "receiver",
        }
    }
}

/// Smallest significant change of height for a barometer in whole metres, metres: two of its steps.
const WHOLE_METRES_M: f64 = 2.0;
/// The same for a barometer that resolves decimetres: gusts and propellers move it by half of that.
const FINE_M: f64 = 1.0;
/// The same for a receiver: three times the 2 m by which its altitude wanders within half a minute.
const RECEIVER_M: f64 = 6.0;

/// One block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Block {
    /// Its beginning, seconds.
    pub(super) time_s: f64,
    /// Median height, metres.
    pub(super) height_m: f64,
    /// Median speed, m/s; `None` without a source of speed.
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
    /// Smallest significant change of height, metres.
    pub(super) tolerance_m: f64,
}

/// Row, time in seconds and altitude in metres.
pub(super) type Sample = (usize, f64, f64);

/// The cells of one row that are used.
struct Row {
    time_s: f64,
    height_m: Option<f64>,
    velocity_mps: Option<[f64; 2]>,
    airspeed_mps: Option<f64>,
}

impl Blocks {
    /// Blocks of a flight; `None` without an altitude.
    pub(super) fn new(flight: &Flight) -> Option<Self> {
        let (altitudes, heights) = altitudes(flight)?;
        let times = |samples: &[Sample]| samples.iter().map(|(_, time_s, _)| *time_s).collect();
        let speeds =
            [Channel::GpsVnMps, Channel::TasMps].into_iter().find_map(|channel| flight.channel(channel));
        let speeds = speeds.into_iter().flat_map(Column::samples);
        let speeds: Vec<f64> = speeds.filter_map(|(row, _)| flight.time_s.get(row).copied()).collect();
        // A longer block is more useful than one without a speed.
        let interval_s = median_interval_s(times(&altitudes)).max(median_interval_s(speeds));
        let length_s = SHORTEST_S.max(FIXES_A_BLOCK * interval_s);
        let is_whole = |(_, _, metres): &&Sample| metres.fract() == 0.0;
        let tolerance_m = match heights {
            Heights::Receiver => RECEIVER_M,
            // Zeros also occur among decimetres, so more than half must be whole.
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
            // Rows that run back in time are left out, as in the estimator.
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

    /// Range of heights of the blocks from one time to another, metres.
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

/// Row, time and metres of every altitude of the best source of height: the barometer, unless it is missing
/// or stuck.
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
    // A barometer with samples in only part of the log would hide the rest of it.
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

/// Range from the lowest to the highest tenth of the values.
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

/// Collects rows into blocks.
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

/// Takes the median of three blocks' heights and speeds: with only two samples in a block, one wild sample
/// would be half of it.
fn smoothed(blocks: Vec<Block>) -> Vec<Block> {
    let of = |place: usize, value: &dyn Fn(&Block) -> Option<f64>| {
        let around = blocks.get(place.saturating_sub(1)..(place + 2).min(blocks.len())).unwrap_or_default();
        let mut values: Vec<f64> = around.iter().filter_map(value).collect();
        // At the ends there are only two: the block keeps its own value.
        if values.len() == 3 { median(&mut values) } else { None }
    };
    let smooth = |(place, block): (usize, &Block)| Block {
        height_m: of(place, &|block| Some(block.height_m)).unwrap_or(block.height_m),
        speed_mps: block.speed_mps.map(|own| of(place, &|block| block.speed_mps).unwrap_or(own)),
        ..*block
    };
    blocks.iter().enumerate().map(smooth).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column with the given cell in each row.
    fn column(rows: usize, cell: impl Fn(usize) -> Option<f32>) -> Column {
        let mut column = Column::default();
        (0..rows).for_each(|row| column.push(cell(row)));
        column
    }

    /// A minute and a half at one row a second, on a clock that begins at 1,000 s. The vehicle climbs at
    /// 1 m/s and moves by 3 m/s north and 4 m/s east.
    fn straight() -> Flight {
        let height = |row: usize| Some(500.0 + row as f32);
        Flight {
            time_s: (0..90).map(|row| 1_000.0 + f64::from(row)).collect(),
            channels: vec![
                (Channel::BaroAltM, column(90, height)),
                (Channel::GpsVnMps, column(90, |_| Some(3.0))),
                (Channel::GpsVeMps, column(90, |_| Some(4.0))),
            ],
            ..Flight::default()
        }
    }

    /// A block lasts two and a half fixes, begins at a multiple of that from the log's first row, and its
    /// place follows the velocity: 3 m north and 4 m east a second.
    #[test]
    fn the_place_is_the_velocity_times_the_time() {
        let found = Blocks::new(&straight()).unwrap();
        assert_eq!((found.length_s, found.blocks.len(), found.has_speed()), (2.5, 36, true));
        for (place, block) in found.blocks.iter().enumerate() {
            let since_s = 2.5 * place as f64;
            assert_eq!(block.time_s, 1_000.0 + since_s);
            assert_eq!(block.place_m, [3.0 * since_s, 4.0 * since_s]);
            assert_eq!((block.speed_mps, block.leg), (Some(5.0), 0));
            // Of two or three rows in a block, one metre apart.
            assert!((block.height_m - 500.0 - since_s).abs() <= 1.5, "{block:?}");
        }
    }

    /// Four blocks without a height are no gap: the velocity is taken to have continued. After a longer one a
    /// new leg begins, at the place where the last one ended.
    #[test]
    fn a_gap_of_more_than_four_blocks_begins_another_leg() {
        let with_gap = |lost: std::ops::Range<usize>| {
            let mut flight = straight();
            for (_, column) in &mut flight.channels {
                for row in lost.clone() {
                    column.set(row, None);
                }
            }
            Blocks::new(&flight).unwrap()
        };
        // Rows 20 to 27 are the blocks from 20 s to 27.5 s: the next one is 10 s after the last.
        let short = with_gap(20..28);
        let last = short.blocks.last().unwrap();
        assert_eq!((last.leg, last.place_m), (0, [3.0 * 87.5, 4.0 * 87.5]));
        assert!(short.blocks.windows(2).all(|pair| !short.is_gap(&pair[0], &pair[1])));
        let long = with_gap(20..30);
        let last = long.blocks.last().unwrap();
        // From 17.5 s to 30 s its motion is unknown.
        assert_eq!((last.leg, last.place_m), (1, [3.0 * 75.0, 4.0 * 75.0]));
        assert_eq!(long.blocks.windows(2).filter(|pair| long.is_gap(&pair[0], &pair[1])).count(), 1);
    }

    /// Blocks farther apart than four of their lengths have a gap between them, whatever the length.
    #[test]
    fn a_gap_is_more_than_four_lengths() {
        let mut found = Blocks::new(&straight()).unwrap();
        let [first, mut next] = [found.blocks[0], found.blocks[1]];
        for length_s in [1.0, 2.0, 5.0] {
            found.length_s = length_s;
            next.time_s = first.time_s + 4.0 * length_s;
            assert!(!found.is_gap(&first, &next), "{length_s}");
            next.time_s += 0.5;
            assert!(found.is_gap(&first, &next), "{length_s}");
        }
    }

    /// The range of heights is that of the blocks between the two times, both included.
    #[test]
    fn a_range_of_heights_has_its_ends_in_it() {
        let mut found = Blocks::new(&straight()).unwrap();
        for (place, block) in found.blocks.iter_mut().enumerate() {
            block.height_m = (place * place) as f64;
        }
        assert_eq!(found.range_m(1_005.0, 1_010.0), 16.0 - 4.0);
        assert_eq!(found.range_m(1_005.5, 1_009.5), 0.0, "one block");
        assert_eq!(found.range_m(1_005.5, 1_006.0), 0.0, "none");
    }

    /// Without a receiver the airspeed is used, from 8 m/s on: less may be wind on a parked aircraft. Without
    /// either there is no speed.
    #[test]
    fn an_airspeed_stands_in_from_the_speed_of_the_wind_on() {
        let with = |airspeed_mps: Option<f32>| {
            let mut flight = straight();
            flight.channels.truncate(1);
            flight.channels.extend(airspeed_mps.map(|mps| (Channel::TasMps, column(90, |_| Some(mps)))));
            Blocks::new(&flight).unwrap()
        };
        assert_eq!(with(Some(20.0)).blocks[7].speed_mps, Some(20.0));
        assert_eq!(with(Some(8.0)).blocks[7].speed_mps, Some(8.0));
        assert_eq!(with(Some(5.0)).blocks[7].speed_mps, None);
        assert!(!with(Some(5.0)).has_speed() && !with(None).has_speed());
    }

    /// A single wild block between two others takes the height and the speed of one of these; the blocks at
    /// the ends keep their own.
    #[test]
    fn a_wild_block_is_smoothed_away() {
        let with_wild = |wild: usize| {
            let block = |place: usize| Block {
                time_s: place as f64,
                height_m: if place == wild { 900.0 } else { place as f64 },
                speed_mps: Some(if place == wild { 300.0 } else { 10.0 }),
                place_m: [0.0; 2],
                leg: 0,
            };
            let told = |block: &Block| (block.height_m, block.speed_mps);
            smoothed((0..6).map(block).collect()).iter().map(told).collect::<Vec<_>>()
        };
        for wild in 1..5 {
            let told = with_wild(wild);
            assert!(told.iter().all(|(height_m, speed)| *height_m < 6.0 && *speed == Some(10.0)), "{told:?}");
        }
        assert_eq!(with_wild(0)[0], (900.0, Some(300.0)));
    }

    /// The middle of the sorted values; of two, the lower one.
    #[test]
    fn a_median_is_the_middle_of_the_sorted() {
        assert_eq!(median(&mut [5.0, 1.0, 3.0, 2.0, 4.0]), Some(3.0));
        assert_eq!(median(&mut [5.0, 1.0, 3.0, 2.0, 4.0, 6.0]), Some(3.0));
        assert_eq!(median(&mut [7.0, 9.0]), Some(7.0));
        assert_eq!(median(&mut []), None);
    }

    /// Rows that repeat a time are not counted as an interval.
    #[test]
    fn repeated_times_are_no_interval() {
        assert_eq!(median_interval_s(vec![0.0, 0.0, 0.0, 2.0, 4.0]), 2.0);
        assert_eq!(median_interval_s(vec![3.0]), 0.0);
    }

    /// Which sensor's heights are used for a log of 600 s whose clock begins at 1,000 s, in which the
    /// receiver climbs by 600 m.
    fn taken(barometer_m: impl Fn(usize) -> Option<f32>, receiver_m: impl Fn(usize) -> f32) -> Heights {
        let flight = Flight {
            time_s: (0..600).map(|row| 1_000.0 + f64::from(row)).collect(),
            channels: vec![
                (Channel::BaroAltM, column(600, barometer_m)),
                (Channel::GpsAltM, column(600, |row| Some(receiver_m(row)))),
            ],
            ..Flight::default()
        };
        altitudes(&flight).unwrap().1
    }

    /// The barometer's heights are used if it moves at least a fifth as much as the receiver and covers at
    /// least nine tenths of the log. At rest neither moves, which is no fault.
    #[test]
    fn a_barometer_is_taken_that_moves_and_is_there() {
        let climb_m = |row: usize| 300.0 + row as f32;
        let share = |share: f32| taken(|row| Some(300.0 + share * row as f32), climb_m);
        assert_eq!([0.1, 0.3, 1.0].map(share), [Heights::Receiver, Heights::Barometer, Heights::Barometer]);
        let part = |from: usize| taken(|row| (row >= from).then(|| climb_m(row)), climb_m);
        assert_eq!([150, 30].map(part), [Heights::Receiver, Heights::Barometer]);
        assert_eq!(taken(|_| Some(500.0), |_| 500.0), Heights::Barometer);
    }
}
