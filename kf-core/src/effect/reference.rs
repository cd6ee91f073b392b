//! Effects on the reference: what they add to the receiver's altitude.

use super::catalogue::{EffectSubject, Row, Uses};

/// A receiver that is late by `tau` reports `h - tau hdot`. Smoothing and telemetry add up to a few seconds;
/// a receiver that predicts can be early.
pub(super) const LATENCY: Row = Row {
    name: "gps.latency",
    unit: "s",
    subject: EffectSubject::Gps,
    needs: &["gps_alt_m"],
    uses: Uses::HEIGHT,
    plausible: [-1.0, 3.0],
    typical_regressor_m: 16.0,
    has_time_constant: false,
    value: |tracker, _| tracker.climb_rate_mps().map(|climb_rate_mps| -climb_rate_mps),
};

/// Remainder of a cold start's error: code altitude with few satellites is off by some tens of metres (Kaplan
/// and Hegarty, "Understanding GPS", on vertical dilution of precision).
pub(super) const CONVERGENCE: Row = Row {
    name: "gps.convergence",
    unit: "m",
    needs: &[],
    uses: Uses::NOTHING,
    plausible: [-100.0, 100.0],
    typical_regressor_m: 1.0,
    has_time_constant: true,
    value: |tracker, regressor| {
        Some(libm::expf(-tracker.elapsed_s(regressor.since) / regressor.time_constant_s))
    },
    ..LATENCY
};

/// An antenna that is ahead of the sensors by the coefficient is higher by `sin(pitch)` of it; at most the
/// aircraft's length.
pub(super) const LEVER_ARM: Row = Row {
    name: "gps.lever_arm",
    unit: "m",
    needs: super::inertial::ATTITUDE_COLUMNS,
    uses: Uses::ATTITUDE,
    plausible: [-20.0, 20.0],
    typical_regressor_m: 1.0,
    value: |tracker, _| tracker.sin_pitch(),
    ..LATENCY
};
