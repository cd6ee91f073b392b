//! A mission whose shape is only known at run time.

use flight_computer::{Estimation, Retainable};
use kf_core::input::TickInput;
use kf_core::latch::LatchRecord;
use kf_core::mission::{Counters, Mission};
use kf_core::output::TickOutput;
use kf_core::snapshot::{MissionMark, MissionSnapshot, SnapshotError};
use model::{Model, ModelError};

use super::error::ReplayError;

/// A [`Mission`] of any shape.
pub trait AnyMission: Retainable + Send {
    /// See [`Mission::latch`].
    fn latch(&self) -> Option<&LatchRecord>;
    /// See [`Mission::counters`].
    fn counters(&self) -> &Counters;
}

impl<const HEAD: usize, const TAIL: usize, const E: usize> AnyMission for Mission<HEAD, TAIL, E> {
    fn latch(&self) -> Option<&LatchRecord> {
        Self::latch(self)
    }

    fn counters(&self) -> &Counters {
        Self::counters(self)
    }
}

impl Estimation for Box<dyn AnyMission> {
    fn tick(&mut self, input: &TickInput) -> TickOutput {
        (**self).tick(input)
    }
}

impl Retainable for Box<dyn AnyMission> {
    fn last_us(&self) -> u64 {
        (**self).last_us()
    }

    fn mark(&self) -> MissionMark {
        (**self).mark()
    }

    fn snapshot(&self) -> Option<MissionSnapshot> {
        (**self).snapshot()
    }

    fn restore_snapshot(&mut self, bytes: &[u8], mark: &MissionMark) -> Result<u64, SnapshotError> {
        (**self).restore_snapshot(bytes, mark)
    }
}

fn boxed<const HEAD: usize, const TAIL: usize, const E: usize>(
    model: &Model,
) -> Result<Box<dyn AnyMission>, ReplayError> {
    let config = model.mission_config()?;
    Ok(Box::new(Mission::<HEAD, TAIL, E>::new(&config)?))
}

/// A new mission of the shape that the model needs.
///
/// # Errors
/// [`ReplayError::Model`], [`ReplayError::Config`].
pub fn mission(model: &Model) -> Result<Box<dyn AnyMission>, ReplayError> {
    macro_rules! by_shape {
        ($($effects:literal)*) => {
            match (model.shape().head, model.shape().effects) {
                $(
                    (0, $effects) => boxed::<0, { 4 + $effects }, $effects>(model),
                    (3, $effects) => boxed::<3, { 1 + $effects }, $effects>(model),
                )*
                // More effects than the estimator supports.
                (_, effects) => Err(model.validate().err().unwrap_or(
                    ModelError::Effects { wanted: 0, found: effects }
                ).into()),
            }
        };
    }
    by_shape!(0 1 2 3 4 5 6 7 8)
}
