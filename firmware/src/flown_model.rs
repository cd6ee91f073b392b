//! The model that was compiled in: the workbench's, to the bit (`build.rs`).

use core::mem::MaybeUninit;

use kf_core::effect::EffectId;
use kf_core::estimator::ConfigError;
use kf_core::mission::Mission;

mod generated {
    include!(concat!(env!("OUT_DIR"), "/model.rs"));
}

pub use generated::FINGERPRINT;

/// Where the model comes from.
pub const NAME: &str = env!("PYLON_MODEL_NAME");

/// The mission of that model.
pub type FlownMission = Mission<{ generated::HEAD }, { generated::TAIL }, { generated::EFFECTS }>;

/// Its estimated effects, in the model's order.
pub fn effects() -> [EffectId; generated::EFFECTS] {
    generated::mission_config().estimated_effects.map(|effect| effect.id())
}

/// Makes the mission before its first tick where it stays: it is too large to be moved over the stack.
#[inline(never)]
pub fn mission(place: &mut MaybeUninit<FlownMission>) -> Result<&mut FlownMission, ConfigError> {
    Ok(place.write(Mission::new(&generated::mission_config())?))
}
