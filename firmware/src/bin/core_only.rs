//! The smallest image that contains the mission's tick: what is linked here is what the tick needs.
//!
//! It is never run. `budgets.toml` lists the symbols that it must not contain (no panic, no soft-float
//! double, no square root), for both shapes of the filter: the paper's, and the dense one with four effects.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use kf_core::config::{
    MissionConfig, MonitorConfig, QualityConfig, ReferenceConfig, SecondCorrection, SensorConfig, SigmaSource,
};
use kf_core::effect::{Clock, EffectId, EffectTerm, Regressor};
use kf_core::input::TickInput;
use kf_core::mission::Mission;
// The vector table needs every interrupt of the chip.
use stm32f4xx_hal as _;

/// A configuration of which the compiler knows nothing.
fn configuration<const E: usize>() -> MissionConfig<E> {
    let number = || black_box(1.0);
    let sensor = || SensorConfig {
        sigma_m: number(),
        correlation_time_s: number(),
        prior_bias_m: number(),
        prior_sigma_m: number(),
        wander_m_per_sqrt_s: number(),
    };
    let effect = || EffectTerm {
        regressor: Regressor {
            id: black_box(EffectId::BaroDynamicPressure),
            time_constant_s: number(),
            since: black_box(Clock::Launch),
        },
        coefficient: number(),
        sigma: number(),
        envelope_m: black_box(None),
    };
    let mut constant_effects = heapless::Vec::new();
    while black_box(true) && constant_effects.push(effect()).is_ok() {}
    MissionConfig {
        settling_s: number(),
        reference: ReferenceConfig {
            sigma_m: number(),
            correlation_time_s: number(),
            prior_altitude_m: black_box(None),
            prior_sigma_m: number(),
            climb_rate: black_box(None),
            lost_after_s: number(),
        },
        latitude_deg: number(),
        sensors: [sensor(), sensor(), sensor()],
        monitor: MonitorConfig {
            sigma: black_box(SigmaSource::Residual),
            multiplier: number(),
            window_s: number(),
            persistence_s: number(),
            reference_check: black_box(true),
        },
        second_correction: black_box(SecondCorrection::Off),
        quality: QualityConfig {
            minimum_duration_s: number(),
            trimmed_altitude_m: number(),
            trimmed_airspeed_mps: number(),
            reference_drift_m: number(),
            minimum_satellites: black_box(4),
            vertical_accuracy_m: number(),
            bias_drift_sigmas: number(),
            implausible_share: number(),
        },
        estimated_effects: core::array::from_fn(|_| effect()),
        constant_effects,
    }
}

/// Flies a mission on inputs of which the compiler knows nothing.
fn fly<const HEAD: usize, const TAIL: usize, const E: usize>() {
    let Ok(mut mission) = Mission::<HEAD, TAIL, E>::new(&configuration::<E>()) else {
        return;
    };
    while black_box(true) {
        let output = mission.tick(&black_box(TickInput::default()));
        black_box(&output);
        black_box(mission.latch());
        black_box(mission.counters());
    }
}

#[entry]
fn main() -> ! {
    loop {
        fly::<3, 1, 0>();
        fly::<0, 8, 4>();
    }
}

#[panic_handler]
fn panicked(_: &PanicInfo) -> ! {
    loop {}
}
