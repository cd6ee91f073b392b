//! Time as data: microseconds since an arbitrary origin.

/// Seconds from one time to a later one. Exact to f32 up to 71 minutes; longer spans, which no
/// caller tells apart from 71 minutes, come out as that.
#[must_use]
#[inline]
pub fn seconds_between(from_us: u64, to_us: u64) -> f32 {
    u32::try_from(to_us.saturating_sub(from_us)).unwrap_or(u32::MAX) as f32 * 1e-6
}

/// Microseconds of a span in seconds that has been checked to be positive and finite.
#[must_use]
pub fn microseconds(seconds: f32) -> u64 {
    (seconds * 1e6) as u64
}
