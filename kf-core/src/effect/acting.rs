//! Which effects of a model act on what: needed several times a tick, so looked up once.

use super::EffectSubject;
use crate::config::MissionConfig;
use crate::sensor::SENSORS;

/// One bit per effect, for each subject: the reference, then the sensors in the order of
/// [`crate::sensor::Sensor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ActingEffects {
    estimated: [u32; 1 + SENSORS],
    constant: [u32; 1 + SENSORS],
}

impl ActingEffects {
    /// Looks up a model's effects.
    pub(crate) fn of<const E: usize>(config: &MissionConfig<E>) -> Self {
        let mut acting = Self { estimated: [0; 1 + SENSORS], constant: [0; 1 + SENSORS] };
        for (effect, term) in config.estimated_effects.iter().enumerate() {
            acting.estimated[row(term.id().subject())] |= bit(effect);
        }
        for (effect, term) in config.constant_effects.iter().enumerate() {
            acting.constant[row(term.id().subject())] |= bit(effect);
        }
        acting
    }

    /// Whether any effect acts on that subject.
    #[inline]
    pub(crate) fn any(&self, subject: EffectSubject) -> bool {
        self.estimated[row(subject)] | self.constant[row(subject)] != 0
    }

    /// Whether that estimated effect acts on that subject.
    #[inline]
    pub(crate) fn estimated(&self, subject: EffectSubject, effect: usize) -> bool {
        self.estimated[row(subject)] & bit(effect) != 0
    }

    /// Whether that constant effect acts on that subject.
    #[inline]
    pub(crate) fn constant(&self, subject: EffectSubject, effect: usize) -> bool {
        self.constant[row(subject)] & bit(effect) != 0
    }

    /// The regressors of the estimated effects that act on a subject; zero for the others.
    #[inline(always)]
    pub(crate) fn own_regressors<const E: usize>(
        &self,
        subject: EffectSubject,
        regressors_m: &[f32; E],
    ) -> [f32; E] {
        core::array::from_fn(
            |effect| if self.estimated(subject, effect) { regressors_m[effect] } else { 0.0 },
        )
    }
}

#[inline(always)]
const fn row(subject: EffectSubject) -> usize {
    match subject {
        EffectSubject::Gps => 0,
        EffectSubject::Sensor(sensor) => 1 + sensor.index(),
    }
}

/// There are fewer effects of either kind than bits.
#[inline(always)]
const fn bit(effect: usize) -> u32 {
    1 << (effect & 31)
}
