//! Stretches in which the reference jumped away from every sensor and came back.
//!
//! Such fixes are not measurements, and one of them weighs more in a least-squares fit than an hour of good
//! ones. A jump that persists is kept: it is a receiver's change of satellites, or an effect.

use super::reference_path::Fix;

/// A jump exceeds this many times the usual change between two fixes (robust sigma) ...
const JUMP_SIGMAS: f64 = 8.0;
/// ... and this many metres ...
const JUMP_M: f64 = 2.0;
/// ... and this many times the altitude change between two fixes by the aircraft's own acceleration.
const JUMP_ACCELERATIONS: f64 = 3.0;
/// Longest time until the reference comes back, seconds.
const LONGEST_S: f64 = 30.0;
/// How much the two edges of a glitch may differ, as a share of their size.
const EDGES_APART: f64 = 0.35;

/// Removes the fixes of glitches; returns the remaining fixes and the glitches (first and last fix,
/// microseconds).
#[must_use]
pub fn split<const S: usize>(fixes: Vec<Fix>, paths: &[Vec<(u64, f64)>; S]) -> (Vec<Fix>, Vec<(u64, u64)>) {
    let sensors: Vec<Vec<Option<f64>>> =
        paths.iter().filter(|path| !path.is_empty()).map(|path| sampled(path, &fixes)).collect();
    let jumps: Vec<Option<Jump>> = (0..fixes.len()).map(|k| jump(&fixes, &sensors, k)).collect();
    let mut sizes: Vec<f64> = jumps.iter().flatten().map(|jump| jump.metres.abs()).collect();
    if sizes.len() < 20 {
        return (fixes, Vec::new());
    }
    sizes.sort_by(f64::total_cmp);
    // The median of |x| is 0.6745 sigma for a Gaussian.
    let usual_m = sizes[sizes.len() / 2] / 0.6745;
    let is_jump = |jump: &Jump| {
        let bound = (JUMP_SIGMAS * usual_m).max(JUMP_M) + JUMP_ACCELERATIONS * jump.acceleration_m;
        jump.metres.abs() > bound
    };

    let mut glitches = Vec::new();
    let mut is_bad = vec![false; fixes.len()];
    let mut k = 1;
    while k < fixes.len() {
        let end = jumps[k].as_ref().filter(|jump| is_jump(jump)).and_then(|away| {
            (k + 1..fixes.len())
                .take_while(|m| fixes[*m].time_us - fixes[k].time_us <= (LONGEST_S * 1e6) as u64)
                .find(|m| {
                    jumps[*m].as_ref().is_some_and(|back| {
                        (back.metres + away.metres).abs() < EDGES_APART * away.metres.abs()
                    })
                })
        });
        match end {
            Some(end) => {
                is_bad[k..end].fill(true);
                glitches.push((fixes[k].time_us, fixes[end - 1].time_us));
                k = end + 1;
            }
            None => k += 1,
        }
    }
    let kept = fixes.into_iter().zip(is_bad).filter(|(_, bad)| !bad).map(|(fix, _)| fix).collect();
    (kept, glitches)
}

/// How far the reference moved relative to the sensors since the last fix.
struct Jump {
    metres: f64,
    /// Second difference of the altitude by the sensors, metres.
    acceleration_m: f64,
}

fn jump(fixes: &[Fix], sensors: &[Vec<Option<f64>>], k: usize) -> Option<Jump> {
    let before = k.checked_sub(1)?;
    let rise_m = fixes.get(k)?.altitude_m - fixes.get(before)?.altitude_m;
    let mut moved: Vec<f64> = Vec::new();
    let mut acceleration_m: f64 = 0.0;
    for sensor in sensors {
        if let (Some(last), Some(now)) = (sensor[before], sensor[k]) {
            moved.push(rise_m - (now - last));
            for other in [k.checked_sub(2), Some(k + 1)].into_iter().flatten() {
                if let Some(Some(beside)) = sensor.get(other) {
                    let bend = if other > k { beside - 2.0 * now + last } else { now - 2.0 * last + beside };
                    acceleration_m = acceleration_m.max(bend.abs());
                }
            }
        }
    }
    // The smallest of them: a jump that one sensor does not see is not the reference's.
    let metres = moved.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some(Jump { metres, acceleration_m })
}

/// A sensor's altitude at the fixes, interpolated between its readings; `None` outside of them.
fn sampled(path: &[(u64, f64)], fixes: &[Fix]) -> Vec<Option<f64>> {
    let mut next = 0;
    let at = fixes.iter().map(|fix| {
        while path.get(next).is_some_and(|(time_us, _)| *time_us < fix.time_us) {
            next += 1;
        }
        let (after_us, after_m) = *path.get(next)?;
        if after_us == fix.time_us {
            return Some(after_m);
        }
        let (before_us, before_m) = *path.get(next.checked_sub(1)?)?;
        let share = (fix.time_us - before_us) as f64 / (after_us - before_us) as f64;
        Some(before_m + share * (after_m - before_m))
    });
    at.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 5 Hz fixes of a level flight with a wiggle of 0.3 m, and a sensor at 50 Hz.
    fn flight(offset: impl Fn(f64) -> f64) -> (Vec<Fix>, [Vec<(u64, f64)>; 1]) {
        let wiggle = |k: i32| 0.3 * f64::from(k * 7919 % 13 - 6) / 6.0;
        let fixes = (0..300).map(|k| Fix {
            time_us: k as u64 * 200_000,
            altitude_m: 1000.0 + wiggle(k) + offset(f64::from(k) * 0.2),
            climb_mps: None,
        });
        let path = (0..3000).map(|k| (k * 20_000, 1000.0)).collect();
        (fixes.collect(), [path])
    }

    #[test]
    fn a_jump_that_comes_back_is_taken_out() {
        let (fixes, paths) = flight(|t| if (20.0..24.0).contains(&t) { 25.0 } else { 0.0 });
        let (kept, glitches) = split(fixes, &paths);
        assert_eq!(glitches, [(20_000_000, 23_800_000)]);
        assert_eq!(kept.len(), 280);
        assert!(kept.iter().all(|fix| fix.altitude_m < 1002.0));
    }

    #[test]
    fn a_jump_that_stays_and_a_slow_swing_are_kept() {
        let (fixes, paths) = flight(|t| if t > 20.0 { 25.0 } else { 0.0 });
        assert_eq!(split(fixes, &paths).1, []);
        let (fixes, paths) = flight(|t| 25.0 * (t / 8.0).sin());
        assert_eq!(split(fixes, &paths).1, []);
    }

    /// A jump of the receiver is a movement that the sensor does not share; the sensor's own bend is looked
    /// for on either side of it.
    #[test]
    fn a_jump_is_looked_at_on_either_side() {
        let fix = |(k, altitude_m): (u64, f64)| Fix { time_us: k * 200_000, altitude_m, climb_mps: None };
        let fixes: Vec<Fix> = (0..).zip([0.0, 0.0, 0.0, 30.0, 30.0]).map(fix).collect();
        let of = |heights_m: [f64; 5], k| jump(&fixes, &[heights_m.map(Some).to_vec()], k).unwrap();
        let after = of([0.0, 0.0, 0.0, 0.0, 5.0], 3);
        assert_eq!((after.metres, after.acceleration_m), (30.0, 5.0));
        let before = of([0.0, -4.0, 0.0, 2.0, 4.0], 3);
        assert_eq!((before.metres, before.acceleration_m), (28.0, 2.0));
        assert_eq!(of([4.0, 0.0, 0.0, 0.0, 0.0], 2).acceleration_m, 4.0);
        assert!(jump(&fixes, &[vec![None; 5]], 3).is_none());
    }
}
