//! Progress on standard error, for work that takes longer than a second.

use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Delay before anything is shown.
const PATIENCE: Duration = Duration::from_secs(1);
/// Interval between the spinner's steps.
const TICK: Duration = Duration::from_millis(125);
/// Spinner steps between updates of its message: one update a second.
const TICKS_PER_MESSAGE: u32 = 8;

/// A bar that appears after a second, on a terminal only.
#[derive(Debug)]
pub struct Progress {
    started: Instant,
    what: &'static str,
    total: u64,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Progress through `total` steps of `what`.
    pub fn new(what: &'static str, total: u64) -> Self {
        Self { started: Instant::now(), what, total, bar: None }
    }

    /// Shows that `done` steps are done.
    pub fn show(&mut self, done: u64) {
        if self.bar.is_none() && self.started.elapsed() > PATIENCE {
            let template = "{msg} {wide_bar} {human_pos} of {human_len}, {eta} left";
            let style =
                ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            self.bar = Some(ProgressBar::new(self.total).with_style(style).with_message(self.what));
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Counts steps when their total is not known in advance; appears after a second, on a terminal only.
#[derive(Debug)]
pub struct Counter {
    started: Instant,
    what: &'static str,
    steps: &'static str,
    done: u64,
    bar: Option<ProgressBar>,
}

impl Counter {
    /// `what` names the work; `steps` names its steps, in the plural.
    pub fn new(what: &'static str, steps: &'static str) -> Self {
        Self { started: Instant::now(), what, steps, done: 0, bar: None }
    }

    /// Counts one more step.
    pub fn step(&mut self) {
        self.done += 1;
        if self.bar.is_none() && self.started.elapsed() > PATIENCE {
            let template = "{spinner} {msg}, {elapsed}";
            let style =
                ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner());
            let bar = ProgressBar::new_spinner().with_style(style).with_elapsed(self.started.elapsed());
            bar.enable_steady_tick(Duration::from_millis(120));
            self.bar = Some(bar);
        }
        if let Some(bar) = &self.bar {
            bar.set_message(format!("{}: {} {}", self.what, self.done, self.steps));
        }
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Runs work of unknown duration; after a second a spinner shows `what`.
pub fn while_busy<T>(what: &'static str, work: impl FnOnce() -> T) -> T {
    while_telling(|| what.to_owned(), work)
}

/// As [`while_busy`], for work whose description changes: `what` is called once a second.
pub fn while_telling<T>(what: impl Fn() -> String + Send, work: impl FnOnce() -> T) -> T {
    let (done, wait) = mpsc::channel::<()>();
    thread::scope(|scope| {
        let tell = move || {
            // Any other error means that the work is done and `done` was dropped.
            let is_busy = |time| wait.recv_timeout(time) == Err(mpsc::RecvTimeoutError::Timeout);
            if !is_busy(PATIENCE) {
                return;
            }
            let spinner = ProgressBar::new_spinner();
            // Ticked by hand: the spinner's own clock would need another thread.
            for tick in 0_u32.. {
                if tick % TICKS_PER_MESSAGE == 0 {
                    spinner.set_message(what());
                }
                spinner.tick();
                if !is_busy(TICK) {
                    break;
                }
            }
            spinner.finish_and_clear();
        };
        // If no thread can be started, the work runs without a spinner.
        let _ = thread::Builder::new().spawn_scoped(scope, tell);
        let result = work();
        drop(done);
        result
    })
}
