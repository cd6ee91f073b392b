//! Progress of a job that a user watches: the current step, its progress if it takes long, and each step's
//! time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Time between two progress lines.
const EVERY: Duration = Duration::from_secs(5);
/// Time between two checks whether a step has ended.
const LOOK: Duration = Duration::from_millis(50);

/// The newest line of output from a step's programs.
#[derive(Debug, Default)]
pub struct News(Mutex<String>);

impl News {
    /// Keeps a line, unless it is blank.
    pub fn hear(&self, line: &str) {
        let line = line.trim();
        if !line.is_empty() {
            line.clone_into(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }

    /// How long the step has been running, and the newest line.
    fn told(&self, elapsed: Duration) -> String {
        let newest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = if newest.is_empty() { String::new() } else { format!(": {newest}") };
        format!("        {:.0} s so far{newest}", elapsed.as_secs_f64())
    }
}

/// The steps of a job, reported on standard error.
#[derive(Debug)]
pub struct Stages {
    planned: usize,
    begun: usize,
    start: Instant,
}

impl Stages {
    /// No step yet of this many.
    pub fn new(planned: usize) -> Self {
        Self { planned, begun: 0, start: Instant::now() }
    }

    /// Runs a step; reports its start, its progress and its duration.
    pub fn run<T: Send>(
        &mut self,
        name: &str,
        step: impl FnOnce(&News) -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        self.begun += 1;
        let number = format!("[{}/{}]", self.begun, self.planned);
        eprintln!("{number:>7} {name}");
        let (news, has_ended, start) = (News::default(), AtomicBool::new(false), Instant::now());
        let done = thread::scope(|scope| {
            scope.spawn(|| {
                let mut told = Duration::ZERO;
                while !has_ended.load(Ordering::Relaxed) {
                    thread::sleep(LOOK);
                    let elapsed = start.elapsed();
                    if elapsed >= told + EVERY {
                        eprintln!("{}", news.told(elapsed));
                        told = elapsed;
                    }
                }
            });
            let done = step(&news);
            has_ended.store(true, Ordering::Relaxed);
            done
        })?;
        eprintln!("        done, {:.1} s", start.elapsed().as_secs_f64());
        Ok(done)
    }

    /// Reports the total time.
    pub fn finish(self) {
        eprintln!("{} steps, {:.1} s", self.begun, self.start.elapsed().as_secs_f64());
    }
}

#[test]
fn what_goes_on_is_told_with_the_newest_line() {
    let news = News::default();
    assert_eq!(news.told(Duration::from_secs(5)), "        5 s so far");
    news.hear("   Compiling libm v0.2.16\n");
    news.hear("   Compiling pylon v0.1.0\n");
    news.hear("\n");
    assert_eq!(news.told(Duration::from_secs(70)), "        70 s so far: Compiling pylon v0.1.0");
}
