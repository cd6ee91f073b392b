//! What a tick's readings are compared with.

use kf_core::effect::EffectSubject;
use model::Model;

use super::follower::Follower;

/// Sum of the effects that the model has on one subject, metres.
pub(super) fn known_m(model: &Model, follower: &Follower, subject: EffectSubject) -> f64 {
    let terms = model.effects.iter().filter(|effect| effect.term.regressor.id.subject() == subject);
    let metres = terms.map(|effect| {
        let regressor_m = follower.raw_m(effect.term.regressor).unwrap_or(0.0);
        f64::from(effect.term.coefficient) * f64::from(regressor_m)
    });
    metres.sum()
}
