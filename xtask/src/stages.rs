//! A job that somebody watches: what is being done, how far it is while it takes long, and what each step
//! took.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Between two signs of life.
const EVERY: Duration = Duration::from_secs(5);
/// How often a step is asked whether it has ended.
const LOOK: Duration = Duration::from_millis(50);

/// What a step's programs said last: the newest line.
#[derive(Debug, Default)]
pub struct News(Mutex<String>);

impl News {
    /// Keeps a line. Blank ones are none.
    pub fn hear(&self, line: &str) {
        let line = line.trim();
        if !line.is_empty() {
            line.clone_into(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
        }
    }

    /// How long it has been going on, and the newest line.
    fn told(&self, elapsed: Duration) -> String {
        let newest = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let newest = if newest.is_empty() { String::new() } else { format!(": {newest}") };
        format!("        {:.0} s so far{newest}", elapsed.as_secs_f64())
    }
}

/// The steps of a job; on standard error.
#[derive(Debug)]
pub struct Stages {
    planned: usize,
    begun: usize,
    start: Instant,
}

impl Stages {
    /// None yet, of so many.
    pub fn new(planned: usize) -> Self {
        Self { planned, begun: 0, start: Instant::now() }
    }

    /// Does a step; says that it has begun, that it goes on, and how long it took.
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

    /// How long all of it took.
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
