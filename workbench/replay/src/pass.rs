//! One pass over a flight's ticks, seen by any number of observers.

use std::sync::atomic::{AtomicU64, Ordering};

use executor::Executor;
use flight_computer::Estimation;
use kf_core::input::TickInput;
use kf_core::output::TickOutput;
use model::Model;

use super::error::ReplayError;
use super::mission::{AnyMission, mission};
use super::{InputSummary, Replay, ReplaySummary};

/// Number of ticks that are made before the observers see them: enough that starting threads costs little,
/// and few enough to stay in a processor's cache.
const CHUNK: usize = 4096;

/// Passes begun in this program.
static PASSES: AtomicU64 = AtomicU64::new(0);

/// How many passes over flights' ticks this program has begun, by [`Replay::pass`], [`Replay::run`] or
/// [`Replay::inputs`]. Tests use it to check that a command does not make a flight's ticks twice.
#[must_use]
pub fn passes_begun() -> u64 {
    PASSES.load(Ordering::Relaxed)
}

/// Counts one pass.
pub(super) fn count_pass() {
    PASSES.fetch_add(1, Ordering::Relaxed);
}

/// Sees every tick of a pass, in order.
pub trait Observer: Send {
    /// Takes the next ticks.
    fn take(&mut self, ticks: &[TickInput]);
}

/// A model flown over a pass: its mission, and a function of every tick's input and output.
pub struct Flown<F> {
    mission: Box<dyn AnyMission>,
    on_tick: F,
}

impl<F: FnMut(&TickInput, &TickOutput) + Send> Flown<F> {
    /// A new mission of the model.
    ///
    /// # Errors
    /// [`ReplayError::Model`] or [`ReplayError::Config`] for a model that no mission can be made from.
    pub fn new(model: &Model, on_tick: F) -> Result<Self, ReplayError> {
        Ok(Self { mission: mission(model)?, on_tick })
    }

    /// The result after the pass.
    #[must_use]
    pub fn summary(&self, inputs: InputSummary) -> ReplaySummary {
        ReplaySummary { inputs, counters: *self.mission.counters(), latch: self.mission.latch().cloned() }
    }
}

impl<F: FnMut(&TickInput, &TickOutput) + Send> Observer for Flown<F> {
    fn take(&mut self, ticks: &[TickInput]) {
        for input in ticks {
            let output = self.mission.tick(input);
            (self.on_tick)(input, &output);
        }
    }
}

impl<F> std::fmt::Debug for Flown<F> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Flown").finish_non_exhaustive()
    }
}

impl Replay<'_> {
    /// Shows every tick of [`Self::mission_inputs`] to every observer, in one pass. The observers run in
    /// parallel where the executor has threads; the most expensive one should come first.
    pub fn pass(&self, observers: &mut [&mut dyn Observer], executor: &dyn Executor) -> InputSummary {
        let mut inputs = self.mission_inputs();
        let mut ticks: Vec<TickInput> = Vec::with_capacity(CHUNK);
        let mut next: Vec<TickInput> = Vec::with_capacity(CHUNK);
        ticks.extend(inputs.by_ref().take(CHUNK));
        while !ticks.is_empty() {
            next.clear();
            let mut jobs: Vec<Box<dyn FnOnce() + Send + '_>> = Vec::with_capacity(observers.len() + 1);
            for observer in observers.iter_mut() {
                let ticks = &ticks;
                jobs.push(Box::new(move || observer.take(ticks)));
            }
            // The next ticks are made while the observers process these.
            jobs.push(Box::new(|| next.extend(inputs.by_ref().take(CHUNK))));
            executor::map(executor, jobs);
            std::mem::swap(&mut ticks, &mut next);
        }
        self.summary_of(&inputs)
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;
    use std::sync::Mutex;

    use executor::Inline;

    use super::*;

    /// An executor that does the jobs backwards.
    struct Backwards;

    impl Executor for Backwards {
        fn width(&self) -> usize {
            2
        }

        fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
            (0..jobs).rev().for_each(job);
        }
    }

    /// Several chunks and a part of one.
    fn flight() -> flight_data::Flight {
        let mut csv = "# pylon-flight: 1\ntime_s,launch,gps_alt_m,gps_vd_mps,baro_alt_m\n".to_owned();
        for k in 0..2 * CHUNK + 100 {
            let t = 0.02 * k as f64;
            let altitude_m = 500.0 + 20.0 * (t / 9.0).sin();
            let fix = if k % 10 == 0 { format!("{altitude_m:.3},0") } else { ",".to_owned() };
            let rough = f64::from((k as u32 * 37) % 19) / 19.0;
            let _ = writeln!(csv, "{t:.3},{},{fix},{:.3}", u8::from(k >= 3000), altitude_m + rough);
        }
        flight_data::parse(csv.as_bytes()).unwrap().0
    }

    #[test]
    fn every_observer_sees_every_tick_in_order_and_missions_fly_as_by_themselves() {
        let flight = flight();
        let replay = Replay::new(&flight, &Model::default(), None).unwrap();
        let mut alone = Vec::new();
        let flown_alone =
            replay.run(&mut |input, output| alone.push((input.time_us, output.clone()))).unwrap();
        for executor in [&Inline as &dyn Executor, &Backwards] {
            let (one, other) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
            let seen_by = |seen| {
                Flown::new(replay.model(), move |input: &TickInput, output: &TickOutput| {
                    let seen: &Mutex<Vec<_>> = seen;
                    seen.lock().unwrap().push((input.time_us, output.clone()));
                })
            };
            let (mut first, mut second) = (seen_by(&one).unwrap(), seen_by(&other).unwrap());
            let inputs = replay.pass(&mut [&mut first, &mut second], executor);
            assert_eq!(*one.lock().unwrap(), alone);
            assert_eq!(*other.lock().unwrap(), alone);
            assert_eq!(first.summary(inputs), flown_alone);
        }
    }
}
