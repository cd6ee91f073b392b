//! Groups blocks into flight and standing, and finds the transitions between them.

use std::ops::Range;

use super::AirborneInterval;
use super::blocks::{Block, Blocks, median};

/// Least speed that counts as fast, m/s: nobody walks or runs faster with a parked vehicle. It is the 15 km/h
/// by which scoring programs detect a flight.
const FAST_MPS: f64 = 4.0;
/// Largest speed of a standing vehicle, m/s: the noise of a receiver's velocity, or a pilot who walks.
const SLOW_MPS: f64 = 2.0;
/// Height is compared within this time before and after a block, seconds.
const NEAR_S: f64 = 5.0;
/// The same for a fast block, which may be level for a moment, seconds.
const WIDE_S: f64 = 15.0;
/// Least standing that separates two flights, seconds: a paraglider may stand still in the wind for less.
const STANDING_S: f64 = 60.0;
/// The same at the height of another stand, seconds: a copter that lands where it took off.
const STANDING_AGAIN_S: f64 = 10.0;
/// The same at the log's beginning and end, seconds: recorders begin shortly before the take-off.
pub const EDGE_S: f64 = 3.0;
/// The same without a speed, seconds: only its length distinguishes it from level flight.
const STANDING_WITHOUT_SPEED_S: f64 = 60.0;
/// The ground's height is the median over this much standing, seconds.
const GROUND_S: f64 = 30.0;
/// A flight is fast for this long, or off the ground for [`OFF_GROUND_S`], seconds; else it was a bump of the
/// sensor or a taxi.
const FAST_S: f64 = 10.0;
/// See [`FAST_S`], seconds.
const OFF_GROUND_S: f64 = 15.0;
/// After a gap of this length nothing is assumed about what was before, seconds.
const LOST_S: f64 = 600.0;
/// Steepest ground, metres a metre (45 degrees): if the vehicle was lower than that nearby, there is air
/// below.
const STEEPEST: f64 = 1.0;
/// A hover lower than this is not distinguished from the drift of a parked barometer, metres.
const LEAST_HOVER_M: f64 = 4.0;
/// Air below a hover is looked for within this time before and after it, seconds: later, the velocity's drift
/// has moved the place.
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
    // The pieces between stands, before the first and after the last, split at long gaps.
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
    // Twice the tolerance within ten seconds: only stairs would do that on the ground.
    let climbs = near_m > 2.0 * tolerance_m;
    if climbs
        || (is_fast && wide_m > 1.5 * tolerance_m)
        || (block.speed_mps.is_none() && wide_m > 2.5 * tolerance_m)
    {
        return Kind::Flying;
    }
    // A block beside a climb stands if its other side is level.
    let sides_m = [blocks.range_m(at_s - near_s, at_s), blocks.range_m(at_s, at_s + near_s)];
    let still_m = sides_m.into_iter().fold(f64::INFINITY, f64::min);
    let is_slow = block.speed_mps.is_none_or(|speed| speed <= SLOW_MPS);
    if is_slow && still_m <= 1.5 * tolerance_m { Kind::Standing } else { Kind::Unclear }
}

/// The stretches that last long enough to be standing on the ground.
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
            // No log begins or ends with a hover of a minute; but a parked barometer drifts, and jumps when a
            // cockpit is opened.
            false
        } else if run.has_speed {
            is_above_air(blocks, &run) || hover.as_ref().is_some_and(|hover| hovers_on(blocks, hover, &run))
        } else {
            // Without a speed there is no place either: a high stretch in the middle of a log is level
            // flight.
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
    /// How long it must be to separate two flights, seconds.
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

/// Runs of standing blocks without gaps; a single unclear block between two runs does not split them.
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

/// Whether the vehicle was lower nearby, shortly before or after, by so much that there is air below.
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

/// Whether a vehicle that hovered still hovers: it has not been lower meanwhile, as it must be to land.
fn hovers_on(blocks: &Blocks, hover: &Run, run: &Run) -> bool {
    let between = blocks.blocks.get(hover.range.end..run.range.end).unwrap_or_default();
    let least_m = hover.height_m - 2.0 * blocks.tolerance_m;
    let is_soon = between.first().zip(between.last()).is_some_and(|(a, b)| b.time_s - a.time_s < LOST_S);
    is_soon && between.iter().all(|block| block.height_m > least_m)
}

/// Height of the ground of a stand, from its first or its last moments.
fn ground_m(blocks: &Blocks, stand: &Range<usize>, at_beginning: bool) -> f64 {
    let count = ((GROUND_S / blocks.length_s) as usize).max(1);
    let all = blocks.blocks.get(stand.clone()).unwrap_or_default();
    let heights = all.iter().map(|block| block.height_m);
    let mut heights: Vec<f64> =
        if at_beginning { heights.take(count).collect() } else { heights.rev().take(count).collect() };
    median(&mut heights).unwrap_or(0.0)
}

/// Splits a stretch where a long gap leaves it unknown what happened.
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

/// The flight between two stands, or between one and the log's end, if there is enough motion for one.
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

#[cfg(test)]
mod tests {
    use super::super::blocks::Heights;
    use super::*;

    /// The clock's time when the log begins, seconds.
    const START_S: f64 = 1_000.0;
    /// Smallest significant change of a receiver's height, metres.
    const TOLERANCE_M: f64 = 6.0;

    /// Blocks of some seconds at the receiver's tolerance, each with a height and a speed.
    fn log(length_s: f64, course: impl Iterator<Item = (f64, Option<f64>)>) -> Blocks {
        let block = |(place, (height_m, speed_mps)): (usize, (f64, Option<f64>))| Block {
            time_s: START_S + place as f64 * length_s,
            height_m,
            speed_mps,
            place_m: [0.0; 2],
            leg: 0,
        };
        let blocks = course.enumerate().map(block).collect();
        Blocks { blocks, length_s, heights: Heights::Receiver, tolerance_m: TOLERANCE_M }
    }

    /// This many blocks, each at a height and a speed.
    fn stretches(length_s: f64, parts: &[(usize, f64, Option<f64>)]) -> Blocks {
        log(length_s, parts.iter().flat_map(|(count, height_m, speed)| vec![(*height_m, *speed); *count]))
    }

    /// The kind of the block in the middle of 101 seconds, whose height is a function of the seconds since
    /// it.
    fn middle(speed_mps: Option<f64>, height_m: impl Fn(i32) -> f64) -> Kind {
        let blocks = log(1.0, (-50..=50).map(|since_s| (height_m(since_s), speed_mps)));
        kind(&blocks, &blocks.blocks[50])
    }

    /// A height that rises by this much after some seconds.
    fn step(after_s: i32, rise_m: f64) -> impl Fn(i32) -> f64 {
        move |since_s| if since_s > after_s { 200.0 + rise_m } else { 200.0 }
    }

    /// It flies if its height changes by two tolerances within ten seconds at any speed, by one and a half
    /// within thirty at a speed that nobody walks at, or by two and a half where no speed is known; no less.
    #[test]
    fn flight_moves_by_more_than_its_tolerance_in_height() {
        let is_flying = |speed_mps, after_s, rise_m| middle(speed_mps, step(after_s, rise_m)) == Kind::Flying;
        for after_s in [-4, 3] {
            assert!(is_flying(Some(1.0), after_s, 12.5) && !is_flying(Some(1.0), after_s, 12.0));
        }
        for after_s in [-10, 10] {
            assert!(is_flying(Some(5.0), after_s, 9.5) && !is_flying(Some(5.0), after_s, 9.0));
            assert!(!is_flying(Some(4.0), after_s, 9.5), "a speed that a runner has");
            assert!(is_flying(None, after_s, 15.5) && !is_flying(None, after_s, 15.0));
        }
        // More than fifteen seconds away does not matter.
        assert!(!is_flying(Some(5.0), -20, 100.0) && !is_flying(None, 20, 100.0));
    }

    /// It stands where it is slow and its height stayed within one and a half tolerances for five seconds
    /// before or after.
    #[test]
    fn standing_is_slow_and_level_on_one_side_at_least() {
        let is_standing =
            |speed_mps, height_m: &dyn Fn(i32) -> f64| middle(speed_mps, height_m) == Kind::Standing;
        let valley = |depth_m: f64| move |since_s: i32| if since_s == 0 { 0.0 } else { depth_m };
        assert!(is_standing(Some(1.0), &valley(8.5)) && !is_standing(Some(1.0), &valley(10.0)));
        assert!(!is_standing(Some(3.0), &valley(0.0)), "walking is not standing");
        // Ten metres within the five seconds after it and none in those before, or the reverse. What was long
        // ago does not matter.
        let before = |since_s: i32| if since_s < -30 { 40.0 } else { step(2, 10.0)(since_s) };
        let after = |since_s: i32| if since_s > 30 { 40.0 } else { step(-3, 10.0)(since_s) };
        assert!(is_standing(Some(1.0), &before) && is_standing(None, &after));
    }

    /// One unclear block does not split a run of standing; two do, and so does one of flight or a gap in the
    /// log.
    #[test]
    fn a_run_of_standing_bridges_one_unclear_block_and_no_gap() {
        use Kind::{Flying, Standing, Unclear};
        let mut blocks = stretches(1.0, &[(6, 200.0, Some(0.0))]);
        assert_eq!(runs(&blocks, &[Standing, Unclear, Standing]).as_slice(), std::slice::from_ref(&(0..3)));
        assert_eq!(runs(&blocks, &[Standing, Flying, Standing]), [0..1, 2..3]);
        assert_eq!(runs(&blocks, &[Standing, Unclear, Unclear, Standing]), [0..1, 3..4]);
        blocks.blocks[2..].iter_mut().for_each(|block| block.time_s += 100.0);
        assert_eq!(runs(&blocks, &[Standing; 6]), [0..2, 2..6]);
    }

    /// The times of the flights of a log, seconds since its beginning.
    fn flights(blocks: &Blocks) -> Vec<(Option<f64>, Option<f64>)> {
        let since = |time_s: Option<f64>| time_s.map(|time_s| time_s - START_S);
        airborne(blocks).iter().map(|found| (since(found.take_off_s), since(found.landing_s))).collect()
    }

    /// Twenty seconds on the ground are a landing at the height of another stand, within two tolerances, and
    /// not elsewhere.
    #[test]
    fn a_short_stand_is_a_landing_where_the_ground_is_known() {
        let with_stand = |height_m| {
            let parked = (60, 200.0, Some(0.0));
            let aloft = (60, 300.0, Some(10.0));
            stretches(1.0, &[parked, aloft, (20, height_m, Some(0.0)), aloft, parked])
        };
        assert_eq!(flights(&with_stand(210.0)).len(), 2);
        assert_eq!(flights(&with_stand(213.0)).len(), 1);
    }

    /// Standing in the air for a minute and a half, where the vehicle was lower at the same place, is a hover
    /// and no landing. At the end of a log twenty seconds are enough. After minutes of hovering, with nothing
    /// lower recorded nearby any more, it still hovers.
    #[test]
    fn a_hover_parts_no_flight() {
        let parked = (60, 200.0, Some(0.0));
        let hover = |seconds| (seconds, 250.0, Some(0.5));
        let moving = |seconds| (seconds, 300.0, Some(10.0));
        let blocks = stretches(1.0, &[parked, hover(90), moving(30), hover(90), parked]);
        assert_eq!(flights(&blocks), [(Some(60.0), Some(270.0))]);
        assert_eq!(flights(&stretches(1.0, &[parked, moving(30), hover(20)])), [(Some(60.0), None)]);
        let blocks = stretches(1.0, &[parked, hover(90), moving(100), hover(90), moving(200), parked]);
        assert_eq!(flights(&blocks), [(Some(60.0), Some(540.0))]);
    }

    /// Without a speed, a minute at one height is ground within five tolerances of the lowest height, and
    /// level flight above.
    #[test]
    fn without_a_speed_what_is_high_is_level_flight() {
        let over = |height_m| {
            let (low, aloft) = ((90, 0.0, None), (60, 300.0, None));
            let climbing = |up: bool| {
                (0..60).map(move |k| if up { 5.0 * f64::from(k) } else { 300.0 - 5.0 * f64::from(k) })
            };
            let climb = |up| climbing(up).map(|height_m| (1, height_m, None)).collect::<Vec<_>>();
            let parts = [vec![low], climb(true), vec![aloft], climb(false), vec![(120, height_m, None)]];
            let back = [climb(true), vec![aloft], climb(false), vec![low]];
            flights(&stretches(1.0, &parts.into_iter().chain(back).flatten().collect::<Vec<_>>())).len()
        };
        assert_eq!([20.0, 30.0, 31.0, 100.0].map(over), [2, 2, 1, 1]);
    }

    /// A run of ten blocks at a height and place, after a block elsewhere that is `before_s` earlier and
    /// before one that is `after_s` later.
    fn above(height_m: f64, before: (f64, f64), after: (f64, f64)) -> (Blocks, Run) {
        let mut blocks = stretches(1.0, &[(12, height_m, Some(0.0))]);
        for (place, (seconds, lower_m), direction) in [(0, before, -1.0), (11, after, 1.0)] {
            let beside = if place == 0 { 1 } else { 10 };
            blocks.blocks[place].time_s = blocks.blocks[beside].time_s + direction * seconds;
            blocks.blocks[place].height_m = lower_m;
        }
        let run = Run::new(&blocks, 1..11).unwrap();
        (blocks, run)
    }

    /// There is air below if the vehicle was lower by more than two tolerances at the same place within three
    /// minutes before or after.
    #[test]
    fn air_is_below_where_it_was_lower_shortly_before_or_after() {
        let is_up = |before, after| {
            let (blocks, run) = above(513.0, before, after);
            is_above_air(&blocks, &run)
        };
        assert!(is_up((100.0, 500.0), (100.0, 513.0)) && is_up((100.0, 513.0), (100.0, 500.0)));
        assert!(!is_up((100.0, 501.0), (100.0, 501.0)), "two tolerances lower");
        assert!(!is_up((180.0, 400.0), (180.0, 400.0)), "three minutes away");
        assert!(!is_up((200.0, 400.0), (200.0, 400.0)));
        // A log that ends with the run.
        let (blocks, _) = above(513.0, (10.0, 500.0), (10.0, 513.0));
        assert!(is_above_air(&blocks, &Run::new(&blocks, 1..12).unwrap()));
    }

    /// Ground may rise by a metre a metre: 500 m away, 500 m and two tolerances lower is a mountain's side.
    /// The place of another leg is not known.
    #[test]
    fn what_is_lower_far_away_is_ground_that_slopes() {
        let is_up = |height_m: f64, leg| {
            let (mut blocks, _) = above(height_m, (10.0, 100.0), (10.0, height_m));
            for block in &mut blocks.blocks {
                block.place_m = [600.0, 800.0];
            }
            blocks.blocks[0].place_m = [300.0, 400.0];
            blocks.blocks[0].leg = leg;
            is_above_air(&blocks, &Run::new(&blocks, 1..11).unwrap())
        };
        assert!(!is_up(612.0, 0) && is_up(612.5, 0));
        assert!(!is_up(612.5, 1));
    }

    /// It still hovers while it stays above two tolerances below the hover, within ten minutes.
    #[test]
    fn a_hover_goes_on_until_it_has_been_lower() {
        let goes_on = |lowest_m, seconds: f64| {
            let mut blocks =
                stretches(1.0, &[(10, 200.0, Some(0.0)), (10, lowest_m, Some(5.0)), (10, 200.0, Some(0.0))]);
            blocks.blocks[29].time_s = blocks.blocks[10].time_s + seconds;
            let (hover, run) = (Run::new(&blocks, 0..10).unwrap(), Run::new(&blocks, 20..30).unwrap());
            hovers_on(&blocks, &hover, &run)
        };
        assert!(goes_on(190.0, 100.0) && goes_on(250.0, 599.0));
        assert!(!goes_on(188.0, 100.0) && !goes_on(187.0, 100.0));
        assert!(!goes_on(200.0, 600.0) && !goes_on(200.0, 700.0));
    }

    /// The ground's height is the median of half a minute at the stand's beginning or end, whatever the block
    /// length.
    #[test]
    fn the_height_of_the_ground_is_that_of_half_a_minute() {
        let blocks = log(2.0, (0..100).map(|place| (f64::from(place), Some(0.0))));
        assert_eq!(ground_m(&blocks, &(0..100), true), 7.0);
        assert_eq!(ground_m(&blocks, &(0..100), false), 92.0);
    }

    /// Nothing is assumed across more than ten minutes without a block.
    #[test]
    fn ten_minutes_of_nothing_part_a_stretch() {
        let mut blocks = stretches(1.0, &[(10, 200.0, None)]).blocks;
        blocks[4..].iter_mut().for_each(|block| block.time_s += 599.0);
        assert_eq!(parted(&blocks, 1..9).as_slice(), std::slice::from_ref(&(1..9)), "600 s");
        blocks[4..].iter_mut().for_each(|block| block.time_s += 1.0);
        assert_eq!(parted(&blocks, 1..9), [1..4, 4..9], "601 s");
    }

    /// A stretch is a flight if it is fast for ten seconds, or off the ground by more than two tolerances for
    /// fifteen. It begins and ends where it leaves the ground by more than one tolerance.
    #[test]
    fn a_flight_is_long_enough_off_the_ground_or_fast() {
        let of = |length_s: f64, count: usize, height_m: f64, speed_mps: f64| {
            let ground = (20, 300.0, Some(0.0));
            let blocks = stretches(length_s, &[ground, (count, height_m, Some(speed_mps)), ground]);
            let kinds: Vec<Kind> = blocks
                .blocks
                .iter()
                .map(|block| if block.speed_mps == Some(0.0) { Kind::Standing } else { Kind::Flying })
                .collect();
            let stands = [0..20, 20 + count..40 + count];
            interval(&blocks, &kinds, 20..20 + count, [Some(&stands[0]), Some(&stands[1])], None)
        };
        assert!(of(1.0, 60, 312.0, 1.0).is_none(), "a sensor's bump of two tolerances");
        assert!(of(1.0, 60, 313.0, 1.0).is_some() && of(1.0, 60, 287.0, 1.0).is_some());
        assert!(of(2.0, 8, 313.0, 1.0).is_some() && of(2.0, 7, 313.0, 1.0).is_none());
        assert!(of(1.0, 60, 306.0, 4.0).is_none() && of(1.0, 60, 306.0, 4.5).is_some());
        // Within one tolerance it has not left the ground; where it never leaves it, all of it counts.
        let ground = (20, 300.0, Some(0.0));
        let roll = (10, 306.0, Some(8.0));
        let blocks = stretches(1.0, &[ground, roll, (30, 330.0, Some(8.0)), roll, (90, 300.0, Some(0.0))]);
        assert_eq!(flights(&blocks), [(Some(30.0), Some(60.0))]);
    }

    /// A flight that continues to the log's end was in the air until its last block's end.
    #[test]
    fn a_flight_that_does_not_land_ends_with_the_log() {
        let blocks = stretches(2.0, &[(40, 200.0, Some(0.0)), (20, 300.0, Some(10.0))]);
        let [found] = airborne(&blocks)[..] else { panic!("one flight") };
        assert_eq!((found.take_off_s, found.landing_s), (Some(1_080.0), None));
        assert_eq!((found.from_s, found.to_s, found.ground_from_s), (1_080.0, 1_120.0, Some(1_000.0)));
    }
}
