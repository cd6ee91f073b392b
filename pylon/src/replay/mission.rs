//! A mission whose shape is only known at run time.

use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::mission::{Counters, Mission, ResumeError};
use kf_core::output::TickOutput;
use kf_core::snapshot::{MissionMark, MissionSnapshot};
use model::{Model, ModelError};

use super::error::ReplayError;

/// A [`Mission`] of any shape.
pub trait AnyMission {
    /// See [`Mission::tick`].
    fn tick(&mut self, input: &TickInput) -> TickOutput;
    /// See [`Mission::latch`].
    fn latch(&self) -> Option<&LatchRecord>;
    /// See [`Mission::counters`].
    fn counters(&self) -> &Counters;
    /// See [`Mission::snapshot`].
    fn snapshot(&self) -> Option<MissionSnapshot>;
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> AnyMission for Mission<HEAD, TAIL, E> {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        Self::tick(self, input)
    }

    fn latch(&self) -> Option<&LatchRecord> {
        Self::latch(self)
    }

    fn counters(&self) -> &Counters {
        Self::counters(self)
    }

    fn snapshot(&self) -> Option<MissionSnapshot> {
        Self::snapshot(self)
    }
}

/// What a mission starts with.
type Kept = Option<(MissionSnapshot, MissionMark)>;

fn boxed<const HEAD: usize, const TAIL: usize, const E: usize>(
    model: &Model,
    kept: Kept,
) -> Result<Box<dyn AnyMission>, ReplayError> {
    let config = model.mission_config()?;
    let mut mission = Mission::<HEAD, TAIL, E>::new(&config)?;
    if let Some((snapshot, mark)) = kept {
        mission.go_on(&snapshot, &mark).map_err(ResumeError::Snapshot)?;
    }
    Ok(Box::new(mission))
}

/// A new mission of the shape that the model needs.
///
/// # Errors
/// [`ReplayError::Model`], [`ReplayError::Config`].
pub fn mission(model: &Model) -> Result<Box<dyn AnyMission>, ReplayError> {
    of_its_shape(model, None)
}

/// The mission that goes on from a snapshot, by the mark of the last tick before it was interrupted.
///
/// # Errors
/// As [`mission`], and [`ReplayError::Resume`].
pub fn resumed_mission(
    model: &Model,
    snapshot: MissionSnapshot,
    mark: MissionMark,
) -> Result<Box<dyn AnyMission>, ReplayError> {
    of_its_shape(model, Some((snapshot, mark)))
}

fn of_its_shape(model: &Model, kept: Kept) -> Result<Box<dyn AnyMission>, ReplayError> {
    macro_rules! by_shape {
        ($($effects:literal)*) => {
            match (model.shape().head, model.shape().effects) {
                $(
                    (0, $effects) => boxed::<0, { 4 + $effects }, $effects>(model, kept),
                    (3, $effects) => boxed::<3, { 1 + $effects }, $effects>(model, kept),
                )*
                // More effects than the estimator holds.
                (_, effects) => Err(model.validate().err().unwrap_or(
                    ModelError::Effects { wanted: 0, found: effects }
                ).into()),
            }
        };
    }
    by_shape!(0 1 2 3 4 5 6 7 8)
}
