//! Autocorrelation and cross-correlation of block means.

use crate::curve::{Curve, Flown, curve};
use crate::engine::{Attachments, Engine, Progress, Refused, refused};
use crate::protocol::{Correlated, CorrelationRequest};

/// Limit on the number of lags up to the longest.
const LAGS: f64 = 400.0;
/// Least number of pairs of blocks that determine a correlation.
const FEWEST_PAIRS: usize = 20;
/// 99 of 100 values of a normal distribution lie within this many sigmas (`resid` of MATLAB's System
/// Identification Toolbox draws the same band).
const BAND_SIGMAS: f64 = 2.576;

/// Computes the requested correlation.
pub fn correlate(
    engine: &mut Engine,
    request: &CorrelationRequest,
    attachments: &mut Attachments,
    progress: &mut Progress<'_>,
) -> Result<Correlated, Refused> {
    if !(request.longest_lag_s.is_finite() && request.longest_lag_s > 0.0) {
        return Err(refused("the longest lag must be above 0 s"));
    }
    let flown = Flown { flight: &request.flight, model: &request.model, times: request.times };
    let signal = curve(engine, &flown, &request.signal, progress)?;
    let with = match &request.with {
        Some(with) => Some(curve(engine, &flown, with, progress)?),
        None => None,
    };
    let from_s = request.from_s.unwrap_or(f64::NEG_INFINITY);
    let to_s = request.to_s.unwrap_or(f64::INFINITY);
    // A block is at least as long as a signal's own interval; otherwise most blocks would be empty.
    let interval_s = |curve: &Curve| curve.gap_s(curve.range(from_s, to_s)).map(|gap_s| gap_s / 4.0);
    let few = || refused("too few values in this stretch of time to correlate");
    let mut block_s = interval_s(&signal).ok_or_else(few)?.max(request.longest_lag_s / LAGS);
    if let Some(with) = &with {
        block_s = block_s.max(interval_s(with).ok_or_else(few)?);
    }
    let start_s = first_s(&signal, from_s, to_s).ok_or_else(few)?;
    let means = block_means(&signal, start_s, to_s, block_s);
    let others = with.as_ref().map(|with| block_means(with, start_s, to_s, block_s));
    let lags = (request.longest_lag_s / block_s).round().max(1.0) as usize;
    let found = by_lag(&means, others.as_deref(), lags).ok_or_else(few)?;
    let is_cut = found.longest < lags;
    let longest = found.longest as i64;
    let first = if with.is_some() { -longest } else { 0 };
    Ok(Correlated {
        lag_s: attachments.put((first..=longest).map(|lag| lag as f64 * block_s)),
        correlation: attachments.put(found.correlation),
        band: found.band,
        block_s,
        blocks: found.blocks as u32,
        is_cut,
    })
}

fn first_s(curve: &Curve, from_s: f64, to_s: f64) -> Option<f64> {
    let mut first = None;
    curve.each(curve.range(from_s, to_s), &mut |_, time_s, _| {
        first.get_or_insert(time_s);
    });
    first
}

/// Means of blocks from `start_s` on, less their overall mean; NaN for a block without a value.
fn block_means(curve: &Curve, start_s: f64, to_s: f64, block_s: f64) -> Vec<f64> {
    let mut blocks: Vec<(f64, f64)> = Vec::new();
    curve.each(curve.range(start_s, to_s), &mut |_, time_s, value| {
        let block = ((time_s - start_s) / block_s) as usize;
        if block >= blocks.len() {
            blocks.resize(block + 1, (0.0, 0.0));
        }
        if let Some((sum, count)) = blocks.get_mut(block) {
            *sum += value;
            *count += 1.0;
        }
    });
    let means: Vec<f64> = blocks.iter().map(|(sum, count)| sum / count).collect();
    let known = || means.iter().filter(|mean| mean.is_finite());
    let mean = known().sum::<f64>() / known().count() as f64;
    means.iter().map(|value| value - mean).collect()
}

/// Correlations by lag, starting at the most negative one for a cross-correlation, otherwise at 0.
struct ByLag {
    correlation: Vec<f64>,
    longest: usize,
    band: f64,
    blocks: usize,
}

fn by_lag(signal: &[f64], with: Option<&[f64]>, lags: usize) -> Option<ByLag> {
    let other = with.unwrap_or(signal);
    let length = signal.len().max(other.len());
    let at = |values: &[f64], place: usize| values.get(place).copied().filter(|value| value.is_finite());
    let variance = |values: &[f64]| {
        let known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
        known.iter().map(|value| value * value).sum::<f64>() / known.len() as f64
    };
    let scale = (variance(signal) * variance(other)).sqrt();
    // The mean product of the pairs `lag` blocks apart, `first` behind `second`.
    let product = |first: &[f64], second: &[f64], lag: usize| {
        let (mut sum, mut pairs) = (0.0, 0);
        for place in lag..length.max(lag) {
            if let (Some(a), Some(b)) = (at(first, place), at(second, place - lag)) {
                sum += a * b;
                pairs += 1;
            }
        }
        (pairs >= FEWEST_PAIRS).then(|| sum / pairs as f64)
    };
    let side = |first: &[f64], second: &[f64]| -> Vec<f64> {
        (0..=lags).map_while(|lag| Some(product(first, second, lag)? / scale)).collect()
    };
    if !(scale.is_finite() && scale > 0.0) {
        return None;
    }
    let behind = side(signal, other);
    let blocks =
        (0..length).filter(|place| at(signal, *place).is_some() && at(other, *place).is_some()).count();
    if behind.is_empty() || blocks == 0 {
        return None;
    }
    let Some(with) = with else {
        let band = BAND_SIGMAS / (blocks as f64).sqrt();
        return Some(ByLag { longest: behind.len() - 1, correlation: behind, band, blocks });
    };
    let ahead = side(with, signal);
    let longest = behind.len().min(ahead.len()) - 1;
    let mut correlation: Vec<f64> = ahead.iter().take(longest + 1).skip(1).rev().copied().collect();
    correlation.extend(behind.iter().take(longest + 1));
    // Bartlett's formula for two uncorrelated series.
    let own = |values: &[f64]| {
        let scale = variance(values);
        (1..=lags).map_while(|lag| Some(product(values, values, lag)? / scale)).collect::<Vec<f64>>()
    };
    let common: f64 = own(signal).iter().zip(own(with)).map(|(a, b)| a * b).sum();
    let band = BAND_SIGMAS * ((1.0 + 2.0 * common).max(1.0) / blocks as f64).sqrt();
    Some(ByLag { correlation, longest, band, blocks })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Approximately white noise of variance one. Weyl's sequence would be too even; the bits of a hash are
    /// not.
    fn noise(seed: u64, count: usize) -> Vec<f64> {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        (0..count).map(|_| (0..12).map(|_| uniform()).sum()).collect()
    }

    #[test]
    fn white_noise_is_within_its_band_and_a_delay_is_found_at_its_lag() {
        let white = noise(1, 4_000);
        let of_white = by_lag(&white, None, 300).unwrap();
        assert!((of_white.correlation[0] - 1.0).abs() < 1e-12);
        let outside = of_white.correlation.iter().skip(1).filter(|value| value.abs() > of_white.band).count();
        // 3 of 300 are expected; 10 have a probability of one in a thousand.
        assert!(outside <= 10, "{outside}");

        let late: Vec<f64> = (0..4_000).map(|k| if k < 25 { 0.0 } else { white[k - 25] }).collect();
        let cross = by_lag(&late, Some(&white), 100).unwrap();
        let largest = cross.correlation.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
        assert_eq!((cross.correlation.len(), largest as i64 - 100), (201, 25));
    }

    #[test]
    fn the_band_of_slow_series_is_wide() {
        let slow = |seed| {
            let mut value = 0.0;
            noise(seed, 4_000)
                .into_iter()
                .map(|x| {
                    value = 0.95 * value + x;
                    value
                })
                .collect::<Vec<f64>>()
        };
        let cross = by_lag(&slow(2), Some(&slow(3)), 200).unwrap();
        let outside = cross.correlation.iter().filter(|value| value.abs() > cross.band).count();
        // White noise's band, 0.041, would leave most of them outside.
        assert!(cross.band > 0.12 && outside <= 20, "{} {outside}", cross.band);
    }

    #[test]
    fn blocks_without_a_value_are_left_out() {
        let mut white = noise(4, 1_000);
        white[100..300].fill(f64::NAN);
        let found = by_lag(&white, None, 50).unwrap();
        assert_eq!((found.blocks, found.longest), (800, 50));
        assert!(by_lag(&[1.0, -1.0, f64::NAN], None, 5).is_none());
    }
}
