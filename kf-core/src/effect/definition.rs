//! An effect by formula: a model's own addition to the catalogue.

use core::cmp::Ordering;
use core::fmt;
use core::hash::{Hash, Hasher};

use super::catalogue::{EffectSubject, Row};
use crate::formula::{self, Frame, Program, Stack};
use crate::input::{GpsFix, TickInput};

use super::formulas::run;
use super::{EffectTerm, SignalTracker};

/// Runs formulas. Each definition refers to it, so that an image without definitions does not contain it. It
/// is made where the definition is, so that it is compiled as that crate is: for speed in the flight
/// computer's image, whose `kf-core` is compiled for size.
pub(crate) struct Machine {
    pub take: fn(&mut Frame, u64, &TickInput, Option<&GpsFix>, &SignalTracker),
    pub run: Run,
}

/// Signature of [`run`].
type Run =
    for<'a> fn(&[EffectTerm], &mut [Option<f32>], &'a mut [f32], &mut Stack, &Frame) -> (&'a mut [f32], u32);

/// Parts of an effect by formula.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    /// Its id in model files and on the command line.
    pub name: &'static str,
    /// What it acts on.
    pub subject: EffectSubject,
    /// Unit of its coefficient; multiplied by the formula's unit it gives metres.
    pub unit: &'static str,
    /// Columns of a flight that the formula reads.
    pub needs: &'static [&'static str],
    /// Range of the coefficient in nature, in that unit.
    pub plausible: [f32; 2],
    /// See [`super::EffectId::typical_regressor_m`].
    pub typical_regressor_m: f32,
    /// The formula, metres per unit of the coefficient.
    pub program: Program,
    /// Text of the formula.
    pub law: &'static str,
    /// Description for the reader.
    pub about: &'static str,
    /// Identifies the subject, the unit and the formula, whatever the formula's layout: a learned coefficient
    /// belongs to one fingerprint.
    pub fingerprint: u64,
}

/// An effect by formula, for [`super::EffectId::Defined`]. Two definitions with the same name and fingerprint
/// are equal.
pub struct Definition {
    parts: Parts,
    pub(super) row: Row,
    pub(crate) machine: &'static Machine,
}

/// The effect by formula that an id refers to.
#[cfg(feature = "formulas")]
pub type Defined = &'static Definition;

/// The effect by formula that an id refers to. An image without the feature `formulas` has none, so that an
/// id takes one byte.
#[cfg(not(feature = "formulas"))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Defined {}

/// The definition that an id refers to.
pub(super) const fn definition_of(defined: Defined) -> &'static Definition {
    #[cfg(feature = "formulas")]
    return defined;
    #[cfg(not(feature = "formulas"))]
    match defined {}
}

impl Definition {
    /// Makes an effect of these parts.
    #[must_use]
    pub const fn new(parts: Parts, has_time_constant: bool) -> Self {
        let row = Row {
            name: parts.name,
            unit: parts.unit,
            subject: parts.subject,
            needs: parts.needs,
            uses: formula::uses(parts.program.signals()),
            plausible: parts.plausible,
            typical_regressor_m: parts.typical_regressor_m,
            has_time_constant,
            // A formula has a state, which the tracker of signals does not keep.
            value: |_, _| None,
        };
        Self { parts, row, machine: &Machine { take: Frame::take, run } }
    }

    /// The parts that it was made of.
    #[must_use]
    pub const fn parts(&self) -> &Parts {
        &self.parts
    }

    fn key(&self) -> (&'static str, u64) {
        (self.parts.name, self.parts.fingerprint)
    }
}

impl fmt::Debug for Definition {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.parts.name)
    }
}

impl PartialEq for Definition {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Definition {}

impl Hash for Definition {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl PartialOrd for Definition {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Definition {
    fn cmp(&self, other: &Self) -> Ordering {
        self.key().cmp(&other.key())
    }
}
