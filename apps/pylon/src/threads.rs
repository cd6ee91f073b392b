//! The machine's threads as an executor for the workbench's crates, which start none themselves.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use executor::Executor;

/// As many threads as there are cores, started for each piece of work and ended after it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Threads;

impl Executor for Threads {
    fn width(&self) -> usize {
        thread::available_parallelism().map_or(1, usize::from)
    }

    fn for_each(&self, jobs: usize, job: &(dyn Fn(usize) + Sync)) {
        let next = AtomicUsize::new(0);
        let work = || {
            while let Some(index) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|index| *index < jobs) {
                job(index);
            }
        };
        thread::scope(|scope| {
            let helpers: Vec<_> = (1..self.width().min(jobs))
                // If no thread can be started, this one does all the work.
                .map_while(|_| thread::Builder::new().spawn_scoped(scope, work).ok())
                .collect();
            work();
            for helper in helpers {
                helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_is_done_once_and_results_keep_their_order() {
        for jobs in [0, 1, 2, 100] {
            let expected: Vec<usize> = (0..jobs).map(|index| index * index).collect();
            let squares = executor::map(&Threads, (0..jobs).map(|index| move || index * index));
            assert_eq!(squares, expected);
        }
    }

    #[test]
    fn a_panic_in_another_thread_is_contained() {
        let said = crate::contained::contained(|| {
            executor::both(&Threads, || -> u8 { panic!("elsewhere") }, || 1);
        });
        assert!(said.unwrap_err().to_string().starts_with("elsewhere"));
    }

    #[test]
    fn a_panic_of_a_job_is_the_callers() {
        let caught = std::panic::catch_unwind(|| {
            executor::map(&Threads, (0..4).map(|index| move || assert!(index != 2, "the third job")));
        });
        let said = caught.unwrap_err();
        assert_eq!(said.downcast_ref::<&str>(), Some(&"the third job"));
    }
}
