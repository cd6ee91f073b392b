//! Runs work that can be divided: in the calling thread, or in threads that the program provides.
//!
//! The workbench's crates divide their work into jobs and start no thread themselves, so that they also run
//! where there are no threads, such as in a browser. Results do not depend on the executor: they come in the
//! order of the jobs.

pub mod contained;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Runs jobs, one after another or several at a time.
pub trait Executor: Sync {
    /// How many jobs can run at a time, at least 1: the number of parts that work is worth dividing into.
    fn width(&self) -> usize;

    /// Calls `job` with every number below `jobs`, once each and in any order; returns when all have ended. A
    /// job's panic is passed on to the caller.
    fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync));
}

/// Runs every job itself, in order.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inline;

impl Executor for Inline {
    fn width(&self) -> usize {
        1
    }

    fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        (0..jobs).for_each(job);
    }
}

/// A job, or its result.
enum Slot<J, T> {
    Waiting(J),
    Running,
    Done(T),
}

/// Results of the jobs, in their order.
///
/// # Panics
/// When a job does.
pub fn map<T, J>(executor: &dyn Executor, jobs: impl IntoIterator<Item = J>) -> Vec<T>
where
    T: Send,
    J: FnOnce() -> T + Send,
{
    let slots: Vec<_> = jobs.into_iter().map(|job| Mutex::new(Slot::Waiting(job))).collect();
    executor.for_each(slots.len(), &|index| {
        let Some(slot) = slots.get(index) else { return };
        let take = |slot: &mut Slot<J, T>| match std::mem::replace(slot, Slot::Running) {
            Slot::Waiting(job) => Some(job),
            taken => {
                *slot = taken;
                None
            }
        };
        // The lock is released before the job begins.
        let job = take(&mut locked(slot));
        if let Some(job) = job {
            let value = job();
            *locked(slot) = Slot::Done(value);
        }
    });
    let slots = slots.into_iter().map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner));
    slots
        .map(|slot| match slot {
            Slot::Done(value) => value,
            // A job that an executor left out costs time, not results.
            Slot::Waiting(job) => job(),
            Slot::Running => unreachable!("the executor came back before its jobs had ended"),
        })
        .collect()
}

/// Results of two pieces of work that do not wait for each other.
///
/// # Panics
/// When one does.
pub fn both<A, B>(
    executor: &dyn Executor,
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B)
where
    A: Send,
    B: Send,
{
    let (mut of_first, mut of_second) = (None, None);
    let jobs: [Box<dyn FnOnce() + Send + '_>; 2] =
        [Box::new(|| of_first = Some(first())), Box::new(|| of_second = Some(second()))];
    map(executor, jobs);
    match (of_first, of_second) {
        (Some(first), Some(second)) => (first, second),
        _ => unreachable!("every job has been done"),
    }
}

fn locked<T>(slot: &Mutex<T>) -> MutexGuard<'_, T> {
    slot.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An executor that runs the last job first, runs some twice, and leaves the first one out.
    struct Careless;

    impl Executor for Careless {
        fn width(&self) -> usize {
            3
        }

        fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
            (1..jobs).rev().for_each(job);
            job(jobs - 1);
            job(jobs);
        }
    }

    #[test]
    fn results_come_in_the_order_of_the_jobs_whoever_does_them() {
        for executor in [&Inline as &dyn Executor, &Careless] {
            let done = Mutex::new(0);
            let jobs = (0..5).map(|number| {
                let done = &done;
                move || {
                    *done.lock().unwrap() += 1;
                    10 * number
                }
            });
            assert_eq!(map(executor, jobs), [0, 10, 20, 30, 40]);
            assert_eq!(*done.lock().unwrap(), 5);
            assert_eq!(both(executor, || 'a', || 1.5), ('a', 1.5));
        }
    }
}
