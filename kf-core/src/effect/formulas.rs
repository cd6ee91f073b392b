//! Runs the formulas of a model, tick by tick.

use super::definition::{Machine, definition_of};
use super::{EffectId, EffectTerm, SignalTracker};
use crate::config::{MAX_CONSTANT_EFFECTS, MAX_ESTIMATED_EFFECTS, MissionConfig};
use crate::formula::{Frame, Silent, Stack, step};
use crate::input::{GpsFix, TickInput};
use crate::sensor::SENSORS;

/// Limit on the numbers that the formulas of a model without estimated effects can remember together; zero in
/// an image whose model has no formula, which then needs no memory for them.
pub const MAX_FORMULA_WORDS: usize = if cfg!(feature = "formulas") { formula_words(0) } else { 0 };

/// Limit on the numbers that the formulas of a model can remember beside that many estimated effects: a
/// mission's snapshot is then no longer than that of the model with the most estimated effects, which takes
/// all the room there is.
///
/// Each estimated effect fewer saves its coefficient, its row of the covariance, and its regressor at the
/// last fix; the count of silent formulas and the length take two of these words.
#[must_use]
pub const fn formula_words(estimated: usize) -> usize {
    let saved = MAX_ESTIMATED_EFFECTS.saturating_sub(estimated);
    let (most, own) = (1 + SENSORS + MAX_ESTIMATED_EFFECTS, 1 + SENSORS + MAX_ESTIMATED_EFFECTS - saved);
    (most * (most + 1) / 2 - own * (own + 1) / 2 + 2 * saved).saturating_sub(2)
}

/// Numbers that the formulas of a mission remember.
pub(crate) type FormulaWords = heapless::Vec<f32, MAX_FORMULA_WORDS>;

/// Signals, memory and values of a model's effects by formula. In an image whose model has no formula it
/// takes almost no memory.
#[derive(Clone, Debug)]
pub(crate) struct Formulas {
    machine: Option<&'static Machine>,
    used: u64,
    /// One, or none without the feature `formulas`.
    memory: [Memory; MEMORIES],
    /// The integrals could not be continued over a restart.
    integrals_lost: bool,
}

const MEMORIES: usize = cfg!(feature = "formulas") as usize;

#[derive(Clone, Copy, Debug)]
struct Memory {
    frame: Frame,
    state: [f32; MAX_FORMULA_WORDS],
    stack: Stack,
    estimated_m: [Option<f32>; MAX_ESTIMATED_EFFECTS],
    constant_m: [Option<f32>; MAX_CONSTANT_EFFECTS],
}

impl Default for Memory {
    fn default() -> Self {
        Self {
            frame: Frame::default(),
            state: [0.0; MAX_FORMULA_WORDS],
            stack: Stack::default(),
            estimated_m: [None; MAX_ESTIMATED_EFFECTS],
            constant_m: [None; MAX_CONSTANT_EFFECTS],
        }
    }
}

impl core::fmt::Debug for Machine {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str("Machine")
    }
}

impl Formulas {
    /// Whether a model's formulas remember no more than [`formula_words`].
    pub(crate) fn fit<const E: usize>(config: &MissionConfig<E>) -> bool {
        words(config) <= formula_words(E)
    }

    /// Makes the formulas of a model's effects, which must [`Self::fit`]. That check is separate: an option
    /// of this would be on the stack twice.
    pub(crate) fn of<const E: usize>(config: &MissionConfig<E>) -> Self {
        let mut formulas =
            Self { machine: None, used: 0, memory: [Memory::default(); MEMORIES], integrals_lost: false };
        for term in config.estimated_effects.iter().chain(&config.constant_effects) {
            if let EffectId::Defined(defined) = term.id() {
                let definition = definition_of(defined);
                formulas.machine = Some(definition.machine);
                formulas.used |= definition.parts().program.signals();
            }
        }
        formulas
    }

    /// See [`SignalTracker::begin_calibration`].
    pub(crate) const fn begin_calibration(&mut self) {
        if let [memory, ..] = self.memory.as_mut_slice() {
            memory.frame.begin_calibration();
        }
    }

    /// See [`SignalTracker::lose_integrals`].
    pub(crate) const fn lose_integrals(&mut self) {
        self.integrals_lost = true;
    }

    /// See [`SignalTracker::resume_captive`].
    pub(crate) const fn resume_captive(&mut self) {
        self.integrals_lost = false;
    }

    /// Takes a tick that the signal tracker has already taken; returns how many formulas had no value though
    /// their signals are there.
    #[inline]
    pub(crate) fn take<const E: usize>(
        &mut self,
        config: &MissionConfig<E>,
        input: &TickInput,
        fix: Option<&GpsFix>,
        tracker: &SignalTracker,
    ) -> u32 {
        let (Some(machine), [memory, ..]) = (self.machine, self.memory.as_mut_slice()) else { return 0 };
        (machine.take)(&mut memory.frame, self.used, input, fix, tracker);
        let Memory { frame, state, stack, estimated_m, constant_m } = memory;
        let (rest, silent) = (machine.run)(&config.estimated_effects, estimated_m, state, stack, frame);
        let silent_constants = if config.constant_effects.is_empty() {
            0
        } else {
            (machine.run)(&config.constant_effects, constant_m, rest, stack, frame).1
        };
        frame.end();
        if self.integrals_lost {
            forget_integrals(&config.estimated_effects, estimated_m);
            forget_integrals(&config.constant_effects, constant_m);
        }
        silent + silent_constants
    }

    /// Value of the estimated effect with that index, metres per unit of coefficient.
    #[inline]
    pub(crate) fn estimated_m(&self, effect: usize) -> Option<f32> {
        self.memory.first().and_then(|memory| memory.estimated_m.get(effect).copied().flatten())
    }

    /// Value of the constant effect with that index.
    #[inline]
    pub(crate) fn constant_m(&self, effect: usize) -> Option<f32> {
        self.memory.first().and_then(|memory| memory.constant_m.get(effect).copied().flatten())
    }

    /// The numbers remembered, to be kept over a restart.
    pub(crate) fn kept<const E: usize>(&self, config: &MissionConfig<E>) -> FormulaWords {
        self.memory.iter().flat_map(|memory| memory.state).take(words(config)).collect()
    }

    /// Whether these are numbers of this model's formulas.
    pub(crate) fn is_ours<const E: usize>(config: &MissionConfig<E>, kept: &FormulaWords) -> bool {
        kept.len() == words(config) && kept.iter().all(|word| word.is_finite())
    }

    /// Continues from what was kept at a time: the next tick's step starts there.
    pub(crate) fn resume(&mut self, kept: &FormulaWords, last_us: u64) {
        let [memory, ..] = self.memory.as_mut_slice() else { return };
        for (word, kept) in memory.state.iter_mut().zip(kept) {
            *word = *kept;
        }
        memory.frame.resume(last_us);
    }
}

/// How many numbers the formulas of a model remember.
fn words<const E: usize>(config: &MissionConfig<E>) -> usize {
    let terms = config.estimated_effects.iter().chain(&config.constant_effects);
    terms.map(EffectTerm::id).map(|id| id.formula().map_or(0, |formula| formula.program.state_words())).sum()
}

/// Runs the formulas among `terms` for one tick, in order, each with its part of `state`. Returns the
/// remaining state, and how many formulas had no value though their signals are there.
#[inline]
pub(super) fn run<'a>(
    terms: &[EffectTerm],
    values_m: &mut [Option<f32>],
    mut state: &'a mut [f32],
    stack: &mut Stack,
    frame: &Frame,
) -> (&'a mut [f32], u32) {
    let mut silent = 0;
    for (term, value_m) in terms.iter().zip(values_m) {
        let EffectId::Defined(defined) = term.id() else { continue };
        let program = &definition_of(defined).parts().program;
        let Some((own, rest)) = core::mem::take(&mut state).split_at_mut_checked(program.state_words())
        else {
            break;
        };
        state = rest;
        *value_m = match step(program, own, stack, frame, term.regressor.time_constant_s) {
            Ok(value_m) => Some(value_m),
            Err(why) => {
                silent += u32::from(why != Silent::NotYet);
                None
            }
        };
    }
    (state, silent)
}

/// Removes the value of each formula with an integral: the integrals could not be continued over a restart.
#[cold]
fn forget_integrals(terms: &[EffectTerm], values_m: &mut [Option<f32>]) {
    for (term, value_m) in terms.iter().zip(values_m) {
        if term.id().formula().is_some_and(|parts| parts.program.is_integrated()) {
            *value_m = None;
        }
    }
}
