//! A model's effects by formula, tick by tick, for the diagnosis: with every time constant that is tried.

use kf_core::effect::{EffectId, Regressor, SignalTracker};
use kf_core::formula::{Evaluation, Frame};
use kf_core::input::{GpsFix, TickInput};
use model::Model;

use super::candidates::catalogue;

/// One formula with one time constant.
struct Follow {
    regressor: Regressor,
    evaluation: Evaluation,
    value_m: Option<f32>,
}

/// The formulas, and the signals that they read.
pub(super) struct Formulas {
    used: u64,
    frame: Frame,
    follows: Vec<Follow>,
}

impl Formulas {
    /// The formulas of a model, both those in use and those only defined, and further ones.
    pub(super) fn of(model: &Model, further: impl IntoIterator<Item = Regressor>) -> Self {
        let own = model.effects.iter().map(|effect| effect.term.regressor);
        let tried = catalogue(model, false).into_iter().map(|candidate| candidate.regressor);
        Self::new(own.chain(tried).chain(further))
    }

    /// The formulas of these regressors. Those of the catalogue are not formulas and are left out.
    pub(super) fn new(regressors: impl Iterator<Item = Regressor>) -> Self {
        let (mut used, mut follows) = (0, Vec::<Follow>::new());
        for regressor in regressors {
            let Some(parts) = regressor.id.formula() else { continue };
            if follows.iter().all(|follow| !is_same(follow.regressor, regressor)) {
                used |= parts.program.signals();
                let evaluation = Evaluation::new(&parts.program, regressor.time_constant_s);
                follows.push(Follow { regressor, evaluation, value_m: None });
            }
        }
        Self { used, frame: Frame::default(), follows }
    }

    /// See [`SignalTracker::begin_calibration`].
    pub(super) fn begin_calibration(&mut self) {
        self.frame.begin_calibration();
    }

    /// Processes a tick that the tracker has processed.
    pub(super) fn take(&mut self, input: &TickInput, fix: Option<&GpsFix>, tracker: &SignalTracker) {
        if self.follows.is_empty() {
            return;
        }
        self.frame.take(self.used, input, fix, tracker);
        for follow in &mut self.follows {
            follow.value_m = follow.evaluation.step(&self.frame).ok();
        }
        self.frame.end();
    }

    /// The current value of the regressor, metres per unit.
    pub(super) fn value_m(&self, regressor: Regressor) -> Option<f32> {
        self.follows.iter().find(|follow| is_same(follow.regressor, regressor))?.value_m
    }
}

/// Whether two regressors are the same: a time constant that is not used does not count.
fn is_same(one: Regressor, other: Regressor) -> bool {
    let reads_time = || matches!(one.id, EffectId::Defined(_)) && one.id.has_time_constant();
    one.id == other.id && (!reads_time() || one.time_constant_s.to_bits() == other.time_constant_s.to_bits())
}
