//! Which blocks are flight, which are standing, and where the one becomes the other.

use std::ops::Range;

use super::AirborneInterval;
use super::blocks::{Block, Blocks, median};

/// Faster than this nobody walks or runs with a parked vehicle, m/s: the 15 km/h by which scoring programs tell a flight.
const FAST_MPS: f64 = 4.0;
/// A vehicle that stands moves slower than this, m/s: the noise of a receiver's velocity, and a pilot who walks.
const SLOW_MPS: f64 = 2.0;
/// Height is looked at so far to either side, seconds: what happens now.
const NEAR_S: f64 = 5.0;
/// The same for what moves fast, which may be level for a moment.
const WIDE_S: f64 = 15.0;
/// Standing for less than this separates no two flights, seconds: a paraglider that stands still in the wind.
const STANDING_S: f64 = 60.0;
/// But so much is enough at the height of another stand, seconds: a copter that lands where it took off.
const STANDING_AGAIN_S: f64 = 10.0;
/// At the log's beginning and end so much is enough, seconds: recorders begin shortly before the take-off.
pub const EDGE_S: f64 = 3.0;
/// Without a speed standing must last this long: level flight looks the same, but for its length.
const STANDING_WITHOUT_SPEED_S: f64 = 60.0;
/// The ground's height is the median over so long of standing, seconds.
const GROUND_S: f64 = 30.0;
/// A flight moves fast for so long, or is off the ground for [`OFF_GROUND_S`]; else it was a bump of the sensor, or a taxi.
const FAST_S: f64 = 10.0;
/// See [`FAST_S`], seconds.
const OFF_GROUND_S: f64 = 15.0;
/// After a gap of this length nothing is known of what was before, seconds.
const LOST_S: f64 = 600.0;
/// Ground rises by no more than this a metre (45 degrees): lower nearby than that is air below.
const STEEPEST: f64 = 1.0;
/// A hover lower than this is not told from the drift of a parked barometer, metres.
const LEAST_HOVER_M: f64 = 4.0;
/// Air below a hover is looked for so long before and after it, seconds: later, a velocity's drift has moved the place.
const NEARBY_S: f64 = 180.0;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Flying,
    Standing,
    Unclear,
}

/// The times in the air.
pub(super) fn airborne(blocks: &Blocks) -> Vec<AirborneInterval> {
    let all = &blocks.blocks;
    let kinds: Vec<Kind> = all.iter().map(|block| kind(blocks, block)).collect();
    let stands = grounds(blocks, &kinds);
    // What lies between two stands, or beyond the first and the last, and what a long gap parts.
    let mut bounds: Vec<Range<usize>> = Vec::new();
    let mut from = 0;
    for stand in &stands {
        bounds.push(from..stand.start);
        from = stand.end;
    }
    bounds.push(from..all.len());
    let pieces = bounds.into_iter().flat_map(|range| parted(all, range));
    let mut found: Vec<AirborneInterval> = Vec::new();
    for piece in pieces {
        let before = stands.iter().find(|stand| stand.end == piece.start);
        let after = stands.iter().find(|stand| stand.start == piece.end);
        let landed_s = found.last().and_then(|interval| interval.landing_s);
        if let Some(interval) = interval(blocks, &kinds, piece, [before, after], landed_s) {
            found.push(interval);
        }
    }
    found
}

fn kind(blocks: &Blocks, block: &Block) -> Kind {
    let tolerance_m = blocks.tolerance_m;
    let (near_s, wide_s) = (NEAR_S.max(blocks.length_s), WIDE_S.max(blocks.length_s));
    let at_s = block.time_s;
    let near_m = blocks.range_m(at_s - near_s, at_s + near_s);
    let wide_m = blocks.range_m(at_s - wide_s, at_s + wide_s);
    let is_fast = block.speed_mps.is_some_and(|speed| speed > FAST_MPS);
    // Twice the tolerance within ten seconds: on the ground that would be stairs.
    let climbs = near_m > 2.0 * tolerance_m;
    if climbs
        || (is_fast && wide_m > 1.5 * tolerance_m)
        || (block.speed_mps.is_none() && wide_m > 2.5 * tolerance_m)
    {
        return Kind::Flying;
    }
    // A block beside a climb stands if what lies before or after it does.
    let sides_m = [blocks.range_m(at_s - near_s, at_s), blocks.range_m(at_s, at_s + near_s)];
    let still_m = sides_m.into_iter().fold(f64::INFINITY, f64::min);
    let is_slow = block.speed_mps.is_none_or(|speed| speed <= SLOW_MPS);
    if is_slow && still_m <= 1.5 * tolerance_m { Kind::Standing } else { Kind::Unclear }
}

/// The stretches of standing on the ground that are long enough to say so.
fn grounds(blocks: &Blocks, kinds: &[Kind]) -> Vec<Range<usize>> {
    let runs: Vec<Run> =
        runs(blocks, kinds).into_iter().filter_map(|range| Run::new(blocks, range)).collect();
    let sure_m: Vec<f64> =
        runs.iter().filter(|run| run.seconds >= run.wanted_s).map(|run| run.height_m).collect();
    let is_known =
        |height_m: f64| sure_m.iter().any(|sure_m| (sure_m - height_m).abs() <= 2.0 * blocks.tolerance_m);
    let lowest_m = blocks.blocks.iter().map(|block| block.height_m).fold(f64::INFINITY, f64::min);
    let mut stands: Vec<Range<usize>> = Vec::new();
    let mut hover: Option<Run> = None;
    for run in runs {
        let is_again = run.has_speed && run.seconds >= STANDING_AGAIN_S && is_known(run.height_m);
        if run.seconds < run.wanted_s && !is_again {
            continue;
        }
        let is_up = if run.is_edge && run.seconds >= STANDING_S {
            // Nobody's log begins or ends with a minute's hover; but a parked barometer drifts, and leaps when a cockpit is opened.
            false
        } else if run.has_speed {
            is_above_air(blocks, &run) || hover.as_ref().is_some_and(|hover| hovers_on(blocks, hover, &run))
        } else {
            // Without a speed there is no place either: what lies high in the middle of a log is level flight.
            !run.is_edge && run.height_m > lowest_m + 5.0 * blocks.tolerance_m
        };
        if is_up {
            hover = Some(run);
        } else {
            hover = None;
            stands.push(run.range);
        }
    }
    stands
}

/// A run of standing blocks.
struct Run {
    range: Range<usize>,
    /// Height of its beginning, metres.
    height_m: f64,
    seconds: f64,
    /// How long it must be to part two flights, seconds.
    wanted_s: f64,
    has_speed: bool,
    /// Whether it is at the log's beginning or end.
    is_edge: bool,
}

impl Run {
    fn new(blocks: &Blocks, range: Range<usize>) -> Option<Self> {
        let all = &blocks.blocks;
        let (first, last) = (all.get(range.start)?, all.get(range.end.checked_sub(1)?)?);
        let is_edge = range.start == 0 || range.end == all.len();
        let has_speed = all.get(range.clone())?.iter().all(|block| block.speed_mps.is_some());
        let wanted_s = match (has_speed, is_edge) {
            (true, true) => EDGE_S,
            (true, false) => STANDING_S,
            (false, _) => STANDING_WITHOUT_SPEED_S,
        };
        let seconds = last.time_s + blocks.length_s - first.time_s;
        Some(Self { height_m: ground_m(blocks, &range, true), range, seconds, wanted_s, has_speed, is_edge })
    }
}

/// Runs of standing blocks without gaps in them; one block between two runs that is not clear does not part them.
fn runs(blocks: &Blocks, kinds: &[Kind]) -> Vec<Range<usize>> {
    let all = &blocks.blocks;
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (place, kind) in kinds.iter().enumerate() {
        if *kind != Kind::Standing {
            continue;
        }
        let follows = runs.last().is_some_and(|run| {
            let between = kinds.get(run.end..place).unwrap_or_default();
            let is_near = between.len() <= 1 && between.iter().all(|kind| *kind == Kind::Unclear);
            let (last, this) = (all.get(run.end - 1), all.get(place));
            is_near && last.zip(this).is_some_and(|(last, this)| !blocks.is_gap(last, this))
        });
        match runs.last_mut() {
            Some(run) if follows => run.end = place + 1,
            _ => runs.push(place..place + 1),
        }
    }
    runs
}

/// Whether the vehicle has been so much lower, nearby and shortly before or after, that there is air below.
fn is_above_air(blocks: &Blocks, run: &Run) -> bool {
    let all = &blocks.blocks;
    let is_below = |own: &Block, other: &Block| {
        let apart_m = libm::hypot(own.place_m[0] - other.place_m[0], own.place_m[1] - other.place_m[1]);
        own.leg == other.leg
            && run.height_m - other.height_m
                > LEAST_HOVER_M.max(2.0 * blocks.tolerance_m) + STEEPEST * apart_m
    };
    let (Some(first), Some(last)) = (all.get(run.range.start), all.get(run.range.end - 1)) else {
        return false;
    };
    let before = all.get(..run.range.start).unwrap_or_default().iter().rev();
    let after = all.get(run.range.end..).unwrap_or_default().iter();
    before.take_while(|block| first.time_s - block.time_s < NEARBY_S).any(|block| is_below(first, block))
        || after.take_while(|block| block.time_s - last.time_s < NEARBY_S).any(|block| is_below(last, block))
}

/// Whether a vehicle that hovered is hovering again: it has not been lower meanwhile, which it must be to land.
fn hovers_on(blocks: &Blocks, hover: &Run, run: &Run) -> bool {
    let between = blocks.blocks.get(hover.range.end..run.range.end).unwrap_or_default();
    let least_m = hover.height_m - 2.0 * blocks.tolerance_m;
    let is_soon = between.first().zip(between.last()).is_some_and(|(a, b)| b.time_s - a.time_s < LOST_S);
    is_soon && between.iter().all(|block| block.height_m > least_m)
}

/// Height of the ground of a stand: of its first or its last moments.
fn ground_m(blocks: &Blocks, stand: &Range<usize>, at_beginning: bool) -> f64 {
    let count = ((GROUND_S / blocks.length_s) as usize).max(1);
    let all = blocks.blocks.get(stand.clone()).unwrap_or_default();
    let heights = all.iter().map(|block| block.height_m);
    let mut heights: Vec<f64> =
        if at_beginning { heights.take(count).collect() } else { heights.rev().take(count).collect() };
    median(&mut heights).unwrap_or(0.0)
}

/// A stretch, parted where nothing is known of what happened for a long time.
fn parted(all: &[Block], range: Range<usize>) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut from = range.start;
    for place in range.start + 1..range.end {
        if let (Some(before), Some(this)) = (all.get(place - 1), all.get(place))
            && this.time_s - before.time_s > LOST_S
        {
            parts.push(from..place);
            from = place;
        }
    }
    parts.push(from..range.end);
    parts
}

/// What happened between two stands, or between one and the log's end: a flight, if there is enough of it.
fn interval(
    blocks: &Blocks,
    kinds: &[Kind],
    piece: Range<usize>,
    [before, after]: [Option<&Range<usize>>; 2],
    landed_s: Option<f64>,
) -> Option<AirborneInterval> {
    let all = &blocks.blocks;
    let flying = |place: &usize| kinds.get(*place) == Some(&Kind::Flying);
    piece.clone().find(flying)?;
    let tolerance_m = blocks.tolerance_m;
    let ground_m = [
        before.map(|stand| ground_m(blocks, stand, false)),
        after.map(|stand| ground_m(blocks, stand, true)),
    ];
    let inside = all.get(piece.clone())?;
    let off_ground = |block: &Block, times: f64| {
        ground_m.iter().flatten().all(|ground_m| (block.height_m - ground_m).abs() > times * tolerance_m)
    };
    let seconds = |count: usize| count as f64 * blocks.length_s;
    let fast = piece.clone().filter(flying).filter_map(|place| all.get(place)?.speed_mps);
    let is_flight = seconds(fast.filter(|speed| *speed > FAST_MPS).count()) >= FAST_S
        || seconds(inside.iter().filter(|block| off_ground(block, 2.0)).count()) >= OFF_GROUND_S;
    if !is_flight {
        return None;
    }
    let (first, last) = (inside.first()?, inside.last()?);
    // The roll on the runway is at the height of the ground.
    let leaves = |ground_m: f64| move |block: &&Block| (block.height_m - ground_m).abs() > tolerance_m;
    let take_off_s = ground_m[0].map(|own| inside.iter().find(leaves(own)).unwrap_or(first).time_s);
    let landing_s =
        ground_m[1].map(|own| inside.iter().rev().find(leaves(own)).unwrap_or(last).time_s + blocks.length_s);
    let log_from_s = all.first()?.time_s;
    Some(AirborneInterval {
        take_off_s,
        landing_s,
        from_s: take_off_s.unwrap_or(first.time_s),
        to_s: landing_s.unwrap_or(last.time_s + blocks.length_s),
        ground_from_s: take_off_s.map(|_| landed_s.unwrap_or(log_from_s)),
    })
}
