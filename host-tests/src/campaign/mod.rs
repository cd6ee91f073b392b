//! A Monte Carlo campaign of faults on the whole chain, from the chips' registers and wires to the latch,
//! flags and telemetry.
//!
//! A run draws a flight ([`plan`], [`flight`]), faults ([`fault`]) and a sensor that fails by itself in free
//! flight. It flies twice ([`run`]), clean and with the faults; the same sensor fails in both. The
//! observations of both ([`watch`]) are checked against the invariants ([`mod@judge`]); a campaign is a table
//! of consequences by fault and phase ([`matrix`]). Removing a guard must show ([`mutants`]). A run depends
//! only on the campaign's seed and its own number, whatever else is flown and on how many threads.

mod computer;
pub mod draw;
pub mod fault;
pub mod flight;
pub mod judge;
pub mod known;
pub mod matrix;
pub mod mutants;
pub mod plan;
pub mod run;
pub mod watch;

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::Result;

use judge::{Verdict, judge};
use run::{Case, config};

/// Flies these runs on every core, and returns their verdicts in order. `done` is called after each.
///
/// # Errors
/// The model does not make a mission.
pub fn fly(seed: u64, cases: &[Case], done: &(impl Fn() + Sync)) -> Result<Vec<Verdict>> {
    let config = config()?;
    let next = AtomicUsize::new(0);
    let verdicts: Mutex<Vec<(usize, Result<Verdict>)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(case) = cases.get(place) else { break };
                    let verdict = case.fly(seed, &config).map(|flown| judge(case, &flown));
                    done();
                    if let Ok(mut verdicts) = verdicts.lock() {
                        verdicts.push((place, verdict));
                    }
                }
            });
        }
    });
    let mut verdicts = verdicts.into_inner().map_err(|error| anyhow::anyhow!("{error}"))?;
    verdicts.sort_by_key(|(place, _)| *place);
    verdicts.into_iter().map(|(_, verdict)| verdict).collect()
}
