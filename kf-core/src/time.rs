//! Time as data: microseconds since an arbitrary origin.

/// Seconds from one time to a later one. Exact to f32 up to 71 minutes; longer spans are returned as that,
/// because no caller distinguishes them from 71 minutes.
#[must_use]
#[inline]
pub fn seconds_between(from_us: u64, to_us: u64) -> f32 {
    u32::try_from(to_us.saturating_sub(from_us)).unwrap_or(u32::MAX) as f32 * 1e-6
}

/// Seconds from one time to a later one, to f32 and to the microsecond; beyond 71 minutes, where f32 itself
/// resolves 0.5 ms, to 4 ms. Spans of over 203 days are returned as that.
#[must_use]
#[inline]
pub fn elapsed_s(from_us: u64, to_us: u64) -> f32 {
    let elapsed_us = to_us.saturating_sub(from_us);
    match u32::try_from(elapsed_us) {
        Ok(elapsed_us) => elapsed_us as f32 * 1e-6,
        Err(_) => u32::try_from(elapsed_us >> 12).unwrap_or(u32::MAX) as f32 * 4096e-6,
    }
}

/// Microseconds of a span in seconds that has been checked to be positive and finite.
#[must_use]
pub fn microseconds(seconds: f32) -> u64 {
    (seconds * 1e6) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_are_told_apart() {
        let hour_us = 3_600_000_000;
        for hours in [0, 1, 2, 24, 240_u64] {
            let elapsed = elapsed_s(5, 5 + hours * hour_us);
            assert!((elapsed - hours as f32 * 3600.0).abs() <= hours as f32 * 3600.0 * 1e-6, "{elapsed}");
        }
        assert_eq!(elapsed_s(7, 6), 0.0);
        assert_eq!(elapsed_s(0, 5_000), 0.005);
        // Where the two branches meet, they agree to the coarser one's resolution.
        let seam = u64::from(u32::MAX);
        assert!((elapsed_s(0, seam + 4096) - elapsed_s(0, seam)).abs() < 0.01);
    }
}
