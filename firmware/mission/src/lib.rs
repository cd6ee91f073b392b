//! The mission of the compiled-in model, identical to the workbench's to the bit (`build.rs`).
//!
//! `kf-core`'s mission is generic, so it is compiled where its shape is known. That is here and not in
//! `firmware`, so that the tick is compiled for speed and rarely run code for size (`Cargo.toml`,
//! `[profile.firmware.package]`).
#![no_std]
#![forbid(unsafe_code)]

use core::mem::MaybeUninit;

use flight_computer::Estimation;
use kf_core::effect::EffectId;
use kf_core::estimator::ConfigError;
use kf_core::input::TickInput;
use kf_core::mission::Mission;
use kf_core::output::TickOutput;

mod generated {
    include!(concat!(env!("OUT_DIR"), "/model.rs"));
}

pub use generated::FINGERPRINT;

/// Origin of the model.
pub const NAME: &str = env!("PYLON_MODEL_NAME");

/// The mission of that model.
pub type FlownMission = Mission<{ generated::HEAD }, { generated::TAIL }, { generated::EFFECTS }>;

/// Its estimated effects, in the model's order.
#[must_use]
pub fn effects() -> [EffectId; generated::EFFECTS] {
    generated::mission_config().estimated_effects.map(|effect| effect.id())
}

/// Makes the mission before its first tick in its final place, because it is too large to be moved over the
/// stack. Compiled in its caller, for size.
///
/// # Errors
/// [`ConfigError`]: the model is not a valid mission.
#[inline(always)]
pub fn mission(place: &mut MaybeUninit<FlownMission>) -> Result<&mut FlownMission, ConfigError> {
    Ok(place.write(Mission::new(&generated::mission_config())?))
}

/// The mission, ticked by the code compiled in this crate.
#[derive(Debug)]
pub struct Flown<'a>(pub &'a mut FlownMission);

impl Estimation for Flown<'_> {
    #[inline(never)]
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        self.0.tick(input)
    }
}
