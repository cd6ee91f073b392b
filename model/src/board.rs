//! Signals that a flight computer measures, for the formulas of its model.

use kf_core::effect::EffectId;
use kf_core::formula::Signal;

use crate::{Model, ModelError};

/// A board that a model is built for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Board {
    /// A computer that replays a flight record: every signal that the estimator knows.
    Recorded,
    /// The STM32F405's own sensors: barometer, inertial unit, receiver.
    F405,
}

/// Signals without a sensor on the F405 board; see its `absent.rs`.
const NOT_ON_F405: [&str; 9] = [
    "tas_mps",
    "aoa_rad",
    "sideslip_rad",
    "throttle",
    "oat_c",
    "roll_rad",
    "pitch_rad",
    "yaw_rad",
    "imu_master_alt_m",
];

impl Board {
    fn has(self, signal: Signal) -> bool {
        // The speed over ground replaces the airspeed.
        let is_absent = |need: &&str| NOT_ON_F405.contains(need) && signal != Signal::Airspeed;
        self == Self::Recorded || !signal.needs().iter().any(is_absent)
    }
}

impl Model {
    /// Checks that a board has the signals of every formula that the model uses.
    ///
    /// # Errors
    /// [`ModelError::NotOnBoard`] for the first effect that lacks a signal, with all the signals that it
    /// lacks.
    pub fn check_signals(&self, board: Board) -> Result<(), ModelError> {
        self.effects.iter().try_for_each(|effect| self.check_signals_of(effect.term.id(), board))
    }

    /// Checks that a board has the signals of one effect's formula.
    ///
    /// # Errors
    /// As [`Self::check_signals`].
    pub fn check_signals_of(&self, effect: EffectId, board: Board) -> Result<(), ModelError> {
        let Some(parts) = effect.formula() else { return Ok(()) };
        let used = parts.program.signals();
        let absent = Signal::ALL.iter().filter(|signal| used & signal.bit() != 0 && !board.has(**signal));
        let columns = self.definitions.columns.iter().zip(0..);
        let unknown = columns.filter(|(_, number)| used >> Signal::column_place(*number) & 1 == 1);
        let lacks: Vec<&str> =
            absent.map(|signal| signal.name()).chain(unknown.map(|(column, _)| column.name())).collect();
        if !lacks.is_empty() {
            return Err(ModelError::NotOnBoard { id: parts.name, signals: lacks.join(", ") });
        }
        Ok(())
    }
}
