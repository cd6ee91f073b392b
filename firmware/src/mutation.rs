//! Planted errors, to prove that they are found. There is none unless the build asks for one
//! (`PYLON_MUTATE`, see `build.rs`).

use kf_core::input::TickInput;

/// The input as it is.
#[cfg(not(any(pylon_mutate = "ulp", pylon_mutate = "panic", pylon_mutate = "fault")))]
pub const fn mutated(input: TickInput) -> TickInput {
    input
}

/// The input with the barometer one unit in the last place off: the comparison with the host must see it.
#[cfg(pylon_mutate = "ulp")]
pub fn mutated(mut input: TickInput) -> TickInput {
    use kf_core::input::BaroReading;

    input.baro = input.baro.map(|reading| match reading {
        BaroReading::PressurePa(pressure_pa) => BaroReading::PressurePa(pressure_pa.next_up()),
        BaroReading::AltitudeM(altitude_m) => BaroReading::AltitudeM(altitude_m.next_up()),
    });
    input
}

/// A panic in the middle of a tick.
#[cfg(pylon_mutate = "panic")]
#[expect(clippy::panic, reason = "planted")]
pub fn mutated(input: TickInput) -> TickInput {
    if input.time_us > 0 {
        panic!("planted");
    }
    input
}

/// A fault of the core in the middle of a tick.
#[cfg(pylon_mutate = "fault")]
pub fn mutated(input: TickInput) -> TickInput {
    if input.time_us > 0 {
        cortex_m::asm::udf();
    }
    input
}
